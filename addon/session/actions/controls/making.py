# SPDX-License-Identifier: GPL-3.0-or-later
"""Automatic cages that threads are making, by the names of the objects that get one. Main thread only."""

from collections.abc import Callable, Sequence

from bpy.types import Object

from ....backend import Progress
from ....core.errors import CageError
from ....core.memory import remember
from ...state.background import Work, Works
from .automatic import Shape

BEING_MADE = "A cage is being made for this object - wait for it, or cancel it with the X in the panel"

_cages = remember(Works())


def begin_cage(objects: Sequence[Object], make: Callable[[Progress | None], Shape]) -> Work:
    """Let a thread make one cage for all these objects. Each gets one at a time."""
    if any(obj.name in _cages for obj in objects):
        raise CageError(BEING_MADE)
    work = Work(make)
    _cages.update({obj.name: work for obj in objects})
    return work


def cage_work(name: str) -> Work | None:
    """The cage that is being made for an object, or waits to be taken."""
    return _cages.get(name)


def drop_cage(name: str) -> None:
    """Cancel the making of a cage for an object and the others; or forget it, when it is made and taken."""
    work = _cages.get(name)
    for other in [key for key, each in _cages.items() if each is work]:
        _cages.drop(other)
