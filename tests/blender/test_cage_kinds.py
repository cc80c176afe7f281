# SPDX-License-Identifier: GPL-3.0-or-later
"""A cage moves curves, text, hair and point clouds: the surface where there is one, else the points."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from cages import add_raising_key
from inside import catch_up
from kinds import (
    CURVES,
    MAKERS,
    TESSELLATED,
    add_bezier,
    bend,
    bezier,
    bind,
    cage_around,
    controls_of,
    curve_object,
    hair,
    has_surface,
    inside,
    moved_by_hand,
    outline,
    poly,
    shown,
    text,
    unmoved,
)
from mathutils import Matrix, Vector
from mathutils.kdtree import KDTree
from probe import render_points
from registry import WITH_CAGE
from rig import FLOAT32, apply_matrix, make_active, push, update
from test_interface import WIDE, draw_panel


@pytest.fixture(params=MAKERS)
def caged(request) -> tuple[bpy.types.Object, bpy.types.Object]:
    return bind(MAKERS[request.param]())


def shear() -> Matrix:
    return Matrix(((1.0, 0.4, 0.0, 0.2), (0.0, 1.2, 0.1, 0.0), (0.0, 0.0, 0.8, -0.3), (0.0, 0.0, 0.0, 1.0)))


def affine(points: np.ndarray) -> np.ndarray:
    return apply_matrix(shear(), points)


def size(points: np.ndarray) -> float:
    return max(1.0, float(np.abs(points).max()))


def test_rest_in_rest_out(caged):
    obj, _cage = caged
    rest = moved_by_hand(obj, lambda points: points)
    assert np.abs(shown(obj) - rest).max() < FLOAT32 * size(rest)


def test_an_affine_cage_moves_points_and_handles_affinely(caged):
    obj, cage = caged
    cage.data.transform(shear())
    cage.data.update()
    expected = moved_by_hand(obj, affine)
    assert np.abs(shown(obj) - expected).max() < TESSELLATED * size(expected)
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status


def test_a_bent_cage_moves_each_point_and_each_handle_by_itself(caged):
    obj, cage = caged
    warp = bend(cage)
    expected = moved_by_hand(obj, warp)
    found = shown(obj)
    assert found.shape == expected.shape
    assert np.abs(found - expected).max() < TESSELLATED * size(expected)
    assert np.abs(found - moved_by_hand(obj, lambda points: points)).max() > 0.05


@pytest.mark.parametrize("method", WITH_CAGE)
@pytest.mark.parametrize("kind", ["bezier", "text"])
def test_each_method_follows_a_similarity(kind, method):
    obj, cage = bind(MAKERS[kind](), method)
    turn = (
        Matrix.Translation((0.3, 0.1, -0.2)) @ Matrix.Rotation(0.7, 4, (0.6, 0.0, 0.8)) @ Matrix.Scale(1.3, 4)
    )
    cage.matrix_world = turn
    expected = moved_by_hand(obj, lambda points: apply_matrix(turn, points))
    assert np.abs(shown(obj) - expected).max() < TESSELLATED


def test_factor_blends_points_and_handles(caged):
    obj, cage = caged
    warp = bend(cage)
    obj.sinew.active.factor = 0.25
    expected = moved_by_hand(obj, lambda points: 0.75 * points + 0.25 * warp(points))
    assert np.abs(shown(obj) - expected).max() < TESSELLATED * size(expected)
    obj.sinew.active.factor = 0.0
    rest = moved_by_hand(obj, lambda points: points)
    assert np.abs(shown(obj) - rest).max() < FLOAT32 * size(rest)


def test_it_lives_through_undo_save_and_the_loss_of_its_cage(caged, tmp_path):
    obj, cage = caged
    name, cage_name = obj.name, cage.name
    tolerance = FLOAT32 * size(shown(obj))
    bend(cage)
    before = shown(obj)
    push("Bound")
    cage.location.z = 1.0
    push("Moved")
    for step, height in ((bpy.ops.ed.undo, 0.0), (bpy.ops.ed.redo, 1.0)):
        step()
        assert np.abs(shown(bpy.data.objects[name]) - before - (0.0, 0.0, height)).max() < 2 * tolerance
        assert bpy.data.objects[cage_name].location.z == height
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "caged.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "caged.blend"))
    obj, cage = bpy.data.objects[name], bpy.data.objects[cage_name]
    for aside in (0.0, 1.0):
        cage.location.x = aside
        assert np.abs(shown(obj) - before - (aside, 0.0, 1.0)).max() < 2 * tolerance
    bpy.data.objects.remove(cage)
    assert np.abs(shown(obj) - before - (1.0, 0.0, 1.0)).max() < 2 * tolerance
    assert obj.sinew.active.cage_missing


def test_renders_and_frames_show_an_animated_cage(caged):
    obj, cage = caged
    rest = shown(obj)
    key = add_raising_key(cage, 1.0)
    for frame, value in ((1, 0.0), (11, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    for frame in (11, 1, 6):
        bpy.context.scene.frame_set(frame)
        found = shown(obj)
        assert np.array_equal(render_points(obj), found)
        share = (found - rest)[:, 2].mean()
        assert np.abs(found - rest - (0.0, 0.0, share)).max() < 2 * FLOAT32 * size(rest)
        assert {1: abs(share) < 1e-5, 6: 0.3 < share < 0.7, 11: share > 0.999}[frame]


@pytest.mark.parametrize("kind", ["bevelled", "text"])
def test_renders_may_tessellate_otherwise(kind):
    obj = MAKERS[kind]()
    obj.data.resolution_u, obj.data.render_resolution_u = 4, 9
    if obj.type == "CURVE":
        obj.data.resolution_u = 9
        for spline in obj.data.splines:  # a change of the curve's own would be one of all of them
            spline.resolution_u = 4
    obj, cage = bind(obj)
    cage.data.transform(shear())
    cage.data.update()
    expected = moved_by_hand(obj, affine)
    assert np.abs(shown(obj) - expected).max() < FLOAT32
    rendered = render_points(obj)
    assert len(rendered) > len(expected)
    obj.data.resolution_u = 9  # the shape for viewports does not fit any more
    expected = moved_by_hand(obj, affine)
    assert np.abs(rendered - expected).max() < FLOAT32


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
def test_points_added_after_bind_ask_for_a_rebind(caged, automatic):
    obj, cage = caged
    cage.location.z = 1.0
    obj.sinew.active.auto_rebind = automatic
    update()
    add_a_point(obj)
    update()
    catch_up()
    found, rest = shown(obj), moved_by_hand(obj, lambda points: points)
    deformer = obj.sinew.active
    if not automatic:
        assert np.abs(found - unmoved(obj)).max() < FLOAT32
        assert deformer.status == "Topology changed - Rebind"
        make_active(obj)
        assert bpy.ops.sinew.bind() == {"FINISHED"}
        found = shown(obj)
    assert deformer.status_level == "INFO", deformer.status
    assert np.abs(found - rest - (0.0, 0.0, 1.0)).max() < FLOAT32


@pytest.mark.parametrize("kind", ["text", "outline"])
def test_other_letters_of_as_many_points_are_noticed(kind):
    obj = MAKERS[kind]()
    obj.data.body = "db"
    obj, cage = bind(obj)
    bend(cage)
    update()
    obj.data.body = "bd"
    assert np.abs(shown(obj) - moved_by_hand(obj, lambda points: points)).max() < FLOAT32
    assert obj.sinew.active.status == "Topology changed - Rebind"
    obj.data.body = "db"
    update()
    catch_up()
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    assert np.abs(shown(obj) - moved_by_hand(obj, lambda points: points)).max() > 0.05


def test_a_point_of_another_type_is_noticed():
    obj, cage = bind(poly())
    cage.location.z = 1.0
    update()
    obj.data.splines[0].type = "NURBS"
    update()
    catch_up()
    rest = moved_by_hand(obj, lambda points: points)
    assert np.abs(shown(obj) - rest).max() < FLOAT32
    assert obj.sinew.active.status == "Topology changed - Rebind"


@pytest.mark.parametrize("before", ["bezier", "bevelled"])
def test_a_curve_that_gains_or_loses_its_surface_can_be_bound_anew(before):
    obj, cage = bind(MAKERS[before]())
    cage.location.z = 1.0
    update()
    obj.data.bevel_depth = 0.0 if obj.data.bevel_depth else 0.03
    update()
    catch_up()
    rest = moved_by_hand(obj, lambda points: points)
    assert np.abs(shown(obj) - rest).max() < FLOAT32
    assert obj.sinew.active.status == "Topology changed - Rebind"
    make_active(obj)
    assert bpy.ops.sinew.bind() == {"FINISHED"}
    assert np.abs(shown(obj) - rest - (0.0, 0.0, 1.0)).max() < FLOAT32


@pytest.mark.parametrize("kind", ["bezier", "nurbs", "mixed"])
def test_points_moved_in_edit_mode_take_the_cages_motion_along(kind):
    obj, cage = bind(MAKERS[kind]())
    cage.location.z = 1.0
    update()
    make_active(obj)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.curve.select_all(action="SELECT")
    bpy.ops.transform.translate(value=(0.25, 0.0, 0.0))
    assert np.abs(shown(obj) - moved_by_hand(obj, lambda points: points + (0.0, 0.0, 1.0))).max() < FLOAT32
    bpy.ops.object.mode_set(mode="OBJECT")
    assert np.abs(shown(obj) - moved_by_hand(obj, lambda points: points + (0.0, 0.0, 1.0))).max() < FLOAT32
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status


def test_text_is_typed_at_rest_and_bound_anew():
    obj, cage = bind(outline())
    obj.sinew.active.auto_rebind = True
    cage.location.z = 1.0
    make_active(obj)
    bpy.ops.object.mode_set(mode="EDIT")
    assert np.abs(shown(obj)[:, 2] - 1.0).max() < FLOAT32
    bpy.ops.font.text_insert(text="ew")
    assert np.abs(shown(obj)[:, 2]).max() < FLOAT32
    bpy.ops.object.mode_set(mode="OBJECT")
    catch_up()
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    assert np.abs(shown(obj)[:, 2] - 1.0).max() < FLOAT32


def test_hair_follows_while_it_is_sculpted():
    obj, cage = bind(hair())
    rest = shown(obj)
    make_active(obj)
    bpy.ops.object.mode_set(mode="SCULPT_CURVES")
    cage.location.z = 1.0
    assert np.abs(shown(obj) - rest - (0.0, 0.0, 1.0)).max() < FLOAT32 * size(rest)
    catch_up()
    bpy.ops.object.mode_set(mode="OBJECT")
    catch_up()
    assert np.abs(shown(obj) - rest - (0.0, 0.0, 1.0)).max() < FLOAT32 * size(rest)
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status


def test_a_shape_key_of_the_curve_still_counts():
    obj, cage = bind(bezier())
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="Aside")
    for point in key.data:
        for name in ("co", "handle_left", "handle_right"):
            setattr(point, name, getattr(point, name) + Vector((0.3, 0.0, 0.0)))
    key.value = 0.0  # new keys are on from Blender 5.0
    rest = shown(obj)
    key.value = 1.0
    cage.location.z = 0.5
    assert np.abs(shown(obj) - rest - (0.3, 0.0, 0.5)).max() < FLOAT32


def test_what_a_modifier_adds_to_a_curve_stays_where_it_is():
    """A point cloud, whose points would else be moved by the numbers of the curve's."""
    obj = bezier()
    group = bpy.data.node_groups.new("Adds", "GeometryNodeTree")
    if hasattr(group, "interface"):
        for in_out in ("INPUT", "OUTPUT"):
            group.interface.new_socket("Geometry", in_out=in_out, socket_type="NodeSocketGeometry")
    else:
        for sockets in (group.inputs, group.outputs):
            sockets.new("NodeSocketGeometry", "Geometry")
    entry, leave = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    points, join = group.nodes.new("GeometryNodePoints"), group.nodes.new("GeometryNodeJoinGeometry")
    points.inputs["Count"].default_value, points.inputs["Position"].default_value = 5, (3.0, 2.0, 1.0)
    for given in (entry.outputs[0], points.outputs[0]):
        group.links.new(given, join.inputs[0])
    group.links.new(join.outputs[0], leave.inputs[0])
    obj.modifiers.new("Adds", "NODES").node_group = group
    obj, cage = bind(obj)
    expected = moved_by_hand(obj, bend(cage))
    assert np.abs(shown(obj) - expected).max() < TESSELLATED
    depsgraph = bpy.context.evaluated_depsgraph_get()
    clouds = [  # what is found lives no longer than its turn
        np.array([point.co for point in found.object.data.points])
        for found in depsgraph.object_instances
        if found.object.type == "POINTCLOUD"
    ]
    assert len(clouds) == 1
    assert np.array_equal(clouds[0], np.tile((3.0, 2.0, 1.0), (5, 1)))


