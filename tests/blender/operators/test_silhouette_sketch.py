# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw Outline by a curve as the stroke, as in scripts, and by events, as a window would send them."""

from __future__ import annotations

import math

import bpy
import numpy as np
import pytest
from expected import Expected
from inside import inner
from mathutils import Matrix
from mouse import event, front_view
from rigs import cages
from rigs.rig import (
    Rig,
    add_key,
    apply_matrix,
    base_points,
    close,
    coordinates,
    evaluated_points,
    fails,
    grid_object,
    linked,
    make_active,
    update,
)
from rigs.rig_of_curves import polyline, stroke_through

FRONT = Matrix.Rotation(math.radians(90.0), 4, "X")  # a camera that looks along y
EDGE = 0.16  # length of the longest edge of the ball


def ball(name: str = "Ball") -> bpy.types.Object:
    return cages.ball(name, 4, 1.0)


def arc(size=lambda angle: 1.0, largest: float = 1.0, count: int = 61) -> np.ndarray:
    """An arc around y on the right side, from below to above, at a distance before the ball."""
    angles = np.linspace(-largest, largest, count)
    radii = np.array([size(angle) for angle in angles])
    return np.column_stack((radii * np.cos(angles), np.full(count, -3.0), radii * np.sin(angles)))


def bump(angle: float) -> float:
    return 1.0 + 0.3 * math.cos(0.5 * math.pi * angle)


def curve(points: np.ndarray, name: str = "Stroke", closed: bool = False) -> bpy.types.Object:
    stroke = polyline(points, name)
    stroke.data.splines[0].use_cyclic_u = closed
    update()
    return stroke


def sketch(stroke: bpy.types.Object, view: Matrix = FRONT, **keywords) -> set[str]:
    return bpy.ops.sinew.silhouette_sketch(stroke=stroke.name, view=view, **keywords)


def key_names(obj: bpy.types.Object) -> list[str]:
    keys = obj.data.shape_keys
    return [] if keys is None else [key.name for key in keys.key_blocks]


def outline(points: np.ndarray, angle: float) -> float:
    """How far points (n, 3) reach in a direction of the front view."""
    return float((points @ (math.cos(angle), 0.0, math.sin(angle))).max())


def test_a_bump_is_drawn_onto_the_outline_and_what_is_far_stays():
    obj = ball()
    before = base_points(obj)
    assert sketch(curve(arc(bump)), reach=0.6) == {"FINISHED"}
    assert key_names(obj) == ["Basis", "Silhouette"]
    assert np.array_equal(base_points(obj), before)
    after = evaluated_points(obj)
    # Between the vertices an outline of edges is lower than the stroke by up to a chord.
    assert outline(after, 0.0) == pytest.approx(1.3, abs=EDGE**2 / 8)
    assert np.abs(after[:, 1] - before[:, 1]).max() < 0.1  # depths are kept, but for the turn of details
    far = before[:, 0] < -0.1
    assert np.array_equal(after[far], before[far])


def test_a_stroke_along_the_silhouette_changes_nothing():
    """The stroke is the silhouette that the library finds, at another depth."""
    obj = ball()
    before = base_points(obj)
    native = inner.native._module()
    faces = np.array([face.vertices[:] for face in obj.data.polygons])
    lines = native.silhouette_lines(
        native.SurfaceMesh(before.astype(float), faces), np.array(FRONT)[:3, :3].T
    )
    (edges, shares, closed), *others = lines
    assert closed
    assert not others
    on = before[edges[:, 0]] + shares[:, None] * (before[edges[:, 1]] - before[edges[:, 0]])
    for points in (on[:40], on[::-1][:30]):
        assert sketch(curve(points - (0.0, 3.0, 0.0)), reach=0.5) == {"FINISHED"}
        assert close(evaluated_points(obj), before)
    assert sketch(curve(on - (0.0, 3.0, 0.0), closed=True), unlimited=True) == {"FINISHED"}
    assert close(evaluated_points(obj), before)


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_the_view_may_be_that_of_the_camera(kind: str):
    obj = ball()
    data = bpy.data.cameras.new("Camera")
    data.type = kind
    camera = linked(bpy.data.objects.new("Camera", data))
    bpy.context.scene.camera = camera
    camera.matrix_world = Matrix.Translation((0.0, -4.0, 0.0)) @ FRONT
    update()
    # A near eye sees a smaller circle, of which the tangents are 1 / sqrt(15), at a depth of 1.
    points = arc(bump)
    points[:, 1] = -3.0
    if kind == "PERSP":
        points[:, (0, 2)] /= math.sqrt(15.0)
    assert bpy.ops.sinew.silhouette_sketch(stroke=curve(points).name, reach=0.6) == {"FINISHED"}
    after = evaluated_points(obj)
    seen = after[:, 0] / (after[:, 1] + 4.0) * math.sqrt(15.0) if kind == "PERSP" else after[:, 0]
    assert seen.max() == pytest.approx(1.3, abs=0.02)  # what is nearer than the line is seen larger


