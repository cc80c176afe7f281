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
from rigs import rig as scenes
from rigs.cages import ball
from rigs.kinds import BY_CONTROL
from rigs.point_objects import MAKERS, TESSELLATED, add, attach, moved_by_hand
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
    obj, other = ball("Parts", 1, 0.3), ball("Other", 1, 0.2)
    other.data.transform(Matrix.Translation((0.6, 0.1, 0.0)))
    scenes.make_active(obj, other)
    bpy.ops.object.join()
    obj.data.vertices.add(1)
    obj.data.vertices[-1].co.z = 0.7
    return obj


TARGETS = {**MAKERS, "loose_parts": loose_parts}


def by_handles(obj: bpy.types.Object, method: str) -> list[bpy.types.Object]:
    points = scenes.evaluated_points(obj)
    places = points[np.unique([*points.argmin(axis=0), *points.argmax(axis=0)])]  # nothing is far outside
    empties = [scenes.new_empty(f"Point {number}", place) for number, place in enumerate(places)]
    deformer = add(obj, *empties, source="SELECTED", method=method)
    assert [handle.control for handle in deformer.handles] == empties
    assert obj.type == "LATTICE" or not obj.vertex_groups
    return empties


def by_lattice(obj: bpy.types.Object, method: str) -> list[bpy.types.Object]:
    scenes.press(obj, "lattice_add")
    lattice = obj.sinew.active.controls[0].object
    lattice.parent = None
    return [lattice]


def by_wire(obj: bpy.types.Object, method: str) -> list[bpy.types.Object]:
    wire = polyline(np.array([(-1.0, 0.0, 0.0), (0.0, 0.2, 0.0), (1.0, 0.0, 0.0)]))
    scenes.press(obj, "wire_add", curve=wire.name, radius=1e4 * FAR)
    return [wire]


def by_tool(obj: bpy.types.Object, method: str) -> list[bpy.types.Object]:
    tool = scenes.new_empty("Tool")
    scenes.press(obj, "tool_add", control=tool.name, outer=FAR)
    obj.sinew.active.controls[0].inner = 0.5 * FAR
    return [tool]


ADDED = {
    Control.HANDLES: by_handles,
    Control.CAGE: lambda obj, method: [attach(obj, method)],
    Control.LATTICE: by_lattice,
    Control.CURVES: by_wire,
    Control.TOOLS: by_tool,
}


def motion_for(method: str) -> Matrix:
    """What the method carries over from its controls to what they move."""
    row = BY_ID[method]
    if row.control in (Control.CAGE, Control.LATTICE):
        return BY_CONTROL[row.control].carries
    is_rigid = row.reproduces not in (Reproduced.REST, Reproduced.TRANSLATIONS)
    return scenes.some_motion() if is_rigid else Matrix.Translation((0.4, -0.2, 0.7))


def close(seen: np.ndarray, expected: np.ndarray) -> bool:
    return scenes.close(seen, expected, (TESSELLATED + ROUNDED) * max(1.0, float(np.abs(expected).max())))


@pytest.mark.parametrize("kind", TARGETS)
@pytest.mark.parametrize("method", ON_POINTS)
def test_every_space_method_moves_everything_in_viewports_and_renders(kind: str, method: str):
    obj = TARGETS[kind]()
    scenes.update()
    controls = ADDED[BY_ID[method].control](obj, method)
    assert obj.sinew.active.method == method
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    rest, motion = moved_by_hand(obj, lambda points: points), motion_for(method)
    assert close(scenes.evaluated_points(obj), rest)
    expected = moved_by_hand(obj, lambda points: scenes.apply_matrix(motion, points))
    scenes.make_active(obj)
    for control in controls:
        for frame, pose in ((1, Matrix.Identity(4)), (11, motion)):
            control.matrix_world = pose @ control.matrix_world
            for name in ("location", "rotation_euler", "scale"):
                control.keyframe_insert(name, frame=frame)
    for frame, shape in ((11, expected), (1, rest), (11, expected)):
        bpy.context.scene.frame_set(frame)
        assert close(scenes.evaluated_points(obj), shape), frame
        assert close(render_points(obj), shape), frame
