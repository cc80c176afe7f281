# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of the rows of a list."""

import re
from collections.abc import Container, Sequence

from .sides import side_of

_NUMBER = re.compile(r"\.\d{3,}$")


def unique_name(name: str, taken: Sequence[str]) -> str:
    """The name, with a number after it if it is taken."""
    if name not in taken:
        return name
    return next(f"{name}.{number:03}" for number in range(1, 1000) if f"{name}.{number:03}" not in taken)


def spoken(name: str) -> str:
    """A name of bones as people write it: ``upper_arm.L`` becomes "Upper Arm L"."""
    words = re.sub(r"[\s._-]+", " ", without_number(name)).strip().split(" ")
    return " ".join(word[:1].upper() + word[1:] for word in words)


def numbered(name: str, taken: Container[str]) -> str:
    """The name, with a number from 2 on if it is taken: before the side, which a name has to end with."""
    before, _space, last = name.rpartition(" ")
    is_side = bool(before) and side_of(name) is not None and len(last) == 1
    names = (f"{before} {n} {last}" if is_side else f"{name} {n}" for n in range(2, 10000))
    return name if name not in taken else next(other for other in names if other not in taken)


def is_numbered(name: str, given: Container[str]) -> bool:
    """Whether it is one of the given names, also with a number after it."""
    return name in given or without_number(name) in given or name.rstrip("0123456789").rstrip(" ") in given


def without_number(name: str) -> str:
    """The name without the number that ``unique_name``, or Blender, puts after it."""
    return _NUMBER.sub("", name)
