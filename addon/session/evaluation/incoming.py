# SPDX-License-Identifier: GPL-3.0-or-later
"""The positions that enter a deformer now, and those that it passes on to the next one in the stack."""

from dataclasses import replace

import numpy as np

from ...core.errors import TopologyChangedError
from ..datablocks import refined
from ..datablocks.movers import DEFORMING
from ..state.evaluation import Chain, Evaluation, is_shown
from ..state.sessions import Bound
from ..targets import node_group, targets
from ..targets.kinds import kind_of

TOPOLOGY_CHANGED = "Topology changed - Rebind"


def find(evaluation: Evaluation, bound: Bound) -> tuple[np.ndarray | None, bool]:
    """The incoming positions float32 (n, 3), None if at rest; and whether only displacements can be shown."""
    if not targets.is_mesh(evaluation.obj):
        session = evaluation.session
        if evaluation.new_geometry or session.structure is None:
            session.structure = targets.structure(evaluation.obj)
        if session.structure != bound.rest.structure:
            raise TopologyChangedError(TOPOLOGY_CHANGED)
        evaluation.note(kind_of(evaluation.obj).hidden_by(evaluation.obj, evaluation.deformer))
        return None, True  # a cage adds displacements, so the incoming positions do not matter
    expected = len(bound.rest.points)
    if evaluation.chain.broken:
        evaluation.note("Another modifier stands between two deformers: this one adds its displacement")
        return None, True
    if evaluation.chain.points is not None:
        if len(evaluation.chain.points) != expected:
            raise TopologyChangedError(TOPOLOGY_CHANGED)
        return evaluation.chain.points, False
    source = evaluation.chain.entered
    if not source and not evaluation.new_geometry and evaluation.shown.positions is not None:
        return evaluation.shown.incoming, evaluation.shown.displacement
    found = refined.read_entering(evaluation, source or evaluation.deformer.uid, expected)
    if found.points is not None and len(bound.rest.not_finite):
        points = found.points.copy()
        points[bound.rest.not_finite] = bound.rest.points_float32[bound.rest.not_finite]
        found = replace(found, points=points)
    if found.points is not None:
        evaluation.note("")
        return (None if np.array_equal(found.points, bound.rest.points_float32) else found.points), False
    if found.count < 0 and evaluation.obj.mode == "EDIT":
        return evaluation.shown.incoming, False
    if found.count > expected or _entering(evaluation) not in (None, expected):
        raise TopologyChangedError(TOPOLOGY_CHANGED)
    if 0 <= found.count < expected and _is_last(evaluation):
        raise TopologyChangedError(TOPOLOGY_CHANGED)
    evaluation.note("A later modifier reorders vertices: the deformation is added as displacement")
    return None, True


def _entering(evaluation: Evaluation) -> int | None:
    """How many vertices enter; None if a modifier before this deformer may change their number."""
    if evaluation.obj.mode == "EDIT":
        return None
    for modifier in evaluation.obj.modifiers:
        if modifier == evaluation.modifier:
            return len(evaluation.obj.data.vertices)
        if (
            is_shown(modifier, evaluation.mode)
            and modifier.type not in DEFORMING
            and not node_group.is_ours(modifier)
        ):
            return None
    return None


def _is_last(evaluation: Evaluation) -> bool:
    """Whether no visible modifier comes after the one of this deformer."""
    return (
        next(other for other in reversed(evaluation.obj.modifiers) if is_shown(other, evaluation.mode))
        == evaluation.modifier
    )


def after(evaluation: Evaluation) -> Chain:
    """What the deformer passes on, computed in float32 as its node group does."""
    shown, settings = evaluation.shown, evaluation.settings
    if shown.positions is None or shown.displacement or settings.mask_group:
        return Chain(broken=True)
    if shown.factor == 1.0:
        return Chain(points=shown.positions)
    before = evaluation.session.bound.rest.points_float32 if shown.incoming is None else shown.incoming
    factor = np.float32(shown.factor)
    return Chain(points=before * (np.float32(1.0) - factor) + shown.positions * factor)
