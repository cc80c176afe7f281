# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of handles as index arrays and weights, which the native module binds.

This only reads Blender's data.
"""

import numpy as np
from bpy.types import Mesh

from ....backend import HandlePoints, Handles, Recipe, Shape, connected_parts
from ....core.elements import Elements, Owner
from ....core.errors import ConstraintError
from ....core.status import Remedy
from ....mesh_io import RestShape
from ....properties import SinewDeformer, SinewHandle
from ...blocks.vertex_groups import read_weights
from ..bind_input import BindInput, options
from .poses import rest_of

_IMPLIED = "support"  # the key of the fixed region around a support


def key(settings: SinewDeformer) -> tuple:
    """The settings of the regions in use, and of the loose parts. The order of the regions does not count."""
    has_points = settings.definition.is_space  # a handle without a region acts where its control rests
    parts = "" if has_points else settings.loose_parts
    regions = sorted(
        (
            handle.uid,
            handle.kind,
            handle.vertex_group or (tuple(rest_of(handle)[:3, 3]) if has_points else ""),
            handle.weight,
            *_own_values(settings, handle),
        )
        for handle in settings.handles
        if handle.enabled
    )
    return (parts, *regions)


def _own_values(settings: SinewDeformer, handle: SinewHandle) -> tuple:
    """The parameters that the method has per handle."""
    return tuple(getattr(handle, parameter.id) for parameter in settings.definition.handle_parameters)


def has_constraints(settings: SinewDeformer) -> bool:
    """Whether at least one region is in use."""
    return any(handle.enabled for handle in settings.handles)


def request(settings: SinewDeformer, mesh: Mesh, rest: RestShape, key: tuple, base_count: int) -> BindInput:
    """The arrays for the native module. Raises a ``ConstraintError`` if the regions cannot be bound.

    ``base_count`` is the number of vertices of the base mesh.
    """
    read_weights(rest, mesh, settings)
    method = settings.definition
    count = len(rest.points)
    follow = settings.loose_parts == "FOLLOW" and not method.is_space
    names: list[str] = []
    indices: list[np.ndarray] = []
    weights: list[np.ndarray | None] = []
    own: list[tuple] = []
    taken = np.zeros(count, dtype=bool)
    holder = np.full(count, -1)
    labels: list[str] = []
    points: list[np.ndarray] = []
    support: np.ndarray | None = None
    of_supports: list[tuple] = []
    for handle in settings.handles:
        if not handle.enabled:
            continue
        if not handle.vertex_group and method.is_space and handle.kind == "HANDLE":
            if not handle.has_rest:
                raise ConstraintError(
                    f"{handle.name} has no vertex group and no control - choose one of them, then Rebind"
                )
            names.append(handle.uid)
            indices.append(np.empty(0, dtype=np.intp))
            weights.append(None)
            own.append(_own_values(settings, handle))
            points.append(rest_of(handle)[:3, 3][None])
            continue
        painted = rest.weights.get(handle.vertex_group)
        if painted is None:
            raise ConstraintError(
                f"{handle.name}: vertex group '{handle.vertex_group}' is not on the mesh - pick one, Rebind"
            )
        members = np.flatnonzero(painted > 0.0)
        if len(members) == 0:
            raise ConstraintError(
                f"{handle.name}: vertex group '{handle.vertex_group}' has no vertices - assign some, Rebind"
            )
        if handle.kind == "SUPPORT":
            support = painted > 0.0 if support is None else support | (painted > 0.0)
            of_supports.append(_own_values(settings, handle))
            continue
        strength = painted[members].astype(np.float64) * handle.weight
        _refuse_overlap(holder, members[strength >= 1.0], handle.name, labels)
        taken[members] = True
        names.append(handle.uid)
        indices.append(members)
        points.append(rest.points[members])
        weights.append(strength)
        own.append(_own_values(settings, handle))
    if support is not None:
        held = ~support & ~taken
        if follow:
            held &= _on_touched_parts(rest, support | taken)
        outside = np.flatnonzero(held)
        if len(outside):
            names.append(_IMPLIED)
            indices.append(outside)
            points.append(rest.points[outside])
            weights.append(None)
            own.append(tuple(map(min, zip(*of_supports, strict=True))))  # all supports share one border
    if not names:
        raise ConstraintError(
            "Nothing holds the mesh - select vertices in Edit Mode and Add Handle or Add Fixed"
        )
    return BindInput(
        key=key,
        recipe=Recipe(
            method,
            Shape(rest.points, (rest.counts, rest.corners)),
            options(settings, rest),
            HandlePoints(np.concatenate(points), tuple(map(len, points)))
            if method.is_space
            else Handles(
                tuple(indices),
                tuple(weights),
                {row.id: values for row, values in zip(method.handle_parameters, zip(*own, strict=True))},
                "follow" if follow else "stay",
            ),
        ),
        rest=rest,
        on_base=count == base_count,
        control="1 handle" if len(names) == 1 else f"{len(names)} handles",
        handles=tuple(names),
        indices=tuple(indices),
    )


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
            f"{other} and {name} share {vertices} - take them out of one of the two groups, then Rebind",
            Elements(Owner.TARGET, "vertex", shared),
            Remedy.PART_REGIONS,
        )
    holder[hard] = len(labels)
    labels.append(name)
