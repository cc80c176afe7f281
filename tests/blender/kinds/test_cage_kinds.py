# SPDX-License-Identifier: GPL-3.0-or-later
"""A cage moves meshes, curves, text, hair and point clouds: the surface where there is one, or points."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from inside import catch_up, inner, settle
from mathutils import Matrix
from probe import exported_points, render_points
from rigs import rig as scenes
from rigs.cages import SHEAR, ball, transform
from rigs.point_objects import (
    CURVES,
    MAKERS,
    TESSELLATED,
    bend,
    bezier,
    bind,
    cage_around,
    controls_of,
    hair,
    has_surface,
    inside,
    moved_by_hand,
    outline,
    text,
    unmoved,
)
from rigs.sheet import draw, draw_panel

Caged = tuple[bpy.types.Object, bpy.types.Object]
WITH_MESH = {"mesh": ball, **MAKERS}
REFUSED = "Topology changed - Rebind"


@pytest.fixture(params=MAKERS)
def caged(request: pytest.FixtureRequest) -> Caged:
    """An object of each kind and the cage that moves it; a test may ask for a mesh, too."""
    return bind(WITH_MESH[request.param]())


def size(points: np.ndarray) -> float:
    return max(1.0, float(np.abs(points).max()))


def at_rest(obj: bpy.types.Object) -> np.ndarray:
    """What Blender shows of its points as they are, taken apart as Sinew does it."""
    return moved_by_hand(obj, lambda points: points)


def assert_shows(obj: bpy.types.Object, expected: np.ndarray, tolerance: float = scenes.FLOAT32) -> None:
    """That, to a share of its size, and nothing complains."""
    found = scenes.evaluated_points(obj)
    assert found.shape == expected.shape
    assert np.abs(found - expected).max() < tolerance * size(expected)


def assert_lifted(obj: bpy.types.Object, rest: np.ndarray, height: float = 1.0) -> None:
    """By the cage, which rose so far."""
    assert_shows(obj, rest + (0.0, 0.0, height))


def assert_well(obj: bpy.types.Object) -> None:
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status


def test_each_point_and_each_handle_goes_where_the_cage_takes_it(caged: Caged):
    obj, cage = caged
    rest = at_rest(obj)
    assert cage.hide_render
    assert_shows(obj, rest)
    warp = bend(cage)
    expected = moved_by_hand(obj, warp)
    assert_shows(obj, expected, TESSELLATED)
    assert np.abs(expected - rest).max() > 0.05
    assert_well(obj)
    obj.sinew.active.factor = 0.25
    blended = moved_by_hand(obj, lambda points: 0.75 * points + 0.25 * warp(points))
    assert_shows(obj, blended, TESSELLATED)
    obj.sinew.active.factor = 0.0
    assert_shows(obj, rest)


def test_it_lives_through_undo_save_and_the_loss_of_its_cage(caged: Caged, tmp_path: Path):
    obj, cage = caged
    name, cage_name = obj.name, cage.name
    bend(cage)
    before = scenes.evaluated_points(obj)
    scenes.push("Bound")
    cage.location.z = 1.0
    scenes.push("Moved")
    for step, height in ((bpy.ops.ed.undo, 0.0), (bpy.ops.ed.redo, 1.0)):
        step()
        assert_shows(bpy.data.objects[name], before + (0.0, 0.0, height), 2 * scenes.FLOAT32)
        assert bpy.data.objects[cage_name].location.z == height
    scenes.reopen(tmp_path / "caged.blend")
    obj, cage = bpy.data.objects[name], bpy.data.objects[cage_name]
    for aside in (0.0, 1.0):
        cage.location.x = aside
        assert_shows(obj, before + (aside, 0.0, 1.0), 2 * scenes.FLOAT32)
    bpy.data.objects.remove(cage)
    assert_shows(obj, before + (1.0, 0.0, 1.0), 2 * scenes.FLOAT32)
    assert obj.sinew.active.cage_missing


@pytest.mark.parametrize("late", [False, True], ids=["bound for it", "since it was bound"])
@pytest.mark.parametrize("kind", ["bevelled", "text"])
def test_renders_and_exporters_may_tessellate_otherwise(kind: str, late: bool, tmp_path: Path):
    obj = MAKERS[kind]()
    obj.data.resolution_u, obj.data.render_resolution_u = 4, 4 if late else 9
    if obj.type == "CURVE":
        obj.data.resolution_u = 9
        for spline in obj.data.splines:  # a change of the curve's own would be one of all of them
            spline.resolution_u = 4
    obj, cage = bind(obj)
    transform(cage, SHEAR)
    expected = moved_by_hand(obj, lambda points: scenes.apply_matrix(SHEAR, points))
    assert np.abs(scenes.evaluated_points(obj) - expected).max() < scenes.FLOAT32
    obj.data.render_resolution_u = 9
    seen = [render_points(obj)]
    if kind == "text":  # the exporter writes a curve with a surface twice
        seen.append(exported_points(obj, tmp_path))
    assert len(seen[0]) > len(expected)
    obj.data.resolution_u = 9  # the shape for viewports does not fit any more
    expected = moved_by_hand(obj, lambda points: scenes.apply_matrix(SHEAR, points))
    for points in seen:
        assert np.abs(points - expected).max() < TESSELLATED


def add_a_point(obj: bpy.types.Object) -> None:
    if obj.type == "FONT":
        obj.data.body += "ew"
    elif obj.type == "CURVE":
        spline = obj.data.splines[0]
        points = spline.bezier_points if spline.type == "BEZIER" else spline.points
        points.add(1)
        points[-1].co = (0.1, 0.2, 0.1, 1.0)[: len(points[-1].co)]
        if spline.type == "BEZIER":
            points[-1].handle_left, points[-1].handle_right = (0.0, 0.2, 0.1), (0.2, 0.2, 0.1)
    else:
        pytest.skip("points are added to these by brushes and nodes")


@pytest.mark.parametrize("automatic", [False, True])
def test_points_added_after_bind_ask_for_a_rebind(caged: Caged, automatic: bool):
    obj, cage = caged
    cage.location.z = 1.0
    obj.sinew.active.auto_rebind = automatic
    scenes.update()
    add_a_point(obj)
    settle()
    rest = at_rest(obj)
    if not automatic:
        assert np.abs(scenes.evaluated_points(obj) - unmoved(obj)).max() < scenes.FLOAT32
        assert obj.sinew.active.status == REFUSED
        scenes.press(obj, "bind")
    assert_well(obj)
    assert_lifted(obj, rest)


def exchange_letters(obj: bpy.types.Object) -> None:
    obj.data.body = obj.data.body[::-1]


def change_type(obj: bpy.types.Object) -> None:
    spline = obj.data.splines[0]
    spline.type = "NURBS" if spline.type == "POLY" else "POLY"


def change_bevel(obj: bpy.types.Object) -> None:
    obj.data.bevel_depth = 0.0 if obj.data.bevel_depth else 0.03


CHANGES = {"text": exchange_letters, "outline": exchange_letters, "poly": change_type}
CHANGES |= {"bezier": change_bevel, "bevelled": change_bevel}


@pytest.mark.parametrize("kind", CHANGES)
def test_as_many_points_of_another_curve_are_noticed(kind: str):
    """Other letters, points of another type, a surface gained or lost: at rest until it is mended."""
    obj, change = MAKERS[kind](), CHANGES[kind]
    if obj.type == "FONT":
        obj.data.body = "db"
    obj, cage = bind(obj)
    cage.location.z = 1.0
    scenes.update()
    mends = [lambda: change(obj), lambda: scenes.press(obj, "bind")]
    if change is change_bevel:  # a surface makes another kind of target, for which it has to be bound
        del mends[0]
    for mend in mends:
        change(obj)
        settle()
        assert_shows(obj, at_rest(obj))
        assert obj.sinew.active.status == REFUSED
        mend()
        settle()
        assert_well(obj)
        assert_lifted(obj, at_rest(obj))


@pytest.mark.parametrize("kind", ["bezier", "nurbs", "mixed"])
def test_points_moved_in_edit_mode_take_the_cages_motion_along(kind: str):
    obj, cage = bind(MAKERS[kind]())
    cage.location.z = 1.0
    with scenes.in_mode(obj):
        bpy.ops.curve.select_all(action="SELECT")
        bpy.ops.transform.translate(value=(0.25, 0.0, 0.0))
        assert_lifted(obj, at_rest(obj))
    assert_lifted(obj, at_rest(obj))
    assert_well(obj)


def test_text_is_typed_at_rest_and_bound_anew():
    obj, cage = bind(outline())
    obj.sinew.active.auto_rebind = True
    cage.location.z = 1.0
    with scenes.in_mode(obj):
        assert np.abs(scenes.evaluated_points(obj)[:, 2] - 1.0).max() < scenes.FLOAT32
        bpy.ops.font.text_insert(text="ew")
        assert np.abs(scenes.evaluated_points(obj)[:, 2]).max() < scenes.FLOAT32
    catch_up()
    assert_well(obj)
    assert np.abs(scenes.evaluated_points(obj)[:, 2] - 1.0).max() < scenes.FLOAT32


def test_hair_follows_while_it_is_sculpted():
    obj, cage = bind(hair())
    rest = scenes.evaluated_points(obj)
    with scenes.in_mode(obj, "SCULPT_CURVES"):
        cage.location.z = 1.0
        assert_lifted(obj, rest)
        catch_up()
    catch_up()
    assert_lifted(obj, rest)
    assert_well(obj)


def test_a_shape_key_of_the_curve_still_counts():
    obj, cage = bind(bezier())
    key = scenes.add_key(obj, "Aside", Matrix.Translation((0.3, 0.0, 0.0)))
    rest = scenes.evaluated_points(obj)
    key.value = 1.0
    cage.location.z = 0.5
    assert np.abs(scenes.evaluated_points(obj) - rest - (0.3, 0.0, 0.5)).max() < scenes.FLOAT32


def test_what_a_modifier_adds_to_a_curve_stays_where_it_is():
    """A point cloud, whose points would else be moved by the numbers of the curve's."""
    obj = bezier()
    group, entry, leave = scenes.new_nodes("Adds")
    points, join = group.nodes.new("GeometryNodePoints"), group.nodes.new("GeometryNodeJoinGeometry")
    points.inputs["Count"].default_value, points.inputs["Position"].default_value = 5, (3.0, 2.0, 1.0)
    for given in (entry, points.outputs[0]):
        group.links.new(given, join.inputs[0])
    group.links.new(join.outputs[0], leave)
    obj.modifiers.new("Adds", "NODES").node_group = group
    obj, cage = bind(obj)
    expected = moved_by_hand(obj, bend(cage))
    assert np.abs(scenes.evaluated_points(obj) - expected).max() < TESSELLATED
    depsgraph = bpy.context.evaluated_depsgraph_get()
    clouds = [  # what is found lives no longer than its turn
        np.array([point.co for point in found.object.data.points])
        for found in depsgraph.object_instances
        if found.object.type == "POINTCLOUD"
    ]
    assert len(clouds) == 1
    assert np.array_equal(clouds[0], np.tile((3.0, 2.0, 1.0), (5, 1)))


