# SPDX-License-Identifier: GPL-3.0-or-later
"""Sinew Drag with methods that deform space: handles at the very place, without a region.

Nothing here names a method: each that handles move through space takes part.
"""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from inside import notes_of
from mathutils import Euler, Matrix, Vector
from registry import BY_ID, ON_HANDLE_POINTS
from rigs.point_objects import CURVES, MAKERS, moved_by_hand
from rigs.rig import (
    base_points,
    close,
    evaluated_points,
    grid_object,
    make_active,
    press,
    refused,
    update,
)
from seen import assert_seen, seen
from test_drag import LIFT, drag

MEETS = 2e-3  # of a plate 2 wide: what a cut-off or a smoothing may leave


@pytest.fixture(params=[name for name in ON_HANDLE_POINTS if not BY_ID[name].wraps])
def method(request: pytest.FixtureRequest) -> str:
    return request.param


def at(obj: bpy.types.Object, x: float, y: float) -> np.ndarray:
    """The shown place of a vertex that rests there."""
    index = int(np.argmin(np.linalg.norm(base_points(obj)[:, :2] - (x, y), axis=1)))
    return evaluated_points(obj)[index]


def names(obj: bpy.types.Object) -> list[str]:
    return [row.name for row in obj.sinew.active.handles]


def test_a_drag_makes_a_deformer_with_a_handle_at_the_place_and_the_next_one_takes_it(method: str):
    obj = grid_object(cells=20)
    control = drag(0.2, 0.3, method=method)
    (handle,) = obj.sinew.active.handles
    assert obj.sinew.active.method == method
    assert (handle.kind, handle.vertex_group, handle.control) == ("HANDLE", "", control)
    assert not obj.vertex_groups
    assert close(at(obj, 0.2, 0.3), np.array((0.2, 0.3, 0.5)), MEETS)
    assert np.array(control.matrix_world.translation) == pytest.approx((0.2, 0.3, 0.5), abs=1e-5)
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    assert "Hold Still" not in " ".join(notes_of(obj.sinew.active))  # a click holds such a handle
    assert drag(0.2, 0.3, value=(0.1, 0.0, 0.2), method=method) == control
    assert len(names(obj)) == 1
    assert close(at(obj, 0.2, 0.3), np.array((0.3, 0.3, 0.7)), MEETS)


def test_a_second_handle_changes_nothing_until_it_is_dragged(method: str):
    """It rests where the surface rests, and is posed as the surface is."""
    obj = grid_object(cells=20)
    drag(-0.5, 0.0, method=method)
    drag(0.7, 0.6, value=(0.0, 0.0, 0.0), method=method)
    before = evaluated_points(obj)
    drag(-0.3, 0.1, value=(0.0, 0.0, 0.0), radius=0.05)  # on the slope
    assert len(names(obj)) == 3
    if BY_ID[method].reproduces.value == "rest":  # the least change keeps what is met already
        assert close(evaluated_points(obj), before, MEETS)
    assert close(at(obj, -0.5, 0.0), np.array((-0.5, 0.0, 0.5)), MEETS)
    assert close(evaluated_points(obj), before, 0.05)


def test_a_mirrored_drag_moves_both_sides(method: str):
    obj = grid_object(cells=20)
    press(obj, "deformer_add", method=method)
    obj.sinew.active.use_mirror_x = True
    drag(0.5, 0.3, value=(0.1, 0.0, 0.4))
    assert sorted(names(obj)) == ["Point.L", "Point.R"]
    assert close(at(obj, 0.5, 0.3), np.array((0.6, 0.3, 0.4)), MEETS)
    assert close(at(obj, -0.5, 0.3), np.array((-0.6, 0.3, 0.4)), MEETS)
    drag(0.0, 0.8, value=(0.0, 0.0, 0.0))
    assert sorted(names(obj)) == ["Point", "Point.L", "Point.R"], "one on the plane of symmetry"


def test_a_turned_and_scaled_object_is_dragged_in_the_world(method: str):
    obj = grid_object(cells=20)
    obj.matrix_world = Matrix.LocRotScale((1.0, 2.0, 0.5), Euler((0.3, 0.2, 0.5)), (1.5, 0.8, 1.2))
    update()
    place = obj.matrix_world @ Vector((0.25, 0.35, 0.0))  # the middle of a face
    control = drag(place.x, place.y, method=method, value=LIFT)
    assert (control.matrix_world.translation - place - Vector(LIFT)).length < 1e-4
    near = np.linalg.norm(base_points(obj)[:, :2] - (0.25, 0.35), axis=1) < 0.08
    shown = obj.matrix_world @ Vector(evaluated_points(obj)[near].mean(axis=0))
    assert near.sum() == 4
    assert (shown - place - Vector(LIFT)).length < 0.02  # a face is curved a little


KINDS = [kind for kind in MAKERS if kind != "nurbs"]  # a NURBS curve does not pass through its points


def middle_of_a_face(obj: bpy.types.Object) -> np.ndarray | None:
    """One that looks up; None for an object without faces."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    if obj.type in ("CURVES", "POINTCLOUD", "LATTICE"):
        return None
    mesh = evaluated.to_mesh()
    places = [np.array(face.center) for face in mesh.polygons if face.normal.z > 0.5]
    evaluated.to_mesh_clear()
    return max(places, key=lambda place: place[2]) if places else None


@pytest.mark.parametrize("kind", KINDS)
def test_a_drag_takes_hold_of_curves_text_hair_and_clouds(kind: str):
    """On their surface, or at the point that is nearest to the line of sight, by a method that can do it."""
    obj = MAKERS[kind]()
    update()
    before = moved_by_hand(obj, lambda points: points)
    make_active(obj)
    place = middle_of_a_face(obj)
    place = before[np.argmax(before[:, 2])] if place is None else place
    control = drag(place[0], place[1])
    assert obj.sinew.active.method == "inverse_ffd"
    (handle,) = obj.sinew.active.handles
    assert handle.control == control
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    lifted = evaluated_points(obj) - before
    near = np.linalg.norm(before - place, axis=1)
    if kind in ("hair", "cloud", "lattice"):
        assert close(lifted[near < 1e-6], np.tile(LIFT, ((near < 1e-6).sum(), 1)), MEETS)
    # A curve moves by its points: a place half-way between two follows less.
    assert lifted[np.argmin(near), 2] > (0.2 if kind in CURVES else 0.3)
    assert np.abs(lifted).max() < 0.7
    assert drag(*control.matrix_world.translation[:2]) == control
    assert len(obj.sinew.active.handles) == 1


def test_a_surface_method_refuses_what_is_no_mesh():
    hair = MAKERS["hair"]()
    origin, before = (*evaluated_points(hair)[0][:2], 9.0), seen()
    refused("needs the surface of a mesh", "drag", origin=origin, value=LIFT, method="arap")
    assert_seen(before)
