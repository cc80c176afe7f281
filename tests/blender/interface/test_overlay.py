# SPDX-License-Identifier: GPL-3.0-or-later
"""What overlays would draw, without drawing: arrays, when they are made anew, what stays registered."""

import builtins
import types
from collections.abc import Callable, Iterable

import addon_utils
import bmesh
import bpy
import numpy as np
import pytest
from inside import OPACITY, inner
from mathutils import Color, Matrix
from rigs import rig as scenes
from rigs.cages import ball, box, mean_value, set_rest, surround

SLACK = 1e-4  # a fortieth of what a screen can show; Blender's own conversion is a fast approximation
KINDS = ("REGIONS", "WEIGHT", "PARAMETER", "MASK", "CAGE", "GRID", "BANDS", "GRAPH", "DISTORTION")


def scale(value: float) -> np.ndarray:
    """The colour of a value between 0 and 1."""
    return np.array(inner.overlay_colours.scale(np.full(1, value))[0])


def chosen(name: str) -> np.ndarray:
    """The colour that the preferences give something, as it is on the screen."""
    return on_screen(getattr(inner.preferences.preferences(bpy.context), name))


def covered(picture) -> np.ndarray:
    """Its colours, premultiplied."""
    alpha = picture.colours[:, 3:]
    return np.concatenate((picture.colours[:, :3] * alpha, alpha), axis=1)


def on_screen(linear) -> np.ndarray:
    """By Blender's own conversion."""
    return np.array(Color(linear).from_scene_linear_to_srgb())


def colour_of(plate: scenes.Rig) -> np.ndarray:
    return on_screen(plate.deformer.handles[0].colour)


def assert_covers(picture, vertices, rgb: np.ndarray, amount: float | np.ndarray = OPACITY) -> None:
    """There, and as much of it."""
    amount = np.reshape(amount, (-1, 1))
    expected = np.concatenate((rgb * amount, amount), axis=1)
    assert np.abs(covered(picture)[vertices] - expected).max() < SLACK


def choose(cage: bpy.types.Object, vertices: Iterable[int]) -> None:
    for vertex in cage.data.vertices:
        vertex.select = vertex.index in vertices


def is_even(picture, vertices=slice(None)) -> bool:
    return len(np.unique(covered(picture)[vertices], axis=0)) == 1


def ticks(picture) -> list[str]:
    return [text for _at, text in picture.legend.ticks]


def others(*groups: np.ndarray) -> np.ndarray:
    """The vertices of the plate that are in none of these."""
    return np.setdiff1d(np.arange(121), np.concatenate(groups))


@pytest.mark.parametrize(
    ("method", "kind", "flat", "none"),
    [
        ("spline_surface", "GRID", 1e-4, "Soft Sheet has no control grid"),
        ("embedded_deformation", "GRAPH", 0.2, "Soft Sheet has no graph"),
        ("rigid_cells", "GRAPH", 0.2, "Soft Sheet has no graph"),  # cells are cubes
    ],
)
def test_grids_and_graphs_move_with_the_handles(
    paint, plate: scenes.Rig, method: str, kind: str, flat: float, none: str
):
    plate.bind(method)
    if kind == "GRID":
        plate.deformer.parameters.columns, plate.deformer.parameters.rows = 7, 5
        scenes.update()

    def points() -> np.ndarray:
        """The middle of the bead of each node; beads come after the bars."""
        picture = paint(plate.obj, overlay=kind)
        if kind == "GRID":
            assert (picture.legend.note, len(picture.points)) == ("7 x 5 points", 8 * 58 + 6 * 35)
        count = 35 if kind == "GRID" else int(picture.legend.note.split()[0].replace(",", ""))
        assert np.isfinite(picture.points).all()
        assert picture.triangles.max() == len(picture.points) - 1
        return picture.points[-6 * count :].reshape(count, 6, 3).mean(axis=1)

    at_rest = points()
    assert len(at_rest) > 20
    assert np.abs(at_rest[:, 2]).max() < flat
    plate.lift(1.0)
    lifted = points() - at_rest
    assert kind != "GRID" or np.abs(lifted[:, :2]).max() < 1e-4
    assert lifted[:, 2].max() > 0.9
    assert lifted[:, 2].min() < 0.1
    plate.deformer.method = "thin_shell"
    assert paint(plate.obj, overlay=kind).legend.note == none


