# SPDX-License-Identifier: GPL-3.0-or-later
"""Grab Once by its properties, as scripts and Adjust Last Operation call it, and by events."""

import math
from collections.abc import Callable

import bmesh
import bpy
import numpy as np
import pytest
from editing import centre, edit, edited, grab, placed_object, select, selection
from inside import inner, use_threads
from mathutils import Matrix, Vector
from mouse import event, front_view
from registry import GRABBING
from rigs import rig as scenes


def in_world(obj: bpy.types.Object) -> np.ndarray:
    return scenes.apply_matrix(obj.matrix_world, edited(obj).astype(float))


def test_the_surface_methods_that_work_alone_are_offered():
    offered = bpy.ops.sinew.grab_region.get_rna_type().properties["method"].enum_items.keys()
    assert set(offered) == set(GRABBING)


@pytest.mark.parametrize("method", GRABBING)
def test_the_selection_moves_exactly_and_the_rest_stays(method: str):
    obj = scenes.grid_object(cells=20)
    chosen = edit(obj, centre)
    before = edited(obj)
    grab(value=(0.0, 0.0, 1.0), radius=0.5, method=method)
    after = edited(obj)
    assert len(bpy.data.meshes) == 1, "none is left behind"
    assert np.array_equal(after[chosen], before[chosen] + np.float32((0.0, 0.0, 1.0)))
    far = np.linalg.norm(before[:, :2], axis=1) > 0.15 + 0.5
    assert np.array_equal(after[far], before[far])
    near = np.setdiff1d(np.flatnonzero((after != before).any(axis=1)), chosen)
    assert len(near) > 50
    assert 0.0 < after[near, 2].mean() < 1.0


@pytest.mark.parametrize("method", GRABBING)
@pytest.mark.parametrize(
    "make", [scenes.grid_object, placed_object], ids=["at the origin", "placed and scaled"]
)
@pytest.mark.parametrize("angle", [0.0, 0.9], ids=["move", "turn"])
def test_nothing_fixed_means_one_rigid_motion_of_the_world(method: str, make: Callable, angle: float):
    obj = make(cells=12)
    chosen = edit(obj, lambda point: point.y > 0.75)
    before = in_world(obj)
    if angle:
        axis, pivot = (0.3, 0.9, -0.2), Matrix.Translation(before[chosen].mean(axis=0))
        grab(unlimited=True, method=method, mode="ROTATE", angle=angle, axis=axis)
        matrix = pivot @ Matrix.Rotation(angle, 4, axis) @ pivot.inverted()
    else:
        grab(unlimited=True, method=method, value=(0.3, -0.2, 0.7))
        matrix = Matrix.Translation((0.3, -0.2, 0.7))
    tolerance = 2e-6 if make is scenes.grid_object else 1e-5  # float32 at a size of 2, and a matrix
    assert np.abs(in_world(obj) - scenes.apply_matrix(matrix, before)).max() < tolerance


@pytest.mark.parametrize("method", GRABBING)
def test_only_the_part_within_reach_changes_the_answer(method: str):
    """Far from the radius there may be anything: the same shape with and without another 5,000 vertices."""
    results = []
    for cells, size in ((20, 1.0), (60, 3.0)):
        obj = scenes.grid_object(f"Plate {cells}", cells)
        obj.data.transform(Matrix.Scale(size, 4))
        edit(obj, centre)
        before = edited(obj)
        grab(mode="TRANSLATE", value=(0.1, 0.0, 0.4), radius=0.5, method=method)
        near = np.abs(before[:, :2]).max(axis=1) < 0.95
        order = np.lexsort(np.round(before[near].T, 4))
        results.append(edited(obj)[near][order])
        bpy.ops.object.mode_set(mode="OBJECT")
    assert np.abs(results[0] - results[1]).max() < 2e-4  # the roots of the two grids differ by rounding


