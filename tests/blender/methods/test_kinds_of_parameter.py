# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows that only this file knows: with curves, with objects, around another method, on handle points.

A new Blender finds them as one more module of the registry's folder. Their native classes tell by the shape
which values arrived.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from second_blender import another_blender

MODULE = """
from .schema import Control, Curve, Family, Method, Moved, Pointer, factorising

WORDS = {"known_as": "none", "search": "none", "fails": "Nowhere", "picture": "none"}
ROWS = (
    Method(
        id="throwaway",
        number=999,
        label="Throwaway",
        family=Family.MULTIRESOLUTION,
        control=Control.HANDLES,
        section="1",
        paper="none",
        **WORDS,
        summary="Adds its parameters to the shape",
        iterative=False,
        moves=frozenset({Moved.MESH}),
        bind_seconds=factorising(0.01),
        parameters=(
            Curve("profile", "Profile", ((0.0, 0.0), (1.0, 1.0)), samples=3).described(
                "What the constructor gets"
            ),
            Curve(
                "falloff", "Falloff", ((0.0, 0.0), (0.5, 1.0), (1.0, 0.0)), samples=5, rebinds=False
            ).described("What each solve gets"),
            Pointer("frame", "Frame", types=("EMPTY",), rebinds=False).described("Where each solve looks"),
        ),
    ),
    Method(
        id="around",
        number=998,
        label="Around",
        family=Family.MULTIRESOLUTION,
        control=Control.HANDLES,
        section="1",
        paper="none",
        **WORDS,
        summary="Moves on what another method moved",
        iterative=False,
        moves=frozenset({Moved.MESH}),
        bind_seconds=factorising(0.01),
        wraps=(Family.SURFACE_LINEAR, Family.SURFACE_NONLINEAR),
    ),
    Method(
        id="nearest",
        number=997,
        label="Nearest",
        family=Family.SPACE_LINEAR,
        control=Control.HANDLES,
        section="1",
        paper="none",
        **WORDS,
        summary="Each point moves with the nearest point of a handle",
        iterative=False,
        moves=frozenset(Moved),
        bind_seconds=factorising(0.01),
    ),
)
"""

SET_UP = """
import importlib, traceback, bpy, numpy as np
from mathutils import Matrix
from pathlib import Path
from rigs.rig import Rig, make_active, new_empty, reopen, update
from rigs.sheet import DrawContext, Sheet

room = lambda path: importlib.import_module(f"{addon_name}.{path}")
native, housekeeping = room("backend").availability().module, room("session.actions.housekeeping")
limb = room("core.tasks").TASK_BY_ID["limb"]
object.__setattr__(limb, "methods", (*limb.methods, "throwaway", "around", "nearest"))

class Throwaway:
    built, solved = [], []
    def __init__(self, mesh, *, profile):
        Throwaway.built.append(profile)
        self.shell = native.ThinShell(mesh)
    def can_reuse(self, former):
        return False
    def set_handles(self, handles, **options):
        return self.shell.set_handles(handles, **options)
    def solve(self, poses, *, falloff, frame, **options):
        Throwaway.solved.append((falloff, frame))
        positions, report = self.shell.solve(poses, **options)
        positions[:, 0] += 0.0 if frame is None else frame[0, 3]
        positions[:, 2] += falloff[2]
        return positions, report

class Around:
    bases = []
    def __init__(self, mesh, *, base):
        Around.bases.append(type(base).__name__)
        self.base = base
    def can_reuse(self, former):
        return False
    def set_handles(self, handles, **options):
        return self.base.set_handles(handles, **options)
    def solve(self, poses, **options):
        positions, report = self.base.solve(poses, **options)
        positions[:, 2] += 1.0
        return positions, report

class Nearest:
    made = []
    def __init__(self, points, counts, weights):
        assert weights is None, "all are held fully"
        self.rest, self.counts = points.copy(), counts
        Nearest.made.append(points.tolist())
    def can_reuse(self, former, points):
        return False
    def bind(self, points, progress):
        self.points = points
        self.nearest = np.argmin(np.linalg.norm(points[:, None] - self.rest, axis=2), axis=1)
    def warp_poses(self, poses, out=None, *, incoming=None, from_rest=None):
        maps = np.repeat(poses, self.counts, axis=0)
        posed = np.einsum("cij,cj->ci", maps[:, :, :3], self.rest) + maps[:, :, 3]
        moved = (self.points if incoming is None else incoming) + (posed - self.rest)[self.nearest]
        if out is None:
            return moved
        out[:] = moved
        return out

native.Throwaway, native.Around, native.Nearest = Throwaway, Around, Nearest
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

plate = None

def scene(tell):
    nonlocal plate
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    Throwaway.built, Throwaway.solved = [], []
    plate = Rig.plate().bind("throwaway")
    try:
        tell()
        seen[tell.__name__] = ""
    except AssertionError:
        seen[tell.__name__] = traceback.format_exc()

def same(found, expected):
    assert np.allclose(np.array(found, float), expected, atol=1e-6), found

def solves_nothing():
    solved = len(Throwaway.solved)
    update()
    assert len(Throwaway.solved) == solved
"""

