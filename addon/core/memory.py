# SPDX-License-Identifier: GPL-3.0-or-later
"""A list of everything that the process remembers between calls, so that one call can forget all of it.

Nothing here is the only copy: everything can be computed again from the properties in the .blend file.
"""

from typing import Protocol, TypeVar


class Clearable(Protocol):
    """A container that can be emptied."""

    def clear(self) -> None:
        """Empty the container."""


C = TypeVar("C", bound=Clearable)
_remembered: list[Clearable] = []


def remember(container: C) -> C:
    """Register a container, which ``forget_all`` then empties, and return it. Call it once per container."""
    _remembered.append(container)
    return container


def forget_all() -> None:
    """Empty every container, because another file is opened or a test begins."""
    for container in _remembered:
        container.clear()