def test_one_cage_moves_a_mesh_and_a_text_and_several_cages_a_curve():
    obj, cage = bind(text())
    bpy.ops.mesh.primitive_ico_sphere_add(radius=0.4)
    ball = bpy.context.object
    bind(ball, cage=cage)
    curve = bezier()
    bind(curve, cage=cage)
    other = cage_around(curve, 0.4)
    bind(curve, cage=other)
    curve.sinew.active.factor = 0.5
    rests = [shown(target) for target in (obj, ball, curve)]
    cage.location.x, other.location.z = 0.4, 1.0
    for target, rest, motion in zip((obj, ball, curve), rests, ((0.4, 0, 0), (0.4, 0, 0), (0.4, 0, 0.5))):
        assert np.abs(shown(target) - rest - motion).max() < FLOAT32, target.name


@pytest.mark.parametrize("kind", ["mixed", "text", "hair"])
def test_a_duplicate_gets_shapes_of_its_own(kind):
    obj, cage = bind(MAKERS[kind]())
    make_active(obj)
    bpy.ops.object.duplicate()
    copy = bpy.context.object
    catch_up()
    assert copy.sinew.active.proxy != obj.sinew.active.proxy
    rest = shown(obj)
    copy.sinew.active.factor = 0.5
    cage.location.z = 1.0
    assert np.abs(shown(obj) - rest - (0.0, 0.0, 1.0)).max() < FLOAT32 * size(rest)
    assert np.abs(shown(copy) - rest - (0.0, 0.0, 0.5)).max() < FLOAT32 * size(rest)


