# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw Outline by a curve as the stroke, as in scripts, and by events, as a window would send them."""

import math

import bpy
import numpy as np
import pytest
from expected import Expected
from inside import inner
from mathutils import Matrix
from mouse import event, front_view
from rigs import cages, rig as scenes
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
    scenes.update()
    return stroke


def sketch(stroke: bpy.types.Object, view: Matrix | None = FRONT, **keywords) -> None:
    seen_from = {} if view is None else {"view": view}
    assert bpy.ops.sinew.silhouette_sketch(stroke=stroke.name, **seen_from, **keywords) == {"FINISHED"}


def key_names(obj: bpy.types.Object) -> list[str]:
    keys = obj.data.shape_keys
    return [] if keys is None else [key.name for key in keys.key_blocks]


def outline(points: np.ndarray, angle: float) -> float:
    """How far points (n, 3) reach in a direction of the front view."""
    return float((points @ (math.cos(angle), 0.0, math.sin(angle))).max())


def test_a_bump_is_drawn_onto_the_outline_and_what_is_far_stays():
    obj = ball()
    before = scenes.base_points(obj)
    sketch(curve(arc(bump)), reach=0.6)
    assert key_names(obj) == ["Basis", "Silhouette"]
    assert np.array_equal(scenes.base_points(obj), before)
    after = scenes.evaluated_points(obj)
    # Between the vertices an outline of edges is lower than the stroke by up to a chord.
    assert outline(after, 0.0) == pytest.approx(1.3, abs=EDGE**2 / 8)
    assert np.abs(after[:, 1] - before[:, 1]).max() < 0.1  # depths are kept, but for the turn of details
    far = before[:, 0] < -0.1
    assert np.array_equal(after[far], before[far])


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_the_view_may_be_that_of_the_camera(kind: str):
    obj = ball()
    data = bpy.data.cameras.new("Camera")
    data.type = kind
    bpy.context.scene.camera = scenes.linked(bpy.data.objects.new("Camera", data))
    bpy.context.scene.camera.matrix_world = Matrix.Translation((0.0, -4.0, 0.0)) @ FRONT
    # A near eye sees a smaller circle, of which the tangents are 1 / sqrt(15), at a depth of 1.
    nearer = math.sqrt(15.0) if kind == "PERSP" else 1.0
    sketch(curve(arc(bump) / (nearer, 1.0, nearer)), None, reach=0.6)
    after = scenes.evaluated_points(obj)
    seen = after[:, 0] / (after[:, 1] + 4.0) * nearer if kind == "PERSP" else after[:, 0]
    assert seen.max() == pytest.approx(1.3, abs=0.02)  # what is nearer than the line is seen larger


def test_an_object_that_is_placed_turned_and_scaled_is_seen_as_it_is():
    stroke, plain = curve(arc(bump)), ball("Plain")
    sketch(stroke, reach=0.6)
    placed = ball("Placed")
    matrix = Matrix.Translation((3.0, 2.0, -1.0)) @ Matrix.Rotation(0.7, 4, (1, 2, 3))
    matrix @= Matrix.Diagonal((0.5, -2.0, 1.0, 1.0))
    placed.data.transform(matrix.inverted())
    placed.matrix_world = matrix
    scenes.update()
    sketch(stroke, reach=0.6)
    assert scenes.close(
        scenes.apply_matrix(matrix, scenes.evaluated_points(placed)), scenes.evaluated_points(plain), 1e-5
    )


def test_shape_keys_add_up_and_each_can_be_removed():
    obj = ball()
    before = scenes.evaluated_points(obj)
    sketch(curve(arc(bump)), reach=0.6)
    first = scenes.evaluated_points(obj)
    sketch(curve(arc(bump) * (-1.0, 1.0, 1.0), "Left"), reach=0.6)
    both = scenes.evaluated_points(obj)
    assert outline(both, math.pi) == pytest.approx(1.3, abs=EDGE**2 / 8)
    assert scenes.close(both[before[:, 0] > 0.1], first[before[:, 0] > 0.1])
    obj.data.shape_keys.key_blocks["Silhouette.001"].value = 0.0
    assert scenes.close(scenes.evaluated_points(obj), first)
    obj.shape_key_remove(obj.data.shape_keys.key_blocks["Silhouette"])
    assert scenes.close(scenes.evaluated_points(obj), before)


