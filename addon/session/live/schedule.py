# SPDX-License-Identifier: GPL-3.0-or-later
"""In which order rigs are solved: each after those that it reads.

Between two steps Blender evaluates what the first one wrote, so that the controls and modifiers of the next
one see it. Rigs in a circle have no right shape: they are solved in turn until nothing moves, or for so many
rounds.
"""

import threading
from collections.abc import Iterable
from typing import NamedTuple

from bpy.types import Depsgraph, Object

from .dependencies import Reads, Relations

_MOST_ROUNDS = 8  # of a circle
_waiting = threading.local()  # of each thread: a render may be evaluated beside the window


class Step(NamedTuple):
    """Rigs that are solved together: none reads another, or all are in circles."""

    rigs: dict[Object, Reads]
    rounds: int

    @property
    def read(self) -> set[Object]:
        """The rigs that these read."""
        return {other for reads in self.rigs.values() for other in reads.rigs}


def steps(rigs: Iterable[Object]) -> list[Step]:
    """All rigs in their order; empty if none reads another.

    Whoever reads a rig also reads what that one reads, and so has more rigs below it, unless a circle is all
    that it reads. So the number of rigs below gives the order.
    """
    relations = Relations()
    below = {rig: relations.below(rig) for rig in rigs}
    if not any(below.values()):
        return []
    found: dict[tuple[int, bool], dict[Object, Reads]] = {}
    for rig, others in below.items():
        found.setdefault((len(others), rig not in others), {})[rig] = relations.reads(rig)
    return [
        Step(found[count, stands_alone], 1 if stands_alone else _MOST_ROUNDS)
        for count, stands_alone in sorted(found)
    ]


def begin(depsgraph: Depsgraph) -> None:
    """Call before anything is written. Later calls of ``evaluate`` are safe then.

    While a handler runs, Blender still holds its list of what it has updated. If the scene is on it, another
    evaluation copies the scene anew, but not what it computes for the copy, and a later one crashes (3.4.1).
    An evaluation of nothing only ends the list.
    """
    evaluate(depsgraph)


def evaluate(depsgraph: Depsgraph) -> None:
    """Let Blender evaluate what was written. It calls the handlers meanwhile, but ``is_waiting`` is true."""
    _waiting.now = True
    try:
        depsgraph.update()
    finally:
        _waiting.now = False


def is_waiting() -> bool:
    """Whether Blender evaluates between two steps."""
    return getattr(_waiting, "now", False)