def test_nothing_is_left_when_a_deformer_is_removed(caged):
    obj, cage = caged
    meshes = {mesh.name for mesh in bpy.data.meshes if mesh.name.startswith(".Sinew")}
    assert len(meshes) == 5  # a rest shape, that of the cage, an empty one for renders, two shapes
    bend(cage)
    rest = unmoved(obj)
    make_active(obj)
    assert bpy.ops.sinew.deformer_remove() == {"FINISHED"}
    assert np.array_equal(shown(obj), rest)
    assert not obj.modifiers
    assert not [mesh for mesh in bpy.data.meshes if mesh.name.startswith(".Sinew")]
    assert cage.name in bpy.data.objects


@pytest.mark.parametrize("kind", MAKERS)
def test_an_automatic_cage_holds_points_and_handles_and_moves_them(room, kind):
    obj = MAKERS[kind]()
    obj.location.x, obj.rotation_euler.z = 2.0, 0.3
    rest = moved_by_hand(obj, lambda points: points)
    make_active(obj)
    assert bpy.ops.sinew.cage_add(faces=100) == {"FINISHED"}
    deformer = obj.sinew.active
    assert deformer.status_level == "INFO", deformer.status
    assert room("core.status").notes(deformer.uid) == ()
    cage = deformer.cage
    assert bpy.context.object == cage
    held = controls_of(obj) if kind in CURVES else rest
    assert inside(held, cage).all()
    assert np.abs(np.array(cage.matrix_world) - np.array(obj.matrix_world)).max() < 1e-6
    assert np.abs(shown(obj) - rest).max() < FLOAT32 * size(rest)
    obj.location.y = 1.0
    update()
    assert np.abs(np.array(cage.matrix_world) - np.array(obj.matrix_world)).max() < 1e-6
    assert np.abs(shown(obj) - rest).max() < FLOAT32 * size(rest)
    cage.data.transform(Matrix.Translation((0.0, 0.0, 0.5)))
    cage.data.update()
    assert np.abs(shown(obj) - rest - (0.0, 0.0, 0.5)).max() < FLOAT32 * size(rest)


