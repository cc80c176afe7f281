# SPDX-License-Identifier: GPL-3.0-or-later
"""What the process remembers between calls, so that all of it can be forgotten at once.

None of it is truth: the properties in the .blend file are, and everything else follows from them.
"""

from typing import Protocol, TypeVar


class Clearable(Protocol):
    """A container."""

    def clear(self) -> None:
        """Forget what it holds."""


C = TypeVar("C", bound=Clearable)
_remembered: list[Clearable] = []


def remember(container: C) -> C:
    """The same container, emptied by ``forget_all``. Call it once per module-level container."""
    _remembered.append(container)
    return container


def forget_all() -> None:
    """Empty every container: another file is opened, or a test begins."""
    for container in _remembered:
        container.clear()
