# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of handles as index arrays and weights, which the native module binds.

This only reads Blender's data.
"""

import numpy as np
from bpy.types import Mesh

from ....backend import Apart, HandlePoints, Recipe, Regions, Shape, connected_parts
from ....core.elements import Elements, Owner
from ....core.errors import ConstraintError
from ....core.methods import Method, Posed, Reproduced
from ....core.status import Remedy
from ....mesh_io import RestShape
from ....properties import SinewDeformer, SinewHandle
from ...datablocks import references
from ...datablocks.vertex_groups import read_weights
from ..bind_input import BindInput, options, unpainted
from . import companions, points as apart_points
from .poses import rest_of

_IMPLIED = "support"  # the key of the fixed region around a support
_REACH = 0.02  # of the size of the target: how far such points are from the place of a control
_NO_VERTICES = np.empty(0, dtype=np.intp)
_NOUNS = (
    ("HANDLE", "handle", "handles"),
    ("FIXED", "still", "still"),
    ("SUPPORT", "free area", "free areas"),
)


def key(settings: SinewDeformer) -> tuple:
    """The settings of the regions in use, and of the loose parts. The order of the regions does not count."""
    has_points = settings.definition.is_space  # a handle without a region acts where its control rests
    parts = "" if has_points else settings.loose_parts
    regions = sorted(
        (
            handle.uid,
            handle.kind,
            handle.vertex_group or (_key_without_region(settings, handle) if has_points else ""),
            handle.weight,
            *_own_values(settings, handle),
        )
        for handle in settings.handles
        if handle.enabled
    )
    return (parts, *companions.key(settings), *regions)


def _key_without_region(settings: SinewDeformer, handle: SinewHandle) -> tuple:
    if apart_points.are_apart(settings, handle):
        return apart_points.key(settings, handle)
    return tuple(rest_of(handle).ravel())


def _own_values(settings: SinewDeformer, handle: SinewHandle) -> tuple:
    """The parameters that the method has per handle."""
    return tuple(getattr(handle, parameter.id) for parameter in settings.definition.handle_parameters)


def has_constraints(settings: SinewDeformer) -> bool:
    """Whether at least one region is in use. A morph to another mesh needs none."""
    return any(handle.enabled for handle in settings.handles) or references.has_mesh_shape(settings)


def request(settings: SinewDeformer, mesh: Mesh, rest: RestShape, key: tuple, base_count: int) -> BindInput:
    """The arrays for the native module. Raises a ``ConstraintError`` if the regions cannot be bound.

    ``base_count`` is the number of vertices of the base mesh.
    """
    read_weights(rest, mesh, settings)
    method = settings.definition
    count = len(rest.points)
    bound: list[SinewHandle] = []
    unused: list[str] = []
    follow = settings.loose_parts == "FOLLOW" and not method.is_space
    indices: list[np.ndarray] = []
    weights: list[np.ndarray | None] = []
    own: list[tuple] = []
    taken = np.zeros(count, dtype=bool)
    holder = np.full(count, -1)
    labels: list[str] = []
    points: list[np.ndarray] = []
    apart: dict[int, Apart] = {}
    outside = _NO_VERTICES
    support: np.ndarray | None = None
    of_supports: list[tuple] = []
    for handle in settings.handles:
        if not handle.enabled:
            continue
        is_free = method.is_space and handle.weight == 0.0
        if not handle.vertex_group and method.is_space and handle.kind == "HANDLE" and not is_free:
            if not handle.has_rest:
                raise ConstraintError(
                    f"{handle.name} has no vertex group and no control - choose one of them, then bind again"
                )
            if apart_points.are_apart(settings, handle):
                at_rest, edges = apart_points.at_rest(settings, handle)
                apart[len(points)] = Apart(edges, apart_points.key(settings, handle)[1])
                points.append(at_rest.points)
            else:
                points.append(_points_of_control(rest_of(handle), rest.points, method.posed is Posed.CONTROL))
            bound.append(handle)
            indices.append(_NO_VERTICES)
            weights.append(np.full(len(points[-1]), handle.weight))
            own.append(_own_values(settings, handle))
            continue
        painted = rest.weights.get(handle.vertex_group)
        members = np.flatnonzero(painted > 0.0) if painted is not None else _NO_VERTICES
        if painted is None or len(members) == 0:
            unused.append(_why_unused(handle, painted))
            continue
        if handle.kind == "SUPPORT":
            support = painted > 0.0 if support is None else support | (painted > 0.0)
            of_supports.append(_own_values(settings, handle))
            continue
        strength = painted[members].astype(np.float64) * handle.weight
        _refuse_overlap(holder, members[strength >= 1.0], handle.name, labels)
        taken[members] = True
        if is_free:
            unused.append(_why_unused(handle, painted))
            continue
        bound.append(handle)
        indices.append(members)
        points.append(rest.points[members])
        weights.append(strength)
        own.append(_own_values(settings, handle))
    keys, names = [handle.uid for handle in bound], [handle.name for handle in bound]
    if support is not None:
        held = ~support & ~taken
        if follow:
            held &= _on_touched_parts(rest, support | taken)
        outside = np.flatnonzero(held)
        if len(outside):
            keys.append(_IMPLIED)
            names.append("the region outside the supports")
            indices.append(outside)
            points.append(rest.points[outside])
            weights.append(None)
            own.append(tuple(map(min, zip(*of_supports, strict=True))))  # all supports share one border
    if not keys and not references.has_mesh_shape(settings):
        raise ConstraintError(
            unused[0]
            if unused
            else "Nothing holds the mesh - select vertices in Edit Mode and Make Handle or Hold Still"
        )
    return BindInput(
        key=key,
        recipe=Recipe(
            method,
            Shape(rest.points, (rest.counts, rest.corners)),
            options(settings, rest),
            _handle_points(settings, rest, points, weights, apart)
            if method.is_space
            else Regions(
                tuple(indices),
                tuple(weights),
                {row.id: values for row, values in zip(method.handle_parameters, zip(*own, strict=True))},
                "follow" if follow and keys else "stay",
            ),
        ),
        rest=rest,
        on_base=count == base_count,
        control=_counted([handle.kind for handle in bound] + ["SUPPORT"] * len(of_supports))
        + (f" ({sum(len(points[row]) for row in apart):,} points)" if apart else "")
        or "no regions",
        handles=tuple(keys),
        names=tuple(names),
        unused=tuple(unused),
        stiff=_why_stiff(method, bound, len(keys), count - np.count_nonzero(holder >= 0) - len(outside))
        if not references.has_mesh_shape(settings)
        else "",
        unpainted=unpainted(settings, rest),
        indices=tuple(indices),
    )


def _handle_points(
    settings: SinewDeformer,
    rest: RestShape,
    points: list[np.ndarray],
    weights: list[np.ndarray | None],
    apart: dict[int, Apart],
) -> HandlePoints:
    """The points (c, 3) and weights (c,) of each handle; and which rows are ``apart``."""
    counts = tuple(map(len, points))
    held = np.concatenate([np.ones(n) if w is None else w for n, w in zip(counts, weights, strict=True)])
    return HandlePoints(
        np.concatenate(points),
        counts,
        None if (held == 1.0).all() else held,
        apart,
        companions.around(settings, rest),
        settings.sizes == "BOX",
    )


def _points_of_control(frame: np.ndarray, shape: np.ndarray, takes_maps: bool) -> np.ndarray:
    """The handle points (k, 3) of a control without a region, at its rest ``frame`` (4, 4): its place.

    If the method takes maps, six points close around it turn and scale with the control.
    """
    if not takes_maps:
        return frame[:3, 3][None]
    axes, _scales = np.linalg.qr(frame[:3, :3])
    reach = _REACH * float(np.ptp(shape, axis=0).max()) if len(shape) else _REACH
    return frame[:3, 3] + reach * np.concatenate((np.zeros((1, 3)), axes.T, -axes.T))


def _why_unused(handle: SinewHandle, painted: np.ndarray | None) -> str:
    """The line in the panel about a region that holds nothing."""
    if not handle.vertex_group or (painted is not None and painted.any()):
        return f"{handle.name} is not used: its weight is 0"
    lacks = "is not on the mesh - pick another" if painted is None else "has no vertices - assign some"
    return f"{handle.name} is not used: its vertex group '{handle.vertex_group}' {lacks}"


def _why_stiff(method: Method, bound: list[SinewHandle], regions: int, free: int) -> str:
    """Why nothing will bend with so many regions and ``free`` vertices outside of them; empty if it will."""
    if all(handle.kind != "HANDLE" for handle in bound):
        return "Nothing will bend: no handle moves it - Make Handle"
    if free <= 0 and not method.is_space:
        return "Nothing will bend: all vertices are in regions - make these smaller"
    if regions == 1 and method.reproduces is not Reproduced.REST:
        remedy = "Hold Still what" if bound[0].vertex_group else "click with Sinew Drag where it"
        return f"Nothing will bend: all of it follows {bound[0].name} - {remedy} is to stay"
    return ""


def _counted(roles: list[str]) -> str:
    """How many regions of each role there are, as the panel says it: "2 handles, 1 still"."""
    found = []
    for role, one, several in _NOUNS:
        count = roles.count(role)
        if count:
            found.append(f"{count} {one if count == 1 else several}")
    return ", ".join(found)


def _on_touched_parts(rest: RestShape, touched: np.ndarray) -> np.ndarray:
    """Mask of the vertices (n,) whose part has a vertex in a region."""
    parts = connected_parts(len(rest.points), (rest.counts, rest.corners))
    return np.isin(parts, np.unique(parts[touched]))


def _refuse_overlap(holder: np.ndarray, hard: np.ndarray, name: str, labels: list[str]) -> None:
    """A vertex may belong to one hard region only: ``holder`` (n,), its row in ``labels``, or -1."""
    shared = hard[holder[hard] >= 0]
    if len(shared):
        other = labels[holder[shared[0]]]
        vertices = "1 vertex" if len(shared) == 1 else f"{len(shared)} vertices"
        raise ConstraintError(
            f"{other} and {name} share {vertices} - take them out of one of the two groups, then bind again",
            Elements(Owner.TARGET, "vertex", shared),
            Remedy.PART_REGIONS,
        )
    holder[hard] = len(labels)
    labels.append(name)