@pytest.mark.parametrize("shape", ["straight", "planar", "point", "spike"])
def test_an_automatic_cage_fits_around_thin_curves(shape):
    obj = curve_object()
    add_bezier(obj, 4)
    for index, point in enumerate(obj.data.splines[0].bezier_points):
        point.handle_left_type = point.handle_right_type = "FREE"
        along = {"straight": (index, 0, 0), "planar": (index, index % 2, 0)}.get(shape, (0, 0, 0))
        point.co = point.handle_left = point.handle_right = along
        if shape == "spike":  # one handle sticks out of everything that is seen
            point.handle_right = (0.0, 0.0, 8.0 if index == 3 else 0.01 * index)
    make_active(obj)
    assert bpy.ops.sinew.cage_add() == {"FINISHED"}
    assert inside(controls_of(obj), obj.sinew.active.cage).all()


def test_an_object_without_points_says_so():
    for obj in (curve_object(), text()):
        if obj.type == "FONT":
            obj.data.body = ""
        make_active(obj)
        with pytest.raises(RuntimeError, match="has no points"):
            bpy.ops.sinew.cage_add()
        assert not obj.sinew.deformers


def test_surface_methods_are_refused_with_a_way_out(room, caged):
    obj, cage = caged
    make_active(obj)
    with pytest.raises(RuntimeError, match="needs the surface of a mesh"):
        bpy.ops.sinew.deformer_add(method="arap")
    for operator in (bpy.ops.sinew.handle_add, bpy.ops.sinew.repair, bpy.ops.sinew.part_regions):
        with pytest.raises(RuntimeError, match="convert it to a mesh"):
            operator()
    for refused in (lambda: bpy.ops.sinew.apply(as_shape_key=True), bpy.ops.sinew.bake):
        with pytest.raises(RuntimeError, match="convert it to a mesh"):
            refused()
    cage.location.z = 0.5
    update()
    deformer = obj.sinew.active
    deformer.method = "arap"
    rest = moved_by_hand(obj, lambda points: points)
    assert np.abs(shown(obj) - rest).max() < FLOAT32 * size(rest)
    assert "needs the surface of a mesh" in deformer.status
    assert room("core.status").current(deformer.uid).remedy is room("core.status").Remedy.CONVERT
    with pytest.raises(RuntimeError, match="needs the surface of a mesh"):
        bpy.ops.sinew.bind()
    deformer.method = "mean_value"
    assert bpy.ops.sinew.bind() == {"FINISHED"}
    assert deformer.status_level == "INFO", deformer.status


