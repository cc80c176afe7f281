# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that only cages move, the points that Blender shows of them, and their shapes when a script moves
them.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import bpy
import numpy as np
import pytest
from expected import faces_of
from inside import native
from mathutils import Vector

from rigs import rig as scenes

TESSELLATED = 1e-5  # Blender sums its curves up in float32, a dozen steps per segment
HANDLES = ("AUTO", "VECTOR", "ALIGNED", "FREE")
Warp = Callable[[np.ndarray], np.ndarray]


def linked(obj: bpy.types.Object) -> bpy.types.Object:
    bpy.context.scene.collection.objects.link(obj)
    scenes.make_active(obj)
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


def bezier(bevel: float = 0.0) -> bpy.types.Object:
    obj = curve_object()
    add_bezier(obj)
    add_bezier(obj, 4, 0.2)
    obj.data.splines[1].use_cyclic_u = True
    obj.data.bevel_depth = bevel
    return obj


def poly(kind: str = "POLY") -> bpy.types.Object:
    obj = curve_object()
    add_points(obj, kind)
    return obj


def mixed() -> bpy.types.Object:
    """Splines of all types in one curve: those without handles between those with."""
    obj = poly()
    add_bezier(obj)
    add_points(obj, "NURBS", 5)
    add_bezier(obj, 3, 0.1)
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


def lattice() -> bpy.types.Object:
    """As an artist has edited it, so that its points stand in no grid."""
    data = bpy.data.lattices.new("Lattice")
    data.points_u, data.points_v, data.points_w = 4, 3, 2
    random = np.random.default_rng(3)
    for point in data.points:
        point.co_deform = point.co + Vector(random.uniform(-0.05, 0.05, 3))
    return linked(bpy.data.objects.new("Lattice", data))


MAKERS = {maker.__name__: maker for maker in (bezier, poly, mixed, text, outline, hair, cloud, lattice)}
MAKERS |= {"nurbs": lambda: poly("NURBS"), "bevelled": lambda: bezier(0.05)}
CURVES = ("bezier", "poly", "nurbs", "mixed")


def moved_by_hand(obj: bpy.types.Object, warp: Warp) -> np.ndarray:
    """What Blender shows where points and handles of a curve are moved; of others what it shows, moved."""
    with alone(obj) as copy:
        if obj.type not in ("CURVE", "FONT") or has_surface(obj):
            return warp(scenes.evaluated_points(copy))
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
        found = scenes.evaluated_points(curve)
        if curve != copy:
            bpy.data.objects.remove(curve)
            scenes.make_active(obj)
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
    if copy.type == "LATTICE" and copy.data.shape_keys is not None:
        for deformer in obj.sinew.deformers:
            copy.data.shape_keys.key_blocks[deformer.shape_key].mute = True
    bpy.context.scene.collection.objects.link(copy)
    scenes.update()
    try:
        yield copy
    finally:
        bpy.data.objects.remove(copy)


def unmoved(obj: bpy.types.Object) -> np.ndarray:
    """What Blender shows without modifiers."""
    with alone(obj) as copy:
        return scenes.evaluated_points(copy)


def has_surface(obj: bpy.types.Object) -> bool:
    """Blender makes a mesh of the curve or text."""
    return obj.data.bevel_depth > 0.0 or obj.data.extrude > 0.0


def cage_around(obj: bpy.types.Object, margin: float = 0.15) -> bpy.types.Object:
    """A box of twelve triangles around the points and handles."""
    # Blender 5.2 does not know the bounds of lattices.
    bounds = scenes.evaluated_points(obj) if obj.type == "LATTICE" else np.array(obj.bound_box)
    low, high = bounds.min(axis=0), bounds.max(axis=0)
    reach = margin + 0.5 * (high - low).max()
    middle = 0.5 * (low + high)
    faces = [face for a, b, c, d in scenes.SIDES for face in ((a, b, c), (a, c, d))]
    return scenes.new_object("Cage", middle + reach * np.array(scenes.CORNERS), faces)


def attach(obj: bpy.types.Object, method: str, cage: bpy.types.Object | None = None) -> bpy.types.Object:
    """Add a cage; a refusal of the bind is in the status."""
    scenes.update()
    cage = cage or cage_around(obj)
    scenes.press(obj, "cage_add", source="OBJECT", cage=cage.name, method=method)
    return cage


def bind(obj: bpy.types.Object, method: str = "mean_value", cage: bpy.types.Object | None = None):
    """The object and its cage, bound."""
    cage = attach(obj, method, cage)
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    return obj, cage


def bend(cage: bpy.types.Object) -> Warp:
    """Pose the cage as no affine map does; the warp of new mean value coordinates in its rest."""
    rest = scenes.base_points(cage)
    mesh = native().SurfaceMesh(rest, faces_of(cage.data))
    spread = 0.3 * np.ptp(rest, axis=0).max() * np.random.default_rng(5).uniform(-1.0, 1.0, rest.shape)
    for vertex, place in zip(cage.data.vertices, rest + spread):
        vertex.co = place
    cage.data.update()
    posed = scenes.base_points(cage)

    def warp(points: np.ndarray) -> np.ndarray:
        coordinates = native().MeanValue(mesh, precision="double")
        coordinates.bind(points)
        return coordinates.warp(posed)

    return warp


def inside(points: np.ndarray, cage: bpy.types.Object) -> np.ndarray:
    """By winding number: the sum of the solid angles of the triangles; in its plane if the cage is flat."""
    corners = np.array([vertex.co for vertex in cage.data.vertices], dtype=float)
    if len(cage.data.polygons) == 1:
        normal = np.array(cage.data.polygons[0].normal)
        seen = corners[list(cage.data.polygons[0].vertices)][None] - points[:, None]
        ahead = np.roll(seen, -1, axis=1)
        turns = np.arctan2(np.cross(seen, ahead) @ normal, (seen * ahead).sum(2)).sum(axis=1)
        level = np.abs((points - corners[0]) @ normal) < 1e-5 * np.ptp(corners, axis=0).max()
        return level & (np.abs(turns - 2.0 * np.pi) < 1e-6)
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


def add(obj: bpy.types.Object, *others: bpy.types.Object, source: str = "POINTS", **words: object):
    """Press the button with these objects selected; the deformer."""
    scenes.make_active(obj, *others)
    assert bpy.ops.sinew.point_add(source=source, **words) == {"FINISHED"}
    scenes.make_active(obj)
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    return obj.sinew.active


def add_bones(obj: bpy.types.Object, armature: bpy.types.Object, **words: object):
    with scenes.in_mode(armature, "POSE"):
        bpy.ops.pose.select_all(action="SELECT")
        obj.select_set(True)
        assert bpy.ops.sinew.point_add(source="SELECTED", **words) == {"FINISHED"}
    scenes.make_active(obj)
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    return obj.sinew.active
