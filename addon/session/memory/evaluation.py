# SPDX-License-Identifier: GPL-3.0-or-later
"""One evaluation of one deformer: everything known while it lasts. Never kept, as it holds Blender's data."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from bpy.types import Depsgraph, NodesModifier, Object

from ...core import status
from ...core.status import Level, Status
from ...properties import SinewDeformer
from .sessions import Session, Shown


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
    """``deformer`` is the original, ``settings`` its evaluated copy with animated values."""

    obj: Object
    evaluated: Object
    depsgraph: Depsgraph
    modifier: NodesModifier
    deformer: SinewDeformer
    settings: SinewDeformer
    session: Session
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
