# SPDX-License-Identifier: GPL-3.0-or-later
"""The messages that the panel shows about each deformer, by the key of the deformer.

Nothing here is saved: the messages are computed again when a file is opened.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum, Flag, auto

from .elements import NO_ELEMENTS, Elements
from .memory import remember


class Level(Enum):
    """How serious a line is, which decides its icon."""

    NONE = "NONE"
    INFO = "INFO"
    WARNING = "WARNING"
    ERROR = "ERROR"


class Remedy(Flag):
    """What the buttons beside a line do, such as ``BAKE | UNBAKE``. ``ui`` maps each to an operator."""

    NONE = 0
    BIND = auto()
    REPAIR = auto()
    PART_REGIONS = auto()
    OVERRIDE = auto()
    PREFERENCES = auto()
    CAGE_REST = auto()
    FLIP_CAGE = auto()
    OUTSIDE = auto()
    LATTICE_REST = auto()
    CONVERT = auto()
    NEW_CONTROL = auto()
    BAKE = auto()
    UNBAKE = auto()
    REFINE = auto()
    ARMATURE_OFF = auto()
    KEEP_INSIDE = auto()
    FIND_FILE = auto()
    QUICK_CAGE = auto()
    STOP_REFINING = auto()
    USE_FACTOR = auto()


@dataclass(frozen=True)
class Status:
    """One line, the elements that **Show** selects, and the remedies that buttons offer.

    ``left_out``: it tells what could not be used, so scripts and reports have to tell it, too.
    """

    level: Level = Level.NONE
    text: str = ""
    elements: Elements = NO_ELEMENTS
    remedy: Remedy = Remedy.NONE
    left_out: bool = False


EMPTY = Status()

_statuses: dict[str, Status] = remember({})
_notes: dict[str, tuple[Status, ...]] = remember({})
_incoming: dict[str, Status] = remember({})
_masks: dict[str, Status] = remember({})
_refined: dict[str, Status] = remember({})
_files: dict[str, tuple[Status, ...]] = remember({})
_renders: dict[str, Status] = remember({})
_unreported: dict[str, str] = remember({})


def warnings_of(remarks: Iterable[str]) -> list[Status]:
    """Remarks of the library, with capitals as everywhere in panels."""
    return [Status(Level.WARNING, remark[:1].upper() + remark[1:]) for remark in remarks]


def current(key: str) -> Status:
    """The main line of a deformer."""
    return _statuses.get(key, EMPTY)


def notes(key: str) -> tuple[Status, ...]:
    """The other lines, which are mostly warnings."""
    live = (_incoming.get(key), _masks.get(key), _refined.get(key), _renders.get(key))
    return (*_files.get(key, ()), *_notes.get(key, ()), *(line for line in live if line is not None))


def left_out(key: str) -> tuple[str, ...]:
    """The other lines that tell what could not be used."""
    return tuple(line.text for line in notes(key) if line.left_out)


def told(key: str) -> str:
    """The main line as scripts read it: followed by what could not be used."""
    return ". ".join((current(key).text, *left_out(key)))


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


def put_mask(key: str, text: str) -> None:
    """Replace the line that tells why there is no mask; empty for no line."""
    if text:
        _masks[key] = Status(Level.WARNING, text, left_out=True)
    else:
        _masks.pop(key, None)


def put_refined(key: str, text: str) -> None:
    """Replace the line that tells why Fast Subdivision shows the control mesh; empty for no line."""
    if text:
        line = f"Fast Subdivision shows the control mesh: {text}"
        _refined[key] = Status(Level.WARNING, line, remedy=Remedy.STOP_REFINING)
    else:
        _refined.pop(key, None)


def put_files(key: str, lines: tuple[Status, ...]) -> None:
    """Replace the lines that tell which files are missing."""
    _files[key] = lines


def put_render(key: str, text: str) -> None:
    """Replace the line that tells why renders show the rest shape; empty for no line.

    Each text is also among those that ``take_unreported`` returns next.
    """
    if text:
        _renders[key], _unreported[key] = Status(Level.WARNING, text), text
    else:
        _renders.pop(key, None)


def take_unreported() -> dict[str, str]:
    """Why deformers showed the rest shape in renders since the last call, by their keys."""
    found = dict(_unreported)
    _unreported.clear()
    return found


def fail(key: str, error: Exception) -> None:
    """Show an error as the main line."""
    elements, remedy = getattr(error, "elements", NO_ELEMENTS), getattr(error, "remedy", Remedy.NONE)
    _statuses[key] = Status(Level.ERROR, str(error), elements, remedy)


def clear(key: str) -> None:
    """Remove all lines of a deformer."""
    _statuses.pop(key, None)
    put_notes(key, ())
    put_mask(key, "")
    put_refined(key, "")
    put_files(key, ())
    put_render(key, "")