def test_bands_lie_between_the_handles(paint, plate: scenes.Rig):
    plate.bind("handle_aware_isolines")
    plate.deformer.parameters.bands = 8
    scenes.update()
    picture = paint(plate.obj, overlay="BANDS")
    count = int(picture.legend.note.split()[0])
    assert 5 <= count <= 8  # four around each handle, some of which may have no vertex
    assert len(np.unique(covered(picture), axis=0)) == count
    assert is_even(picture, plate.top)
    assert is_even(picture, plate.base)
    assert not is_even(picture, np.concatenate((plate.top, plate.base)))
    plate.deformer.method = "thin_shell"
    assert paint(plate.obj, overlay="BANDS").legend.note == "Soft Sheet has no bands"


def test_regions_have_their_colours_on_the_whole_mesh(paint, bound_plate: scenes.Rig):
    """Where one ends its colour goes on without cover, else the faces around it would fade to black."""
    picture = paint(bound_plate.obj, overlay="REGIONS")
    assert picture.colours.dtype == picture.points.dtype == np.float32
    assert_covers(picture, bound_plate.top, colour_of(bound_plate))
    assert_covers(picture, bound_plate.base, chosen("overlay_fixed"))
    assert not covered(picture)[others(bound_plate.top, bound_plate.base)].any()
    assert list(dict(picture.legend.rows)) == ["Top", "Still"]
    rest = bound_plate.rest()
    next_to = np.flatnonzero(np.abs(rest[:, 1] - 0.6) < 1e-5)
    assert len(next_to) == 11
    assert np.abs(picture.colours[next_to] - (*colour_of(bound_plate), 0.0)).max() < SLACK
    corners = rest[picture.triangles]
    areas = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
    assert areas.min() > 0.0
    assert areas.sum() == pytest.approx(4.0)


def test_soft_weights_fade(paint, plate: scenes.Rig):
    for x, weight in ((-1.0, 0.25), (1.0, 0.5)):
        half = [int(v) for v in plate.top if plate.rest()[v, 0] * x > 0.0]
        plate.obj.vertex_groups["Top"].add(half, weight, "REPLACE")
    plate.bind()
    plate.deformer.handles[0].weight = 0.8
    scenes.update()
    x = plate.rest()[plate.top, 0]
    amount = OPACITY * 0.8 * np.where(x < -1e-6, 0.25, np.where(x > 1e-6, 0.5, 1.0))
    assert_covers(paint(plate.obj, overlay="REGIONS"), plate.top, colour_of(plate), amount)


def test_around_a_support_is_fixed(paint, plate: scenes.Rig):
    soft = scenes.add_group(plate.obj, "Soft", lambda point: point[1] > -0.3)
    plate.bind(fixed=False)
    scenes.press(plate.obj, "handle_add", kind="SUPPORT", vertex_group="Soft")
    picture = paint(plate.obj, overlay="REGIONS")
    assert_covers(picture, others(soft), chosen("overlay_fixed"))
    assert not covered(picture)[np.setdiff1d(soft, plate.top)].any()


def test_what_the_mask_hides_is_dark(paint, bound_plate: scenes.Rig):
    left = scenes.add_group(bound_plate.obj, "Left", lambda point: point[0] < 0.0)
    bound_plate.deformer.mask_group = "Left"
    scenes.update()
    picture = paint(bound_plate.obj, overlay="REGIONS")
    dark = np.array(inner.overlay_colours.HIDDEN)
    assert_covers(picture, others(left), dark)
    assert_covers(picture, np.intersect1d(left, bound_plate.top), colour_of(bound_plate))
    assert dict(picture.legend.rows)["Masked out"] == pytest.approx(tuple(dark))
    mask = paint(bound_plate.obj, overlay="MASK")
    assert set(np.unique(covered(mask)[left], axis=0)[:, 3]) == {np.float32(OPACITY)}
    assert is_even(mask, others(left))
    assert mask.legend.note == "Painted by Left"


def test_weight_of_the_active_handle(paint, bound_plate: scenes.Rig):
    bound_plate.deformer.active_handle = 1
    picture = paint(bound_plate.obj, overlay="WEIGHT")
    assert_covers(picture, bound_plate.base, scale(1.0))
    assert is_even(picture, others(bound_plate.base))
    assert picture.legend.title == "Weight of Base"
    bound_plate.deformer.active_handle = 0
    assert_covers(paint(bound_plate.obj), bound_plate.top, scale(1.0))


