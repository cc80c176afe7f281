# SPDX-License-Identifier: GPL-3.0-or-later
"""What the Sinew panel shows, and which page its question mark opens: the first situation that is there."""

from typing import Protocol

from bpy.types import Context, UILayout

from . import elsewhere, linked, nothing, posing, puppet, start


class Situation(Protocol):
    """What each module of this folder implements."""

    @staticmethod
    def is_there(context: Context) -> bool:
        """Whether the panel shows this situation."""

    @staticmethod
    def page(context: Context) -> str:
        """The page of the manual about it."""

    @staticmethod
    def draw(context: Context, layout: UILayout) -> None:
        """Draw it."""


_SITUATIONS: tuple[Situation, ...] = (puppet, nothing, linked, elsewhere, start, posing)


def situation_of(context: Context) -> Situation:
    """What the panel shows now."""
    return next(situation for situation in _SITUATIONS if situation.is_there(context))
