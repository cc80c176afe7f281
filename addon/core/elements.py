# SPDX-License-Identifier: GPL-3.0-or-later
"""The elements that a message speaks of, so that **Select** can show them."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum


class Owner(Enum):
    """Whose elements they are."""

    TARGET = "the object that is deformed"
    CONTROL = "the object that deforms it, a cage for example"


@dataclass(frozen=True)
class Elements:
    """``indices`` of elements of one ``kind``: vertex, face, or (in errors of the native module) handle."""

    owner: Owner
    kind: str
    indices: Iterable[int]  # kept as a tuple

    def __post_init__(self) -> None:
        object.__setattr__(self, "indices", tuple(int(index) for index in self.indices))

    def __bool__(self) -> bool:
        """There is something to select."""
        return bool(self.indices)


NO_ELEMENTS = Elements(Owner.TARGET, "", ())
