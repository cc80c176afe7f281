# SPDX-License-Identifier: GPL-3.0-or-later
"""A cage moves curves, text, hair and point clouds: the surface where there is one, else the points."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import bpy
import numpy as np
import pytest
from mathutils import Matrix, Vector
from mathutils.kdtree import KDTree
from probe import render_points
from rig import apply_matrix, make_active, update
from test_interface import WIDE, draw_panel

FLOAT32 = 4e-6  # as for meshes
TESSELLATED = 1e-5  # Blender sums its curves up in float32, a dozen steps a segment
HANDLES = ("AUTO", "VECTOR", "ALIGNED", "FREE")
Warp = Callable[[np.ndarray], np.ndarray]


def linked(obj: bpy.types.Object) -> bpy.types.Object:
    bpy.context.scene.collection.objects.link(obj)
    make_active(obj)
    return obj


def curve_object(name: str = "Curve") -> bpy.types.Object:
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions = "3D"
    return linked(bpy.data.objects.new(name, data))


def add_bezier(obj: bpy.types.Object, count: int = 5, z: float = 0.0) -> None:
    """Points with handles of every type."""
    spline = obj.data.splines.new("BEZIER")
    spline.bezier_points.add(count - 1)
    for index, point in enumerate(spline.bezier_points):
        angle = index * 1.1
        point.co = 0.5 * np.cos(angle), 0.5 * np.sin(angle), z + 0.08 * index - 0.2
        point.handle_left = point.co + Vector((0.1, -0.2, 0.05 * index))
        point.handle_right = point.co - Vector((0.05, -0.15, 0.1))
        point.handle_left_type = point.handle_right_type = HANDLES[index % 4]


def add_points(obj: bpy.types.Object, kind: str, count: int = 6) -> None:
    spline = obj.data.splines.new(kind)
    spline.points.add(count - 1)
    for index, point in enumerate(spline.points):
        point.co = 0.2 * index - 0.5, 0.4 * np.sin(index), 0.3 * np.cos(2.0 * index), 1.0
    spline.use_endpoint_u = True


def bezier() -> bpy.types.Object:
    obj = curve_object()
    add_bezier(obj)
    add_bezier(obj, 4, 0.2)
    obj.data.splines[1].use_cyclic_u = True
    return obj


def poly() -> bpy.types.Object:
    obj = curve_object()
    add_points(obj, "POLY")
    return obj


def nurbs() -> bpy.types.Object:
    obj = curve_object()
    add_points(obj, "NURBS")
    return obj


def mixed() -> bpy.types.Object:
    """Splines of all types in one curve: those without handles between those with."""
    obj = poly()
    add_bezier(obj)
    add_points(obj, "NURBS", 5)
    add_bezier(obj, 3, 0.1)
    return obj


def bevelled() -> bpy.types.Object:
    obj = bezier()
    obj.data.bevel_depth = 0.05
    return obj


def text(fill: str = "FULL") -> bpy.types.Object:
    data = bpy.data.curves.new("Text", "FONT")
    data.body, data.size, data.align_x, data.align_y = "Sin", 0.6, "CENTER", "CENTER"
    data.extrude = 0.05 if fill == "FULL" else 0.0
    if fill == "NONE":
        data.fill_mode = "NONE"
    return linked(bpy.data.objects.new("Text", data))


def outline() -> bpy.types.Object:
    return text("NONE")


def hair() -> bpy.types.Object:
    bpy.ops.object.curves_random_add()
    obj = bpy.context.object
    obj.name = "Hair"
    return obj


def cloud() -> bpy.types.Object:
    """Blender before 4.5 (4.3 for curves) hides point cloud objects from artists."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.6)
    try:
        bpy.ops.object.convert(target="POINTCLOUD")
    except TypeError:
        pytest.skip("this Blender makes no point cloud objects")
    return bpy.context.object


MAKERS = {
    maker.__name__: maker for maker in (bezier, poly, nurbs, mixed, bevelled, text, outline, hair, cloud)
}
CURVES = ("bezier", "poly", "nurbs", "mixed")
SURFACES = ("bevelled", "text")


