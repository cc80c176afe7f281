# SPDX-License-Identifier: GPL-3.0-or-later
"""What overlays would draw, without drawing: arrays, when they are made anew, what stays registered."""

import builtins
import types

import addon_utils
import bmesh
import bpy
import numpy as np
import pytest
from inside import RESULT
from mathutils import Color, Matrix
from rig import Rig, add_group, base_points, make_active, move_world, update

OPACITY = 0.5
SLACK = 1e-4  # a fortieth of what a screen can show; Blender's own conversion is a fast approximation


@pytest.fixture
def overlay(room, scene):
    """``ui.overlay``, with its updates followed as with a window, and a known opacity."""
    module = room("ui.overlay")
    module.cache.clear()
    preferences = room("preferences").preferences(bpy.context)
    preferences.overlay_opacity = 1.0
    bpy.context.scene.sinew.opacity = OPACITY
    bpy.app.handlers.depsgraph_update_post.append(module.on_update)
    yield module
    bpy.app.handlers.depsgraph_update_post.remove(module.on_update)
    preferences.property_unset("overlay_opacity")


@pytest.fixture
def paint(overlay, room):
    """The picture of an object for some settings."""

    def picture(obj: bpy.types.Object, **wanted):
        for name, value in wanted.items():
            setattr(bpy.context.scene.sinew, name, value)
        look = room("ui.overlay_mesh").overlay_settings(bpy.context)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        return overlay.cache.overlay_mesh(obj, obj.sinew.active, look, depsgraph)

    return picture


def covered(picture) -> np.ndarray:
    """Its colours, premultiplied."""
    return picture.colours * np.concatenate(
        (picture.colours[:, 3:].repeat(3, axis=1), np.ones((len(picture.colours), 1))), axis=1
    )


def on_screen(linear) -> np.ndarray:
    """By Blender's own conversion."""
    return np.array(Color(linear).from_scene_linear_to_srgb())


def chosen(room, name: str) -> np.ndarray:
    return on_screen(getattr(room("preferences").preferences(bpy.context), name))


def cover(rgb: np.ndarray, amount: float) -> np.ndarray:
    """Premultiplied."""
    return np.array((*(rgb * amount), amount))


def rows(picture) -> dict:
    return dict(picture.legend.rows)


def test_each_region_has_its_colour_and_free_vertices_none(paint, room, bound_plate: Rig):
    picture = paint(bound_plate.obj, overlay="REGIONS")
    handle = on_screen(bound_plate.deformer.handles[0].colour)
    assert np.abs(covered(picture)[bound_plate.top] - cover(handle, OPACITY)).max() < SLACK
    fixed = cover(chosen(room, "overlay_fixed"), OPACITY)
    assert np.abs(covered(picture)[bound_plate.base] - fixed).max() < SLACK
    free = np.setdiff1d(np.arange(121), np.concatenate((bound_plate.top, bound_plate.base)))
    assert not covered(picture)[free].any()
    assert picture.colours.dtype == picture.points.dtype == np.float32
    assert list(rows(picture)) == ["Top", "Fixed"]


def test_where_a_region_ends_its_colour_goes_on_without_cover(paint, bound_plate: Rig):
    """Else the faces around a region would fade to black."""
    picture = paint(bound_plate.obj, overlay="REGIONS")
    rest, handle = bound_plate.rest(), on_screen(bound_plate.deformer.handles[0].colour)
    next_to = np.flatnonzero(np.abs(rest[:, 1] - 0.6) < 1e-5)
    assert len(next_to) == 11
    assert np.abs(picture.colours[next_to] - (*handle, 0.0)).max() < SLACK


def test_triangles_cover_the_rest_mesh(paint, bound_plate: Rig):
    picture = paint(bound_plate.obj, overlay="REGIONS")
    corners = base_points(bound_plate.obj)[picture.triangles]
    areas = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
    assert areas.min() > 0.0
    assert areas.sum() == pytest.approx(4.0)


