# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of the rows of a list."""

import re
from collections.abc import Sequence

_NUMBER = re.compile(r"\.\d{3,}$")


def unique_name(name: str, taken: Sequence[str]) -> str:
    """The name, with a number after it if it is taken."""
    if name not in taken:
        return name
    return next(f"{name}.{number:03}" for number in range(1, 1000) if f"{name}.{number:03}" not in taken)


def without_number(name: str) -> str:
    """The name without the number that ``unique_name``, or Blender, puts after it."""
    return _NUMBER.sub("", name)
