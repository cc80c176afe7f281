# SPDX-License-Identifier: GPL-3.0-or-later
"""Left and right in names, by the rules of Blender's own mirror tools.

A side is ``L``, ``R`` in either case behind a separator at the end (``Hand.L``, ``hand_r``) or before one
at the start (``L-Hand``), else ``Left``, ``Right`` in any case at the start or the end. A number such as
``.001`` stays behind.
"""

import re
from enum import Enum

_SEPARATORS = ". -_"
_LETTERS = {"l": "r", "r": "l", "L": "R", "R": "L"}
_NUMBER = re.compile(r"(\.[0-9][^.]*)$")


class Side(Enum):
    """Which side of the body a name speaks of; left is the positive half of the x axis."""

    LEFT = "LEFT"
    RIGHT = "RIGHT"


def flip(name: str) -> str:
    """The same name of the other side; empty where the name has no side."""
    before, side, after = _split(name)
    return before + _other(side) + after if side else ""


def side_of(name: str) -> Side | None:
    """The side a name speaks of."""
    side = _split(name)[1]
    if not side:
        return None
    return Side.LEFT if side[0] in "lL" else Side.RIGHT


def _split(name: str) -> tuple[str, str, str]:
    """What stands before the side, the side, and what stands after; an empty side where there is none."""
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
            found = re.search(word, stem, re.IGNORECASE | re.ASCII)  # the first one counts
            if found and (found.start() == 0 or found.end() == len(stem)):
                return stem[: found.start()], found.group(), stem[found.end() :] + number
    return name, "", ""


def _other(side: str) -> str:
    """Its case is kept as Blender keeps it: by the first two letters."""
    if len(side) == 1:
        return _LETTERS[side]
    word = "right" if side[0] in "lL" else "left"
    if side[0].islower():
        return word
    return word.upper() if side[1].isupper() else word.capitalize()