def test_an_edited_stroke_redraws_its_key():
    obj = ball()
    scenes.add_key(obj, "Own", Matrix.Diagonal((1.0, 1.0, 0.9, 1.0))).value = 1.0
    stroke = curve(arc(bump))
    sketch(stroke, reach=0.6)
    first = scenes.evaluated_points(obj)
    for point in stroke.data.splines[0].points:
        point.co.x *= 1.2
    key = obj.data.shape_keys.key_blocks["Silhouette"]
    key.mute = True
    sketch(stroke, reach=0.8, shape_key="Silhouette")
    assert key.mute
    key.mute = False
    again = scenes.evaluated_points(obj)
    assert not scenes.close(again, first, 0.1)
    assert key_names(obj) == ["Basis", "Own", "Silhouette"]
    obj.shape_key_remove(key)
    sketch(stroke, reach=0.8)
    assert scenes.close(scenes.evaluated_points(obj), again)


def test_a_drawn_stroke_may_be_kept_as_a_curve():
    obj = ball()
    drawing = {"points": stroke_through(arc(bump)), "keep_stroke": True}
    assert bpy.ops.sinew.silhouette_sketch(view=FRONT, reach=0.6, **drawing) == {"FINISHED"}
    drawn = scenes.evaluated_points(obj)
    kept = bpy.data.objects["Silhouette Stroke"]
    assert scenes.close(np.array([point.co[:3] for point in kept.data.splines[0].points]), arc(bump))
    scenes.make_active(obj)
    sketch(kept, reach=0.6, shape_key="Silhouette")
    assert scenes.close(scenes.evaluated_points(obj), drawn)


def test_a_deformer_after_the_key_gets_the_redrawn_shape(plate: scenes.Rig):
    """The border of a plate is its outline from above; the pose comes on top."""
    expected = Expected.of_rig(plate.bind())
    plate.lift(0.5)
    scenes.make_active(plate.obj)
    x = np.linspace(-0.8, 0.8, 41)
    stroke = curve(np.column_stack((x, 1.0 + 0.2 * np.cos(0.5 * np.pi * x / 0.8) ** 2, 0.0 * x)))
    sketch(stroke, Matrix.Translation((0.0, 0.0, 5.0)), reach=0.4)
    scenes.make_active(plate.obj)
    keyed = scenes.coordinates(plate.obj.data.shape_keys.key_blocks["Silhouette"].data)
    assert keyed[:, 1].max() == pytest.approx(1.2, abs=0.01)
    assert scenes.close(plate.points(), expected.now(plate.obj, plate.control, incoming=keyed), 1e-5)


@pytest.mark.parametrize(
    ("before", "size", "hidden", "stays"), [(4.0, 1.3, False, 0), (4.0, 1.3, True, 1), (1.5, 0.7, False, 1)]
)
def test_only_the_loose_part_with_the_line_follows(before: float, size: float, hidden: bool, stays: int):
    """Of a ball behind a larger one, whose outline counts only if hidden lines do; and of two that touch."""
    parts = [ball(), ball("Nearer")]
    parts[1].data.transform(Matrix.Translation((0.0, -before, 0.0)) @ Matrix.Scale(size, 4))
    scenes.make_active(*parts)
    bpy.ops.object.join()
    rest = scenes.base_points(parts[0])
    sketch(curve(arc(lambda angle: 1.0 + (bump(angle) - 1.0) / 3.0)), unlimited=True, use_hidden=hidden)
    moved = np.abs(scenes.evaluated_points(parts[0]) - rest).max(axis=1).reshape(2, -1).max(axis=1)
    assert moved[1 - stays] > 0.05
    assert moved[stays] == 0.0


