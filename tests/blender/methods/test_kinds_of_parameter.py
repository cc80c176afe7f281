# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows that only this file knows: with curves, with objects, around another method, on handle points.

A new Blender finds them as one more module of the registry's folder. Their native classes tell by the shape
which values arrived.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from second_blender import another_blender

MODULE = """
from .schema import Control, Curve, Family, Method, Moved, Pointer, factorising

ROWS = (
    Method(
        id="throwaway",
        number=999,
        label="Throwaway",
        family=Family.MULTIRESOLUTION,
        control=Control.HANDLES,
        native="Throwaway",
        section="1",
        paper="none",
        summary="Adds its parameters to the shape",
        iterative=False,
        moves=frozenset({Moved.MESH}),
        bind_seconds=factorising(0.01),
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
    Method(
        id="around",
        number=998,
        label="Around",
        family=Family.MULTIRESOLUTION,
        control=Control.HANDLES,
        native="Around",
        section="1",
        paper="none",
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
        native="Nearest",
        section="1",
        paper="none",
        summary="Each point moves with the nearest point of a handle",
        iterative=False,
        moves=frozenset(Moved),
        bind_seconds=factorising(0.01),
    ),
)
"""

SET_UP = """
import importlib, bpy, numpy as np
from mathutils import Matrix
from rigs.rig import Rig, make_active, update

room = lambda path: importlib.import_module(f"{addon_name}.{path}")
native, housekeeping = room("backend").availability().module, room("session.actions.housekeeping")

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
    def __init__(self, points, weights):
        assert weights is None, "all are held fully"
        self.rest = points.copy()
        Nearest.made.append(points.tolist())
    def can_reuse(self, former, points):
        return False
    def bind(self, points, progress):
        self.points = points
        self.nearest = np.argmin(np.linalg.norm(points[:, None] - self.rest, axis=2), axis=1)
    def warp(self, posed, out=None, incoming=None):
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
    tell(seen.setdefault(tell.__name__, {}))
"""

