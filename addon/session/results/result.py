# SPDX-License-Identifier: GPL-3.0-or-later
"""The shape, triangles and distortion of a deformed mesh, for the code that draws or measures it.

They are computed when they are asked for, and kept until the factor or the shape changes. Main thread only.
"""

from dataclasses import dataclass, field

import numpy as np
from bpy.types import Object

from ...compat import read_triangles
from ...core.geometry import distortion
from ...core.geometry.distortion import Measure, RestMetric
from ...core.memory import remember
from ...mesh_io import RestShape, group_weights, known_groups
from ...properties import SinewDeformer
from ..controls import kinds
from ..controls.influence import Influence
from ..state import sessions
from ..state.sessions import Bound
from ..targets import targets


@dataclass(frozen=True)
class Result:
    """The shape after a deformer. ``source`` is what it was computed from.

    ``points`` are float32 (n, 3) in object space, ``triangles`` int32 (t, 3). ``handles`` are the keys of the
    bound regions, and ``indices`` their vertices.
    """

    source: tuple
    rest: RestShape
    handles: tuple[str, ...]
    indices: tuple[np.ndarray, ...]
    points: np.ndarray
    triangles: np.ndarray


@dataclass(frozen=True)
class Distortion:
    """A ratio per vertex (n,), 1 where nothing is distorted. The ``worst`` vertex is farthest from 1."""

    source: tuple
    measure: Measure
    values: np.ndarray
    worst: int

    @property
    def largest(self) -> float:
        """The ratio of the worst vertex."""
        return float(self.values[self.worst])


@dataclass
class _Kept:
    """What is kept of one deformer while it has this rest shape. No factor is kept."""

    rest: RestShape
    triangles: np.ndarray
    groups: dict[str, np.ndarray | None] = field(default_factory=dict)
    metric: RestMetric | None = None
    result: Result | None = None
    distortion: Distortion | None = None


_kept: dict[str, _Kept] = remember({})


def source(obj: Object, deformer: SinewDeformer) -> tuple | None:
    """What the shape shown depends on, for comparison by ``same``; None if the deformer is not bound."""
    session, bound = sessions.find(deformer.uid), _bound(deformer)
    if session is None or bound is None:
        return None
    shown = session.view("VIEWPORT")
    mask = weights(obj, deformer, deformer.mask_group)
    return bound.rest, bound.indices, shown.positions, shown.incoming, shown.displacement, shown.factor, mask


def same(one: tuple | None, other: tuple | None) -> bool:
    """Whether two sources give the same shape."""
    if one is None or other is None:
        return one is other
    return all(a is b or (isinstance(a, float) and a == b) for a, b in zip(one, other))


def shape_shown(obj: Object, deformer: SinewDeformer) -> Result | None:
    """The shape after the deformer now; None if it is not bound."""
    now, bound = source(obj, deformer), _bound(deformer)
    if now is None or bound is None:
        return None
    kept = _entry(deformer, bound)
    if kept.result is None or not same(kept.result.source, now):
        points = _blend(bound.rest, *now[2:])
        kept.result = Result(now, bound.rest, bound.handles, bound.indices, points, kept.triangles)
    return kept.result


def measured(obj: Object, deformer: SinewDeformer, wanted: Measure) -> Distortion | None:
    """The distortion, if it has been computed for the shape shown now. This never computes it."""
    kept = _kept.get(deformer.uid)
    if kept is None or kept.distortion is None or kept.distortion.measure is not wanted:
        return None
    return kept.distortion if same(kept.distortion.source, source(obj, deformer)) else None


def measure(obj: Object, deformer: SinewDeformer, wanted: Measure) -> Distortion | None:
    """The distortion of the shape shown now; None if the deformer is not bound."""
    found = measured(obj, deformer, wanted)
    result = shape_shown(obj, deformer)
    if found is not None or result is None:
        return found
    kept = _kept[deformer.uid]
    if kept.metric is None:
        kept.metric = distortion.rest_metric(result.rest.points, result.triangles)
    ratios = distortion.ratio(wanted, *distortion.singular_values(kept.metric, result.points))
    values = distortion.at_vertices(kept.metric, ratios)
    kept.distortion = Distortion(result.source, wanted, values, distortion.worst(values))
    return kept.distortion


def selected(deformer: SinewDeformer) -> tuple[int, ...]:
    """The selected vertices of the control of the deformer."""
    return kinds.kind_in_use(deformer).selected(deformer)