@pytest.mark.parametrize("make", [bezier, ball])
def test_several_cages_move_one_object(make: Callable):
    obj, cage = bind(make())
    _, other = bind(obj, cage=cage_around(obj, 0.4))
    obj.sinew.active.factor = 0.5
    rest = scenes.evaluated_points(obj)
    cage.location.x, other.location.z = 0.4, 1.0
    assert np.abs(scenes.evaluated_points(obj) - rest - (0.4, 0.0, 0.5)).max() < scenes.FLOAT32


def hidden_meshes() -> int:
    return len([mesh for mesh in bpy.data.meshes if mesh.name.startswith(".Sinew")])


@pytest.mark.parametrize("kind", WITH_MESH)
def test_an_automatic_cage_holds_points_and_handles_moves_them_and_leaves_nothing_behind(kind: str):
    obj = WITH_MESH[kind]()
    obj.location.x, obj.rotation_euler.z = 2.0, 0.3
    rest = at_rest(obj)
    scenes.press(obj, "cage_add", faces=100)
    assert_well(obj)
    assert inner.status.notes(obj.sinew.active.uid) == ()
    cage = obj.sinew.active.cage
    assert bpy.context.object == cage
    assert cage.parent == obj or kind in CURVES or kind == "bevelled"
    assert len(cage.data.polygons) <= 100
    assert inside(controls_of(obj) if kind in CURVES else rest, cage).all()
    for y in (0.0, 1.0):
        obj.location.y = y
        scenes.update()
        assert np.abs(np.array(cage.matrix_world) - np.array(obj.matrix_world)).max() < 1e-6
        assert_shows(obj, rest)
    transform(cage, Matrix.Translation((0.0, 0.0, 0.5)))
    assert_lifted(obj, rest, 0.5)
    name, plain = cage.name, unmoved(obj)
    assert hidden_meshes() == 5  # a rest shape, that of the cage, an empty one for renders, two shapes
    scenes.press(obj, "deformer_remove")
    assert name not in bpy.data.objects
    assert hidden_meshes() == 0
    assert not obj.modifiers
    assert np.array_equal(scenes.evaluated_points(obj), plain)