def shown(obj: bpy.types.Object) -> np.ndarray:
    """What Blender shows, object space, (n, 3): vertices, places along a curve, or the points themselves."""
    update()
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    if obj.type in ("CURVES", "POINTCLOUD"):
        positions = evaluated.data.attributes["position"].data
        flat = np.empty(len(positions) * 3, dtype=np.float32)
        positions.foreach_get("vector", flat)
        return flat.reshape(-1, 3).astype(float)
    mesh = evaluated.to_mesh()
    flat = np.empty(len(mesh.vertices) * 3, dtype=np.float32)
    mesh.vertices.foreach_get("co", flat)
    evaluated.to_mesh_clear()
    return flat.reshape(-1, 3).astype(float)


def moved_by_hand(obj: bpy.types.Object, warp: Warp) -> np.ndarray:
    """What Blender shows where points and handles of a curve are moved; of others what it shows, moved."""
    with alone(obj) as copy:
        if obj.type not in ("CURVE", "FONT") or has_surface(obj):
            return warp(shown(copy))
        curve = curve_of(copy) if obj.type == "FONT" else copy
        points = [point for spline in curve.data.splines for point in (*spline.bezier_points, *spline.points)]
        names = ("co", "handle_left", "handle_right")
        before = [[getattr(point, name)[:3] for name in names if hasattr(point, name)] for point in points]
        for point, places in zip(points, before):
            goals = warp(np.array(places, dtype=float))
            if len(goals) == 1:
                point.co = (*goals[0], point.co[3])
                continue
            point.handle_left_type = point.handle_right_type = "FREE"
            point.co, point.handle_left, point.handle_right = goals
        found = shown(curve)
        if curve != copy:
            bpy.data.objects.remove(curve)
            make_active(obj)
        return found


def curve_of(letters: bpy.types.Object) -> bpy.types.Object:
    """The outlines of a text as a curve."""
    obj = curve_object("By Hand")
    obj.data.dimensions, obj.data.fill_mode = "2D", "NONE"
    for outline in letters.to_curve(bpy.context.evaluated_depsgraph_get()).splines:
        spline = obj.data.splines.new("BEZIER")
        spline.bezier_points.add(len(outline.bezier_points) - 1)
        spline.use_cyclic_u = outline.use_cyclic_u
        for point, read in zip(spline.bezier_points, outline.bezier_points):
            point.handle_left_type = point.handle_right_type = "FREE"
            point.co, point.handle_left, point.handle_right = read.co, read.handle_left, read.handle_right
    letters.to_curve_clear()
    return obj


@contextmanager
def alone(obj: bpy.types.Object) -> Iterator[bpy.types.Object]:
    """A copy without modifiers."""
    if obj.mode == "EDIT":
        obj.update_from_editmode()
    copy = obj.copy()
    copy.data = obj.data.copy()
    copy.sinew.deformers.clear()
    copy.modifiers.clear()
    copy.animation_data_clear()
    bpy.context.scene.collection.objects.link(copy)
    update()
    try:
        yield copy
    finally:
        bpy.data.objects.remove(copy)


def unmoved(obj: bpy.types.Object) -> np.ndarray:
    """What Blender shows without modifiers."""
    with alone(obj) as copy:
        return shown(copy)


def has_surface(obj: bpy.types.Object) -> bool:
    """Blender makes a mesh of the curve or text."""
    return obj.data.bevel_depth > 0.0 or obj.data.extrude > 0.0


def cage_around(obj: bpy.types.Object, margin: float = 0.15) -> bpy.types.Object:
    """A box of twelve triangles around the points and handles."""
    low, high = np.array(obj.bound_box).min(axis=0), np.array(obj.bound_box).max(axis=0)
    reach = margin + 0.5 * (high - low).max()
    middle = 0.5 * (low + high)
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    mesh = bpy.data.meshes.new("Cage")
    faces = [face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]
    mesh.from_pydata([tuple(middle + reach * np.array(corner)) for corner in corners], [], faces)
    cage = bpy.data.objects.new("Cage", mesh)
    bpy.context.scene.collection.objects.link(cage)
    return cage


def bind(obj: bpy.types.Object, method: str = "mean_value", cage: bpy.types.Object | None = None):
    """The object and its cage, bound."""
    update()
    cage = cage or cage_around(obj)
    make_active(obj)
    assert bpy.ops.sinew.cage_add(source="OBJECT", cage=cage.name, method=method) == {"FINISHED"}
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    return obj, cage


@pytest.fixture(params=MAKERS)
def caged(request) -> tuple[bpy.types.Object, bpy.types.Object]:
    return bind(MAKERS[request.param]())


def shear() -> Matrix:
    return Matrix(((1.0, 0.4, 0.0, 0.2), (0.0, 1.2, 0.1, 0.0), (0.0, 0.0, 0.8, -0.3), (0.0, 0.0, 0.0, 1.0)))


