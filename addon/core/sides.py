# SPDX-License-Identifier: GPL-3.0-or-later
"""Left and right in names, by the rules of Blender's own mirror tools.

The side of a name is one of these, in upper or lower case: ``L`` or ``R`` after a separator at the end
(``Hand.L``, ``hand_r``), or before a separator at the start (``L-Hand``); else ``Left`` or ``Right`` at the
start or at the end. A number at the end, such as ``.001``, is kept there.
"""

import re
from enum import Enum

_SEPARATORS = ". -_"
_LETTERS = {"l": "r", "r": "l", "L": "R", "R": "L"}
_NUMBER = re.compile(r"(\.[0-9][^.]*)$")


class Side(Enum):
    """The side of the body that a name states. Left is the positive half of the x axis."""

    LEFT = "LEFT"
    RIGHT = "RIGHT"


def flip(name: str) -> str:
    """The name of the same thing on the other side; empty if the name states no side."""
    before, side, after = _split(name)
    return before + _other(side) + after if side else ""


def side_of(name: str) -> Side | None:
    """The side that a name states, or None."""
    side = _split(name)[1]
    if not side:
        return None
    return Side.LEFT if side[0] in "lL" else Side.RIGHT


def _split(name: str) -> tuple[str, str, str]:
    """The text before the side, the side, and the text after it.

    The side is empty if the name states none.
    """
    if len(name.encode()) < 3:
        return name, "", ""
    stem, number = name, ""
    if name[-1] in "0123456789" and (found := _NUMBER.search(name)):
        stem, number = name[: found.start()], found.group()
    if len(stem) > 1 and stem[-2] in _SEPARATORS and stem[-1] in _LETTERS:
        return stem[:-1], stem[-1], number
    if len(stem) > 1 and stem[1] in _SEPARATORS and stem[0] in _LETTERS:
        return "", stem[0], stem[1:] + number
    if len(stem.encode()) > 5:
        for word in ("right", "left"):
            found = re.search(word, stem, re.IGNORECASE | re.ASCII)  # Blender looks at the first one only
            if found and (found.start() == 0 or found.end() == len(stem)):
                return stem[: found.start()], found.group(), stem[found.end() :] + number
    return name, "", ""


def _other(side: str) -> str:
    """The opposite side, in the same case. As in Blender, the first two letters decide the case."""
    if len(side) == 1:
        return _LETTERS[side]
    word = "right" if side[0] in "lL" else "left"
    if side[0].islower():
        return word
    return word.upper() if side[1].isupper() else word.capitalize()
