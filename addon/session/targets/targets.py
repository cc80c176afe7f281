# SPDX-License-Identifier: GPL-3.0-or-later
"""The objects that can be moved, by their type: no other module asks for it.

A mesh has vertices, which every method moves. Curves, text, hair and point clouds have control points, or
faces that Blender makes of them. No regions can be marked there, so only methods of space move them. A
lattice has points. What shows a deformer on each: ``kinds``.
"""

from collections.abc import Sequence

import numpy as np
from bpy.types import Curve, Object, Spline

from ...compat import read_key, read_lattice, write_key, write_positions
from ...core.errors import OptionError, SinewError
from ...core.labels import label_of
from ...core.methods import Method, Moved
from ...core.point_types import MESH, SURFACE, PointType, point_type_with_id
from ...core.status import Remedy
from ...ids import Keys
from ...properties import SinewDeformer

_MOVED = ("MESH", "CURVE", "FONT", "CURVES", "POINTCLOUD", "LATTICE")
_CLOUDS = ("CURVES", "POINTCLOUD")
_WITH_POINTS = (*_MOVED, "SURFACE")


def is_mesh(obj: Object) -> bool:
    """Whether the object is a mesh, for which all methods and operators work."""
    return obj.type == "MESH"


def can_be_moved(obj: Object) -> bool:
    """Whether methods of space, at least, can move the object."""
    return obj.type in _MOVED


def is_cloud(obj: Object) -> bool:
    """Whether Blender makes no mesh of the object, but shows its points."""
    return obj.type in _CLOUDS


def has_groups_and_keys(obj: Object) -> bool:
    """Whether the object has vertex groups, and shape keys are made of it."""
    return obj.type in ("MESH", "LATTICE")


def can_be_converted(obj: Object) -> bool:
    """Whether Blender can convert an object that can be moved to a mesh."""
    return obj.type != "LATTICE"


def has_points(obj: Object) -> bool:
    """Whether the points of the object can be read after its modifiers."""
    return obj.type in _WITH_POINTS


def is_path(obj: Object) -> bool:
    """Whether children of the object may follow its curve instead of its frame."""
    return obj.type == "CURVE"


def label(obj: Object) -> str:
    """The name of the type, for use in a sentence."""
    return obj.bl_rna.properties["type"].enum_items[obj.type].name.lower()


def point_type(deformer: SinewDeformer) -> PointType:
    """The points that the deformer moves, since it was bound."""
    rest = deformer.rest_in("VIEWPORT")
    return MESH if rest is None else point_type_with_id(rest.get(Keys.REST_POINT_TYPE))


def has_bones(obj: Object) -> bool:
    """Whether the object is an armature."""
    return obj.type == "ARMATURE"


def is_exported(obj: Object) -> bool:
    """Whether Blender writes the shape shown of this object into Alembic files.

    Of objects of other types it writes the shape without modifiers, or nothing.
    """
    return obj.type in ("MESH", "CURVES")


def suits(obj: Object, deformer: SinewDeformer) -> bool:
    """Whether the object is a mesh, or is none, as it was when the deformer was bound."""
    return not deformer.is_bound or (point_type(deformer) is MESH) == is_mesh(obj)


def size(obj: Object) -> int:
    """Roughly how many vertices or points the object has; 0 if counting takes long."""
    for points in ("vertices", "points"):
        if hasattr(obj.data, points):
            return len(getattr(obj.data, points))
    return 0


def vertex_count(obj: Object) -> int:
    """How many vertices the mesh has without modifiers; -1 for objects of another type."""
    return len(obj.data.vertices) if is_mesh(obj) else -1


