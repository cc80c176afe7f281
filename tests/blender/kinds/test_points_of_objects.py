# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles that act as all points of an object, as the edges between them, or as a bone from head to tail."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from inside import native
from mathutils import Matrix
from probe import render_points
from registry import BY_ID, RIGID_ON_HANDLE_POINTS, Reproduced
from rigs.point_objects import MAKERS, add, add_bones, moved_by_hand
from rigs.rig import (
    FLOAT32,
    apply_matrix,
    base_points,
    close,
    coordinates,
    evaluated_points,
    grid_object,
    make_active,
    move_world,
    new_armature,
    new_empty,
    new_object,
    press,
    refused,
    some_motion,
    update,
)
from rigs.rig_of_lattice import lattice_object
from rigs.sheet import draw

# The weights are kept in single precision, and a segment is a quadrature of eight places on either side.
QUADRATURE = 1e-4
TRANSLATED = [name for name in RIGID_ON_HANDLE_POINTS if BY_ID[name].reproduces is Reproduced.TRANSLATIONS]
MOVES_ONLY = ("space_propagation", *TRANSLATED)  # it fits nothing, and a single point has no turn to spread
CORNERS = [(-1.0, -1.0, 0.2), (1.0, -1.0, 0.0), (1.0, 1.0, -0.3), (-1.0, 1.0, 0.4)]


def in_target(obj: bpy.types.Object, other: bpy.types.Object) -> np.ndarray:
    """The points that Blender shows of another object, in the space of the target."""
    shown = evaluated_points(other)
    return apply_matrix(np.linalg.inv(np.array(obj.matrix_world)) @ np.array(other.matrix_world), shown)


def warped(method: str, rest: np.ndarray, posed: np.ndarray, points: np.ndarray, **options) -> np.ndarray:
    made = getattr(native(), BY_ID[method].native)(rest, **options)
    made.bind(points)
    return made.warp(posed)


def frame(name: str = "Frame") -> bpy.types.Object:
    """Four vertices and three edges, which can bend as no affine map does."""
    return new_object(name, CORNERS, edges=[(0, 1), (1, 2), (2, 3)])