def test_an_object_that_is_placed_turned_and_scaled_is_seen_as_it_is():
    stroke = curve(arc(bump))
    plain = ball("Plain")
    sketch(stroke, reach=0.6)
    placed = ball("Placed")
    matrix = Matrix.Translation((3.0, 2.0, -1.0)) @ Matrix.Rotation(0.7, 4, (1, 2, 3))
    matrix @= Matrix.Diagonal((0.5, -2.0, 1.0, 1.0))
    placed.data.transform(matrix.inverted())
    placed.matrix_world = matrix
    update()
    assert sketch(stroke, reach=0.6) == {"FINISHED"}
    assert close(apply_matrix(matrix, evaluated_points(placed)), evaluated_points(plain), 1e-5)


def test_shape_keys_add_up_and_each_can_be_removed():
    obj = ball()
    before = evaluated_points(obj)
    sketch(curve(arc(bump)), reach=0.6)
    first = evaluated_points(obj)
    left = curve(arc(bump) * (-1.0, 1.0, 1.0), "Left")
    assert sketch(left, reach=0.6) == {"FINISHED"}
    both = evaluated_points(obj)
    assert outline(both, math.pi) == pytest.approx(1.3, abs=EDGE**2 / 8)
    assert close(both[before[:, 0] > 0.1], first[before[:, 0] > 0.1])
    obj.data.shape_keys.key_blocks["Silhouette.001"].value = 0.0
    assert close(evaluated_points(obj), first)
    obj.shape_key_remove(obj.data.shape_keys.key_blocks["Silhouette"])
    assert close(evaluated_points(obj), before)


def test_an_edited_stroke_redraws_its_key():
    obj = ball()
    add_key(obj, "Own", Matrix.Diagonal((1.0, 1.0, 0.9, 1.0))).value = 1.0
    stroke = curve(arc(bump))
    sketch(stroke, reach=0.6)
    first = evaluated_points(obj)
    for point in stroke.data.splines[0].points:
        point.co.x *= 1.2
    update()
    key = obj.data.shape_keys.key_blocks["Silhouette"]
    key.mute = True
    assert sketch(stroke, reach=0.8, shape_key="Silhouette") == {"FINISHED"}
    assert key.mute
    key.mute = False
    again = evaluated_points(obj)
    assert not close(again, first, 0.1)
    assert key_names(obj) == ["Basis", "Own", "Silhouette"]
    obj.shape_key_remove(key)
    sketch(stroke, reach=0.8)
    assert close(evaluated_points(obj), again)


def test_a_drawn_stroke_may_be_kept_as_a_curve():
    obj = ball()
    points = stroke_through(arc(bump))
    answer = bpy.ops.sinew.silhouette_sketch(points=points, view=FRONT, reach=0.6, keep_stroke=True)
    assert answer == {"FINISHED"}
    drawn = evaluated_points(obj)
    kept = bpy.data.objects["Silhouette Stroke"]
    assert close(np.array([point.co[:3] for point in kept.data.splines[0].points]), arc(bump))
    make_active(obj)
    assert sketch(kept, reach=0.6, shape_key="Silhouette") == {"FINISHED"}
    assert close(evaluated_points(obj), drawn)


def test_a_deformer_after_the_key_gets_the_redrawn_shape(plate: Rig):
    """The border of a plate is its outline from above; the pose comes on top."""
    plate.bind()
    expected = Expected.of_rig(plate)
    plate.lift(0.5)
    make_active(plate.obj)
    x = np.linspace(-0.8, 0.8, 41)
    stroke = curve(np.column_stack((x, 1.0 + 0.2 * np.cos(0.5 * np.pi * x / 0.8) ** 2, 0.0 * x)))
    assert sketch(stroke, Matrix.Translation((0.0, 0.0, 5.0)), reach=0.4) == {"FINISHED"}
    make_active(plate.obj)
    keyed = coordinates(plate.obj.data.shape_keys.key_blocks["Silhouette"].data)
    assert keyed[:, 1].max() == pytest.approx(1.2, abs=0.01)
    assert close(plate.points(), expected.now(plate.obj, plate.control, incoming=keyed), 1e-5)


