# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles move the shape: regions of the mesh that follow objects and bones, or stay. See ``kinds``."""

import numpy as np
from bpy.types import Depsgraph

from ....core.status import Level, Status
from ....properties import SinewDeformer
from ...memory.evaluation import Evaluation
from ...memory.sessions import Bound
from ..bind_input import BindInput
from . import poses
from .poses import complete_rest_frames as set_rest
from .regions import has_constraints as is_set
from .regions import key, request

__all__ = ("MISSING", "is_set", "key", "notes", "placed", "pose", "request", "set_rest")

MISSING = "No regions yet - select vertices in Edit Mode, then Add Handle or Add Fixed"


def notes(report: object, request: BindInput) -> tuple[Status, ...]:
    """Parts that nothing holds."""
    if not report.free_parts:
        return ()
    count = report.free_parts
    text = "1 free part stays at rest" if count == 1 else f"{count} free parts stay at rest"
    elements = (tuple(report.free_vertices.tolist()), "vertex") if request.on_base else ((), "")
    return (Status(Level.WARNING, text, *elements),)


def pose(evaluation: Evaluation, bound: Bound) -> tuple[np.ndarray, dict[str, object]]:
    """Poses (k, 3, 4) in bound order, and (k,) whether each moves the rest shape."""
    affine, from_rest = poses.gather(evaluation, bound)
    return affine, {"from_rest": from_rest}


def placed(deformer: SinewDeformer, depsgraph: Depsgraph) -> list[object]:
    """Matrices of the controls."""
    return [poses.placement(handle, depsgraph) for handle in deformer.handles if handle.kind == "HANDLE"]
