# SPDX-License-Identifier: GPL-3.0-or-later
"""Whatever poses the points of a control moves the target: keys, hooks, bones, modifiers, Edit Mode, cloth.

The shape is that of a new native object for the points that Blender shows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import bpy
import numpy as np
import pytest
from expected import Expected
from mathutils import Matrix
from probe import render_points
from rigs import rig as scenes
from rigs.cages import ball, box, mean_value, surround
from rigs.point_objects import add
from rigs.rig_of_lattice import WITH_LATTICE, by_lattice, lattice_object, lattice_points, small_ball
from test_control_grid import METHOD, SIDE, new_grid
from test_points_of_objects import CORNERS, in_target, warped
from test_wires import curve, expected as by_wires, wired

DRAWN = 2e-5  # Blender sums its curves up in float32, a dozen steps per segment
Solve = Callable[[np.ndarray, np.ndarray], np.ndarray]  # takes the points at rest and now, to the shape
Posable = tuple[bpy.types.Object, bpy.types.Object, Solve]


def in_a_cage() -> Posable:
    target, control = ball(), box()
    surround(target, control)
    coordinates = mean_value(control, scenes.base_points(target))
    return target, control, lambda _rest, posed: coordinates.warp(posed)


def in_a_lattice() -> Posable:
    target, control = small_ball(levels=2), lattice_object((3, 3, 3))
    scenes.press(target, "lattice_add", source="OBJECT", lattice=control.name)
    made = by_lattice(target, control, lattice_points(control), WITH_LATTICE[0]).native
    return target, control, lambda _rest, posed: made.warp(posed)


def with_a_wire(kind: str) -> Callable[[], Posable]:
    def make() -> Posable:
        control = curve(kind)
        target = wired(control)
        return target, control, lambda rest, posed: by_wires(scenes.base_points(target), (rest, posed))

    return make


def with_points(method: str) -> Callable[[], Posable]:
    def make() -> Posable:
        target, control = scenes.grid_object(), scenes.new_object("Points", CORNERS, [(0, 1, 2, 3)])
        add(target, control, method=method)
        return target, control, lambda rest, posed: warped(method, rest, posed, scenes.base_points(target))

    return make


def with_a_grid() -> Posable:
    rig = scenes.Rig.plate(cells=20).bind(METHOD)
    rig.deformer.parameters.columns = rig.deformer.parameters.rows = SIDE

    def solve(rest: np.ndarray, posed: np.ndarray) -> np.ndarray:
        return Expected.of_rig(rig, METHOD, columns=SIDE, rows=SIDE, grid=posed - rest).lifted(0.0)

    return rig.obj, new_grid(rig), solve


POINTS = {f"points, {method}": with_points(method) for method in ("rbf", "mls", "space_propagation")}
WIRES = {f"wire, {kind}": with_a_wire(kind) for kind in ("BEZIER", "NURBS", "POLY")}
CONTROLS = {"cage": in_a_cage, "lattice": in_a_lattice, "grid": with_a_grid, **WIRES, **POINTS}


# The ways. Each stops where one may look, with the points of the control in the space of the target.


def up(control: bpy.types.Object) -> bpy.types.ShapeKey:
    """A key that lifts the points, those ahead more."""
    block = scenes.add_key(control, "Up", Matrix.Translation((0.0, 0.1, 0.4)) @ scenes.slope(0.3, 0.2))
    block.value = 0.8
    return block


def shape_key(target: bpy.types.Object, control: bpy.types.Object) -> Iterator[np.ndarray]:
    """Also where nobody sees it."""
    up(control)
    yield (posed := in_target(target, control))
    control.hide_viewport = True
    yield posed


def keyframes(target: bpy.types.Object, control: bpy.types.Object) -> Iterator[np.ndarray]:
    scenes.key(up(control), {1: {"value": 0.0}, 11: {"value": 1.0}})
    for frame in (11, 6, 1):
        bpy.context.scene.frame_set(frame)
        yield in_target(target, control)


def hook(target: bpy.types.Object, control: bpy.types.Object) -> Iterator[np.ndarray]:
    modifier = control.modifiers.new("Hook", "HOOK")
    modifier.object, modifier.falloff_type = scenes.new_empty("Hook"), "NONE"
    modifier.vertex_indices_set([0, 1, 2, 3])
    modifier.object.location.z = 0.5
    yield in_target(target, control)


def edit_mode(target: bpy.types.Object, control: bpy.types.Object) -> Iterator[np.ndarray]:
    """While it lasts, and afterwards."""
    kind = {"CURVE": bpy.ops.curve, "LATTICE": bpy.ops.lattice}.get(control.type, bpy.ops.mesh)
    with scenes.in_mode(control):
        kind.select_all(action="DESELECT")
        kind.select_random(ratio=0.5, seed=1)  # a grid that moves as a whole would move nothing
        bpy.ops.transform.resize(value=(1.0, 1.2, 1.3))
        bpy.ops.transform.translate(value=(0.0, 0.0, 0.3))
        yield in_target(target, control)
    yield in_target(target, control)


def its_object(target: bpy.types.Object, control: bpy.types.Object) -> Iterator[np.ndarray]:
    """The target is elsewhere, too."""
    target.location, target.rotation_euler.z = (0.3, 0.0, 0.1), 0.4
    scenes.move_world(control, Matrix.Translation((0.1, 0.0, 0.4)) @ Matrix.Rotation(0.4, 4, (0.6, 0.0, 0.8)))
    yield in_target(target, control)


def bone(target: bpy.types.Object, control: bpy.types.Object) -> Iterator[np.ndarray]:
    high = scenes.add_armature(control).pose.bones["high"]
    high.rotation_euler.x, high.location.x = 0.4, 0.5
    yield in_target(target, control)


def simple_deform(target: bpy.types.Object, control: bpy.types.Object) -> Iterator[np.ndarray]:
    modifier = control.modifiers.new("Bend", "SIMPLE_DEFORM")
    modifier.deform_method, modifier.deform_axis, modifier.angle = "BEND", "Z", 0.8
    yield in_target(target, control)


def cloth(target: bpy.types.Object, control: bpy.types.Object) -> Iterator[np.ndarray]:
    control.modifiers.new("Cloth", "CLOTH")
    for frame in range(1, 6):
        bpy.context.scene.frame_set(frame)
    yield in_target(target, control)


MESHES = ("cage", "grid", *POINTS)
WAYS = {
    **dict.fromkeys((shape_key, keyframes, hook, edit_mode), tuple(CONTROLS)),
    its_object: tuple(kind for kind in CONTROLS if kind != "grid"),  # where that stands does not count
    **dict.fromkeys((bone, simple_deform), MESHES),
    cloth: tuple(POINTS),
}


@pytest.mark.parametrize(
    ("kind", "way"),
    [pytest.param(kind, way, id=f"{kind}-{way.__name__}") for way, kinds in WAYS.items() for kind in kinds],
)
def test_what_poses_the_points_of_a_control_moves_the_target(kind: str, way: Callable):
    target, control, solve = CONTROLS[kind]()
    scenes.update()
    rest, moved = in_target(target, control), 0.0
    assert scenes.close(scenes.evaluated_points(target), scenes.base_points(target))
    for posed in way(target, control):
        expected = solve(rest, posed)
        moved = max(moved, np.abs(expected - scenes.base_points(target)).max())
        assert scenes.close(scenes.evaluated_points(target), expected, DRAWN)
        assert control.mode == "EDIT" or scenes.close(render_points(target), expected, DRAWN)
    assert moved > 0.05
    assert target.sinew.active.status_level == "INFO", target.sinew.active.status