def test_soft_weights_fade(paint, plate: Rig):
    for x, weight in ((-1.0, 0.25), (1.0, 0.5)):
        half = [int(v) for v in plate.top if plate.rest()[v, 0] * x > 0.0]
        plate.obj.vertex_groups["Top"].add(half, weight, "REPLACE")
    plate.bind()
    plate.deformer.handles[0].weight = 0.8
    update()
    picture = paint(plate.obj, overlay="REGIONS")
    x = plate.rest()[plate.top, 0]
    expected = OPACITY * 0.8 * np.where(x < -1e-6, 0.25, np.where(x > 1e-6, 0.5, 1.0))
    assert np.abs(covered(picture)[plate.top, 3] - expected).max() < SLACK
    handle = on_screen(plate.deformer.handles[0].colour)
    assert np.abs(covered(picture)[plate.top, :3] - expected[:, None] * handle).max() < SLACK


def test_around_a_support_is_fixed(paint, room, plate: Rig):
    soft = add_group(plate.obj, "Soft", lambda point: point[1] > -0.3)
    plate.bind(fixed=False)
    make_active(plate.obj)
    bpy.ops.sinew.handle_add(kind="SUPPORT", vertex_group="Soft")
    picture = paint(plate.obj, overlay="REGIONS")
    outside = np.setdiff1d(np.arange(121), soft)
    fixed = cover(chosen(room, "overlay_fixed"), OPACITY)
    assert np.abs(covered(picture)[outside] - fixed).max() < SLACK
    assert not covered(picture)[np.setdiff1d(soft, plate.top)].any()


def test_what_the_mask_hides_is_dark(paint, room, bound_plate: Rig):
    left = add_group(bound_plate.obj, "Left", lambda point: point[0] < 0.0)
    bound_plate.deformer.mask_group = "Left"
    update()
    picture = paint(bound_plate.obj, overlay="REGIONS")
    dark = np.array(room("ui.overlay_colours").HIDDEN)
    right = np.setdiff1d(np.arange(121), left)
    assert np.abs(covered(picture)[right] - cover(dark, OPACITY)).max() < SLACK
    shown = np.intersect1d(left, bound_plate.top)
    handle = on_screen(bound_plate.deformer.handles[0].colour)
    assert np.abs(covered(picture)[shown] - cover(handle, OPACITY)).max() < SLACK
    assert rows(picture)["Masked out"] == pytest.approx(tuple(dark))
    mask = paint(bound_plate.obj, overlay="MASK")
    assert set(np.unique(covered(mask)[left], axis=0)[:, 3]) == {np.float32(OPACITY)}
    assert len(np.unique(covered(mask)[right], axis=0)) == 1
    assert mask.legend.note == "Painted by Left"


def test_weight_of_the_active_handle(paint, room, bound_plate: Rig):
    bound_plate.deformer.active_handle = 1
    picture = paint(bound_plate.obj, overlay="WEIGHT")
    bright = np.array(room("ui.overlay_colours").scale(np.ones(1))[0])
    assert np.abs(covered(picture)[bound_plate.base] - cover(bright, OPACITY)).max() < SLACK
    others = np.setdiff1d(np.arange(121), bound_plate.base)
    assert len(np.unique(covered(picture)[others], axis=0)) == 1
    assert picture.legend.title == "Weight of Base"
    bound_plate.deformer.active_handle = 0
    again = paint(bound_plate.obj)
    assert np.abs(covered(again)[bound_plate.top] - cover(bright, OPACITY)).max() < SLACK


def test_painted_parameter_and_its_numbers(paint, plate: Rig):
    add_group(plate.obj, "Firm", lambda point: point[0] < 0.0)
    plate.bind("arap")
    plate.deformer.arap.rigidity, plate.deformer.arap.rigidity_group = 0.5, "Firm"
    update()
    picture = paint(plate.obj, overlay="PARAMETER", parameter="rigidity")
    assert picture.legend.title == "Rigidity"
    assert [text for _at, text in picture.legend.ticks] == ["0", "0.125", "0.25", "0.375", "0.5"]
    firm = plate.rest()[:, 0] < 0.0
    assert len(np.unique(covered(picture)[firm], axis=0)) == 1
    assert len(np.unique(covered(picture), axis=0)) == 2
    other = paint(plate.obj, parameter="bending")  # As-Rigid-As-Possible has none: its own is shown
    assert other.legend.title == "Rigidity"


