# SPDX-License-Identifier: GPL-3.0-or-later
"""Adds handles that have no region: they act where their controls are. Main thread only."""

from collections.abc import Iterator, Sequence

import bpy
from bpy.types import Object
from mathutils import Matrix, Vector

from ....core.errors import ConstraintError, SinewError
from ....core.names import unique_name
from ....properties import SinewDeformer, SinewHandle
from ...controls import kinds
from ...controls.handles import riding
from ...datablocks.shapes import shapes
from ...state import sessions
from ...targets import targets
from . import empties

_MOST = 500  # empties at the points of one object


@sessions.suspended()
def add_point(
    obj: Object,
    deformer: SinewDeformer,
    control: Object,
    bone: str = "",
    owned: bool = False,
    acts_as: str = "PLACE",
) -> SinewHandle:
    """Add a handle that moves space where ``control``, or its ``bone``, is now. ``bind`` must follow.

    Several objects may have handles of one control. ``owned``: it was made for this handle. ``acts_as``:
    where the handle takes hold of space, if the control has points or is a bone.
    """
    taken = [other.name for other in deformer.handles]
    handle = deformer.handles.add()
    handle.uid = shapes.new_key()
    handle.kind = "HANDLE"
    handle.named = unique_name(bone or control.name, taken)
    handle.name = handle.named
    handle.colour = empties.colour(len(deformer.handles) - 1)
    handle.acts_as = acts_as if bone or targets.has_points(control) else "PLACE"
    try:
        empties.assign(obj, handle, control, bone)
    except SinewError:
        deformer.handles.remove(len(deformer.handles) - 1)
        obj.update_tag()
        raise
    if owned:
        empties.own(obj, deformer, handle, control, riding.rest_of(handle))
    deformer.active_handle = len(deformer.handles) - 1
    kinds.keep_evaluated(obj)
    return handle


def empty_at(obj: Object, place: Vector, name: str = "Point") -> Object:
    """A new empty at a place in the world, a child of ``obj``, which it moves along with."""
    size = max(obj.dimensions) or 1.0
    empty = _new_empty(obj, f"{obj.name} {name}", 0.05 * size)
    empty.parent = obj
    empty.matrix_parent_inverse = Matrix.Translation(obj.matrix_world.inverted_safe() @ place)
    return empty


def empties_on(obj: Object, points: Object) -> list[Object]:
    """New empties that follow the points of a mesh, curve or lattice object, one each, for ``obj``."""
    places = list(_places(points))
    if not places:
        raise ConstraintError(f"{points.name} has no points that an empty can follow - use a mesh or a curve")
    if len(places) > _MOST:
        raise ConstraintError(
            f"{points.name} has {len(places):,} points - use Points of Objects, which needs no empties"
        )
    size = 0.02 * (max(obj.dimensions) or 1.0)
    found = []
    for number in range(len(places)):
        empty = _new_empty(obj, f"{points.name} {number}", size)
        empty.parent, empty.parent_type = points, "VERTEX"
        empty.parent_vertices = (number, 0, 0)
        found.append(empty)
    bpy.context.view_layer.update()
    return found


def with_points(objects: Sequence[Object]) -> list[Object]:
    """Those of the objects whose points can be read after their modifiers."""
    return [obj for obj in objects if targets.has_points(obj)]


def _places(points: Object) -> Iterator[Sequence[float]]:
    data = points.data
    if points.type == "MESH":
        yield from (vertex.co for vertex in data.vertices)
    elif points.type == "LATTICE":
        yield from (point.co for point in data.points)
    elif points.type == "CURVE":
        for spline in data.splines:
            # Of a Bézier point, Blender counts both handles, too.
            yield from (
                place
                for point in spline.bezier_points
                for place in (point.handle_left, point.co, point.handle_right)
            )
            yield from (point.co for point in spline.points)


def _new_empty(obj: Object, name: str, size: float) -> Object:
    empty = bpy.data.objects.new(name, None)
    empty.empty_display_type, empty.empty_display_size = "SPHERE", max(size, 1e-3)
    empty.show_in_front = True
    for collection in obj.users_collection or (bpy.context.scene.collection,):
        collection.objects.link(empty)
    return empty
