# SPDX-License-Identifier: GPL-3.0-or-later
"""The elements that a message names, so that the button **Select** can show them."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum


class Owner(Enum):
    """The object that the elements belong to."""

    TARGET = "the object that is deformed"
    CONTROL = "the object that deforms it, a cage for example"


@dataclass(frozen=True)
class Elements:
    """The ``indices`` of elements that are all of one sort.

    ``element`` is what each of them is: "vertex", "face" or, in errors of the native module, "handle".
    """

    owner: Owner
    element: str
    indices: Iterable[int]  # kept as a tuple

    def __post_init__(self) -> None:
        object.__setattr__(self, "indices", tuple(int(index) for index in self.indices))

    def __bool__(self) -> bool:
        """Whether there is anything to select."""
        return bool(self.indices)


NO_ELEMENTS = Elements(Owner.TARGET, "", ())