SCENES = """
@scene
def a_default_curve_is_its_points(seen):
    seen["profile"] = Throwaway.built[-1].tolist()
    seen["falloff"] = Throwaway.solved[-1][0].tolist()
    seen["frame"] = Throwaway.solved[-1][1]
    seen["moved"] = moved().tolist()
    seen["trees"] = len([tree for tree in bpy.data.node_groups if "sinew_curve" in tree])

@scene
def a_drawn_curve_reaches_constructor_and_solve(seen):
    bpy.ops.sinew.curve_edit(parameter="falloff")
    solved = len(Throwaway.solved)
    update()
    seen["same"] = len(Throwaway.solved) == solved
    draw(falloff, (0.5, 0.25))
    seen["falloff"] = Throwaway.solved[-1][0].tolist()
    seen["moved"] = moved().tolist()
    built = len(Throwaway.built)
    bpy.ops.sinew.curve_edit(parameter="profile")
    update()
    plate.deformer.parameters.profile.nodes[0].mapping.curves[0].points.new(0.5, 0.75)
    draw(profile, (0.5, 0.75))
    seen["built"] = len(Throwaway.built) - built
    seen["profile"] = Throwaway.built[-1].tolist()
    bpy.ops.sinew.curve_edit(parameter="falloff", reset=True)
    update()
    seen["reset"] = Throwaway.solved[-1][0].tolist()

@scene
def an_object_gives_its_frame_hidden_too(seen):
    other = bpy.data.objects.new("Other", None)
    bpy.context.scene.collection.objects.link(other)
    plate.obj.location = 1.0, 2.0, 3.0
    other.location = 1.5, 2.0, 3.0
    plate.deformer.parameters.frame = other
    update()
    seen["frame"] = Throwaway.solved[-1][1].tolist()
    seen["moved"] = moved().tolist()
    other.hide_viewport = True
    housekeeping.tidy()
    update()
    other.location.x = 1.25
    update()
    seen["hidden"] = moved().tolist()
    solved = len(Throwaway.solved)
    update()
    seen["same"] = len(Throwaway.solved) == solved
    bpy.data.objects.remove(other)
    update()
    seen["gone"] = Throwaway.solved[-1][1]

@scene
def curves_are_saved_and_belong_to_one_deformer(seen):
    bpy.ops.sinew.curve_edit(parameter="falloff")
    draw(falloff, (0.5, 0.25))
    path = f"{folder}/curve.blend"
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    seen["loaded"] = moved().tolist()
    make_active(plate.obj)
    bpy.ops.object.duplicate()
    housekeeping.tidy()
    update()
    copy = bpy.context.object
    trees = [obj.sinew.active.parameters.falloff for obj in (plate.obj, copy)]
    seen["apart"] = trees[0] != trees[1]
    draw(falloff, (0.5, 0.75))
    seen["original"] = moved().tolist()
    name, plate.name = plate.name, copy.name
    seen["copy"] = moved().tolist()
    plate.name = name
    for obj in (plate.obj, copy):
        make_active(obj)
        bpy.ops.sinew.deformer_remove()
    seen["left"] = [tree.name for tree in bpy.data.node_groups if "sinew_curve" in tree]

@scene
def a_method_is_put_around_another(seen):
    deformer = plate.deformer
    deformer.method = "around"
    items = deformer.around.bl_rna.properties["base"].enum_items
    seen["offered"] = [item.identifier for item in items]
    methods = room("core.methods")
    wrapped = methods.BY_ID["around"].wraps
    seen["wrapped"] = [
        method.id for method in methods.METHODS if method.family in wrapped and not method.keyed
    ]
    deformer.around.base = "thin_shell"
    update()
    seen["moved"] = moved().tolist()
    made = len(Around.bases)
    deformer.thin_shell.laplacian = "uniform"
    update()
    seen["again"] = len(Around.bases) > made
    deformer.around.base = "arap"
    deformer.arap.max_iterations = 3
    update()
    seen["bases"] = list(dict.fromkeys(Around.bases))
    seen["iterative"] = deformer.is_iterative
    seen["status"] = deformer.status_level

@scene
def a_space_method_gets_the_points_of_handles_with_and_without_a_group(seen):
    deformer = plate.deformer
    deformer.method = "nearest"
    update()
    seen["status"] = deformer.status_level
    seen["given"] = sorted(Nearest.made[-1]) == sorted(plate.rest()[[*plate.top, *plate.base]].tolist())
    plate.lift(1.0)
    seen["lifted"] = sorted(set((plate.points() - plate.rest())[:, 2].round(6).tolist()))
    seen["held"] = np.ptp((plate.points() - plate.rest())[plate.top], axis=0).max()
    plate.lift(-1.0)
    handle = deformer.handles[0]
    handle.vertex_group = ""
    bpy.ops.sinew.bind()
    update()
    seen["alone"] = (deformer.status_level, len(Nearest.made[-1]) - len(plate.base))
    place = np.array(handle.rest_matrix).reshape(4, 4, order="F")[:3, 3]
    seen["place"] = np.abs(np.array(Nearest.made[-1]) - place).max(axis=1).min()
    plate.lift(1.0)
    seen["again"] = sorted(set((plate.points() - plate.rest())[:, 2].round(6).tolist()))
    deformer.handles.add().name = "New"
    plate.obj.update_tag()
    update()
    seen["refused"] = deformer.status
    deformer.handles.remove(len(deformer.handles) - 1)
    plate.obj.update_tag()
    update()
    seen["mended"] = deformer.status_level

@scene
def the_panel_draws_each_kind(seen):
    drawn = []
    class Layout:
        def row(self, **options):
            return self
        def __getattr__(self, name):
            def draw(*arguments, **options):
                drawn.append((name, *(argument for argument in arguments if isinstance(argument, str))))
                return self
            return draw
    draw_parameter = room("ui.parameters").draw_parameter
    for parameter in row.parameters:
        draw_parameter(Layout(), plate.deformer.parameters, parameter)
    bpy.ops.sinew.curve_edit(parameter="falloff")
    draw_parameter(Layout(), plate.deformer.parameters, falloff)
    seen["drawn"] = drawn
    try:
        bpy.ops.sinew.curve_edit(parameter="frame")
    except RuntimeError as error:
        seen["refused"] = str(error)
"""


