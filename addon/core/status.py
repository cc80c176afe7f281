# SPDX-License-Identifier: GPL-3.0-or-later
"""The messages that the panel shows about each deformer, by the key of the deformer.

Nothing here is saved: the messages are computed again when a file is opened.
"""

from dataclasses import dataclass
from enum import Enum

from .elements import NO_ELEMENTS, Elements
from .memory import remember


class Level(Enum):
    """How serious a line is, which decides its icon."""

    NONE = "NONE"
    INFO = "INFO"
    WARNING = "WARNING"
    ERROR = "ERROR"


class Remedy(Enum):
    """What the button beside a line does. ``ui`` maps each remedy to an operator."""

    NONE = "NONE"
    BIND = "BIND"
    REPAIR = "REPAIR"
    PART_REGIONS = "PART_REGIONS"
    OVERRIDE = "OVERRIDE"
    PREFERENCES = "PREFERENCES"
    CAGE_REST = "CAGE_REST"
    FLIP_CAGE = "FLIP_CAGE"
    OUTSIDE = "OUTSIDE"
    LATTICE_REST = "LATTICE_REST"
    CONVERT = "CONVERT"
    NEW_CONTROL = "NEW_CONTROL"


@dataclass(frozen=True)
class Status:
    """One line, the elements that **Select** shows, and the remedy that a button offers."""

    level: Level = Level.NONE
    text: str = ""
    elements: Elements = NO_ELEMENTS
    remedy: Remedy = Remedy.NONE


EMPTY = Status()

_statuses: dict[str, Status] = remember({})
_notes: dict[str, tuple[Status, ...]] = remember({})
_incoming: dict[str, Status] = remember({})


def current(key: str) -> Status:
    """The main line of a deformer."""
    return _statuses.get(key, EMPTY)


def notes(key: str) -> tuple[Status, ...]:
    """The other lines, which are mostly warnings."""
    lines, last = _notes.get(key, ()), _incoming.get(key)
    return lines if last is None else (*lines, last)


def put(key: str, status: Status) -> None:
    """Replace the main line."""
    _statuses[key] = status


def put_notes(key: str, lines: tuple[Status, ...]) -> None:
    """Replace the other lines."""
    _notes[key] = lines
    _incoming.pop(key, None)


def put_incoming(key: str, text: str) -> None:
    """Replace the line that tells how the incoming shape is followed; empty for no line."""
    if text:
        _incoming[key] = Status(Level.INFO, text)
    else:
        _incoming.pop(key, None)


def fail(key: str, error: Exception) -> None:
    """Show an error as the main line."""
    elements, remedy = getattr(error, "elements", NO_ELEMENTS), getattr(error, "remedy", Remedy.NONE)
    _statuses[key] = Status(Level.ERROR, str(error), elements, remedy)


def clear(key: str) -> None:
    """Remove all lines of a deformer."""
    _statuses.pop(key, None)
    put_notes(key, ())
