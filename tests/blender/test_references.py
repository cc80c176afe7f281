# SPDX-License-Identifier: GPL-3.0-or-later
"""Parameters that are curves and objects, through a method that only this file knows.

A new Blender finds its row as one more module of the registry's folder. Its native class is a thin shell that
adds what it is given, so the shape tells which values arrived.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from events import another_blender

MODULE = """
from .schema import Control, Curve, Family, Method, Moved, Pointer

ROWS = (
    Method(
        id="throwaway",
        number=999,
        label="Throwaway",
        family=Family.SPACE_NONLINEAR,
        control=Control.HANDLES,
        native="Throwaway",
        section="1",
        paper="none",
        summary="Adds its parameters to the shape",
        iterative=False,
        moves=frozenset({Moved.MESH}),
        parameters=(
            Curve(
                "profile",
                ((0.0, 0.0), (1.0, 1.0)),
                samples=3,
                rebinds=True,
                label="Profile",
                description="What the constructor gets",
            ),
            Curve(
                "falloff",
                ((0.0, 0.0), (0.5, 1.0), (1.0, 0.0)),
                samples=5,
                label="Falloff",
                description="What each solve gets",
            ),
            Pointer("frame", types=("EMPTY",), label="Frame", description="Where each solve looks"),
        ),
    ),
)
"""

SET_UP = """
import importlib, bpy, numpy as np
from mathutils import Matrix
from rig import Rig, make_active, update

room = lambda path: importlib.import_module(f"{addon_name}.{path}")
native, session = room("backend").availability().module, room("session")

class Throwaway:
    built, solved = [], []
    def __init__(self, mesh, *, profile):
        Throwaway.built.append(profile)
        self.shell = native.ThinShell(mesh)
    def set_handles(self, handles, **options):
        return self.shell.set_handles(handles, **options)
    def solve(self, poses, *, falloff, frame, **options):
        Throwaway.solved.append((falloff, frame))
        positions, report = self.shell.solve(poses, **options)
        positions[:, 0] += 0.0 if frame is None else frame[0, 3]
        positions[:, 2] += falloff[2]
        return positions, report

native.Throwaway = Throwaway
row = room("core.methods").BY_ID["throwaway"]
profile, falloff, frame = row.parameters

def moved():
    return (plate.points() - plate.rest())[len(plate.rest()) // 2]

def draw(curve, place):
    tree = getattr(plate.deformer.parameters, curve.id)
    points = tree.nodes[0].mapping.curves[0].points
    points[1].location = place
    tree.nodes[0].mapping.update()
    tree.update_tag()
    update()

bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
plate = Rig.plate().bind("throwaway")
"""


@pytest.fixture
def throwaway(room, addon_name: str, tmp_path: Path) -> Iterator:
    """Runs a script in a new Blender, after ``SET_UP``; what the script put into ``seen``."""
    module = Path(room("core.methods").__file__).with_name("throwaway.py")
    module.write_text(MODULE, encoding="utf-8")
    yield lambda script: another_blender(
        f"addon_name = {addon_name!r}\n{SET_UP}\n{script}", tmp_path, addon_name
    )
    module.unlink()


def test_a_default_curve_is_its_points(throwaway) -> None:
    seen = throwaway(
        """
        seen["profile"] = Throwaway.built[-1].tolist()
        seen["falloff"] = Throwaway.solved[-1][0].tolist()
        seen["frame"] = Throwaway.solved[-1][1]
        seen["moved"] = moved().tolist()
        seen["trees"] = len([tree for tree in bpy.data.node_groups if "sinew_curve" in tree])
        """
    )
    assert seen["profile"] == [0.0, 0.5, 1.0]
    assert seen["falloff"] == [0.0, 0.5, 1.0, 0.5, 0.0]
    assert seen["frame"] is None
    assert seen["moved"] == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)
    assert seen["trees"] == 0