@pytest.mark.parametrize(
    ("motion", "matrix"),
    [
        ({"mode": "ROTATE", "angle": 0.7, "axis": (1.0, 0.0, 0.0)}, Matrix.Rotation(0.7, 4, "X")),
        ({"mode": "RESIZE", "scale": (1.0, 0.5, 2.0)}, Matrix.Diagonal((1.0, 0.5, 2.0, 1.0))),
    ],
)
def test_rotation_and_scale_about_the_centre(motion: dict, matrix: Matrix):
    obj = scenes.grid_object()
    chosen = edit(obj, lambda point: point.x > 0.75)
    before = edited(obj)[chosen].astype(float)
    grab(radius=0.3, **motion)
    pivot = before.mean(axis=0)
    assert np.abs(edited(obj)[chosen] - pivot - scenes.apply_matrix(matrix, before - pivot)).max() < 1e-6


@pytest.mark.parametrize("orientation", ["GLOBAL", "LOCAL"])
def test_motion_is_of_the_world_whatever_the_object_is(orientation: str):
    obj = placed_object()
    chosen = edit(obj, lambda point: point.y > 0.75)
    before = in_world(obj)[chosen]
    grab(mode="TRANSLATE", value=(0.5, 0.25, -1.0), orientation=orientation, radius=0.4)
    axes = np.eye(3) if orientation == "GLOBAL" else np.array(obj.matrix_world.to_3x3().normalized())
    assert np.abs(in_world(obj)[chosen] - before - axes @ (0.5, 0.25, -1.0)).max() < 2e-6


def test_the_radius_is_measured_in_the_world_and_over_the_surface():
    """Two sheets a hair apart, joined at the far edge: the other sheet is near, but far to walk."""
    line = np.linspace(0.0, 1.0, 11)
    there_and_back = [(x, 0.0) for x in line] + [(x, -0.02) for x in line[::-1]]
    points = [(x, y, z) for y in (0.0, 0.1) for x, z in there_and_back]
    obj = scenes.new_object("Fold", points, [(i, i + 1, i + 23, i + 22) for i in range(21)])
    obj.scale = (2.0, 2.0, 2.0)
    edit(obj, lambda point: point.x < 0.05 and point.z > -0.01)
    before = edited(obj)
    grab(mode="TRANSLATE", value=(0.0, 0.0, 0.5), radius=1.1)
    moved = (edited(obj) != before).any(axis=1)
    assert not moved[before[:, 2] < -0.01].any()
    assert moved[(before[:, 0] < 0.54) & (before[:, 2] > -0.01)].all()  # 1.1 in the world is 0.55 here
    assert not moved[before[:, 0] > 0.56].any()


def test_other_parts_hidden_vertices_and_fixed_regions_stay():
    obj = scenes.grid_object(cells=20)
    held = scenes.add_group(obj, "Anchor", lambda point: point[0] > 0.25)
    scenes.press(obj, "handle_add", kind="FIXED", vertex_group="Anchor")
    scenes.make_active(obj)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.primitive_cube_add(size=0.1, location=(0.0, 0.0, 0.1))
    other = select(obj, lambda point: point.z > 0.01)
    hidden = select(obj, lambda point: point.x < -0.35)
    bpy.ops.mesh.hide()
    chosen = select(obj, lambda point: centre(point) and point.z < 0.01)
    before = edited(obj)
    grab(value=(0.0, 0.0, -0.4), unlimited=True)
    moved = (edited(obj) != before).any(axis=1)
    assert moved[chosen].all()
    assert not moved[[*held, *hidden, *other]].any()
    assert moved.sum() > len(chosen) + 100


def test_a_selected_vertex_of_a_fixed_region_stays():
    obj = scenes.grid_object()
    members = scenes.add_group(obj, "Anchor", lambda point: point[0] < 0.0)
    scenes.press(obj, "handle_add", kind="FIXED", vertex_group="Anchor")
    edit(obj, lambda point: abs(point.y) < 0.1)
    before = edited(obj)
    grab(value=(0.0, 0.0, 0.4), radius=0.3)
    assert np.array_equal(edited(obj)[members], before[members])
    select(obj, lambda point: point.x < -0.5)
    scenes.refused("belong to Still regions", "grab_region", value=(0.0, 0.0, 1.0))


