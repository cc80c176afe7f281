# SPDX-License-Identifier: GPL-3.0-or-later
"""Gives controls to handles: empties made for them, or objects and bones that the user chooses."""

import colorsys

import bpy
import numpy as np
from bpy.types import Depsgraph, Object
from mathutils import Matrix

from ....core.errors import ConstraintError
from ....core.geometry import frames
from ....mesh_io import RestShape
from ....properties import SinewDeformer, SinewHandle
from ...controls.handles import poses, riding
from ...controls.placement import read_place
from ...datablocks.movers import is_moved_before
from ...datablocks.transforms import put


def colour(number: int) -> tuple[float, float, float]:
    """The colour of handle ``number``. The colours of successive handles are easy to tell apart."""
    return colorsys.hsv_to_rgb((0.06 + number * 0.618034) % 1.0, 0.75, 0.95)


def make_empty(
    obj: Object, rest: RestShape, members: np.ndarray, name: str, pose: np.ndarray
) -> tuple[Object, np.ndarray]:
    """An empty at a region, with z along its mean normal, and its rest frame relative to the target (4, 4).

    It is a child of the target, so it moves along with it. Its own transform is zero at rest, so Alt+G, Alt+R
    and Alt+S bring the region back to rest.
    """
    target = np.array(obj.matrix_world, dtype=np.float64)
    relative = frames.inverse(target, obj.name)
    at_rest = frames.in_world(target, frames.region_frame(rest.points, rest.counts, rest.corners, members))
    radius = frames.radius(frames.transformed(target, rest.points[members]))
    if radius == 0.0:
        radius = 0.1 * frames.radius(frames.transformed(target, rest.points))
    frame = relative @ at_rest
    return new_empty(obj, frame, np.vstack((pose, (0.0, 0.0, 0.0, 1.0))), name, 0.6 * radius), frame


def new_empty(obj: Object, frame: np.ndarray, pose: np.ndarray, name: str, size: float) -> Object:
    """An empty whose rest ``frame`` (4, 4) relative to the target is moved by a ``pose`` (4, 4).

    It is a child of the target, and its own transform is zero at rest.
    """
    target = np.array(obj.matrix_world, dtype=np.float64)
    at_rest = target @ frame
    moved = target @ pose @ frames.inverse(target, obj.name)
    empty = bpy.data.objects.new(name, None)
    empty.empty_display_type = "SPHERE"
    empty.empty_display_size = max(size, 1e-3)
    empty.show_in_front = True
    for collection in obj.users_collection or (bpy.context.scene.collection,):
        collection.objects.link(empty)
    empty.parent = obj
    empty.matrix_parent_inverse = to_matrix(frame)
    put(empty, to_matrix(np.linalg.inv(at_rest) @ moved @ at_rest))
    return empty


def own(
    obj: Object, deformer: SinewDeformer, handle: SinewHandle, control: Object, frame: np.ndarray
) -> None:
    """Let an empty that was made for a handle move it, from its rest ``frame`` (4, 4) in what enters now.

    Where something before the deformer may move the mesh, it stands on the surface.
    """
    handle.control, handle.bone, handle.owns_control = control, "", True
    poses.set_rest(handle, frame)
    is_child = control.parent == obj and control.parent_type == "OBJECT"
    if is_child:
        riding.set_stand(handle, riding.parent_inverse(control))
    handle.stands_on = handle.stood_on = "SURFACE" if is_child and is_moved_before(obj, deformer) else "WORLD"


def to_matrix(array: np.ndarray) -> Matrix:
    """A matrix of Blender's from an array (4, 4)."""
    return Matrix(array.tolist())


def assign(
    obj: Object,
    handle: SinewHandle,
    control: Object,
    bone: str,
    pose: np.ndarray | None = None,
    depsgraph: Depsgraph | None = None,
) -> None:
    """Let an object or a bone move a handle. Its place now means ``pose``, so nothing jumps.

    Without a ``depsgraph`` the scene is evaluated.
    """
    if control == obj:
        raise ConstraintError(f"{obj.name} cannot control itself - choose another object")
    place = read_place(control, depsgraph or bpy.context.evaluated_depsgraph_get(), bone)
    if place is None:
        raise ConstraintError(f"{control.name} has no bone '{bone}' - choose one of its pose bones")
    handle.control, handle.bone = control, bone
    poses.capture_rest(handle, np.array(obj.matrix_world, dtype=np.float64), place.matrix(), pose)