SCENES = """
@scene
def a_default_curve_is_its_points():
    assert Throwaway.built[-1].tolist() == [0.0, 0.5, 1.0]
    assert Throwaway.solved[-1][0].tolist() == [0.0, 0.5, 1.0, 0.5, 0.0]
    assert Throwaway.solved[-1][1] is None
    same(moved(), [0.0, 0.0, 1.0])
    assert not [tree for tree in bpy.data.node_groups if "sinew_curve" in tree]

@scene
def a_drawn_curve_reaches_constructor_and_solve():
    bpy.ops.sinew.curve_edit(parameter="falloff")
    solves_nothing()
    draw(falloff, (0.5, 0.25))
    same(Throwaway.solved[-1][0], [0.0, 0.125, 0.25, 0.125, 0.0])
    same(moved(), [0.0, 0.0, 0.25])
    built = len(Throwaway.built)
    bpy.ops.sinew.curve_edit(parameter="profile")
    update()
    plate.deformer.parameters.profile.nodes[0].mapping.curves[0].points.new(0.5, 0.75)
    draw(profile, (0.5, 0.75))
    assert len(Throwaway.built) > built
    same(Throwaway.built[-1], [0.0, 0.75, 1.0])
    bpy.ops.sinew.curve_edit(parameter="falloff", reset=True)
    update()
    assert Throwaway.solved[-1][0].tolist() == [0.0, 0.5, 1.0, 0.5, 0.0]

@scene
def an_object_gives_its_frame_hidden_too():
    other = new_empty("Other", (1.5, 2.0, 3.0))
    plate.obj.location = 1.0, 2.0, 3.0
    plate.deformer.parameters.frame = other
    update()
    same(Throwaway.solved[-1][1], [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0]])
    same(moved(), [0.5, 0.0, 1.0])
    other.hide_viewport = True
    housekeeping.tidy()
    update()
    other.location.x = 1.25
    update()
    same(moved(), [0.25, 0.0, 1.0])
    solves_nothing()
    bpy.data.objects.remove(other)
    update()
    assert Throwaway.solved[-1][1] is None

@scene
def curves_are_saved_and_belong_to_one_deformer():
    bpy.ops.sinew.curve_edit(parameter="falloff")
    draw(falloff, (0.5, 0.25))
    reopen(f"{folder}/curve.blend")
    same(moved(), [0.0, 0.0, 0.25])
    make_active(plate.obj)
    bpy.ops.object.duplicate()
    housekeeping.tidy()
    update()
    copy = bpy.context.object
    trees = [obj.sinew.active.parameters.falloff for obj in (plate.obj, copy)]
    assert trees[0] != trees[1]
    draw(falloff, (0.5, 0.75))
    same(moved(), [0.0, 0.0, 0.75])
    name, plate.name = plate.name, copy.name
    same(moved(), [0.0, 0.0, 0.25])
    plate.name = name
    for obj in (plate.obj, copy):
        make_active(obj)
        bpy.ops.sinew.deformer_remove()
    assert not [tree.name for tree in bpy.data.node_groups if "sinew_curve" in tree]

def takes(values, method):
    try:
        values.base = method
    except TypeError:
        return False
    return True

@scene
def a_method_is_put_around_another():
    deformer = plate.deformer
    deformer.method = "around"
    methods = room("core.methods")
    offered = {row.id for row in methods.METHODS if takes(deformer.around, row.id)}
    families = methods.BY_ID["around"].wraps
    wrapped = {row.id for row in methods.METHODS if row.family in families and not row.keyed}
    assert offered == wrapped and len(wrapped) > 1, offered
    assert not offered & {"green", "around", "throwaway"}
    deformer.around.base = "thin_shell"
    update()
    same(moved(), [0.0, 0.0, 1.0])
    made = len(Around.bases)
    deformer.thin_shell.laplacian = "uniform"
    update()
    assert len(Around.bases) > made
    deformer.around.base = "arap"
    deformer.arap.max_iterations = 3
    update()
    assert list(dict.fromkeys(Around.bases)) == ["ThinShell", "Arap"]
    assert deformer.is_iterative
    assert deformer.status_level == "INFO", deformer.status

@scene
def a_space_method_gets_the_points_of_handles_with_and_without_a_group():
    deformer = plate.deformer
    deformer.method = "nearest"
    update()
    assert deformer.status_level == "INFO", deformer.status
    held = plate.rest()[[*plate.top, *plate.base]].tolist()
    assert sorted(Nearest.made[-1]) == sorted(held)

    def heights():
        return sorted(set((plate.points() - plate.rest())[:, 2].round(6).tolist()))

    plate.lift(1.0)
    assert heights() == [0.0, 1.0]
    assert np.ptp((plate.points() - plate.rest())[plate.top], axis=0).max() < 1e-6
    plate.lift(-1.0)
    handle = deformer.handles[0]
    handle.vertex_group = ""
    bpy.ops.sinew.bind()
    update()
    assert deformer.status_level == "INFO", deformer.status
    assert len(Nearest.made[-1]) == len(plate.base) + 1
    place = np.array(handle.rest_matrix).reshape(4, 4, order="F")[:3, 3]
    assert np.abs(np.array(Nearest.made[-1]) - place).max(axis=1).min() < 1e-6
    plate.lift(1.0)
    assert heights() == [0.0, 1.0]
    deformer.handles.add().name = "New"
    plate.obj.update_tag()
    update()
    assert "New has no vertex group and no control" in deformer.status
    deformer.handles.remove(len(deformer.handles) - 1)
    plate.obj.update_tag()
    update()
    assert deformer.status_level == "INFO", deformer.status

@scene
def the_panel_draws_each_kind():
    draw_parameter, sheet = room("ui.parameters").draw_parameter, Sheet()
    for parameter in row.parameters:
        draw_parameter(DrawContext(), sheet, plate.deformer.parameters, parameter)
    bpy.ops.sinew.curve_edit(parameter="falloff")
    draw_parameter(DrawContext(), sheet, plate.deformer.parameters, falloff)
    drawn = [
        (name, *(word for word in words if isinstance(word, str)))
        for name, words, *_ in sheet.calls
        if name in ("label", "operator", "prop", "template_curve_mapping")
    ]
    assert drawn == [
        ("operator", "sinew.curve_edit"),
        ("operator", "sinew.curve_edit"),
        ("label",),
        ("prop", "frame"),
        ("label",),
        ("operator", "sinew.curve_edit"),
        ("template_curve_mapping", "mapping"),
    ], drawn
    try:
        bpy.ops.sinew.curve_edit(parameter="frame")
    except RuntimeError as error:
        assert "Throwaway has no curve 'frame' - its curves: profile, falloff" in str(error)
    else:
        assert False, "an object is no curve"
"""


@pytest.fixture(scope="module")
def scenes(room, addon_name: str, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """What went wrong in each scene, by its name; one new Blender plays them all."""
    folder = tmp_path_factory.mktemp("throwaway")
    module = Path(room("core.methods").__file__).with_name("throwaway.py")
    module.write_text(MODULE, encoding="utf-8")
    given = f"addon_name, folder = {addon_name!r}, {str(folder)!r}"
    try:
        return another_blender(f"{given}\n{SET_UP}\n{SCENES}", folder, addon_name)
    finally:
        module.unlink()


@pytest.mark.parametrize("scene", re.findall(r"@scene\ndef (\w+)", SCENES))
def test_with_new_kinds_of_parameter(scenes: dict[str, str], scene: str):
    assert not scenes[scene], scenes[scene]