def joined_balls(before: float, size: float = 1.0) -> bpy.types.Object:
    """Two balls in one mesh; the second one of this size stands nearer to the viewer."""
    first, second = ball(), ball("Second")
    for vertex in second.data.vertices:
        vertex.co = size * vertex.co
        vertex.co.y -= before
    second.select_set(True)
    first.select_set(True)
    bpy.context.view_layer.objects.active = first
    bpy.ops.object.join()
    return first


def test_an_outline_that_the_mesh_hides_is_taken_only_if_hidden_lines_count():
    """The stroke runs along the outline of a ball behind a larger one."""
    obj = joined_balls(4.0, 1.3)
    before = base_points(obj)
    behind = before[:, 1] > -2.0
    stroke = curve(arc(lambda angle: 1.0 + 0.1 * math.cos(0.5 * math.pi * angle)))
    make_active(obj)
    assert sketch(stroke, reach=0.4) == {"FINISHED"}
    moved = np.abs(evaluated_points(obj) - before).max(axis=1) > 1e-6
    assert moved.any()
    assert not moved[behind].any()
    obj.shape_key_clear()
    assert sketch(stroke, reach=0.4, use_hidden=True) == {"FINISHED"}
    moved = np.abs(evaluated_points(obj) - before).max(axis=1) > 1e-6
    assert moved.any()
    assert not moved[~behind].any()


def test_only_the_loose_part_with_the_line_follows():
    """Another one touches it, and the whole surface follows."""
    obj = joined_balls(1.5, 0.7)
    before = base_points(obj)
    stroked = np.arange(len(before)) < len(before) // 2
    make_active(obj)
    assert sketch(curve(arc(bump)), unlimited=True) == {"FINISHED"}
    after = evaluated_points(obj)
    assert np.abs(after[stroked] - before[stroked]).max() > 0.2
    assert np.array_equal(after[~stroked], before[~stroked])


def test_fixed_regions_stay_and_a_line_inside_one_is_refused():
    obj = ball()
    before = base_points(obj)
    fixed = before[:, 2] > 0.4
    obj.vertex_groups.new(name="Above").add(np.flatnonzero(fixed).tolist(), 1.0, "REPLACE")
    bpy.ops.sinew.deformer_add(method="thin_shell")
    bpy.ops.sinew.handle_add(kind="FIXED", vertex_group="Above")
    make_active(obj)
    assert sketch(curve(arc(bump)), unlimited=True) == {"FINISHED"}
    keyed = coordinates(obj.data.shape_keys.key_blocks["Silhouette"].data)
    assert np.array_equal(keyed[fixed], before[fixed].astype(np.float32))
    assert np.abs(keyed[~fixed] - before[~fixed]).max() > 0.2
    above = arc(lambda angle: 1.1, 0.3) @ np.array(Matrix.Rotation(math.radians(-60.0), 3, "Y")).T
    above[:, 1] = -3.0
    assert above[:, 2].min() > 0.5
    make_active(obj)
    fails("Still regions", sketch, curve(above, "Above"))
    assert key_names(obj) == ["Basis", "Silhouette"]
    obj.sinew.deformers[0].handles[0].kind = "SUPPORT"
    assert sketch(bpy.data.objects["Above"], reach=0.2) == {"FINISHED"}


def test_selected_edges_are_the_line():
    obj = grid_object(cells=20)
    make_active(obj)
    for edge in obj.data.edges:
        edge.select = all(
            abs(obj.data.vertices[v].co.x) < 1e-4 and abs(obj.data.vertices[v].co.y) < 0.65
            for v in edge.vertices
        )
    y = np.linspace(-0.6, 0.6, 31)
    stroke = curve(np.column_stack((np.full(31, 5.0), y, 0.3 * np.cos(0.5 * np.pi * y / 0.6))))
    side = Matrix(((0, 0, 1, 0), (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 0, 1)))
    assert sketch(stroke, side, line="EDGES", reach=0.3) == {"FINISHED"}
    after = evaluated_points(obj)
    ridge = np.abs(after[:, 0]) < 1e-3
    assert after[ridge, 2].max() == pytest.approx(0.3, abs=0.01)
    assert np.abs(after[np.abs(after[:, 0]) > 0.35, 2]).max() == 0.0


def test_sharpness_lifts_the_line_above_what_is_beside_it():
    heights = []
    for sharpness in (0.0, 2.0):
        obj = ball()
        sketch(curve(arc(bump)), reach=0.6, sharpness=sharpness)
        after = evaluated_points(obj)
        on_line = np.abs(base_points(obj)[:, 1]) < 0.5 * EDGE
        beside = (np.abs(base_points(obj)[:, 1]) < 1.6 * EDGE) & ~on_line & (base_points(obj)[:, 0] > 0.9)
        heights.append(outline(after, 0.0) - after[beside, 0].mean())
        for leftover in list(bpy.data.objects):
            bpy.data.objects.remove(leftover)
    assert heights[1] > 1.05 * heights[0]


