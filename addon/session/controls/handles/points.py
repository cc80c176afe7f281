# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles that take hold of space at all points of their control, rather than where the control is.

Those are the points of an object after its modifiers, or the head and the tail of a bone. How they rested is
stored as a hidden mesh in the frame of the target, with the edges between them.
"""

import hashlib
from functools import partial

import bpy
import numpy as np
from bpy.types import Depsgraph, Mesh, Object

from ....backend import HandlePoints
from ....compat import read_edges, write_positions
from ....core.errors import ConstraintError
from ....core.geometry import frames
from ....core.status import Remedy
from ....ids import Datablocks, Keys
from ....mesh_io import RestShape
from ....properties import SinewDeformer, SinewHandle
from ...datablocks import libraries, rest_frame
from ...state.evaluation import Evaluation, Place
from ...state.sessions import Bound
from ...targets.kinds import kind_of
from ..objects import stored_rest
from ..placement import read_place


def are_apart(settings: SinewDeformer, handle: SinewHandle) -> bool:
    """Whether the points of the control count, and not only its place."""
    is_regionless = handle.kind == "HANDLE" and not handle.vertex_group
    return is_regionless and handle.acts_as != "PLACE" and settings.definition.is_space


def key(settings: SinewDeformer, handle: SinewHandle) -> tuple:
    """What a factor depends on, for a handle whose points count."""
    token = "" if handle.rest is None else rest_frame.token(settings, handle.rest)
    return token, handle.acts_as == "SEGMENTS" and takes_segments(settings)


def takes_segments(settings: SinewDeformer) -> bool:
    """Whether a method in use takes the lines between points as handles."""
    return any(method.takes_segments for method, _values in settings.methods)


def place_of(settings: SinewDeformer, handle: SinewHandle, depsgraph: Depsgraph) -> Place | None:
    """Where the control of a handle is, with its points where they count; None for a handle without one."""
    if handle.kind != "HANDLE":
        return None
    control, bone = handle.control, handle.bone
    if control is None or not are_apart(settings, handle):
        return read_place(control, depsgraph, bone)
    if not bone:
        expected = -1 if handle.rest is None else len(handle.rest.vertices)
        return read_place(control, depsgraph, read_points=kind_of(control).points_shown, expected=expected)
    posed = None if control.pose is None else control.evaluated_get(depsgraph).pose.bones.get(bone)
    return None if posed is None else read_place(control, depsgraph, read_points=partial(_ends, bone))


def _ends(bone: str, control: Object, depsgraph: Depsgraph) -> np.ndarray:
    posed = control.evaluated_get(depsgraph).pose.bones[bone]
    return np.array((posed.head, posed.tail), dtype=np.float32)


def at_rest(settings: SinewDeformer, handle: SinewHandle) -> tuple[RestShape, np.ndarray]:
    """The points at rest, in the frame of the target, and the edges (e, 2) between them."""
    if handle.rest is None:
        raise ConstraintError(
            f"The points of {handle.name} are not bound yet - press Rebind", remedy=Remedy.BIND
        )
    found = rest_frame.read(settings, handle.rest)
    if len(found.not_finite):
        raise ConstraintError(
            f"{handle.name} has points with invalid coordinates (NaN or infinite) - correct them, then "
            "Rebind",
            remedy=Remedy.BIND,
        )
    return found, read_edges(handle.rest)


def bound_counts(bound: Bound) -> dict[int, int]:
    """How many points the handles have whose points count, by their row among the bound handles."""
    control = bound.factor.recipe.control
    if not isinstance(control, HandlePoints):
        return {}
    return {row: control.counts[row] for row in control.apart}


def now(evaluation: Evaluation, handle: SinewHandle, place: Place | None, expected: int) -> np.ndarray | None:
    """The points (c, 3) of a handle in the frame of the target; without its control the last known ones.

    None if these are unknown.
    """
    held = evaluation.session.poses
    if place is None or handle.control_missing:
        return held.get(held_key(handle))
    world = np.array(evaluation.evaluated.matrix_world, dtype=np.float64)
    return _posed(handle, place, frames.inverse(world, "The mesh object"), expected)


def held_key(handle: SinewHandle) -> str:
    """The key of the last known points of a handle, beside the last known pose under its own key."""
    return f"{handle.uid} points"


def transform_rest(handle: SinewHandle, by: np.ndarray, held: dict[str, np.ndarray]) -> None:
    """The last known points follow an affine map ``by`` (4, 4) of the target's object space."""
    if held_key(handle) in held:
        held[held_key(handle)] = frames.transformed(by, held[held_key(handle)])


def _posed(handle: SinewHandle, place: Place, to_target: np.ndarray, expected: int) -> np.ndarray:
    """The points (c, 3) float64 in the frame of the target. Raises a ``ConstraintError`` if they do not
    fit.
    """
    if len(place.vertices) != expected:
        raise ConstraintError(
            f"{handle.name} has {len(place.vertices):,} points, at bind it had {expected:,} - Rebind takes "
            "it as it is now",
            remedy=Remedy.BIND,
        )
    with np.errstate(invalid="ignore"):  # refused below
        found = frames.transformed(to_target @ place.matrix(), place.vertices.astype(np.float64))
    if not frames.are_valid(found).all():
        raise ConstraintError(
            f"{handle.name} has points with invalid coordinates (NaN or infinite) - undo, or correct them"
        )
    return found


def is_stale(settings: SinewDeformer, handle: SinewHandle, depsgraph: Depsgraph) -> bool:
    """Whether the points are not those that are stored."""
    if not are_apart(settings, handle) or handle.control is None or libraries.is_lost(handle.control):
        return False
    place = None if handle.control_missing else place_of(settings, handle, depsgraph)
    return place is not None and (handle.rest is None or len(place.vertices) != len(handle.rest.vertices))


def take_rest(obj: Object, handle: SinewHandle) -> None:
    """Let the points of a handle rest where they are now. This makes datablocks."""
    control, depsgraph = handle.control, bpy.context.evaluated_depsgraph_get()
    control.update_from_editmode()
    kind = kind_of(control)
    points = _ends(handle.bone, control, depsgraph) if handle.bone else kind.points_shown(control, depsgraph)
    if not len(points):
        raise ConstraintError(
            f"{control.name} has no points - let {handle.name} act as a place, or add some, then Rebind"
        )
    edges = np.array([[0, 1]], dtype=np.int32) if handle.bone else kind.edges_shown(control, depsgraph)
    handle.rest = stored_rest(obj, control, _mesh(points, edges), handle.rest)


def _mesh(points: np.ndarray, edges: np.ndarray) -> Mesh:
    mesh = bpy.data.meshes.new(Datablocks.REST)
    mesh.vertices.add(len(points))
    write_positions(mesh, points)
    mesh.edges.add(len(edges))
    mesh.edges.foreach_set("vertices", np.ascontiguousarray(edges, dtype=np.int32).ravel())
    mesh[Keys.REST_STRUCTURE] = hashlib.sha1(edges.tobytes()).hexdigest()  # tells meshes of other edges apart
    return mesh