def test_painted_parameter_and_its_numbers(paint, plate: scenes.Rig):
    firm = scenes.add_group(plate.obj, "Firm", lambda point: point[0] < 0.0)
    plate.bind("arap")
    plate.deformer.arap.rigidity, plate.deformer.arap.rigidity_group = 0.5, "Firm"
    scenes.update()
    picture = paint(plate.obj, overlay="PARAMETER", parameter="rigidity")
    assert picture.legend.title == "Rigidity"
    assert ticks(picture) == ["0", "0.125", "0.25", "0.375", "0.5"]
    assert is_even(picture, firm)
    assert is_even(picture, others(firm))
    assert not is_even(picture)
    other = paint(plate.obj, parameter="bending")  # Natural Bend has none: its own is shown
    assert other.legend.title == "Rigidity"


def test_a_parameter_of_zero_is_zero_everywhere(paint, bound_plate: scenes.Rig):
    bound_plate.deformer.thin_shell.stretching = 0.0
    picture = paint(bound_plate.obj, overlay="PARAMETER", parameter="stretching")
    assert np.abs(picture.colours[:, :3] - scale(0.0)).max() < SLACK
    assert ticks(picture) == ["0", "0.25", "0.5", "0.75", "1"]
    assert picture.legend.note == "The same everywhere"


def test_weights_painted_later_show_when_the_mesh_is_tagged(paint, bound_plate: scenes.Rig):
    bound_plate.deformer.mask_group = "Later"
    scenes.update()
    assert paint(bound_plate.obj, overlay="MASK").legend.note == "No mask: shown everywhere"
    scenes.add_group(bound_plate.obj, "Later", lambda point: point[0] < 0.0)
    bound_plate.obj.data.update_tag()
    scenes.update()
    assert paint(bound_plate.obj).legend.note == "Painted by Later"


def stretched_plate(plate: scenes.Rig, *factors: float) -> bpy.types.Object:
    """All of the plate is one handle, scaled."""
    scenes.add_group(plate.obj, "All", lambda point: True)
    scenes.add_regions(plate.obj, "thin_shell", {"All": "HANDLE"})
    scenes.move_world(plate.control, Matrix.Diagonal((*factors, 1.0)))
    return plate.obj


@pytest.mark.parametrize(
    ("measure", "factors", "end"),
    [
        ("STRETCH", (2.0, 1.0, 1.0), "overlay_stretched"),
        ("STRETCH", (0.5, 0.5, 1.0), "overlay_compressed"),
        ("AREA", (2.0, 1.0, 1.0), "overlay_stretched"),
        ("AREA", (0.5, 1.0, 1.0), "overlay_compressed"),
        ("ANGLE", (0.5, 1.0, 1.0), "overlay_stretched"),
        ("DIRICHLET", (4.0, 4.0, 1.0), "overlay_stretched"),
    ],
)
def test_distortion_has_full_colour_at_the_range(paint, plate: scenes.Rig, measure, factors, end):
    obj = stretched_plate(plate, *factors)
    picture = paint(obj, overlay="DISTORTION", measure=measure, distortion_range=2.0)
    assert_covers(picture, slice(None), chosen(end))
    assert ticks(picture)[-1] == "2"
    assert ticks(picture)[0] == ("0.5" if measure in ("STRETCH", "AREA") else "1")


def test_without_distortion_all_is_neutral(paint, plate: scenes.Rig):
    obj = stretched_plate(plate, 1.0, 1.0, 1.0)
    scenes.move_world(plate.control, Matrix.Translation((1.0, 2.0, 3.0)) @ Matrix.Rotation(0.7, 4, "X"))
    neutral = np.array(inner.overlay_colours.NEUTRAL)
    for measure in ("STRETCH", "AREA", "ANGLE", "DIRICHLET"):
        picture = paint(obj, overlay="DISTORTION", measure=measure)
        assert np.abs(picture.colours[:, :3] - neutral).max() < 0.01


def test_factor_and_mask_lessen_the_distortion(paint, plate: scenes.Rig):
    obj = stretched_plate(plate, 3.0, 1.0, 1.0)
    plate.deformer.factor = 0.5
    scenes.update()
    paint(obj, overlay="DISTORTION", measure="STRETCH")
    found = inner.result.measured(obj, plate.deformer, inner.distortion.Measure.STRETCH)
    assert np.allclose(found.values, 2.0, atol=1e-5)