@pytest.mark.parametrize("chosen", [(5,), (4, 5), (2, 5), (0, 1, 2, 3, 4, 5)])
def test_loose_vertices_just_move(chosen: tuple[int, ...], capfd: pytest.CaptureFixture):
    """A square with a wire at its corner, and a vertex on its own."""
    points = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 1, 0), (5, 5, 5)], dtype=float)
    obj = scenes.new_object("Loose", points, [(0, 1, 2, 3)], [(2, 4)])
    edit(obj, lambda point: any(point == Vector(points[index]) for index in chosen))
    grab(value=(0.0, 0.0, 1.0), radius=0.5)
    points[list(chosen), 2] += 1.0
    assert np.array_equal(edited(obj), points)
    assert "only the selection moves" in capfd.readouterr().out


@pytest.mark.parametrize("method", GRABBING)
@pytest.mark.parametrize(
    "odd",
    [
        {"mode": "RESIZE", "scale": (0.0, 0.0, 0.0)},
        {"mode": "RESIZE", "scale": (-1.0, 1.0, 1.0)},
        {"mode": "ROTATE", "angle": 1.0, "axis": (0.0, 0.0, 0.0)},
        {"mode": "ROTATE", "angle": math.inf},
        {"radius": math.nan},
        {"radius": 1e30, "value": (0.0, 0.0, 1.0)},
    ],
)
def test_odd_motions_work(method: str, odd: dict):
    obj = scenes.grid_object()
    edit(obj, centre)
    grab(**{"radius": 0.4, "method": method, **odd})
    assert np.isfinite(edited(obj)).all()


def test_mirror_is_said_not_to_be_followed(capfd: pytest.CaptureFixture):
    obj = scenes.grid_object()
    obj.data.use_mirror_x = True
    edit(obj, lambda point: point.x > 0.75)
    before = edited(obj)
    grab(value=(0.0, 0.0, 0.5), radius=0.4)
    assert np.array_equal(edited(obj)[before[:, 0] < 0.0], before[before[:, 0] < 0.0])
    assert "Grab Once ignores the Mirror option" in capfd.readouterr().out


@pytest.mark.parametrize("method", GRABBING)
def test_vertices_without_a_place_stay_and_are_counted(method: str, capfd: pytest.CaptureFixture):
    obj = scenes.grid_object(cells=20)
    wrong = 10 * 21 + 14  # within the radius
    obj.data.vertices[wrong].co = (math.nan, 0.0, 0.0)
    chosen = edit(obj, lambda point: math.isfinite(point.x) and centre(point))
    before = edited(obj)
    grab(value=(0.0, 0.0, 0.5), radius=0.6, method=method)
    after = edited(obj)
    assert after[wrong].tobytes() == before[wrong].tobytes()
    assert np.isfinite(np.delete(after, wrong, axis=0)).all()
    assert np.array_equal(after[chosen], before[chosen] + np.float32((0.0, 0.0, 0.5)))
    assert "1 vertex has invalid coordinates (NaN or infinite) and will not move" in capfd.readouterr().out
    select(obj, lambda point: not math.isfinite(point.x))
    scenes.refused("The selected vertices have invalid coordinates", "grab_region", value=(0.0, 0.0, 0.5))


@pytest.mark.parametrize("method", GRABBING)
def test_messy_meshes_still_work(method: str):
    """N-gons, a face of no area, an edge of three faces, a wire, all within reach."""
    bm = bmesh.new()
    bmesh.ops.create_grid(bm, x_segments=8, y_segments=8, size=1.0)
    bm.verts.ensure_lookup_table()
    bmesh.ops.dissolve_faces(bm, faces=[face for face in bm.faces if face.calc_center_median().x > 0.5])
    bm.verts.ensure_lookup_table()
    edge = next(edge for edge in bm.edges if len(edge.link_faces) == 2)
    fin = bm.verts.new((edge.verts[0].co.x, edge.verts[0].co.y, 0.5))
    bm.faces.new((*edge.verts, fin))
    first, second, *_rest = bm.verts
    bm.faces.new((first, second, bm.verts.new(first.co)))
    bm.edges.new((first, bm.verts.new((-2.0, -2.0, 0.0))))
    obj = scenes.new_object("Messy", [])
    bm.to_mesh(obj.data)
    bm.free()
    chosen = edit(obj, lambda point: point.x < -0.9)
    before = edited(obj)
    grab(value=(0.0, 0.0, 0.5), radius=3.0, method=method)
    after = edited(obj)
    assert np.isfinite(after).all()
    assert np.array_equal(after[chosen], before[chosen] + np.float32((0.0, 0.0, 0.5)))


