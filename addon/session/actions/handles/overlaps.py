# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes shared vertices out of one of two hard regions: a vertex may belong to one only."""

import numpy as np
from bpy.types import Object

from ....core.elements import Elements, Owner
from ....core.errors import ConstraintError, SinewError
from ....mesh_io import group_weights
from ....properties import SinewDeformer, SinewHandle
from ...state import sessions


@sessions.suspended()
def part_regions(obj: Object, deformer: SinewDeformer) -> list[tuple[str, str, int]]:
    """Take every vertex that two hard regions share out of the later one.

    If nothing would be left of that one, such as a handle inside a fixed region, the earlier one gives the
    vertices up. Returns (the region that keeps, the one that gives, how many) per pair. The deformer is not
    bound again: see ``bind``.
    """
    if obj.data.library is not None:
        raise SinewError("The mesh is linked - make it local, or override it, before you change its groups")
    regions = [handle for handle in deformer.handles if handle.enabled and handle.kind != "SUPPORT"]
    hard = {handle.uid: _hard(obj, handle) for handle in regions}
    parted = []
    for row, later in enumerate(regions):
        for earlier in regions[:row]:
            shared = hard[earlier.uid] & hard[later.uid]
            if not shared.any():
                continue
            keeps, gives = _kept_and_given(earlier, later, hard, shared)
            obj.vertex_groups[gives.vertex_group].remove(np.flatnonzero(shared).tolist())
            hard[gives.uid] &= ~shared
            parted.append((keeps.name, gives.name, int(shared.sum())))
    obj.update_tag()
    return parted


def _hard(obj: Object, handle: SinewHandle) -> np.ndarray:
    """Which vertices (n,) of the base mesh the region holds exactly."""
    names = [group.name for group in obj.vertex_groups]
    painted = group_weights(obj.data, names, {handle.vertex_group}).get(handle.vertex_group)
    if painted is None:
        return np.zeros(len(obj.data.vertices), dtype=bool)
    return painted.astype(np.float64) * handle.weight >= 1.0


def _kept_and_given(
    earlier: SinewHandle, later: SinewHandle, hard: dict[str, np.ndarray], shared: np.ndarray
) -> tuple[SinewHandle, SinewHandle]:
    """The region that keeps the shared vertices, and the one that gives them up."""
    if earlier.vertex_group != later.vertex_group:
        if (hard[later.uid] & ~shared).any():
            return earlier, later
        if (hard[earlier.uid] & ~shared).any():
            return later, earlier
    raise ConstraintError(
        f"{earlier.name} and {later.name} are the same vertices - remove one, or pick another group for it",
        Elements(Owner.TARGET, "vertex", np.flatnonzero(shared)),
    )
