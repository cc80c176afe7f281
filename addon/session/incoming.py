# SPDX-License-Identifier: GPL-3.0-or-later
"""What enters a deformer now, and what leaves it for the next one in the stack."""

from dataclasses import replace

import numpy as np

from ..core.errors import TopologyChangedError
from ..mesh_io import read_incoming
from . import kinds, node_group, rig
from .state import Bound
from .turn import Chain, Turn, is_shown

_DEFORMING = {  # Blender's modifiers that keep the vertices they get
    "ARMATURE",
    "CAST",
    "CORRECTIVE_SMOOTH",
    "CURVE",
    "DISPLACE",
    "HOOK",
    "LAPLACIANDEFORM",
    "LAPLACIANSMOOTH",
    "LATTICE",
    "MESH_CACHE",
    "MESH_DEFORM",
    "SHRINKWRAP",
    "SIMPLE_DEFORM",
    "SMOOTH",
    "SURFACE_DEFORM",
    "WARP",
    "WAVE",
}
TOPOLOGY_CHANGED = "Topology changed - Rebind"


def find(turn: Turn, bound: Bound) -> tuple[np.ndarray | None, bool]:
    """The incoming positions float32 (n, 3), None for rest; and whether only displacements can be shown."""
    if not kinds.is_mesh(turn.obj):
        session = turn.session
        if turn.new_geometry or session.structure is None:
            session.structure = kinds.structure(turn.obj)
        if session.structure != bound.rest.structure:
            raise TopologyChangedError(TOPOLOGY_CHANGED)
        return None, True  # to a cage it is all the same: what it moves, it moves on from where that is
    expected = len(bound.rest.points)
    if turn.chain.broken:
        turn.note("Another modifier stands between two deformers: this one adds its displacement")
        return None, True
    if turn.chain.points is not None:
        if len(turn.chain.points) != expected:
            raise TopologyChangedError(TOPOLOGY_CHANGED)
        return turn.chain.points, False
    source = turn.chain.entered
    if not source and not turn.new_geometry and turn.shown.positions is not None:
        return turn.shown.incoming, turn.shown.displacement
    found = read_incoming(turn.evaluated.data, *rig.attribute_names(source or turn.deformer.uid), expected)
    if found.points is not None and len(bound.rest.not_finite):
        points = found.points.copy()
        points[bound.rest.not_finite] = bound.rest.compact[bound.rest.not_finite]
        found = replace(found, points=points)
    if found.points is not None:
        turn.note("")
        return (None if np.array_equal(found.points, bound.rest.compact) else found.points), False
    if found.count < 0 and turn.obj.mode == "EDIT":
        return turn.shown.incoming, False
    if found.count > expected or _entering(turn) not in (None, expected):
        raise TopologyChangedError(TOPOLOGY_CHANGED)
    if 0 <= found.count < expected and _is_last(turn):
        raise TopologyChangedError(TOPOLOGY_CHANGED)
    turn.note("A later modifier reorders vertices: the deformation is added as displacement")
    return None, True


def _entering(turn: Turn) -> int | None:
    """How many vertices enter, where nothing before this deformer can change their number."""
    if turn.obj.mode == "EDIT":
        return None
    for modifier in turn.obj.modifiers:
        if modifier == turn.modifier:
            return len(turn.obj.data.vertices)
        if (
            is_shown(modifier, turn.mode)
            and modifier.type not in _DEFORMING
            and not node_group.is_ours(modifier)
        ):
            return None
    return None


def _is_last(turn: Turn) -> bool:
    """No visible modifier follows this deformer's."""
    return (
        next(other for other in reversed(turn.obj.modifiers) if is_shown(other, turn.mode)) == turn.modifier
    )


def after(turn: Turn) -> Chain:
    """What leaves the deformer, as its node group computes it in float32."""
    shown, settings = turn.shown, turn.settings
    if shown.positions is None or shown.displacement or settings.mask_group:
        return Chain(broken=True)
    if shown.factor == 1.0:
        return Chain(points=shown.positions)
    before = turn.session.bound.rest.compact if shown.incoming is None else shown.incoming
    factor = np.float32(shown.factor)
    return Chain(points=before * (np.float32(1.0) - factor) + shown.positions * factor)