def by_segments(ends: np.ndarray, posed: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Moving least squares of segments (s, 2, 3)."""
    pairs = np.arange(2 * len(ends)).reshape(-1, 2).tolist()
    flat = ends.reshape(-1, 3), posed.reshape(-1, 3)
    return warped("mls", *flat, points, alpha=1.0, segments=pairs)


def heads_and_tails(armature: bpy.types.Object) -> np.ndarray:
    update()
    posed = armature.evaluated_get(bpy.context.evaluated_depsgraph_get()).pose.bones
    world = np.array(armature.matrix_world)
    return np.array([apply_matrix(world, np.array((bone.head, bone.tail))) for bone in posed])


def skeleton() -> bpy.types.Object:
    """Two bones in a row and one aside; none of them lies in the plate."""
    return new_armature(
        Low=((-0.8, -0.9, 0.3), (-0.2, 0.0, 0.3)),
        High=((-0.2, 0.0, 0.3), (0.1, 0.9, 0.4)),
        Aside=((0.8, -0.5, -0.3), (0.8, 0.5, -0.3)),
    )


@pytest.mark.parametrize("kind", ["plate", "bezier", "text", "hair"])
def test_bones_act_from_head_to_tail(kind: str):
    obj, armature = grid_object() if kind == "plate" else MAKERS[kind](), skeleton()
    before = moved_by_hand(obj, lambda points: points)
    deformer = add_bones(obj, armature, method="mls", segments=True)
    deformer.parameters.alpha = 1.0
    assert [handle.acts_as for handle in deformer.handles] == ["SEGMENTS"] * 3
    assert close(evaluated_points(obj), before, QUADRATURE)
    ends = heads_and_tails(armature)
    low, high, _aside = armature.pose.bones
    low.rotation_euler, high.rotation_euler = (0.4, 0.2, -0.5), (-0.7, 0.0, 0.3)
    high.scale = 1.0, 1.3, 1.0
    posed = heads_and_tails(armature)
    assert np.abs(posed - ends).max() > 0.3
    expected = moved_by_hand(obj, lambda points: by_segments(ends, posed, points))
    for shown in (evaluated_points(obj), render_points(obj)):
        assert close(shown, expected, QUADRATURE)
    for handle in deformer.handles:  # a switch of each handle
        handle.acts_as = "PLACE"
    assert np.abs(evaluated_points(obj) - expected).max() > 0.02, "bones turn the space at their heads"


def test_edges_of_an_object_act_as_segments():
    """Points that no edge joins stay points among them."""
    plate, edges = grid_object(), new_object("Mixed", [*CORNERS, (0.0, 0.0, 0.5)], edges=[(0, 1), (2, 3)])
    edges.location.z = 0.1
    deformer = add(plate, edges, method="mls", segments=True)
    deformer.parameters.alpha = 1.0
    at_rest, rest = base_points(plate), in_target(plate, edges)
    edges.data.vertices[4].co.z, edges.data.vertices[2].co = 1.0, (1.4, 0.8, 0.6)
    edges.rotation_euler.x = 0.3
    posed, options = in_target(plate, edges), {"alpha": 1.0, "segments": [(0, 1), (2, 3)]}
    assert close(evaluated_points(plate), warped("mls", rest, posed, at_rest, **options), 1e-5)
    deformer.handles[0].acts_as = "POINTS"
    make_active(plate)
    assert close(evaluated_points(plate), warped("mls", rest, posed, at_rest, alpha=1.0), 1e-5)


def test_points_and_lines_of_a_lattice_as_its_modifiers_move_them():
    plate, lattice, empty = grid_object(), lattice_object((3, 2, 2), "Points"), new_empty("Hook")
    lattice.location = 0.05, 0.03, 0.17
    hook = lattice.modifiers.new("Hook", "HOOK")
    hook.object = empty
    hook.vertex_indices_set([0, 1, 11])
    update()
    deformer = add(plate, lattice, method="mls")
    deformer.parameters.alpha = 1.0
    at_rest, rest = base_points(plate), in_target(plate, lattice)
    empty.location.z = 0.4
    update()
    posed = in_target(plate, lattice)
    assert (np.abs(posed - rest).max(axis=1) > 0.1).sum() == 3
    expected = warped("mls", rest, posed, at_rest, alpha=1.0)
    assert close(evaluated_points(plate), expected, 1e-5)
    assert close(render_points(plate), expected, 1e-5)
    deformer.handles[0].acts_as = "SEGMENTS"
    empty.location.z = 0.0
    press(plate, "bind")
    empty.location.z = 0.4
    update()
    grid = coordinates(lattice.data.points, "co_deform")  # a unit apart
    pairs = np.argwhere(np.triu(np.abs(np.linalg.norm(grid[:, None] - grid, axis=2) - 1.0) < 1e-5))
    assert len(pairs) == 20
    assert close(evaluated_points(plate), by_segments(rest[pairs], posed[pairs], at_rest), QUADRATURE)


@pytest.mark.parametrize("method", RIGID_ON_HANDLE_POINTS)
@pytest.mark.parametrize("segments", [False, True])
def test_points_together_carry_a_plate_rigidly(method: str, segments: bool):
    """Whatever the method fits to them; some give single points the turn of the edges at them."""
    if segments and not BY_ID[method].takes_segments:
        pytest.skip("it takes no segments")
    plate, points = grid_object(), frame()
    press(plate, "deformer_add", method=method)
    add(plate, points, segments=segments)
    before = base_points(plate)
    assert close(evaluated_points(plate), before, 1e-6)
    motion = Matrix.Translation((0.4, -0.2, 0.7)) if method in MOVES_ONLY else some_motion()
    move_world(points, motion)
    assert close(evaluated_points(plate), apply_matrix(motion, before), 2e-5)


@pytest.mark.parametrize("method", ["embedded_deformation", "rigid_cells"])
def test_single_points_turn_with_the_edges_at_them(method: str):
    """Half of a ladder of points turns: so does what is around its end, also off the ladder."""
    plate = grid_object(cells=20)
    places = [(x, y, 0.0) for x in np.linspace(-1.0, 1.0, 11) for y in (-0.1, 0.1)]
    edges = [(i, i + 2) for i in range(20)] + [(i, i + 1) for i in range(0, 22, 2)]
    ladder = new_object("Ladder", places, edges=edges)
    add(plate, ladder, method=method)
    turn = Matrix.Rotation(0.8, 4, "Y")
    for vertex in ladder.data.vertices:
        if vertex.co.x > 0.3:
            vertex.co = turn @ vertex.co
    ladder.data.update()
    rest, shown = base_points(plate), evaluated_points(plate)
    end = (rest[:, 0] > 0.85) & (np.abs(rest[:, 1]) < 0.35)
    assert close(shown[end], apply_matrix(turn, rest[end]), 0.03)


OTHERS = {  # points of other types, and more of them than empties are made for
    "cloud": (MAKERS["cloud"], "points"),
    "hair": (MAKERS["hair"], "points"),
    "many": (lambda: grid_object("Points", cells=40), "1,681 points"),
}


@pytest.mark.parametrize("kind", OTHERS)
def test_points_of_other_types_move_a_mesh(kind: str):
    points, plate = OTHERS[kind][0](), grid_object()
    deformer = add(plate, points, method="mls")
    assert OTHERS[kind][1] in deformer.status
    assert len(deformer.handles) == 1
    move_world(points, some_motion())
    assert close(evaluated_points(plate), apply_matrix(some_motion(), base_points(plate)), 2e-5)


def test_an_object_without_points_acts_as_a_place():
    plate, empty = grid_object(), new_empty("Empty")
    deformer = add(plate, empty, source="SELECTED")
    deformer.handles[0].acts_as = "POINTS"
    refused("Empty has no points - let Empty act as a place", "bind")
    deformer.handles[0].acts_as = "PLACE"
    bpy.ops.sinew.bind()
    assert deformer.status_level == "INFO", deformer.status


def test_segments_without_length_and_points_that_part_are_named():
    plate = grid_object()
    points = new_object("Points", [*CORNERS, CORNERS[0]], edges=[(0, 4)])
    make_active(plate, points)
    bpy.ops.sinew.point_add(source="POINTS", method="mls", segments=True)
    deformer = plate.sinew.active
    assert deformer.status_level == "ERROR"
    assert "between point 0 of Points and point 4 of Points has no length" in deformer.status
    deformer.handles[0].acts_as = "POINTS"
    press(plate, "bind")
    assert deformer.status_level == "INFO", deformer.status
    points.data.vertices[4].co.z += 0.5
    points.data.update()
    update()
    assert "point 0 of Points and point 4 of Points hold the same place" in deformer.status


def test_a_method_without_segments_takes_their_ends_as_points():
    plate, armature = grid_object(), skeleton()
    deformer = add_bones(plate, armature, method="mls", segments=True)
    deformer.method = "rbf"
    ends = heads_and_tails(armature).reshape(-1, 3)
    armature.pose.bones["Low"].rotation_euler.x = 0.5
    # The tail of the lower bone is the head of the upper one; both points move alike.
    expected = warped("rbf", ends, heads_and_tails(armature).reshape(-1, 3), base_points(plate))
    assert close(evaluated_points(plate), expected, 1e-4)


def by_the_paper(rest: np.ndarray, posed: np.ndarray, shares: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The rigid map that fits points best, weighted by 1 / d^2 and their shares, at each v."""
    out = []
    for point in v:
        w = shares / ((rest - point) ** 2).sum(axis=1)
        p, q = w @ rest / w.sum(), w @ posed / w.sum()
        U, _s, Vt = np.linalg.svd((posed - q).T @ (w[:, None] * (rest - p)))
        out.append(U @ np.diag((1, 1, np.linalg.det(U @ Vt))) @ Vt @ (point - p) + q)
    return np.array(out)


@pytest.mark.parametrize("earlier", [False, True])
def test_segments_count_beside_points_as_in_the_build_that_saved_the_file(earlier: bool):
    """Per length of the size of all handles, which earlier builds took from their box along the axes."""
    plate, armature = grid_object(cells=4), new_armature(Low=((-1.0, -1.0, 0.5), (0.5, -0.5, 1.0)))
    deformer = add_bones(plate, armature, method="mls", segments=True)
    empties = [new_empty(f"E {k}", place) for k, place in enumerate([(1.0, 1.0, 0.3), (-0.5, 1.0, 0.6)])]
    add(plate, *empties, source="SELECTED")
    deformer.parameters.alpha = 1.0
    if earlier:
        deformer.property_unset("sizes")

    def places() -> np.ndarray:
        ends = heads_and_tails(armature)[0]
        return np.array([*ends, *(empty.matrix_world.translation for empty in empties)])

    rest = places()
    armature.pose.bones[0].rotation_euler = 0.5, 0.3, 0.2
    empties[0].location.z += 1.0
    steps = (np.arange(4000)[:, None] + 0.5) / 4000
    size = np.ptp(rest, axis=0).max() if earlier else np.linalg.norm(rest[:, None] - rest, axis=2).max()
    before, after = (np.concatenate([p[0] + steps * (p[1] - p[0]), p[2:]]) for p in (rest, places()))
    length = np.linalg.norm(rest[1] - rest[0])
    shares = np.concatenate([np.full(4000, length / size / 4000), (1.0, 1.0)])
    expected = by_the_paper(before, after, shares, base_points(plate))
    assert close(evaluated_points(plate), expected, 4e-3)  # segments are quadratures of some places


def test_not_a_number_among_points_is_refused():
    plate, points = grid_object(), frame()
    deformer = add(plate, points)
    points.data.vertices[1].co.x = np.nan
    points.data.update()
    update()
    assert deformer.status_level == "ERROR"
    assert "Frame has points with invalid coordinates" in deformer.status
    assert close(evaluated_points(plate), base_points(plate), FLOAT32)


def test_the_panel_offers_segments_where_the_method_has_them():
    plate, points = grid_object(), frame()
    deformer = add(plate, points, method="mls")
    region = bpy.types.SINEW_PT_region

    def offered() -> list[str]:
        return [args[2] for name, args, *_rest in draw(region).calls if name == "prop_enum"]

    assert offered() == ["PLACE", "POINTS", "SEGMENTS"]
    deformer.method = "rbf"
    assert offered() == ["PLACE", "POINTS"]
    deformer.handles[0].acts_as = "SEGMENTS"
    assert "This method has no segments" in draw(region).texts()
    deformer.method = "arap"
    assert not offered()


def test_a_new_control_for_lost_points_is_a_place():
    plate, points = grid_object(), frame()
    deformer = add(plate, points, method="mls", segments=True)
    bpy.data.objects.remove(points)
    press(plate, "control_new")
    assert deformer.handles[0].acts_as == "PLACE"
    move_world(deformer.handles[0].control, some_motion())
    assert close(evaluated_points(plate), apply_matrix(some_motion(), base_points(plate)), 2e-5)


def test_points_that_a_deformer_moves_carry_several_objects():
    """In one evaluation, and in renders."""
    plate, other, points = grid_object(), grid_object("Other", cells=7), frame()
    other.location = 0.2, 0.0, 0.3
    empties = [new_empty(f"Empty {number}", corner) for number, corner in enumerate(CORNERS)]
    add(points, *empties, source="SELECTED", method="mls")
    for obj in (plate, other):
        press(obj, "deformer_add", method="rbf")
        add(obj, points)
    rests = [in_target(obj, points) for obj in (plate, other)]
    empties[2].location.z += 0.8
    assert np.abs(in_target(plate, points) - rests[0]).max() > 0.5
    for obj, rest in zip((plate, other), rests):
        expected = warped("rbf", rest, in_target(obj, points), base_points(obj))
        assert close(evaluated_points(obj), expected, 1e-5)
        assert close(render_points(obj), expected, 1e-5)