def test_the_picture_lies_on_what_blender_shows(paint, bound_plate: scenes.Rig):
    smooth = bound_plate.obj.modifiers.new("Smooth", "SMOOTH")
    smooth.factor, smooth.iterations = 0.5, 3
    bound_plate.lift()
    assert np.array_equal(paint(bound_plate.obj, overlay="REGIONS").points, bound_plate.points())
    smooth.iterations = 10  # Sinew has nothing to solve, the surface moves all the same
    assert np.array_equal(bound_plate.points(), paint(bound_plate.obj).points)


def test_a_subdivision_below_is_covered_smoothly(paint, bound_plate: scenes.Rig):
    bound_plate.lift()
    coarse = covered(paint(bound_plate.obj, overlay="REGIONS"))
    bound_plate.obj.modifiers.new("Subdivision", "SUBSURF").levels = 2
    shown = bound_plate.points()
    fine = paint(bound_plate.obj)
    assert np.array_equal(fine.points, shown)
    assert np.abs(covered(fine)[: len(coarse)] - coarse).max() < SLACK
    beyond, y = covered(fine)[len(coarse) :], shown[len(coarse) :, 1]
    between_rows_of_one_region = y > 0.85
    assert np.abs(beyond[between_rows_of_one_region] - coarse[bound_plate.top[0]]).max() < 0.01
    assert not beyond[np.abs(y) < 0.5].any()
    assert (beyond[:, 3] <= OPACITY + SLACK).all()


def test_copies_have_the_colours_of_their_origin(paint, bound_plate: scenes.Rig):
    array = bound_plate.obj.modifiers.new("Array", "ARRAY")
    array.count, array.relative_offset_displace = 3, (1.5, 0.0, 0.0)
    bound_plate.lift(0.5)
    picture = paint(bound_plate.obj, overlay="REGIONS")
    assert len(picture.points) == 3 * 121
    assert np.array_equal(covered(picture).reshape(3, 121, 4), np.stack([covered(picture)[:121]] * 3))
    assert covered(picture)[bound_plate.top, 3].all()


@pytest.mark.parametrize("where", ["Remesh", "Edit Mode"])
def test_the_deformers_own_shape_is_covered_where_blender_shows_another(
    paint, bound_plate: scenes.Rig, where: str
):
    """The order of vertices is lost, or the mesh that is edited is not the one that is shown."""
    bound_plate.lift(0.5)
    own = bound_plate.points()
    if where == "Remesh":
        bound_plate.obj.modifiers.new("Remesh", "REMESH")
        scenes.update()
        picture = paint(bound_plate.obj, overlay="REGIONS")
        assert np.abs(picture.points - own).max() < SLACK
    else:
        with scenes.in_mode(bound_plate.obj):
            scenes.update()
            picture = paint(bound_plate.obj, overlay="REGIONS")
        assert np.array_equal(picture.points, own)
    assert covered(picture)[bound_plate.top, 3].all()


def test_a_mesh_that_lost_vertices_has_no_overlay_until_bound_again(paint, bound_plate: scenes.Rig):
    bound_plate.lift(0.5)
    with scenes.in_mode(bound_plate.obj):
        bpy.ops.mesh.select_all(action="DESELECT")
        assert paint(bound_plate.obj, overlay="REGIONS") is not None
        edit = bmesh.from_edit_mesh(bound_plate.obj.data)
        edit.verts.ensure_lookup_table()
        bmesh.ops.delete(edit, geom=[edit.verts[60]], context="VERTS")
        bmesh.update_edit_mesh(bound_plate.obj.data)
        scenes.update()
        assert paint(bound_plate.obj) is None
    scenes.update()
    assert paint(bound_plate.obj) is None
    bpy.ops.sinew.bind()
    scenes.update()
    assert len(paint(bound_plate.obj).points) == 120


def test_nothing_bound_draws_nothing_and_has_nothing_to_select(paint, plate: scenes.Rig):
    scenes.press(plate.obj, "deformer_add", method="arap")
    for kind in KINDS:
        assert paint(plate.obj, overlay=kind) is None
    scenes.refused("poll", "select_distorted")