def sample(obj: Object, count: int) -> np.ndarray:
    """Where at least ``count`` points of the object itself are, spread over all of them, float32 (k, 3).

    Fewer if it has fewer; none of a text. In Edit Mode they are where they were before it.
    """
    if obj.type == "LATTICE":
        keys = obj.data.shape_keys
        held = read_lattice(obj.data) if keys is None else read_key(keys.reference_key)
        return held[:: max(len(held) // count, 1)]
    if obj.type == "CURVE":
        splines = obj.data.splines
        points: Sequence = [point for spline in splines for point in (*spline.bezier_points, *spline.points)]
    elif obj.type == "MESH":
        keys = obj.data.shape_keys
        points = obj.data.vertices if keys is None else keys.reference_key.data
    else:
        position = getattr(obj.data, "attributes", {}).get("position")
        points = [] if position is None else position.data
    name = "vector" if obj.type not in ("CURVE", "MESH") else "co"
    chosen = range(0, len(points), max(len(points) // count, 1))
    places = [getattr(points[index], name)[:3] for index in chosen]
    return np.array(places, dtype=np.float32).reshape(-1, 3)


def holds_points(obj: Object, point_type: PointType) -> bool:
    """Whether the object itself has the points of this type, which Blender has not made of something else."""
    return point_type is not SURFACE and obj.type != "FONT"


def point_count(obj: Object, point_type: PointType) -> int:
    """How many points of this type, with their handles, a deformer moves if no modifier comes before it."""
    if obj.type == "CURVE":
        return point_type.points_per_element * sum(map(_length, obj.data.splines))
    return size(obj)


def write_points(obj: Object, places: np.ndarray) -> None:
    """Move all points and handles of an object to ``places``, float32 (n, 3). It must hold its points.

    Those of a lattice are in its Basis, for a shape key shows its deformer.
    """
    if obj.type == "CURVE":
        _write_splines(obj.data, places)
    elif obj.type == "LATTICE":
        write_key(obj.data.shape_keys.reference_key, places)
        obj.data.update_tag()
    else:
        write_positions(obj.data, places)


def _length(spline: Spline) -> int:
    return len(spline.bezier_points) or len(spline.points)


def _write_splines(curve: Curve, places: np.ndarray) -> None:
    parts, first = places.reshape(-1, sum(map(_length, curve.splines)), 3), 0
    for spline in curve.splines:
        for point in spline.bezier_points:
            point.handle_left_type = point.handle_right_type = "FREE"
        last = first + _length(spline)
        if spline.type == "BEZIER":
            for name, part in zip(("co", "handle_left", "handle_right"), parts[:, first:last], strict=True):
                spline.bezier_points.foreach_set(name, part.ravel())
        else:
            homogeneous = np.empty((last - first, 4), dtype=np.float32)
            spline.points.foreach_get("co", homogeneous.ravel())
            homogeneous[:, :3] = parts[0, first:last]
            spline.points.foreach_set("co", homogeneous.ravel())
        first = last
    curve.update_tag()


def structure(obj: Object) -> str:
    """What an object that is no mesh consists of, apart from positions. For comparison."""
    data = obj.data
    if obj.type == "FONT":
        return f"{data.body}\n{data.font.name if data.font else ''}"
    if obj.type == "CURVE":
        return " ".join(
            f"{spline.type}{_length(spline)}{'o' * spline.use_cyclic_u}" for spline in data.splines
        )
    if obj.type == "LATTICE":
        return f"{data.points_u} {data.points_v} {data.points_w}"
    return f"{len(getattr(data, 'curves', ()))} {size(obj)}"


def require_method(obj: Object, method: Method) -> None:
    """Refuse an object that this method cannot move."""
    if not is_mesh(obj) and Moved.POINTS not in method.moves:
        what = f"{label_of(method)} needs the surface of a mesh, and {obj.name} is a {label(obj)}"
        if not can_be_converted(obj):
            raise OptionError(f"{what} - choose a space method")
        raise OptionError(
            f"{what} object - choose a space method, or convert it to a mesh", remedy=Remedy.CONVERT
        )


def require_mesh(obj: Object, what: str) -> None:
    """Refuse an object that is no mesh. ``what`` begins the sentence."""
    if not is_mesh(obj):
        remedy = " object - convert it to a mesh" if can_be_converted(obj) else ""
        raise SinewError(f"{what} meshes, and {obj.name} is a {label(obj)}{remedy}")
