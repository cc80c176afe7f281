# SPDX-License-Identifier: GPL-3.0-or-later
"""No vertex obeys two masters: take shared vertices out of one of two hard regions."""

import numpy as np
from bpy.types import Object

from ....core.elements import Elements, Owner
from ....core.errors import ConstraintError, SinewError
from ....mesh_io import group_weights
from ....properties import SinewDeformer, SinewHandle
from ...memory import sessions


@sessions.suspended()
def part_regions(obj: Object, deformer: SinewDeformer) -> list[tuple[str, str, int]]:
    """Let every vertex that two hard regions share go from the later one.

    Where nothing would be left of the later one, the earlier one gives way: a handle inside a fixed part.
    Returns (the one that keeps, the one that gave, how many) for each pair; the deformer is not bound yet.
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
            keeps, gives = _masters(earlier, later, hard, shared)
            obj.vertex_groups[gives.vertex_group].remove(np.flatnonzero(shared).tolist())
            hard[gives.uid] &= ~shared
            parted.append((keeps.name, gives.name, int(shared.sum())))
    obj.update_tag()
    return parted


def _hard(obj: Object, handle: SinewHandle) -> np.ndarray:
    """Vertices (n,) of the base mesh that the region holds exactly."""
    names = [group.name for group in obj.vertex_groups]
    painted = group_weights(obj.data, names, {handle.vertex_group}).get(handle.vertex_group)
    if painted is None:
        raise ConstraintError(
            f"{handle.name}: vertex group '{handle.vertex_group}' is not on the mesh - pick one, Rebind"
        )
    return painted.astype(np.float64) * handle.weight >= 1.0


def _masters(
    earlier: SinewHandle, later: SinewHandle, hard: dict[str, np.ndarray], shared: np.ndarray
) -> tuple[SinewHandle, SinewHandle]:
    """Which of the two keeps the shared vertices, and which gives them up."""
    if earlier.vertex_group != later.vertex_group:
        if (hard[later.uid] & ~shared).any():
            return earlier, later
        if (hard[earlier.uid] & ~shared).any():
            return later, earlier
    raise ConstraintError(
        f"{earlier.name} and {later.name} are the same vertices - remove one, or pick another group for it",
        Elements(Owner.TARGET, "vertex", np.flatnonzero(shared)),
    )