def keys_of(obj: bpy.types.Object) -> list[np.ndarray]:
    return [scenes.coordinates(key.data) for key in obj.data.shape_keys.key_blocks]


def test_the_active_shape_key_is_what_moves():
    obj = scenes.grid_object()
    scenes.add_key(obj, "Pose", Matrix()).data[0].co.z = -0.25
    obj.active_shape_key_index = 1
    basis, pose = keys_of(obj)
    chosen = edit(obj, centre)
    grab(value=(0.0, 0.0, 0.5), radius=0.4)
    bpy.ops.object.mode_set(mode="OBJECT")
    still, moved = keys_of(obj)
    assert np.array_equal(still, basis)
    assert np.abs(moved[chosen] - pose[chosen] - (0.0, 0.0, 0.5)).max() < 1e-6
    assert np.array_equal(moved[0], pose[0])


def test_shape_keys_of_a_mesh_that_grew_in_edit_mode_survive():
    """The same edit with and without a grab that does nothing leaves the same keys."""
    left = []
    for grabs in (False, True):
        obj = scenes.grid_object(f"Keys {grabs}", 4)
        scenes.add_key(obj, "Pose", scenes.slope(0.1, 0.2))
        obj.active_shape_key_index = 0
        edit(obj, lambda point: True)
        bpy.ops.mesh.subdivide()
        select(obj, centre)
        if grabs:
            grab(value=(0.0, 0.0, 0.0), radius=0.4)
        bpy.ops.object.mode_set(mode="OBJECT")
        left.append(keys_of(obj))
    assert np.array_equal(left[0], left[1])


def test_other_objects_in_edit_mode_stay():
    first, second = scenes.grid_object("First"), scenes.grid_object("Second")
    scenes.make_active(first, second)
    bpy.ops.object.mode_set(mode="EDIT")
    select(first, centre)
    select(second, centre)
    before = edited(second)
    grab(value=(0.0, 0.0, 0.5), radius=0.4)
    assert np.array_equal(edited(second), before)
    assert edited(first)[:, 2].max() == 0.5


class Hand:
    """A person at the mouse and keyboard, before a front view where a pixel is a centimetre."""

    def __init__(self, obj: bpy.types.Object, method: str = "thin_shell", radius: float = 0.4) -> None:
        typed = inner.typed_motion
        self.obj, self.x, self.y, self.before = obj, 500.0, 300.0, edited(obj)
        self.outcomes, self.view = inner.grabbing.Outcome, front_view()
        grab = inner.grab.Grab(obj, inner.methods.BY_ID[method])
        motion = typed.TypedMotion(typed.Mode.TRANSLATE, self.view, np.eye(3), (self.x, self.y))
        self.tool = inner.grabbing.Grabbing(grab, motion, grab.selection.mean(axis=0), np.eye(3), radius)

    def send(self, kind: str, value: str = "PRESS", **modifiers: bool):
        text = {"PERIOD": ".", "MINUS": "-", "ZERO": "0", "TWO": "2", "FIVE": "5"}.get(kind, "")
        return self.tool.process(self.obj, event(kind, value, self.x, self.y, text, **modifiers), self.view)

    def move(self, x: float, y: float, **modifiers: bool):
        self.x, self.y = self.x + x, self.y + y
        return self.send("MOUSEMOVE", "NOTHING", **modifiers)

    def type(self, *keys: str) -> None:
        for key in keys:
            assert self.send(key) is self.outcomes.GO_ON


@pytest.fixture
def hand() -> Hand:
    obj = scenes.grid_object(cells=20)
    edit(obj, centre)
    return Hand(obj)