def test_a_parameter_of_zero_is_zero_everywhere(paint, room, bound_plate: Rig):
    bound_plate.deformer.thin_shell.stretching = 0.0
    picture = paint(bound_plate.obj, overlay="PARAMETER", parameter="stretching")
    dark = np.array(room("ui.overlay_colours").scale(np.zeros(1))[0])
    assert np.abs(picture.colours[:, :3] - dark).max() < SLACK
    assert [text for _at, text in picture.legend.ticks] == ["0", "0.25", "0.5", "0.75", "1"]
    assert picture.legend.note == "The same everywhere"


def test_weights_painted_later_show_when_the_mesh_is_tagged(paint, bound_plate: Rig):
    bound_plate.deformer.mask_group = "Later"
    update()
    assert paint(bound_plate.obj, overlay="MASK").legend.note == "No mask: shown everywhere"
    add_group(bound_plate.obj, "Later", lambda point: point[0] < 0.0)
    bound_plate.obj.data.update_tag()
    update()
    assert paint(bound_plate.obj).legend.note == "Painted by Later"


def stretched_plate(plate: Rig, *factors: float) -> Rig:
    """All of the plate is one handle, scaled."""
    add_group(plate.obj, "All", lambda point: True)
    make_active(plate.obj)
    bpy.ops.sinew.deformer_add(method="thin_shell")
    bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group="All")
    move_world(plate.control, Matrix.Diagonal((*factors, 1.0)))
    return plate


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
def test_distortion_has_full_colour_at_the_range(paint, room, plate: Rig, measure, factors, end):
    stretched_plate(plate, *factors)
    picture = paint(plate.obj, overlay="DISTORTION", measure=measure, distortion_range=2.0)
    assert np.abs(covered(picture) - cover(chosen(room, end), OPACITY)).max() < 1e-4
    ticks = [text for _at, text in picture.legend.ticks]
    assert ticks[-1] == "2"
    assert ticks[0] == ("0.5" if measure in ("STRETCH", "AREA") else "1")


def test_without_distortion_all_is_neutral(paint, room, plate: Rig):
    stretched_plate(plate, 1.0, 1.0, 1.0)
    move_world(plate.control, Matrix.Translation((1.0, 2.0, 3.0)) @ Matrix.Rotation(0.7, 4, "X"))
    neutral = np.array(room("ui.overlay_colours").NEUTRAL)
    for measure in ("STRETCH", "AREA", "ANGLE", "DIRICHLET"):
        picture = paint(plate.obj, overlay="DISTORTION", measure=measure)
        assert np.abs(picture.colours[:, :3] - neutral).max() < 0.01


def test_factor_and_mask_lessen_the_distortion(paint, room, plate: Rig):
    stretched_plate(plate, 3.0, 1.0, 1.0)
    plate.deformer.factor = 0.5
    update()
    paint(plate.obj, overlay="DISTORTION", measure="STRETCH")
    measure = room("core.geometry.distortion").Measure.STRETCH
    found = room(RESULT).measured(plate.obj, plate.deformer, measure)
    assert np.allclose(found.values, 2.0, atol=1e-5)


def test_the_picture_lies_on_what_blender_shows(paint, bound_plate: Rig):
    smooth = bound_plate.obj.modifiers.new("Smooth", "SMOOTH")
    smooth.factor, smooth.iterations = 0.5, 3
    bound_plate.lift()
    assert np.array_equal(paint(bound_plate.obj, overlay="REGIONS").points, bound_plate.points())
    smooth.iterations = 10  # Sinew has nothing to solve, the surface moves all the same
    assert np.array_equal(bound_plate.points(), paint(bound_plate.obj).points)