def influence(deformer: SinewDeformer) -> Influence | None:
    """How far each vertex follows the selected vertices of the control; None if it has no weights."""
    session = sessions.find(deformer.uid)
    if session is None or session.bound is None or session.bound.factor.is_released:
        return None  # a thread may be building another one
    return kinds.kind_of_method(session.bound.factor.recipe.method).influence(deformer, session.bound)


def control_grids(deformer: SinewDeformer) -> list[np.ndarray]:
    """The control grids of the shape shown, (rows, columns, 3) in object space; none without a grid."""
    session = sessions.find(deformer.uid)
    if session is None or session.bound is None or session.bound.factor.is_released:
        return []
    bound, shown = session.bound, session.view("VIEWPORT")
    if shown.control is None or not shown.signature or shown.signature[0] != bound.key:
        return []  # another factor made this shape
    return bound.factor.control_grids(shown.control, incoming=shown.incoming, **shown.further)


def network(deformer: SinewDeformer) -> tuple[np.ndarray, np.ndarray] | None:
    """The nodes (m, 3) of the shape shown, in object space, and the pairs (l, 2) that hold together.

    None if the method has no nodes.
    """
    session = sessions.find(deformer.uid)
    if session is None or session.bound is None or session.bound.factor.is_released:
        return None
    bound, shown = session.bound, session.view("VIEWPORT")
    if shown.control is None or not shown.signature or shown.signature[0] != bound.key:
        return None  # another factor made this shape
    return bound.factor.network(shown.control, incoming=shown.incoming, **shown.further)


def bands(deformer: SinewDeformer) -> np.ndarray | None:
    """The band of each vertex, (n,) int32, -1 for one in none; None if the method has no bands."""
    session = sessions.find(deformer.uid)
    if session is None or session.bound is None or session.bound.factor.is_released:
        return None
    return session.bound.factor.bands()


def rest_grids(deformer: SinewDeformer) -> list[np.ndarray]:
    """The control grids of the rest shape, in the same form; none without a grid, or before the bind."""
    session = sessions.find(deformer.uid)
    if session is None or session.bound is None or session.bound.factor.is_released:
        return []
    still = np.tile(np.eye(4)[:3], (len(session.bound.handles), 1, 1))
    return session.bound.factor.control_grids(still)


def weights(obj: Object, deformer: SinewDeformer, group: str) -> np.ndarray | None:
    """The weights of a vertex group, float32 (n,); None if there is none.

    They are read from the mesh, or from the rest mesh if the mesh has other vertices, and kept until
    ``repainted`` is called.
    """
    bound = _bound(deformer)
    if not group or bound is None:
        return None
    groups = _entry(deformer, bound).groups
    if group not in groups:
        names = [other.name for other in obj.vertex_groups]
        mesh = obj.data
        if targets.vertex_count(obj) != len(bound.rest.points):
            mesh = deformer.rest_in("VIEWPORT")
            names = known_groups(mesh)
        groups[group] = group_weights(mesh, names, {group}).get(group)
    return groups[group]


def repainted(deformer: SinewDeformer) -> None:
    """Call when vertex groups may have changed."""
    kept = _kept.get(deformer.uid)
    if kept is not None:
        kept.groups.clear()


def forget() -> None:
    """Forget the results of all deformers."""
    _kept.clear()


def _bound(deformer: SinewDeformer) -> Bound | None:
    """The factor that the viewport shows; None where the deformer is not bound."""
    session = sessions.find(deformer.uid)
    return session.bound if session is not None and deformer.is_bound else None


def _entry(deformer: SinewDeformer, bound: Bound) -> _Kept:
    for uid in [uid for uid in _kept if sessions.find(uid) is None]:
        del _kept[uid]
    kept = _kept.get(deformer.uid)
    if kept is None or kept.rest is not bound.rest:
        kept = _kept[deformer.uid] = _Kept(bound.rest, read_triangles(deformer.rest_in("VIEWPORT")))
    return kept


def _blend(
    rest: RestShape,
    positions: np.ndarray | None,
    incoming: np.ndarray | None,
    displacement: bool,
    factor: float,
    mask: np.ndarray | None,
) -> np.ndarray:
    """What the node group shows: a shape between the incoming one and the solution, by Factor and mask."""
    before = rest.points_float32 if incoming is None else incoming
    if positions is None:
        return before
    after = before + positions if displacement else positions
    if factor == 1.0 and mask is None:
        return after
    share = np.float32(factor) if mask is None else (np.float32(factor) * mask)[:, None]
    return before + share * (after - before)