def lifted(hand: Hand) -> np.ndarray:
    """How the selection moved, (3,)."""
    obj = hand.obj
    chosen = [vertex.index for vertex in bmesh.from_edit_mesh(obj.data).verts if vertex.select]
    obj.update_from_editmode()
    return (edited(obj)[chosen] - hand.before[chosen]).mean(axis=0)


def test_the_mouse_moves_in_the_plane_of_the_view(hand: Hand):
    """A turned view keeps the motion, and it goes on from there."""
    hand.move(30, 50)
    assert np.allclose(lifted(hand), (0.3, 0.0, 0.5), atol=1e-6)
    hand.move(10, 0, shift=True)
    assert np.allclose(lifted(hand), (0.31, 0.0, 0.5), atol=1e-6)
    right, up, toward = np.eye(3)[[1, 2, 0]]
    hand.view = hand.view.__class__(right=right, up=up, toward=toward, pixel=0.02, centre=(410.0, 300.0))
    hand.move(200, -100)
    assert np.allclose(lifted(hand), (0.31, 0.0, 0.5), atol=1e-6)
    hand.move(10, 5)
    assert np.allclose(lifted(hand), (0.31, 0.2, 0.6), atol=1e-6)


def test_axis_and_number_by_keys(hand: Hand):
    hand.send("Z")
    hand.send("Z", is_repeat=True)  # a key that is held counts once
    hand.move(30, 50)
    assert not hand.tool.typed.motion.local
    assert np.allclose(lifted(hand), (0.0, 0.0, 0.5), atol=1e-6)
    hand.type("ZERO", "PERIOD", "FIVE", "MINUS")
    assert np.allclose(lifted(hand), (0.0, 0.0, -0.5), atol=1e-6)
    assert hand.send("RET") is hand.outcomes.CONFIRMED
    assert np.allclose(lifted(hand), (0.0, 0.0, -0.5), atol=1e-6)


@pytest.mark.parametrize("method", GRABBING)
@pytest.mark.parametrize("key", ["ESC", "RIGHTMOUSE"])
def test_cancel_restores_every_bit_and_the_selection(key: str, method: str):
    obj = placed_object()
    random = np.random.default_rng(5)
    for vertex, z in zip(obj.data.vertices, random.normal(0.0, 0.05, len(obj.data.vertices))):
        vertex.co.z = z
    edit(obj, centre)
    before, chosen = edited(obj), selection(obj)
    hand = Hand(obj, method, radius=1.0)
    hand.move(30, 50)
    hand.type("R")
    hand.move(-80, 120)
    for _ in range(4):
        hand.send("WHEELDOWNMOUSE")
    hand.send("A")
    hand.move(7, 3)
    hand.send("TIMER", "NOTHING")
    assert not np.array_equal(edited(obj), before)
    assert hand.send(key) is hand.outcomes.CANCELLED
    assert edited(obj).tobytes() == before.tobytes()
    assert selection(obj) == chosen


@pytest.mark.parametrize("method", GRABBING)
def test_what_was_confirmed_is_what_the_properties_repeat(method: str):
    obj = scenes.grid_object(cells=20)
    edit(obj, centre)
    before = edited(obj)
    hand = Hand(obj, method)
    hand.move(33, 47)
    hand.type("R", "Y")
    hand.move(-11, 90)
    hand.send("WHEELDOWNMOUSE")
    assert hand.send("LEFTMOUSE") is hand.outcomes.CONFIRMED
    after, motion = edited(obj), hand.tool.typed.motion
    hand.tool.grab.restore(obj)
    assert np.array_equal(edited(obj), before)
    grab(mode="ROTATE", angle=motion.angle, axis=motion.axis, radius=hand.tool.radius, method=method)
    np.testing.assert_array_equal(edited(obj), after)


def test_a_turn_has_the_bits_of_the_standard_library():
    """Those of the sine of NumPy 1 depend on where its numbers lie in memory."""
    for angle in np.linspace(-3.0, 3.0, 1000).tolist():
        motion = inner.typed_motion.Motion(inner.typed_motion.Mode.ROTATE, angle=angle, axis=(0.0, 1.0, 0.0))
        assert motion.matrix(np.eye(3), np.zeros(3))[0, 2] == math.sin(angle)