def test_a_picture_is_made_anew_exactly_when_something_changed(paint, overlay, bound_plate: scenes.Rig):
    cache, obj = overlay.cache, bound_plate.obj
    other = scenes.new_empty("Other")

    def painted(change: Callable = lambda: None, **wanted) -> int:
        before = cache.computed
        change()
        scenes.update()
        first = paint(obj, **wanted)
        assert paint(obj) is first
        return cache.computed - before

    deformer, settings = bound_plate.deformer, bpy.context.scene.sinew
    assert painted(overlay="REGIONS") == 1
    assert painted() == 0
    assert painted(lambda: setattr(other, "location", (1.0, 0.0, 0.0))) == 0
    assert painted(lambda: setattr(obj, "location", (0.0, 0.0, 1.0))) == 0
    assert painted(lambda: setattr(settings, "measure", "AREA")) == 1
    assert painted(lambda: bound_plate.lift(0.3)) == 1
    assert painted(lambda: setattr(deformer.handles[0], "colour", (0.1, 0.2, 0.3))) == 1
    assert painted(lambda: setattr(deformer.handles[0], "name", "Renamed")) == 1
    assert painted(lambda: setattr(deformer, "factor", 0.5)) == 1
    assert painted(lambda: setattr(settings, "opacity", 0.4)) == 1
    assert painted(lambda: bpy.ops.sinew.bind()) == 1
    assert painted(overlay="DISTORTION") == 1
    assert painted(lambda: setattr(deformer.handles[0], "colour", (0.3, 0.2, 0.1))) == 0
    before = cache.computed
    for _ in range(100):
        paint(obj)
    assert cache.computed == before


def test_select_shows_the_most_distorted_vertex(paint, plate: scenes.Rig):
    plate.bind("arap")
    scenes.move_world(plate.control, Matrix.Translation((0.2, 0.5, 0.4)))
    paint(plate.obj, overlay="DISTORTION", measure="STRETCH")
    found = inner.result.measured(plate.obj, plate.deformer, inner.distortion.Measure.STRETCH)
    scenes.press(plate.obj, "select_distorted", measure="STRETCH")
    assert plate.obj.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    (selected,) = [vertex.index for vertex in plate.obj.data.vertices if vertex.select]
    away = np.abs(np.log(found.values))
    assert away[selected] == away.max() > 0.1


def test_the_graphics_card_is_not_touched_in_background(paint, overlay, bound_plate: scenes.Rig, monkeypatch):
    imported = builtins.__import__

    def guarded(name, *args, **keywords):
        assert name.split(".")[0] not in ("gpu", "blf", "gpu_extras"), name
        return imported(name, *args, **keywords)

    monkeypatch.setattr(builtins, "__import__", guarded)
    for module in vars(overlay).values():
        assert not (isinstance(module, types.ModuleType) and module.__name__ in ("gpu", "blf"))
    bpy.context.scene.sinew.show_overlay = True
    assert not overlay.is_drawing()
    assert followers(overlay) == 1, "that of the fixture"
    for kind in KINDS:
        assert paint(bound_plate.obj, overlay=kind) is not None
    bpy.context.scene.sinew.show_overlay = False


def followers(overlay) -> int:
    """How many of the handlers that only drawing needs are in place."""
    frames, updates = bpy.app.handlers.frame_change_post, bpy.app.handlers.depsgraph_update_post
    return (overlay.on_frame in frames) + (overlay.on_update in updates)


@pytest.fixture
def windowed(monkeypatch):
    """As if there was a window; nothing is drawn without one, whatever is registered."""
    overlay = inner.overlay
    monkeypatch.setattr(overlay, "has_window", lambda: True)
    yield overlay
    overlay.stop()


def test_switching_off_in_every_scene_leaves_nothing_behind(windowed, scene):
    for _ in range(3):
        scene.sinew.show_overlay = True
        assert windowed.is_drawing()
        assert followers(windowed) == 2
        scene.sinew.overlay = "DISTORTION"
        assert followers(windowed) == 2
        scene.sinew.show_overlay = False
        assert not windowed.is_drawing()
        assert followers(windowed) == 0
    other = bpy.data.scenes.new("Other")
    other.sinew.show_overlay = scene.sinew.show_overlay = True
    scene.sinew.show_overlay = False
    assert windowed.is_drawing()
    other.sinew.show_overlay = False
    assert not windowed.is_drawing()