def test_points_outside_are_said_or_refused(room):
    obj, _cage = bind(bezier())
    point = obj.data.splines[0].bezier_points[3]
    point.handle_right = (0.0, 0.0, 9.0)
    bpy.ops.sinew.bind()
    deformer = obj.sinew.active
    (note,) = room("core.status").notes(deformer.uid)
    assert note.text == "1 point or handle lies outside the cage"
    deformer.method = "harmonic"
    update()
    assert deformer.status_level == "ERROR"
    make_active(obj)
    assert bpy.ops.sinew.select_problems() == {"CANCELLED"}
    assert obj.mode == "OBJECT"


def test_apply_writes_points_and_handles_where_there_are_any(caged):
    obj, cage = caged
    bend(cage)
    before, kind = shown(obj), obj.type
    obj.modifiers.new("Later", "NODES")
    make_active(obj)
    if kind == "FONT" or (kind == "CURVE" and has_surface(obj)):
        with pytest.raises(RuntimeError, match="convert it to a mesh"):
            bpy.ops.sinew.apply()
        assert np.array_equal(shown(obj), before)
        return
    assert bpy.ops.sinew.apply() == {"FINISHED"}
    assert obj.type == kind
    assert not obj.sinew.deformers
    assert [modifier.name for modifier in obj.modifiers] == ["Later"]
    assert np.abs(shown(obj) - before).max() < FLOAT32 * size(before)
    assert np.abs(unmoved(obj) - before).max() < FLOAT32 * size(before)


