# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist takes hold of in a viewport: points of cages, lattices and wires, and tools as a whole.

Main thread only.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from bpy.types import Depsgraph, Object
from mathutils import Matrix

from ...core.errors import ConstraintError, SinewError
from ...core.geometry import frames
from ...properties import SinewDeformer
from ..controls import kinds, movers
from ..datablocks import own_shape
from ..targets.kinds import kind_of


class Grip(NamedTuple):
    """A point of a control by its number, or the whole object if that is -1; and where it is shown (3,)."""

    control: Object
    point: int
    place: np.ndarray


def grips(obj: Object, deformer: SinewDeformer, depsgraph: Depsgraph) -> Iterator[Grip]:
    """The parts of all controls of a deformer."""
    for link in kinds.kind_in_use(deformer).links(deformer):
        control = link.object
        if control.library is not None or link.bone or control == obj:
            continue
        points = own_shape.points_of(control)
        if not len(points):
            yield Grip(control, -1, np.array(control.matrix_world.translation, dtype=np.float64))
            continue
        shown = kind_of(control).points_shown(control, depsgraph)
        if len(shown) == len(points):  # as its modifiers show it
            points = shown
        world = np.array(control.matrix_world, dtype=np.float64)
        for number, place in enumerate(frames.transformed(world, points.astype(np.float64))):
            yield Grip(control, number, place)


class ControlDrag:
    """A part of a control that is dragged. ``move`` moves it, ``restore`` puts it back.

    ``frame`` (4, 4) is the control in the world at the start. Only numbers are kept.
    """

    job = None  # no thread works

    def __init__(self, control: Object, point: int) -> None:
        if control.library is not None:
            raise SinewError(f"{control.name} is linked - make a library override first")
        self.name = control.name
        self._point, self.frame = point, np.array(control.matrix_world, dtype=np.float64)
        self._before = movers.channels_of(control)
        count = len(own_shape.points_of(control))
        if point >= count or (point < 0 < count):
            raise ConstraintError(
                f"{control.name} has {count} points, counted from 0 - there is no number {point}"
            )
        if count and next(own_shape.keys_of(control), None) is not None:
            raise ConstraintError(
                f"{control.name} has shape keys - move its points in Edit Mode, or key these"
            )
        self._numbers = own_shape.read(control)

    def place(self, control: Object) -> np.ndarray:
        """Where the part was at the start (3,), in the world."""
        if self._point < 0:
            return self.frame[:3, 3]
        point = own_shape.points_of(control)[self._point]
        return frames.transformed(self.frame, point[None].astype(np.float64))[0]

    def move(self, control: Object, motion: np.ndarray) -> None:
        """Move the part by a motion (4, 4) of the world, from where it was at the start."""
        if not np.isfinite(motion).all():
            raise ConstraintError("The motion is not a finite number - type another one")
        if self._point < 0:
            movers.move_to(control, "", Matrix((motion @ self.frame).tolist()), self._before)
            return
        by = frames.inverse(self.frame, control.name) @ motion @ self.frame
        own_shape.put_points(control, own_shape.with_point_moved(control, self._numbers, self._point, by))

    def key(self, control: Object) -> None:
        """Key an object that moves as a whole, as Auto Keying does. Points have no keys."""
        if self._point < 0:
            movers.insert_keyframes(control, "")

    def restore(self, control: Object) -> None:
        """Put everything back."""
        for name, values in self._before.items():
            setattr(control, name, values)
        own_shape.put_points(control, self._numbers)