def test_surface_methods_are_refused_with_a_way_out(caged: Caged):
    obj, cage = caged
    is_lattice = obj.type == "LATTICE"
    scenes.refused("needs the surface of a mesh", "deformer_add", obj, method="arap")
    buttons = {
        "deformer_add": {"method": "arap"},
        "handle_add": {},
        "repair": {},
        "part_regions": {},
        "bake": {},
    }
    buttons |= {} if is_lattice else {"apply": {"as_shape_key": True}}
    for button, keywords in buttons.items():
        scenes.refused("is a lattice" if is_lattice else "convert it to a mesh", button, **keywords)
    cage.location.z = 0.5
    scenes.update()
    deformer, remedies = obj.sinew.active, inner.status.Remedy
    deformer.method = "arap"
    assert_shows(obj, at_rest(obj))
    assert "needs the surface of a mesh" in deformer.status
    found = inner.status.current(deformer.uid).remedy
    assert found is (remedies.NONE if is_lattice else remedies.CONVERT)
    scenes.refused("needs the surface of a mesh", "bind")
    deformer.method = "mean_value"
    scenes.press(obj, "bind")
    assert_well(obj)


def test_apply_writes_points_and_handles_where_there_are_any(caged: Caged):
    obj, cage = caged
    bend(cage)
    before, kind = scenes.evaluated_points(obj), obj.type
    obj.modifiers.new("Later", "CURVE" if kind == "LATTICE" else "NODES")
    scenes.make_active(obj)
    if kind == "FONT" or (kind == "CURVE" and has_surface(obj)):
        scenes.refused("convert it to a mesh", "apply")
        assert np.array_equal(scenes.evaluated_points(obj), before)
        return
    assert bpy.ops.sinew.apply() == {"FINISHED"}
    assert obj.type == kind
    assert not obj.sinew.deformers
    assert [modifier.name for modifier in obj.modifiers] == ["Later"]
    assert_shows(obj, before)
    assert np.abs(unmoved(obj) - before).max() < scenes.FLOAT32 * size(before)