@pytest.fixture(scope="module")
def scenes(room, addon_name: str, tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What the scenes tell, by their names; one new Blender shows them all."""
    folder = tmp_path_factory.mktemp("throwaway")
    module = Path(room("core.methods").__file__).with_name("throwaway.py")
    module.write_text(MODULE, encoding="utf-8")
    given = f"addon_name, folder = {addon_name!r}, {str(folder)!r}"
    try:
        return another_blender(f"{given}\n{SET_UP}\n{SCENES}", folder, addon_name)
    finally:
        module.unlink()


@pytest.fixture
def seen(scenes: dict, request: pytest.FixtureRequest) -> dict:
    """What the scene of this test told."""
    return scenes[request.node.name.removeprefix("test_")]


def test_a_default_curve_is_its_points(seen: dict):
    assert seen["profile"] == [0.0, 0.5, 1.0]
    assert seen["falloff"] == [0.0, 0.5, 1.0, 0.5, 0.0]
    assert seen["frame"] is None
    assert seen["moved"] == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)
    assert seen["trees"] == 0


def test_a_drawn_curve_reaches_constructor_and_solve(seen: dict):
    assert seen["same"]
    assert seen["falloff"] == pytest.approx([0.0, 0.125, 0.25, 0.125, 0.0], abs=1e-6)
    assert seen["moved"] == pytest.approx([0.0, 0.0, 0.25], abs=1e-6)
    assert seen["built"] >= 1
    assert seen["profile"] == pytest.approx([0.0, 0.75, 1.0], abs=1e-6)
    assert seen["reset"] == [0.0, 0.5, 1.0, 0.5, 0.0]


def test_an_object_gives_its_frame_hidden_too(seen: dict):
    assert np.allclose(seen["frame"], [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0]], atol=1e-6)
    assert seen["moved"] == pytest.approx([0.5, 0.0, 1.0], abs=1e-6)
    assert seen["hidden"] == pytest.approx([0.25, 0.0, 1.0], abs=1e-6)
    assert seen["same"]
    assert seen["gone"] is None


def test_curves_are_saved_and_belong_to_one_deformer(seen: dict):
    assert seen["loaded"] == pytest.approx([0.0, 0.0, 0.25], abs=1e-6)
    assert seen["apart"]
    assert seen["original"] == pytest.approx([0.0, 0.0, 0.75], abs=1e-6)
    assert seen["copy"] == pytest.approx([0.0, 0.0, 0.25], abs=1e-6)
    assert seen["left"] == []


def test_a_method_is_put_around_another(seen: dict):
    assert len(seen["wrapped"]) > 1
    assert set(seen["offered"]) == set(seen["wrapped"])
    assert not set(seen["offered"]) & {"green", "around", "throwaway"}
    assert seen["moved"] == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)
    assert seen["again"]
    assert seen["bases"] == ["ThinShell", "Arap"]
    assert seen["iterative"]
    assert seen["status"] == "INFO"


def test_a_space_method_gets_the_points_of_handles_with_and_without_a_group(seen: dict):
    assert seen["status"] == "INFO"
    assert seen["given"]
    assert seen["lifted"] == [0.0, 1.0]
    assert seen["held"] < 1e-6
    assert seen["alone"] == ["INFO", 1]
    assert seen["place"] < 1e-6
    assert seen["again"] == [0.0, 1.0]
    assert "New has no vertex group and no control" in seen["refused"]
    assert seen["mended"] == "INFO"


def test_the_panel_draws_each_kind(seen: dict):
    assert seen["drawn"] == [
        ["operator", "sinew.curve_edit"],
        ["operator", "sinew.curve_edit"],
        ["prop", "frame"],
        ["label"],
        ["operator", "sinew.curve_edit"],
        ["template_curve_mapping", "mapping"],
    ]
    assert "Throwaway has no curve 'frame' - its curves: profile, falloff" in seen["refused"]
