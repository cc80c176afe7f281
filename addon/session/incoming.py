# SPDX-License-Identifier: GPL-3.0-or-later
"""What enters a deformer now, and what leaves it for the next one in the stack."""

import numpy as np

from ..core.errors import TopologyChangedError
from ..mesh_io import read_incoming
from . import rig
from .state import Bound
from .turn import Chain, Turn, is_shown

TOPOLOGY_CHANGED = "Topology changed - Rebind"


def find(turn: Turn, bound: Bound) -> tuple[np.ndarray | None, bool]:
    """The incoming positions float32 (n, 3), None for rest; and whether only displacements can be shown."""
    expected = len(bound.rest.points)
    if turn.chain.broken:
        turn.note("Another modifier stands between two deformers: this one adds its displacement")
        return None, True
    if turn.chain.points is not None:
        if len(turn.chain.points) != expected:
            raise TopologyChangedError(TOPOLOGY_CHANGED)
        return turn.chain.points, False
    found = read_incoming(turn.evaluated.data, *rig.attribute_names(turn.deformer.uid), expected)
    if found.points is not None:
        turn.note("")
        return (None if np.array_equal(found.points, bound.rest.compact) else found.points), False
    if found.count < 0 and turn.obj.mode == "EDIT":
        return turn.shown.incoming, False
    if found.count > expected or (0 <= found.count < expected and _is_last(turn)):
        raise TopologyChangedError(TOPOLOGY_CHANGED)
    turn.note("A later modifier reorders vertices: the deformation is added as displacement")
    return None, True


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