def test_undo_and_load_are_followed(windowed, scene, tmp_path):
    bpy.ops.ed.undo_push(message="off")
    scene.sinew.show_overlay = True
    bpy.ops.ed.undo_push(message="on")
    path = str(tmp_path / "on.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.ed.undo()
    assert not bpy.context.scene.sinew.show_overlay
    assert not windowed.is_drawing()
    bpy.ops.ed.redo()
    assert windowed.is_drawing()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert not windowed.is_drawing()
    bpy.ops.wm.open_mainfile(filepath=path)
    assert bpy.context.scene.sinew.show_overlay
    assert windowed.is_drawing()


def test_disabling_the_add_on_stops_it(windowed, addon_name, scene):
    scene.sinew.show_overlay = True
    assert windowed.is_drawing()
    addon_utils.disable(addon_name)
    try:
        assert not windowed.is_drawing()
        assert followers(windowed) == 0
        assert windowed.on_other_state not in bpy.app.handlers.load_post
        assert not hasattr(bpy.types.Scene, "sinew")
    finally:
        addon_utils.enable(addon_name, default_set=True)


def test_the_depth_offset_moves_towards_the_viewer_only():
    """A point drawn a share nearer has the depth that the point at that share of its distance has."""
    nearer, share = inner.overlay_draw.nearer, 0.01
    near, far, point = 0.1, 100.0, np.array((0.3, -0.2, -7.0, 1.0))
    perspective = np.diag((2.0, 3.0, -(far + near) / (far - near), 0.0))
    perspective[2, 3], perspective[3, 2] = -2.0 * far * near / (far - near), -1.0
    moved, plain = nearer(perspective, 7.0, share) @ point, perspective @ point
    closer = perspective @ (point * (1.0, 1.0, 1.0 - share, 1.0))
    assert np.allclose(moved[:2] / moved[3], plain[:2] / plain[3])
    assert moved[2] / moved[3] == pytest.approx(closer[2] / closer[3], rel=1e-12)
    orthographic = np.diag((0.5, 0.5, -2.0 / far, 1.0))
    moved, plain = nearer(orthographic, 7.0, share) @ point, orthographic @ point
    assert np.allclose(moved[:2], plain[:2])
    assert moved[2] == pytest.approx((orthographic @ (point + (0, 0, 7.0 * share, 0)))[2], rel=1e-12)


@pytest.fixture
def caged(scene) -> tuple[bpy.types.Object, bpy.types.Object]:
    """A ball and the box around it that moves it."""
    target, cage = ball(), box(size=1.6)
    surround(target, cage)
    return target, cage


def test_weight_of_the_selected_cage_vertices(paint, caged):
    target, cage = caged
    choose(cage, [5])
    one = paint(target, overlay="CAGE")
    assert one.legend.title == "Weight of cage vertex 5"
    weights = mean_value(cage, scenes.base_points(target)).vertex_weights[:, 5]
    assert np.abs(covered(one)[:, 3] - OPACITY * (0.6 + 0.4 * weights)).max() < SLACK
    choose(cage, range(8))
    assert_covers(paint(target), slice(None), scale(1.0))
    choose(cage, [])
    assert paint(target).legend.note == "Select vertices of the cage"
    with scenes.in_mode(cage):
        bpy.ops.mesh.select_all(action="DESELECT")
        edit = bmesh.from_edit_mesh(cage.data)
        edit.verts.ensure_lookup_table()
        edit.verts[3].select = True
        assert paint(target).legend.title == "Weight of cage vertex 3"


def test_vertices_outside_the_cage_and_negative_weights_stand_out(paint, caged):
    target, cage = caged
    cage.scale = (0.5, 1.0, 1.0)
    scenes.update()
    set_rest(target)
    choose(cage, [vertex.index for vertex in cage.data.vertices if vertex.co.x > 0.0])
    picture, lost = paint(target, overlay="CAGE"), chosen("overlay_stretched")
    outside = np.abs(scenes.base_points(target)[:, 0]) > 0.4 + 1e-6
    assert_covers(picture, outside, lost)
    at_opacity = np.array((*(lost * OPACITY), OPACITY))
    assert not (np.abs(covered(picture)[~outside] - at_opacity).max(axis=1) < SLACK).any()
    assert f"{outside.sum():,} outside the cage" in picture.legend.note


def test_no_cage_weights_without_a_cage_or_while_another_method_is_bound(paint, bound_plate: scenes.Rig):
    """The latter as in a window, where a thread binds the method just chosen."""
    picture = paint(bound_plate.obj, overlay="CAGE")
    assert not picture.colours[:, 3].any()
    assert picture.legend.note == "Soft Sheet has no cage"
    with inner.sessions.suspended():
        bound_plate.deformer.method = "green"
    assert inner.result.influence(bound_plate.deformer) is None
