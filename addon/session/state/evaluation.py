# SPDX-License-Identifier: GPL-3.0-or-later
"""What is known during one evaluation of one deformer. It refers to Blender's data, so it is never kept."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import NamedTuple

import numpy as np
from bpy.types import Depsgraph, Modifier, NodesModifier, Object, ShapeKey
from mathutils import Matrix

from ...core import status
from ...properties import SinewDeformer
from .sessions import Session, Shown

NO_VERTICES = np.zeros((0, 3), dtype=np.float32)


class Place(NamedTuple):
    """Where an object or a bone is in one evaluation. It holds copies, so it may be kept.

    ``fingerprint`` is for comparison: it changes when the place changes, or the shape where that is read too.
    ``matrices``, which are frozen, are those of the object in the world and, for a bone, of the bone in the
    object. ``vertices`` are float32 (c, 3) in the frame of the object; none where its shape does not count.
    """

    fingerprint: tuple[int, ...]
    matrices: tuple[Matrix, ...]
    vertices: np.ndarray = NO_VERTICES

    def matrix(self) -> np.ndarray:
        """The object or the bone in the world, float64 (4, 4)."""
        world = np.array(self.matrices[0].copy(), dtype=np.float64)  # NumPy cannot read a frozen matrix (3.4)
        if len(self.matrices) == 1:
            return world
        return world @ np.array(self.matrices[1].copy(), dtype=np.float64)


# Everything that controls one deformer, read once per evaluation: then compared, and solved with if it moved.
# One place per row of the kind of control, such as a handle; None for a row that nothing controls.
ControlState = Sequence[Place | None]


@dataclass(frozen=True)
class Chain:
    """What the earlier deformers in the stack pass on to the next one.

    ``points`` are the positions after the deformer just before, float32 (n, 3), if they are known. ``broken``
    means that another modifier stands between: what enters is known in the next evaluation only. ``entered``
    is the key of a deformer that passed its input through unchanged. Later deformers still receive what it
    showed in the last evaluation.
    """

    points: np.ndarray | None = None
    broken: bool = False
    entered: str = ""

    def through(self, key: str) -> "Chain":
        """The chain after the deformer of this key, which passes its input through unchanged."""
        known = self.points is not None or self.broken or self.entered
        return self if known else Chain(entered=key)

    def after_other_modifier(self) -> "Chain":
        """The chain after a modifier that is not Sinew's."""
        return Chain(broken=self.broken or self.points is not None)


class Quality(Enum):
    """Whether a shape may be shown before it is final."""

    FINAL = 0
    DRAG = 1  # something is being edited in a window
    DRAFT = 2  # frames play, or the artist scrubs


@dataclass(frozen=True)
class ObjectEvaluation:
    """The evaluation of an object, with all its deformers."""

    obj: Object
    evaluated: Object
    depsgraph: Depsgraph
    mode: str  # VIEWPORT or RENDER: which of the two shapes is computed
    quality: Quality
    new_geometry: bool  # what enters the modifiers may differ from the last evaluation

    @cached_property
    def in_viewport(self) -> bool:
        """Whether this is the evaluation for the window, on the main thread."""
        return self.mode == "VIEWPORT"


@dataclass(frozen=True)
class Evaluation(ObjectEvaluation):
    """``deformer`` is the original, ``settings`` its evaluated copy with animated values.

    ``control`` is where the control of the deformer is now.
    """

    modifier: NodesModifier | ShapeKey
    deformer: SinewDeformer
    settings: SinewDeformer
    session: Session
    control: ControlState
    chain: Chain

    @property
    def preview(self) -> bool:
        """Whether an iterative method may show an early shape of a drag."""
        return self.quality is Quality.DRAG

    @property
    def draft(self) -> bool:
        """Whether an iterative method may show an early shape of a frame."""
        return self.quality is Quality.DRAFT and self.in_viewport and self.deformer.playback == "DRAFT"

    @property
    def shown(self) -> Shown:
        """What the shape mesh of this mode holds."""
        return self.session.view(self.mode)

    @cached_property
    def proxy(self) -> Object | None:
        """The shape object of this mode."""
        return self.deformer.shape(self.mode)

    def note(self, text: str) -> None:
        """Replace the line in the panel that tells how the incoming shape is followed; empty for no line."""
        status.put_incoming(self.deformer.uid, text)


def is_shown(modifier: Modifier | ShapeKey, mode: str) -> bool:
    """Whether the modifier takes part in the evaluation of this mode; or the shape key, in both."""
    if isinstance(modifier, ShapeKey):
        return not modifier.mute
    return modifier.show_viewport if mode == "VIEWPORT" else modifier.show_render
