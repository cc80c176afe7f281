# SPDX-License-Identifier: GPL-3.0-or-later
"""The kinds of object that deformers move, by what shows a deformer: one module per kind."""

from collections.abc import Sequence
from contextlib import AbstractContextManager
from typing import Protocol

import numpy as np
from bpy.types import Depsgraph, Mesh, Modifier, Object, Scene, ShapeKey

from ...core.point_types import PointType
from ...properties import SinewDeformer
from . import lattices, modified


class TargetKind(Protocol):
    """What the module of each kind of target implements.

    Only ``ensure``, ``remove``, ``own_data``, ``keep_first`` and ``new_mesh`` make or remove datablocks. So
    operators, scripts and timers may call them, and handlers may not.
    """

    NOUN: str  # what shows a deformer, in a sentence
    DATA: str  # what holds the points, in a sentence
    STAYS_UNBOUND: bool  # whether what shows a deformer stays while the deformer is not bound
    RENDERS_MAY_DIFFER: bool  # whether other vertices may enter a deformer in renders than in viewports
    READS_ALL_WEIGHTS: bool  # whether ``new_mesh`` reads all vertex groups, whichever are in use

    def require(self, obj: Object) -> None:
        """Refuse an object whose points cannot be moved."""

    def stack(self, obj: Object) -> Sequence[Modifier | ShapeKey]:
        """What moves the points of an object, one after the other; some of it shows deformers."""

    def shown_by(self, obj: Object, deformer: SinewDeformer) -> Modifier | ShapeKey | None:
        """What shows the deformer; None if it was deleted."""

    def mark_of(self, deformer: SinewDeformer) -> Object | str | None:
        """What is equal to the ``mark`` of what shows the deformer, and to no other one."""

    def mark(self, shows: Modifier | ShapeKey) -> Object | str | None:
        """What tells which deformer a part of the stack shows; None if it shows none."""

    def ensure(self, obj: Object, deformer: SinewDeformer) -> Modifier | ShapeKey:
        """What shows the deformer, made if it is missing. Raises a ``SinewError`` if it cannot be made."""

    def connect(self, shows: Modifier | ShapeKey, deformer: SinewDeformer) -> None:
        """Let it show the hidden shapes that the deformer has now."""

    def connect_mask(self, shows: Modifier | ShapeKey, group: str) -> bool:
        """Let a vertex group limit the deformation, or none if the name is empty; whether that is new."""

    def remove(self, obj: Object, deformer: SinewDeformer) -> None:
        """Remove what shows the deformer."""

    def own_data(self, obj: Object) -> None:
        """Give a copied object data of its own, where what shows deformers is a part of it."""

    def follow_renamed(self, obj: Object) -> None:
        """Find again what shows deformers after the artist renamed it. Called before an evaluation."""

    def show(self, obj: Object, mode: str, scene: Scene) -> None:
        """Let the object show what the hidden shapes of this mode hold. Called after an evaluation."""

    def hidden_by(self, obj: Object, deformer: SinewDeformer) -> str:
        """Why Blender does not show the deformer now, for the panel; empty if it does."""

    def position(self, obj: Object, deformer: SinewDeformer | None) -> int:
        """How many modifiers or deformers ``keep_first`` keeps before this one, or before a new one."""

    def modifiers_before(self, obj: Object, deformer: SinewDeformer | None) -> list[Modifier]:
        """The modifiers that act before the deformer, or would before a new one."""

    def keep_first(self, copy: Object, obj: Object, count: int) -> None:
        """Let a copy show the first modifiers or deformers only, in data of its own if needed."""

    def showing_points(self, obj: Object) -> AbstractContextManager[Object]:
        """For a while, an object whose evaluation ``new_mesh`` reads: this one or another."""

    def new_mesh(self, evaluated: Object, depsgraph: Depsgraph) -> Mesh:
        """A new mesh of an evaluated object: its surface, or its points as loose vertices."""

    def take_point_type(self, mesh: Mesh) -> PointType:
        """What a ``new_mesh`` holds of an object that is no mesh. Removes what tells it."""

    def points_shown(self, obj: Object, depsgraph: Depsgraph) -> np.ndarray:
        """The points of any object after its modifiers, float32 (c, 3) in object space."""

    def edges_shown(self, obj: Object, depsgraph: Depsgraph) -> np.ndarray:
        """The edges (e, 2) between these points."""

    def has_keys(self, obj: Object) -> bool:
        """Whether the artist has made shape keys, which keep the shape of an object."""

    def name_of_key(self, shows: Modifier | ShapeKey, deformer: SinewDeformer) -> str:
        """What a shape key made of a deformer is called."""

    def applied(self, obj: Object, deformer: SinewDeformer) -> tuple[np.ndarray, np.ndarray] | None:
        """The object without its deformers and moved by this one alone, both float32 (n, 3).

        None where an evaluation of a copy has to tell.
        """


_LATTICES: TargetKind = lattices
_MODIFIED: TargetKind = modified


def kind_of(obj: Object) -> TargetKind:
    """What shows deformers on an object: shape keys on a lattice, which takes no node modifiers."""
    return _LATTICES if obj.type == "LATTICE" else _MODIFIED