def affine(points: np.ndarray) -> np.ndarray:
    return apply_matrix(shear(), points)


def size(points: np.ndarray) -> float:
    return max(1.0, float(np.abs(points).max()))


def bend(cage: bpy.types.Object) -> Warp:
    """Pose the cage as no affine map does; the warp of mean value coordinates as Ju et al. 2005 write it."""
    rest = np.array([vertex.co for vertex in cage.data.vertices], dtype=float)
    faces = np.array([polygon.vertices[:] for polygon in cage.data.polygons])
    spread = 0.3 * np.ptp(rest, axis=0).max() * np.random.default_rng(5).uniform(-1.0, 1.0, rest.shape)
    for vertex, place in zip(cage.data.vertices, rest + spread):
        vertex.co = place
    cage.data.update()
    posed = np.array([vertex.co for vertex in cage.data.vertices], dtype=float)

    def warp(points: np.ndarray) -> np.ndarray:
        return np.array([_mean_value(point, rest, faces) @ posed for point in points])

    return warp


def _mean_value(point: np.ndarray, rest: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Weights (c,) of the cage's vertices."""
    away = rest - point
    distance = np.linalg.norm(away, axis=1)
    unit = away / distance[:, None]
    weights = np.zeros(len(rest))
    for face in faces:
        u = unit[face]
        length = np.linalg.norm(np.roll(u, -1, axis=0) - np.roll(u, 1, axis=0), axis=1)
        theta = 2.0 * np.arcsin(length / 2.0)
        h = theta.sum() / 2.0
        after, before = np.roll(theta, -1), np.roll(theta, 1)
        c = 2.0 * np.sin(h) * np.sin(h - theta) / (np.sin(after) * np.sin(before)) - 1.0
        s = np.sign(np.linalg.det(u)) * np.sqrt(np.maximum(1.0 - c**2, 0.0))
        below = distance[face] * np.sin(after) * np.roll(s, 1)
        weights[face] += (theta - np.roll(c, -1) * before - np.roll(c, 1) * after) / below
    return weights / weights.sum()


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


@pytest.mark.parametrize("method", ["mean_value", "positive_mean_value", "harmonic", "green"])
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


def test_it_survives_save_and_load(caged, tmp_path):
    obj, cage = caged
    name, cage_name = obj.name, cage.name
    bend(cage)
    before = shown(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "caged.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "caged.blend"))
    obj, cage = bpy.data.objects[name], bpy.data.objects[cage_name]
    tolerance = FLOAT32 * size(before)
    assert np.abs(shown(obj) - before).max() < tolerance
    cage.location.x += 1.0
    assert np.abs(shown(obj) - (before + (1.0, 0.0, 0.0))).max() < 2 * tolerance


def test_undo_and_redo(caged):
    obj, cage = caged
    name, cage_name = obj.name, cage.name
    rest = shown(obj)
    bpy.ops.ed.undo_push(message="Bound")
    cage.location.z = 1.0
    update()
    bpy.ops.ed.undo_push(message="Moved")
    bpy.ops.ed.undo()
    assert np.abs(shown(bpy.data.objects[name]) - rest).max() < FLOAT32 * size(rest)
    bpy.ops.ed.redo()
    moved = shown(bpy.data.objects[name]) - rest
    assert np.abs(moved - (0.0, 0.0, 1.0)).max() < FLOAT32 * size(rest)
    assert bpy.data.objects[cage_name].location.z == 1.0


def test_renders_and_frames_show_an_animated_cage(caged):
    obj, cage = caged
    rest = shown(obj)
    cage.shape_key_add(name="Basis")
    key = cage.shape_key_add(name="Up")
    for point in key.data:
        point.co.z += 1.0
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


def test_a_deleted_cage_leaves_the_last_shape(caged):
    obj, cage = caged
    bend(cage)
    before = shown(obj)
    bpy.data.objects.remove(cage)
    assert np.abs(shown(obj) - before).max() < FLOAT32 * size(before)
    assert obj.sinew.active.cage_missing


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
def test_points_added_after_bind_ask_for_a_rebind(room, caged, automatic):
    obj, cage = caged
    cage.location.z = 1.0
    obj.sinew.active.auto_rebind = automatic
    update()
    add_a_point(obj)
    update()
    room("handlers.deferred").catch_up()
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
def test_other_letters_of_as_many_points_are_noticed(room, kind):
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
    room("handlers.deferred").catch_up()
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    assert np.abs(shown(obj) - moved_by_hand(obj, lambda points: points)).max() > 0.05


def test_a_point_of_another_type_is_noticed(room):
    obj, cage = bind(poly())
    cage.location.z = 1.0
    update()
    obj.data.splines[0].type = "NURBS"
    update()
    room("handlers.deferred").catch_up()
    rest = moved_by_hand(obj, lambda points: points)
    assert np.abs(shown(obj) - rest).max() < FLOAT32
    assert obj.sinew.active.status == "Topology changed - Rebind"


@pytest.mark.parametrize("before", ["bezier", "bevelled"])
def test_a_curve_that_gains_or_loses_its_surface_can_be_bound_anew(room, before):
    obj, cage = bind(MAKERS[before]())
    cage.location.z = 1.0
    update()
    obj.data.bevel_depth = 0.0 if obj.data.bevel_depth else 0.03
    update()
    room("handlers.deferred").catch_up()
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


def inside(points: np.ndarray, cage: bpy.types.Object) -> np.ndarray:
    """By winding number: the sum of the solid angles of the triangles."""
    corners = np.array([vertex.co for vertex in cage.data.vertices], dtype=float)
    faces = np.array([polygon.vertices[:] for polygon in cage.data.polygons])
    a, b, c = np.moveaxis(corners[faces][None] - points[:, None, None], 2, 0)
    la, lb, lc = (np.linalg.norm(side, axis=2) for side in (a, b, c))
    above = np.einsum("pfk,pfk->pf", a, np.cross(b, c))
    below = la * lb * lc + (a * b).sum(2) * lc + (b * c).sum(2) * la + (c * a).sum(2) * lb
    return np.abs(2.0 * np.arctan2(above, below).sum(axis=1) - 4.0 * np.pi) < 1e-6


def controls_of(obj: bpy.types.Object) -> np.ndarray:
    found = [point.co[:3] for spline in obj.data.splines for point in spline.points]
    for spline in obj.data.splines:
        found += [place[:] for point in spline.bezier_points for place in (point.co, point.handle_left)]
        found += [point.handle_right[:] for point in spline.bezier_points]
    return np.array(found, dtype=float)


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
    for operator in (bpy.ops.sinew.apply, bpy.ops.sinew.bake):
        with pytest.raises(RuntimeError, match="convert it to a mesh"):
            operator()
    cage.location.z = 0.5
    update()
    deformer = obj.sinew.active
    deformer.method = "arap"
    rest = moved_by_hand(obj, lambda points: points)
    assert np.abs(shown(obj) - rest).max() < FLOAT32 * size(rest)
    assert "needs the surface of a mesh" in deformer.status
    assert room("core.status").of(deformer.uid).remedy is room("core.status").Remedy.CONVERT
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


def test_convert_to_mesh_keeps_the_shape_shown(room, caged):
    obj, cage = caged
    bend(cage)
    before, name = shown(obj), obj.name
    make_active(obj)
    bpy.ops.object.convert(target="MESH")
    obj = bpy.data.objects[name]
    if obj.type != "MESH":
        pytest.skip("this Blender makes no meshes of these")
    update()
    room("handlers.deferred").catch_up()
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


def test_a_linked_object_shows_its_pose_and_an_override_follows(room, tmp_path):
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
    room("handlers.deferred").catch_up()
    assert np.abs(shown(obj) - posed).max() < FLOAT32
    obj.sinew.deformers[0].cage.location.z = 1.0
    assert np.abs(shown(obj) - posed - (0.0, 0.0, 0.5)).max() < 2 * FLOAT32


def test_the_panels_draw_what_works(room, caged):
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
    picture = room("ui.overlay_picture")
    depsgraph = bpy.context.evaluated_depsgraph_get()
    painted = picture.Gallery().picture(obj, obj.sinew.active, picture.look_of(bpy.context), depsgraph)
    assert (painted is not None) == (obj.type in ("CURVE", "FONT") and has_surface(obj))
    settings.show_overlay = False


def test_hair_goes_into_alembic_files_and_curves_and_text_do_not(tmp_path):
    if not bpy.app.build_options.alembic:
        pytest.skip("this Blender was built without Alembic")
    path = str(tmp_path / "hair.abc")
    for maker in (bezier, text):
        obj, _cage = bind(maker())
        make_active(obj)
        with pytest.raises(RuntimeError, match="without modifiers - convert"):
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