def test_convert_to_mesh_keeps_the_shape_shown(caged: Caged):
    obj, cage = caged
    bend(cage)
    before, name = scenes.evaluated_points(obj), obj.name
    scenes.make_active(obj)
    bpy.ops.object.convert(target="MESH")
    obj = bpy.data.objects[name]
    if obj.type != "MESH":
        pytest.skip("this Blender makes no meshes of these")
    settle()
    found = scenes.evaluated_points(obj)
    if name == "Hair":  # strands become lines through their points, with steps between
        found = found[scenes.nearest(before, found)[0]]
    assert np.abs(found - before).max() < scenes.FLOAT32 * size(before)
    assert not obj.sinew.deformers
    assert cage.name in bpy.data.objects


def test_panels_draw_what_works_and_overlays_colour_surfaces_alone(caged: Caged):
    obj, cage = caged
    scenes.make_active(obj)
    names = {*draw_panel().operator_names(), *draw(bpy.types.SINEW_PT_order).operator_names()}
    assert {"sinew.bind", "sinew.cage_set_rest", "sinew.control_edit"} <= names
    assert not {"sinew.handle_add", "sinew.deformer_add"} & names
    for vertex in cage.data.vertices:
        vertex.select = vertex.index == 0
    picture, settings = inner.overlay_mesh, bpy.context.scene.sinew
    settings.show_overlay = True
    for overlay in ("CAGE", "DISTORTION", "MASK", "REGIONS"):
        settings.overlay = overlay
        scenes.update()
        depsgraph, look = bpy.context.evaluated_depsgraph_get(), picture.overlay_settings(bpy.context)
        painted = picture.OverlayCache().overlay_mesh(obj, obj.sinew.active, look, depsgraph)
        assert (painted is not None) == (obj.type in ("CURVE", "FONT") and has_surface(obj)), overlay
    settings.show_overlay = False


def test_hair_goes_into_alembic_files_and_curves_and_text_do_not(tmp_path: Path):
    if not bpy.app.build_options.alembic:
        pytest.skip("this Blender was built without Alembic")
    path = str(tmp_path / "hair.abc")
    options = {"target": "ALEMBIC", "filepath": path, "frame_start": 1, "frame_end": 1}
    for maker in (bezier, text):
        scenes.refused("without its modifiers - convert", "bake", bind(maker())[0], **options)
    obj, cage = bind(hair())
    cage.location.z = 0.5
    posed, before = scenes.evaluated_points(obj), set(bpy.data.objects)
    scenes.press(obj, "bake", **options)
    bpy.ops.wm.alembic_import(filepath=path, as_background_job=False)
    (read,) = (other for other in bpy.data.objects if other not in before and other.type == "CURVES")
    assert np.abs(scenes.evaluated_points(read) - posed).max() < 1e-5