def test_a_subdivision_below_is_covered_smoothly(paint, bound_plate: Rig):
    bound_plate.lift()
    coarse = covered(paint(bound_plate.obj, overlay="REGIONS"))
    bound_plate.obj.modifiers.new("Subdivision", "SUBSURF").levels = 2
    shown = bound_plate.points()
    fine = paint(bound_plate.obj)
    assert np.array_equal(fine.points, shown)
    assert np.abs(covered(fine)[: len(coarse)] - coarse).max() < SLACK
    beyond = covered(fine)[len(coarse) :]
    top = shown[len(coarse) :, 1] > 0.85  # between rows of one region
    assert np.abs(beyond[top] - coarse[bound_plate.top[0]]).max() < 0.01  # a trace of the bare side
    middle = np.abs(shown[len(coarse) :, 1]) < 0.5
    assert not beyond[middle].any()
    assert (beyond[:, 3] <= OPACITY + SLACK).all()


def test_copies_have_the_colours_of_their_origin(paint, bound_plate: Rig):
    array = bound_plate.obj.modifiers.new("Array", "ARRAY")
    array.count, array.relative_offset_displace = 3, (1.5, 0.0, 0.0)
    bound_plate.lift(0.5)
    picture = paint(bound_plate.obj, overlay="REGIONS")
    assert len(picture.points) == 3 * 121
    assert np.array_equal(covered(picture).reshape(3, 121, 4), np.stack([covered(picture)[:121]] * 3))
    assert covered(picture)[bound_plate.top, 3].all()


def test_where_order_is_lost_the_deformers_own_shape_is_covered(paint, bound_plate: Rig):
    bound_plate.lift(0.5)
    own = bound_plate.points()
    bound_plate.obj.modifiers.new("Remesh", "REMESH")
    update()
    picture = paint(bound_plate.obj, overlay="REGIONS")
    assert np.abs(picture.points - own).max() < SLACK


def test_in_edit_mode_regions_lie_on_the_posed_shape(paint, bound_plate: Rig):
    bound_plate.lift(0.5)
    own = bound_plate.points()
    make_active(bound_plate.obj)
    bpy.ops.object.mode_set(mode="EDIT")
    update()
    picture = paint(bound_plate.obj, overlay="REGIONS")
    bpy.ops.object.mode_set(mode="OBJECT")
    assert np.array_equal(picture.points, own)
    assert covered(picture)[bound_plate.top, 3].all()


def test_a_mesh_that_lost_vertices_has_no_overlay_until_bound_again(paint, bound_plate: Rig):
    bound_plate.lift(0.5)
    make_active(bound_plate.obj)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    assert paint(bound_plate.obj, overlay="REGIONS") is not None
    edit = bmesh.from_edit_mesh(bound_plate.obj.data)
    edit.verts.ensure_lookup_table()
    bmesh.ops.delete(edit, geom=[edit.verts[60]], context="VERTS")
    bmesh.update_edit_mesh(bound_plate.obj.data)
    update()
    assert paint(bound_plate.obj) is None
    bpy.ops.object.mode_set(mode="OBJECT")
    update()
    assert paint(bound_plate.obj) is None
    bpy.ops.sinew.bind()
    update()
    assert len(paint(bound_plate.obj).points) == 120


def test_nothing_bound_draws_nothing(paint, plate: Rig):
    make_active(plate.obj)
    bpy.ops.sinew.deformer_add(method="arap")
    for kind in ("REGIONS", "WEIGHT", "PARAMETER", "MASK", "CAGE", "DISTORTION"):
        assert paint(plate.obj, overlay=kind) is None


def test_a_picture_is_made_anew_exactly_when_something_changed(paint, overlay, bound_plate: Rig):
    cache, obj = overlay.cache, bound_plate.obj
    other = bpy.data.objects.new("Other", bpy.data.meshes.new("Other"))
    bpy.context.scene.collection.objects.link(other)
    update()

    def painted(change, **wanted) -> int:
        before = cache.computed
        change()
        update()
        first = paint(obj, **wanted)
        assert paint(obj) is first
        return cache.computed - before

    def nothing() -> None:
        """No change."""

    deformer, settings = bound_plate.deformer, bpy.context.scene.sinew
    assert painted(nothing, overlay="REGIONS") == 1
    assert painted(nothing) == 0
    assert painted(lambda: setattr(other, "location", (1.0, 0.0, 0.0))) == 0
    assert painted(lambda: setattr(obj, "location", (0.0, 0.0, 1.0))) == 0
    assert painted(lambda: setattr(settings, "measure", "AREA")) == 1
    assert painted(lambda: bound_plate.lift(0.3)) == 1
    assert painted(lambda: setattr(deformer.handles[0], "colour", (0.1, 0.2, 0.3))) == 1
    assert painted(lambda: setattr(deformer.handles[0], "name", "Renamed")) == 1
    assert painted(lambda: setattr(deformer, "factor", 0.5)) == 1
    assert painted(lambda: setattr(settings, "opacity", 0.4)) == 1
    assert painted(lambda: bpy.ops.sinew.bind()) == 1
    assert painted(nothing, overlay="DISTORTION") == 1
    before = cache.computed
    for _ in range(100):
        paint(obj)
    assert cache.computed == before