def test_fixed_regions_stay_and_a_line_inside_one_is_refused():
    obj = ball()
    before = scenes.base_points(obj)
    fixed = scenes.add_group(obj, "Above", lambda point: point[2] > 0.4)
    scenes.add_regions(obj, "thin_shell", {"Above": "FIXED"})
    sketch(curve(arc(bump)), unlimited=True)
    off = np.abs(scenes.coordinates(obj.data.shape_keys.key_blocks["Silhouette"].data) - before)
    assert off[fixed].max() == 0.0
    assert off.max() > 0.2
    above = arc(lambda angle: 1.1, 0.3) @ np.array(Matrix.Rotation(math.radians(-60.0), 3, "Y")).T
    above[:, 1] = -3.0
    assert above[:, 2].min() > 0.5
    scenes.make_active(obj)
    scenes.fails("Still regions", sketch, curve(above, "Above"))
    assert key_names(obj) == ["Basis", "Silhouette"]
    obj.sinew.deformers[0].handles[0].kind = "SUPPORT"
    sketch(bpy.data.objects["Above"], reach=0.2)


def test_selected_edges_are_the_line():
    obj = scenes.grid_object(cells=20)
    places = scenes.base_points(obj)
    for edge in obj.data.edges:
        edge.select = bool((np.abs(places[list(edge.vertices), :2]) < (1e-4, 0.65)).all())
    y = np.linspace(-0.6, 0.6, 31)
    stroke = curve(np.column_stack((np.full(31, 5.0), y, 0.3 * np.cos(0.5 * np.pi * y / 0.6))))
    side = Matrix(((0, 0, 1, 0), (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 0, 1)))
    sketch(stroke, side, line="EDGES", reach=0.3)
    after = scenes.evaluated_points(obj)
    ridge = np.abs(after[:, 0]) < 1e-3
    assert after[ridge, 2].max() == pytest.approx(0.3, abs=0.01)
    assert np.abs(after[np.abs(after[:, 0]) > 0.35, 2]).max() == 0.0


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
    before = scenes.base_points(obj)

    def moved() -> int:
        return (np.abs(scenes.evaluated_points(obj) - before).max(axis=1) > 0.0).sum()

    hand = Hand(obj)
    hand.draw(arc(bump))
    assert hand.tool.stage is hand.stages.ADJUSTING
    assert outline(scenes.evaluated_points(obj), 0.0) == pytest.approx(1.3, abs=0.01)
    for _ in range(3):
        hand.send("WHEELUPMOUSE")
    narrow = moved()
    for _ in range(3):
        hand.send("PAGE_UP")
    assert moved() > narrow
    blunt = scenes.evaluated_points(obj)
    hand.send("WHEELUPMOUSE", shift=True)
    assert hand.tool.sharpness == pytest.approx(0.1)
    assert hand.send("MIDDLEMOUSE") is hand.outcomes.PASS
    assert hand.send("RET") is hand.outcomes.CONFIRMED
    shown = scenes.evaluated_points(obj)
    assert not scenes.close(shown, blunt, 1e-3)
    stroke = np.array(hand.tool.stroke)
    hand.tool.restore(obj)
    assert key_names(obj) == []
    sketch(curve(stroke), reach=hand.tool.radius, sharpness=0.1)
    assert scenes.close(
        scenes.evaluated_points(obj), shown, 1e-4
    )  # a reach in float32 may leave out a vertex


@pytest.mark.parametrize("key", ["ESC", "RIGHTMOUSE"])
@pytest.mark.parametrize("keys", ["no key", "another key", "the key that is redrawn"])
def test_cancel_leaves_nothing_behind(key: str, keys: str):
    obj = ball()
    if keys == "another key":
        scenes.add_key(obj, "Own", Matrix.Scale(1.1, 4)).value = 1.0
    elif keys != "no key":
        sketch(curve(arc(bump)), reach=0.6)
    names, before = key_names(obj), scenes.evaluated_points(obj)
    hand = Hand(obj, "Silhouette" if "redrawn" in keys else "")
    hand.draw(arc(lambda angle: 2.0 - bump(angle)))
    hand.send("A")
    assert not scenes.close(scenes.evaluated_points(obj), before, 0.1)
    assert hand.send(key) is hand.outcomes.CANCELLED
    assert key_names(obj) == names
    assert np.array_equal(scenes.evaluated_points(obj), before)


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
