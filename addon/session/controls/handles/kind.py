# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles move the shape: regions of the mesh that follow objects and bones, or stay. See ``kinds``."""

from typing import Any

import numpy as np
from bpy.types import Depsgraph, Object

from ....core.elements import NO_ELEMENTS, Elements, Owner
from ....core.errors import ConstraintError, SinewError
from ....core.status import Level, Remedy, Status, warnings_of
from ....properties import SinewDeformer
from ...datablocks import libraries, parts
from ...state.evaluation import ControlState, Evaluation
from ...state.sessions import Bound
from ..bind_input import BindInput
from ..objects import forget_row_rest
from . import keys, points, poses, riding
from .links import links
from .poses import complete_rest_frames as take_rest, keep_pose
from .regions import has_constraints as is_set, key, request
from .release import release
from .resetting import not_at_rest, reset

__all__ = (
    "MARKS_REGIONS",
    "MISSING",
    "forget_rest",
    "influence",
    "is_set",
    "is_stale",
    "keep_pose",
    "key",
    "links",
    "lost",
    "not_at_rest",
    "notes",
    "object_with",
    "pose",
    "read_state",
    "release",
    "request",
    "reset",
    "selectable",
    "selected",
    "set_rest",
    "take_rest",
    "transform_rest",
    "use",
)

MISSING = (
    "Nothing is held yet - press on the object with Sinew Drag, "
    "or select vertices in Edit Mode, then Make Handle"
)
MARKS_REGIONS = True
_NAMED = 3  # regions without vertices; the panel counts the others


def notes(report: Any, request: BindInput) -> tuple[Status, ...]:
    """Warnings about regions without vertices, remarks of the method, why nothing will bend, what parts do
    that no region touches, and how many details have no height.

    A space method moves all parts.
    """
    unused = list(request.unused[:_NAMED])
    if len(request.unused) > _NAMED:
        unused.append(f"{len(request.unused) - _NAMED:,} more regions are not used")
    lines = [Status(Level.WARNING, text, left_out=True) for text in unused]
    if report is not None:
        lines += warnings_of(report.remarks)
    if request.stiff:
        lines.append(Status(Level.INFO, request.stiff))
    if request.recipe.method.is_space:
        return tuple(lines)
    riding, staying = len(report.rides), report.free_parts
    if riding:
        text = "1 loose part follows" if riding == 1 else f"{riding:,} loose parts follow"
        lines.append(Status(Level.INFO, f"{text} the surface"))
        lines += _of_parts_inside(report, request)
    if staying and not request.recipe.moves_every_part:
        text = "1 loose part stays at rest" if staying == 1 else f"{staying:,} loose parts stay at rest"
        elements = Elements(Owner.TARGET, "vertex", report.free_vertices) if request.on_base else NO_ELEMENTS
        lines.append(Status(Level.WARNING, text, elements))
    irregular = report.irregular_parts
    if irregular:
        text = "1 part is no subdivision" if irregular == 1 else f"{irregular:,} parts are no subdivisions"
        elements = (
            Elements(Owner.TARGET, "vertex", report.irregular_vertices) if request.on_base else NO_ELEMENTS
        )
        lines.append(Status(Level.WARNING, f"{text}: bent as a plain plate", elements))
    thin = len(report.thin_vertices)
    if thin:
        text = "1 vertex: the sheet is" if thin == 1 else f"{thin:,} vertices: the sheet is"
        elements = Elements(Owner.TARGET, "vertex", report.thin_vertices) if request.on_base else NO_ELEMENTS
        lines.append(Status(Level.INFO, f"{text} thinner than these faces can show", elements))
    vectors = report.detail_vectors
    if vectors:
        text = "1 detail is a vector" if vectors == 1 else f"{vectors:,} details are vectors"
        lines.append(Status(Level.INFO, f"{text}: no normal of the base leads there"))
    return tuple(lines)


