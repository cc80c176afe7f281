# SPDX-License-Identifier: GPL-3.0-or-later
"""Every space method moves everything that has points: loose parts, curves, text, hair and point clouds.

Nothing here names a method. Each object follows a motion of the whole control: a rigid one where the method
promises that, else a translation by a control that reaches everything.
"""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from probe import render_points
from registry import BY_ID, METHODS, Control, Moved, Reproduced
from rigs.cages import ball
from rigs.kinds import BY_CONTROL
from rigs.point_objects import MAKERS, TESSELLATED, add, attach, moved_by_hand
from rigs.rig import (
    apply_matrix,
    base_points,
    evaluated_points,
    key,
    make_active,
    new_empty,
    press,
    some_motion,
    update,
)
from rigs.rig_of_curves import polyline

# What handles move while all else stays has a test of its own: in test_drag_tool.
ON_POINTS = [
    method.id
    for method in METHODS
    if method.is_space
    and Moved.POINTS in method.moves
    and not (method.control is Control.HANDLES and method.reproduces is Reproduced.REST)
]
FAR = 20.0  # beyond everything here
# Weights in single precision and float32 places, for motions as long as the objects are.
ROUNDED = 3e-5


def loose_parts() -> bpy.types.Object:
    """Two balls and a vertex that no face holds."""
    obj, other = ball("Parts", 1), ball("Other", 1)
    points = np.concatenate(
        (0.3 * base_points(obj), 0.2 * base_points(other) + (0.6, 0.1, 0.0), [(0, 0, 0.7)])
    )
    count = len(obj.data.vertices)
    faces = [tuple(face.vertices) for face in obj.data.polygons]
    faces += [tuple(count + index for index in face.vertices) for face in other.data.polygons]
    mesh = bpy.data.meshes.new("Parts")
    mesh.from_pydata(points.tolist(), [], faces)
    obj.data = mesh
    bpy.data.objects.remove(other)
    make_active(obj)
    return obj


TARGETS = {**MAKERS, "loose_parts": loose_parts}


def by_handles(obj: bpy.types.Object, method: str) -> list[bpy.types.Object]:
    points = evaluated_points(obj)
    places = points[np.unique([*points.argmin(axis=0), *points.argmax(axis=0)])]  # nothing is far outside
    empties = [new_empty(f"Point {number}", place) for number, place in enumerate(places)]
    deformer = add(obj, *empties, source="SELECTED", method=method)
    assert [handle.control for handle in deformer.handles] == empties
    assert obj.type == "LATTICE" or not obj.vertex_groups
    return empties


def by_cage(obj: bpy.types.Object, method: str) -> list[bpy.types.Object]:
    return [attach(obj, method)]


def by_lattice(obj: bpy.types.Object, method: str) -> list[bpy.types.Object]:
    press(obj, "lattice_add")
    lattice = obj.sinew.active.controls[0].object
    lattice.parent = None
    return [lattice]


def by_curves(obj: bpy.types.Object, method: str) -> list[bpy.types.Object]:
    wire = polyline(np.array([(-1.0, 0.0, 0.0), (0.0, 0.2, 0.0), (1.0, 0.0, 0.0)]))
    press(obj, "wire_add", curve=wire.name, radius=1e4 * FAR)
    return [wire]


def by_tools(obj: bpy.types.Object, method: str) -> list[bpy.types.Object]:
    tool = new_empty("Tool")
    press(obj, "tool_add", control=tool.name, outer=FAR)
    obj.sinew.active.controls[0].inner = 0.5 * FAR
    return [tool]


ADDED = {
    Control.HANDLES: by_handles,
    Control.CAGE: by_cage,
    Control.LATTICE: by_lattice,
    Control.CURVES: by_curves,
    Control.TOOLS: by_tools,
}


def motion_for(method: str) -> Matrix:
    """What the method carries over from its controls to what they move."""
    row = BY_ID[method]
    if row.control in (Control.CAGE, Control.LATTICE):
        return BY_CONTROL[row.control].carries
    is_rigid = row.reproduces not in (Reproduced.REST, Reproduced.TRANSLATIONS)
    return some_motion() if is_rigid else Matrix.Translation((0.4, -0.2, 0.7))


def key_place(control: bpy.types.Object, frame: int) -> None:
    names = ("location", "rotation_euler", "scale")
    key(control, {frame: {name: getattr(control, name).copy() for name in names}})


def close(seen: np.ndarray, expected: np.ndarray) -> bool:
    tolerance = (TESSELLATED + ROUNDED) * max(1.0, float(np.abs(expected).max()))
    return seen.shape == expected.shape and bool(np.abs(seen - expected).max() < tolerance)


@pytest.mark.parametrize("kind", TARGETS)
@pytest.mark.parametrize("method", ON_POINTS)
def test_every_space_method_moves_everything_in_viewports_and_renders(kind: str, method: str):
    obj = TARGETS[kind]()
    update()
    controls = ADDED[BY_ID[method].control](obj, method)
    assert obj.sinew.active.method == method
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    rest = moved_by_hand(obj, lambda points: points)
    assert close(evaluated_points(obj), rest)
    motion = motion_for(method)
    expected = moved_by_hand(obj, lambda points: apply_matrix(motion, points))
    make_active(obj)
    for control in controls:
        key_place(control, 1)
        control.matrix_world = motion @ control.matrix_world
        key_place(control, 11)
    for frame, shape in ((11, expected), (1, rest), (11, expected)):
        bpy.context.scene.frame_set(frame)
        assert close(evaluated_points(obj), shape), frame
        assert close(render_points(obj), shape), frame
