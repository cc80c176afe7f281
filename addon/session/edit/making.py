# SPDX-License-Identifier: GPL-3.0-or-later
"""Automatic cages that threads are making, by the name of the object that gets one. Main thread only."""

from collections.abc import Callable

from bpy.types import Object

from ...backend import Progress
from ...core.errors import CageError
from ...core.memory import remember
from ..memory.background import Work, Works
from .automatic import Shape

BEING_MADE = "A cage is being made for this object - wait for it, or cancel it with the X in the panel"

_cages = remember(Works())


def begin_cage(obj: Object, make: Callable[[Progress | None], Shape]) -> Work:
    """Let a thread make a cage for an object, which gets one at a time."""
    if obj.name in _cages:
        raise CageError(BEING_MADE)
    return _cages.setdefault(obj.name, Work(make))


def cage_work(name: str) -> Work | None:
    """The cage that is being made for an object, or waits to be taken."""
    return _cages.get(name)


def drop_cage(name: str) -> None:
    """Cancel the making of a cage; or forget it, when it is made and taken."""
    _cages.drop(name)