def test_colours_of_handles_do_not_repaint_other_overlays(paint, overlay, bound_plate: Rig, room):
    paint(bound_plate.obj, overlay="DISTORTION")
    source = room(RESULT).source
    was = source(bound_plate.obj, bound_plate.deformer)
    assert room(RESULT).same(was, source(bound_plate.obj, bound_plate.deformer))
    bound_plate.lift(0.1)
    assert not room(RESULT).same(was, source(bound_plate.obj, bound_plate.deformer))


def test_select_shows_the_most_distorted_vertex(plate: Rig):
    plate.bind("arap")
    move_world(plate.control, Matrix.Translation((0.2, 0.5, 0.4)))
    shown, rest = plate.points(), plate.rest()
    mesh = plate.obj.data
    mesh.calc_loop_triangles()
    total, area = np.zeros(len(rest)), np.zeros(len(rest))
    for triangle in mesh.loop_triangles:
        corners = list(triangle.vertices)
        edges = (rest[corners[1:]] - rest[corners[0]]).T
        moved = (shown[corners[1:]] - shown[corners[0]]).T
        values = np.linalg.svd(moved @ np.linalg.pinv(edges), compute_uv=False)
        weight = 0.5 * np.linalg.norm(np.cross(*edges.T))
        total[corners] += weight * np.log(values[0])
        area[corners] += weight
    make_active(plate.obj)
    assert bpy.ops.sinew.select_distorted(measure="STRETCH") == {"FINISHED"}
    assert plate.obj.mode == "EDIT"
    selected = [vertex.index for vertex in bmesh.from_edit_mesh(mesh).verts if vertex.select]
    bpy.ops.object.mode_set(mode="OBJECT")
    mean = np.abs(total / area)
    assert len(selected) == 1
    assert mean[selected[0]] == pytest.approx(mean.max(), abs=1e-5)


def test_select_says_why_it_cannot(plate: Rig):
    make_active(plate.obj)
    bpy.ops.sinew.deformer_add(method="arap")
    with pytest.raises(RuntimeError, match="poll"):
        bpy.ops.sinew.select_distorted()


def test_the_graphics_card_is_not_touched_in_background(paint, overlay, bound_plate: Rig, monkeypatch):
    imported = builtins.__import__

    def guarded(name, *args, **keywords):
        assert name.split(".")[0] not in ("gpu", "blf", "gpu_extras"), name
        return imported(name, *args, **keywords)

    monkeypatch.setattr(builtins, "__import__", guarded)
    for module in vars(overlay).values():
        assert not (isinstance(module, types.ModuleType) and module.__name__ in ("gpu", "blf"))
    bpy.context.scene.sinew.show_overlay = True
    for kind in ("REGIONS", "WEIGHT", "PARAMETER", "MASK", "CAGE", "DISTORTION"):
        assert paint(bound_plate.obj, overlay=kind) is not None
    bpy.context.scene.sinew.show_overlay = False


def followers(overlay) -> int:
    """How many of the handlers that only drawing needs are in place."""
    return sum(
        handler in getattr(bpy.app.handlers, event)
        for event, handler in (
            ("frame_change_post", overlay.on_frame),
            ("depsgraph_update_post", overlay.on_update),
        )
    )


def test_nothing_is_registered_in_background(room, scene):
    overlay = room("ui.overlay")
    scene.sinew.show_overlay = True
    assert not overlay.is_drawing()
    assert followers(overlay) == 0