class Hand:
    """A person at the mouse, before a front view where a pixel is a centimetre."""

    def __init__(self, obj: bpy.types.Object, replaced: str = "") -> None:
        sketching = inner.sketching
        self.obj, self.outcomes, self.stages = obj, sketching.Outcome, sketching.Stage
        self.view = front_view()
        self.tool = sketching.Sketching(inner.sketch.Sketch(obj, False, replaced), np.zeros(3), 0.0)

    def send(self, kind: str, value: str = "PRESS", place=(0.0, 0.0), **modifiers: bool):
        x, y = 400.0 + 100.0 * place[0], 300.0 + 100.0 * place[1]
        return self.tool.process(self.obj, event(kind, value, x, y, **modifiers), self.view)

    def draw(self, points: np.ndarray) -> None:
        places = points[:, (0, 2)]
        assert self.send("LEFTMOUSE", "PRESS", places[0]) is self.outcomes.GO_ON
        for place in places[1:]:
            assert self.send("MOUSEMOVE", "NOTHING", place) is self.outcomes.GO_ON
        assert self.send("LEFTMOUSE", "RELEASE", places[-1]) is self.outcomes.GO_ON


def test_events_draw_adjust_and_confirm_what_a_curve_repeats():
    obj = ball()
    before = base_points(obj)
    hand = Hand(obj)
    hand.draw(arc(bump))
    assert hand.tool.stage is hand.stages.ADJUSTING
    assert outline(evaluated_points(obj), 0.0) == pytest.approx(1.3, abs=0.01)
    for _ in range(3):
        hand.send("WHEELUPMOUSE")
    narrow = (np.abs(evaluated_points(obj) - before).max(axis=1) > 0.0).sum()
    for _ in range(3):
        hand.send("PAGE_UP")
    assert (np.abs(evaluated_points(obj) - before).max(axis=1) > 0.0).sum() > narrow
    hand.send("WHEELUPMOUSE", shift=True)
    assert hand.tool.sharpness == pytest.approx(0.1)
    assert hand.send("MIDDLEMOUSE") is hand.outcomes.PASS
    assert hand.send("RET") is hand.outcomes.CONFIRMED
    shown = evaluated_points(obj)
    stroke = np.array(hand.tool.stroke)
    hand.tool.restore(obj)
    assert key_names(obj) == []
    sketch(curve(stroke), reach=hand.tool.radius, sharpness=0.1)
    assert close(evaluated_points(obj), shown, 1e-4)  # a reach in float32 may leave out a vertex


def test_cancel_puts_back_a_key_that_was_being_redrawn():
    obj = ball()
    sketch(curve(arc(bump)), reach=0.6)
    before = evaluated_points(obj)
    hand = Hand(obj, "Silhouette")
    hand.draw(arc(lambda angle: 2.0 - bump(angle)))
    assert not close(evaluated_points(obj), before, 0.1)
    hand.send("ESC")
    assert key_names(obj) == ["Basis", "Silhouette"]
    assert np.array_equal(evaluated_points(obj), before)


@pytest.mark.parametrize("key", ["ESC", "RIGHTMOUSE"])
@pytest.mark.parametrize("keyed", [False, True], ids=["first key", "further key"])
def test_cancel_leaves_nothing_behind(key: str, keyed: bool):
    obj = ball()
    if keyed:
        obj.shape_key_add(name="Basis")
        obj.shape_key_add(name="Own").data[0].co.x += 0.1
    names, before = key_names(obj), evaluated_points(obj)
    hand = Hand(obj)
    hand.draw(arc(bump))
    hand.send("A")
    assert len(key_names(obj)) > len(names)
    assert hand.send(key) is hand.outcomes.CANCELLED
    assert key_names(obj) == names
    assert np.array_equal(evaluated_points(obj), before)


def test_a_click_and_a_stroke_elsewhere_are_told_and_another_may_follow():
    obj = ball()
    hand = Hand(obj)
    hand.draw(arc(largest=0.01, count=2))
    assert "too short" in hand.tool.notice
    hand.tool.notice = ""
    hand.draw(arc() + (9.0, 0.0, 0.0))
    assert "no silhouette near" in hand.tool.notice
    assert key_names(obj) == []
    hand.draw(arc(bump))
    assert hand.tool.stage is hand.stages.ADJUSTING