def _of_parts_inside(report: Any, request: BindInput) -> tuple[Status, ...]:
    """A line about the riding parts in cavities, which hold their shape and place better with a bone."""
    vertices = parts.inside(request.rest, report.riding_vertices) if request.on_base else ()
    if not len(vertices):
        return ()
    elements = Elements(Owner.TARGET, "vertex", vertices)
    text = "Loose parts lie inside, as eyes and teeth do - Keep Inside Parts if they belong to the bone"
    return (Status(Level.INFO, text, elements, Remedy.KEEP_INSIDE),)


def selectable(elements: Elements, request: BindInput) -> Elements:
    """The vertices of handles, where the native module names handles by their rows."""
    if elements.element != "handle":
        return elements
    rows = [request.recipe.located(row)[0] for row in elements.indices]
    members = [request.indices[row] for row in rows]
    return Elements(Owner.TARGET, "vertex", np.concatenate(members) if members else ())


def object_with(_deformer: SinewDeformer, _elements: Elements) -> Object:
    """Always raises: the controls of handles have no elements."""
    raise SinewError("The controls of handles have nothing that could be selected")


def read_state(deformer: SinewDeformer, depsgraph: Depsgraph) -> ControlState:
    """One place per handle in the list; None for those without a control."""
    return [points.place_of(deformer, handle, depsgraph) for handle in deformer.handles]


def pose(
    evaluation: Evaluation, bound: Bound, incoming: np.ndarray | None
) -> tuple[np.ndarray, dict[str, np.ndarray]] | None:
    """The poses (k, 3, 4) of the bound handles, and (k,) whether each moves the rest shape; perhaps keys, and
    the points of controls whose points count.
    """
    surfaces = riding.ride(evaluation, bound, incoming)
    if evaluation.in_viewport:
        poses.take_up_controls(evaluation, bound, surfaces)
    found = poses.read_poses(evaluation, bound, surfaces)
    if found is None:
        return None
    poses.keep_poses(evaluation, found)
    keyed = keys.keywords(evaluation.deformer, bound, evaluation.depsgraph)
    points_now = {"placed": np.concatenate(found.placed)} if found.placed else {}
    return found.affine, {"from_rest": found.from_rest, **points_now, **keyed}


def transform_rest(deformer: SinewDeformer, by: np.ndarray, held: dict[str, np.ndarray]) -> None:
    """Take rest frames, last poses and keys along with an affine map ``by`` (4, 4) of the object space."""
    poses.transform_rest(deformer, by, held)
    keys.transform_rest(deformer, by[:3, :3])


def use(_obj: Object, _deformer: SinewDeformer, control: Object, _owned: bool) -> None:
    """Always refuses: a handle needs a region too."""
    raise ConstraintError(f"{control.name} alone moves no handle - name the vertices that follow it")


def set_rest(obj: Object, deformer: SinewDeformer, _renew: bool) -> None:
    """Controls that rest already stay as they are, unless they have gained or lost points that count."""
    take_rest(obj, deformer)


def is_stale(deformer: SinewDeformer, depsgraph: Depsgraph) -> bool:
    """Only where the points of controls count, and not the places of objects and bones alone."""
    return any(points.is_stale(deformer, handle, depsgraph) for handle in deformer.handles)


def forget_rest(deformer: SinewDeformer) -> None:
    """Forget the rest frames and points: at the next bind the controls rest where they are then."""
    for handle in deformer.handles:
        handle.has_rest = handle.has_last_pose = False
        forget_row_rest(handle)


def lost(deformer: SinewDeformer) -> tuple[str, ...]:
    """A line in the panel per handle whose control was deleted, or is missing with its library."""
    lines = []
    for handle in deformer.handles:
        if handle.kind == "HANDLE" and handle.control is not None and libraries.is_lost(handle.control):
            lines.append(libraries.explain(handle.control))
        elif handle.control_missing:
            lines.append(
                f"{handle.name} has lost its control and stays where it was - New Control, or pick another"
            )
    return tuple(dict.fromkeys(lines))


def selected(_deformer: SinewDeformer) -> tuple[int, ...]:
    """None: the controls of handles have no vertices."""
    return ()


def influence(_deformer: SinewDeformer, _bound: Bound) -> None:
    """None: how far a vertex follows a handle is the result of a solve, not a weight."""