def test_the_wheel_changes_how_much_follows(hand: Hand):
    def moved() -> int:
        return (edited(hand.obj) != hand.before).any(axis=1).sum()

    hand.move(0, 50)
    narrow = moved()
    for _ in range(5):
        hand.send("PAGE_UP")
    assert moved() > 1.5 * narrow
    for _ in range(5):
        hand.send("WHEELUPMOUSE")
    assert moved() == narrow
    assert hand.tool.radius == pytest.approx(0.4)
    hand.send("A")
    assert moved() == len(hand.before)


def test_navigation_passes_through_and_other_keys_do_not(hand: Hand):
    assert hand.send("MIDDLEMOUSE") is hand.outcomes.PASS
    assert hand.send("WHEELUPMOUSE", ctrl=True) is hand.outcomes.PASS
    assert hand.send("NDOF_MOTION", "NOTHING") is hand.outcomes.PASS
    hand.type("DEL", "NONE")
    assert np.array_equal(edited(hand.obj), hand.before)


def test_a_preview_goes_on_while_the_mouse_rests():
    obj = scenes.grid_object(cells=40)
    edit(obj, centre)
    hand = Hand(obj, "arap", radius=0.7)
    hand.move(10, 80)
    for _ in range(100):
        hand.send("TIMER", "NOTHING")
    assert hand.tool.grab.settled
    rested = edited(obj)
    assert hand.send("RET") is hand.outcomes.CONFIRMED
    assert np.abs(edited(obj) - rested).max() < 0.02


def test_a_mesh_that_changed_under_the_tool_is_left_alone(hand: Hand):
    hand.move(0, 50)
    bmesh.from_edit_mesh(hand.obj.data).verts.new((9.0, 9.0, 9.0))
    with pytest.raises(inner.errors.TopologyChangedError, match="edited meanwhile"):
        hand.move(0, 10)


@pytest.mark.parametrize("key", ["RET", "ESC"])
def test_a_heavy_region_binds_in_a_thread_and_is_confirmed_when_ready(
    monkeypatch: pytest.MonkeyPatch, key: str
):
    """Or cancelled at once."""
    use_threads(monkeypatch)
    obj = scenes.grid_object(cells=30)
    edit(obj, centre)
    before = edited(obj)
    hand = Hand(obj, "arap")
    assert hand.tool.grab.job is not None
    hand.move(0, 50)
    assert np.array_equal(edited(obj), before)
    outcome = hand.send(key)
    if key == "ESC":
        assert (outcome, hand.tool.grab.job) == (hand.outcomes.CANCELLED, None)
        assert np.array_equal(edited(obj), before)
        return
    while outcome is hand.outcomes.GO_ON:
        hand.tool.grab.job and hand.tool.grab.job.thread.join()
        outcome = hand.send("TIMER", "NOTHING")
    assert outcome is hand.outcomes.CONFIRMED
    after = edited(obj)
    hand.tool.grab.restore(obj)
    grab(value=hand.tool.typed.motion.move, radius=0.4, method="arap")
    assert np.array_equal(edited(obj), after)


def test_scaling_all_that_is_connected_binds_when_it_is_asked_for(monkeypatch: pytest.MonkeyPatch):
    """Moved and turned, a surface that nothing holds goes as one piece, without a bind."""
    use_threads(monkeypatch)
    obj = scenes.grid_object(cells=20)
    chosen = edit(obj, centre)
    before = edited(obj)
    hand = Hand(obj, radius=np.inf)
    assert hand.tool.grab.job is None
    hand.move(0, 50)
    assert np.allclose(edited(obj), before + (0.0, 0.0, 0.5), atol=1e-6)
    hand.type("S", "TWO")
    hand.tool.grab.job.thread.join()
    hand.send("TIMER", "NOTHING")
    assert np.allclose(edited(obj)[chosen], before[chosen] * 2.0, atol=1e-6)
    assert hand.send("RET") is hand.outcomes.CONFIRMED
    after = edited(obj)
    hand.tool.grab.restore(obj)
    grab(mode="RESIZE", scale=(2.0, 2.0, 2.0), unlimited=True, method="thin_shell")
    assert np.array_equal(edited(obj), after)