def test_convert_to_mesh_keeps_the_shape_shown(caged):
    obj, cage = caged
    bend(cage)
    before, name = shown(obj), obj.name
    make_active(obj)
    bpy.ops.object.convert(target="MESH")
    obj = bpy.data.objects[name]
    if obj.type != "MESH":
        pytest.skip("this Blender makes no meshes of these")
    update()
    catch_up()
    found = shown(obj)
    if name == "Hair":  # strands become lines through their points, with steps between
        tree = KDTree(len(found))
        for index, place in enumerate(found):
            tree.insert(place, index)
        tree.balance()
        found = np.array([tree.find(place)[0] for place in before])
    assert np.abs(found - before).max() < FLOAT32 * size(before)
    assert not obj.sinew.deformers
    assert cage.name in bpy.data.objects


def test_a_linked_object_shows_its_pose_and_an_override_follows(tmp_path):
    obj, cage = bind(outline())
    cage.location.z = 0.5
    posed = shown(obj)
    collection = bpy.data.collections.new("Asset")
    bpy.context.scene.collection.children.link(collection)
    for part in (obj, cage):
        collection.objects.link(part)
        bpy.context.scene.collection.objects.unlink(part)
    path = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(path, link=True) as (_there, here):
        here.collections = ["Asset"]
    bpy.context.scene.collection.children.link(here.collections[0])
    update()
    (obj,) = (obj for obj in bpy.data.objects if obj.type == "FONT")
    assert np.abs(shown(obj) - posed).max() < FLOAT32
    here.collections[0].override_hierarchy_create(bpy.context.scene, bpy.context.view_layer)
    update()
    obj = next(obj for obj in bpy.data.objects if obj.override_library and obj.sinew.deformers)
    catch_up()
    assert np.abs(shown(obj) - posed).max() < FLOAT32
    obj.sinew.deformers[0].cage.location.z = 1.0
    assert np.abs(shown(obj) - posed - (0.0, 0.0, 0.5)).max() < 2 * FLOAT32


def test_the_panels_draw_what_works(caged):
    obj, _cage = caged
    make_active(obj)
    names = draw_panel(WIDE).operator_names()
    assert {"sinew.bind", "sinew.cage_set_rest", "sinew.cage_add"} <= set(names)
    assert not {"sinew.handle_add", "sinew.deformer_add"} & set(names)


@pytest.mark.parametrize("overlay", ["CAGE", "DISTORTION", "MASK", "REGIONS"])
def test_overlays_colour_surfaces_and_leave_points_alone(room, caged, overlay):
    obj, cage = caged
    for vertex in cage.data.vertices:
        vertex.select = vertex.index == 0
    settings = bpy.context.scene.sinew
    settings.show_overlay, settings.overlay = True, overlay
    update()
    picture = room("ui.overlay_mesh")
    depsgraph = bpy.context.evaluated_depsgraph_get()
    painted = picture.OverlayCache().overlay_mesh(
        obj, obj.sinew.active, picture.overlay_settings(bpy.context), depsgraph
    )
    assert (painted is not None) == (obj.type in ("CURVE", "FONT") and has_surface(obj))
    settings.show_overlay = False


def test_hair_goes_into_alembic_files_and_curves_and_text_do_not(tmp_path):
    if not bpy.app.build_options.alembic:
        pytest.skip("this Blender was built without Alembic")
    path = str(tmp_path / "hair.abc")
    for maker in (bezier, text):
        obj, _cage = bind(maker())
        make_active(obj)
        with pytest.raises(RuntimeError, match="without its modifiers - convert"):
            bpy.ops.sinew.bake(target="ALEMBIC", filepath=path, frame_start=1, frame_end=1)
    obj, cage = bind(hair())
    cage.location.z = 0.5
    posed = shown(obj)
    make_active(obj)
    assert bpy.ops.sinew.bake(target="ALEMBIC", filepath=path, frame_start=1, frame_end=1) == {"FINISHED"}
    before = set(bpy.data.objects)
    bpy.ops.wm.alembic_import(filepath=path, as_background_job=False)
    (read,) = (other for other in bpy.data.objects if other not in before and other.type == "CURVES")
    assert np.abs(shown(read) - posed).max() < 1e-5