@pytest.fixture
def windowed(room, monkeypatch):
    """As if there was a window; nothing is drawn without one, whatever is registered."""
    overlay = room("ui.overlay")
    monkeypatch.setattr(overlay, "has_window", lambda: True)
    yield overlay
    overlay.stop()


def test_switching_off_leaves_nothing_behind(windowed, scene):
    for _ in range(3):
        scene.sinew.show_overlay = True
        assert windowed.is_drawing()
        assert followers(windowed) == 2
        scene.sinew.overlay = "DISTORTION"
        assert followers(windowed) == 2
        scene.sinew.show_overlay = False
        assert not windowed.is_drawing()
        assert followers(windowed) == 0


def test_another_scene_keeps_it_drawing(windowed, scene):
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


def test_the_depth_offset_moves_towards_the_viewer_only(room):
    """A point drawn a share nearer has the depth that the point at that share of its distance has."""
    nearer, share = room("ui.overlay_draw").nearer, 0.01
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
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=0.6)
    target = bpy.context.object
    bpy.ops.mesh.primitive_cube_add(size=1.6)
    cage = bpy.context.object
    make_active(target)
    assert bpy.ops.sinew.cage_add(source="OBJECT", cage=cage.name, method="mean_value") == {"FINISHED"}
    return target, cage


def choose(cage: bpy.types.Object, vertices: list[int]) -> None:
    for vertex in cage.data.vertices:
        vertex.select = vertex.index in vertices


def test_weight_of_the_selected_cage_vertices(paint, room, caged):
    target, cage = caged
    choose(cage, [5])
    one = paint(target, overlay="CAGE")
    assert one.legend.title == "Weight of cage vertex 5"
    native = room("backend").availability().module
    corners = np.array([tuple(polygon.vertices) for polygon in cage.data.polygons])
    coordinates = native.MeanValue(native.SurfaceMesh(base_points(cage), corners), precision="double")
    coordinates.bind(base_points(target))
    weights = coordinates.vertex_weights[:, 5]
    assert np.abs(covered(one)[:, 3] - OPACITY * (0.6 + 0.4 * weights)).max() < SLACK
    choose(cage, list(range(8)))
    bright = np.array(room("ui.overlay_colours").scale(np.ones(1))[0])
    assert np.abs(covered(paint(target)) - cover(bright, OPACITY)).max() < SLACK
    choose(cage, [])
    assert paint(target).legend.note == "Select vertices of the cage"


def test_weights_follow_the_selection_in_edit_mode(paint, caged):
    target, cage = caged
    make_active(cage)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    edit = bmesh.from_edit_mesh(cage.data)
    edit.verts.ensure_lookup_table()
    edit.verts[3].select = True
    assert paint(target, overlay="CAGE").legend.title == "Weight of cage vertex 3"
    bpy.ops.object.mode_set(mode="OBJECT")


def test_vertices_outside_the_cage_and_negative_weights_stand_out(paint, room, caged):
    target, cage = caged
    cage.scale = (0.5, 1.0, 1.0)
    update()
    make_active(target)
    assert bpy.ops.sinew.cage_set_rest() == {"FINISHED"}
    choose(cage, [vertex.index for vertex in cage.data.vertices if vertex.co.x > 0.0])
    picture = paint(target, overlay="CAGE")
    outside = np.abs(base_points(target)[:, 0]) > 0.4 + 1e-6
    lost = cover(chosen(room, "overlay_stretched"), OPACITY)
    assert np.abs(covered(picture)[outside] - lost).max() < SLACK
    assert not (np.abs(covered(picture)[~outside] - lost).max(axis=1) < SLACK).any()
    assert f"{outside.sum():,} outside the cage" in picture.legend.note


def test_no_cage_weights_while_another_method_is_bound(paint, room, bound_plate: Rig):
    """As in a window, where a thread binds the method just chosen."""
    with room("session").suspended():
        bound_plate.deformer.method = "green"
    assert room(RESULT).influence(bound_plate.deformer) is None


def test_a_method_without_a_cage_has_no_cage_weights(paint, bound_plate: Rig):
    picture = paint(bound_plate.obj, overlay="CAGE")
    assert not picture.colours[:, 3].any()
    assert picture.legend.note == "Thin Shell has no cage"
