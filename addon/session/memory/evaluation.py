# SPDX-License-Identifier: GPL-3.0-or-later
"""One evaluation of one deformer: everything known while it lasts. Never kept, as it holds Blender's data."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from bpy.types import Depsgraph, NodesModifier, Object
from mathutils import Matrix

from ...core import status
from ...core.status import Level, Status
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
        # In Blender 3.4 NumPy cannot read a frozen matrix.
        world, *in_object = (np.array(matrix.copy(), dtype=np.float64) for matrix in self.matrices)
        return world @ in_object[0] if in_object else world


# Everything that controls one deformer, read once per evaluation: then compared, and solved with if it moved.
# One place per row of the kind of control, such as a handle; None for a row that nothing controls.
ControlState = Sequence[Place | None]


@dataclass(frozen=True)
class Chain:
    """What the deformers earlier in the stack leave for the next one.

    ``points`` are the positions that left the one just before, float32 (n, 3), where they are known;
    ``broken`` says that an earlier one is no direct neighbour: only the next evaluation knows what enters.
    ``entered`` is the key of one that lets through what entered it. Until the next evaluation what enters the
    later ones is still what it showed before.
    """

    points: np.ndarray | None = None
    broken: bool = False
    entered: str = ""

    def through(self, key: str) -> "Chain":
        """The deformer of this key lets through what entered."""
        known = self.points is not None or self.broken or self.entered
        return self if known else Chain(entered=key)

    def after_other_modifier(self) -> "Chain":
        """Another add-on's or Blender's own modifier came between."""
        return Chain(broken=self.broken or self.points is not None)


@dataclass(frozen=True)
class Evaluation:
    """``deformer`` is the original, ``settings`` its evaluated copy with animated values.

    ``control`` is where the control of the deformer is now.
    """

    obj: Object
    evaluated: Object
    depsgraph: Depsgraph
    modifier: NodesModifier
    deformer: SinewDeformer
    settings: SinewDeformer
    session: Session
    control: ControlState
    chain: Chain
    preview: bool
    new_geometry: bool  # what enters the modifiers may differ from the last evaluation

    @cached_property
    def mode(self) -> str:
        """VIEWPORT or RENDER."""
        return self.depsgraph.mode

    @cached_property
    def in_viewport(self) -> bool:
        """The window's evaluation, on the main thread."""
        return self.mode == "VIEWPORT"

    @property
    def shown(self) -> Shown:
        """What this mode's shape mesh holds."""
        return self.session.view(self.mode)

    @cached_property
    def proxy(self) -> Object | None:
        """The shape object of this mode."""
        return self.deformer.shape(self.mode)

    def note(self, text: str) -> None:
        """Keep one line about how incoming motion is followed, or none."""
        others = tuple(line for line in status.notes(self.deformer.uid) if line.level is not Level.INFO)
        status.put_notes(self.deformer.uid, (*others, Status(Level.INFO, text)) if text else others)


def is_shown(modifier: NodesModifier, mode: str) -> bool:
    """The modifier takes part in this mode's evaluation."""
    return modifier.show_viewport if mode == "VIEWPORT" else modifier.show_render
