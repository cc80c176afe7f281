# SPDX-License-Identifier: GPL-3.0-or-later
"""In which order rigs are solved: each after those that it reads.

Between two steps Blender evaluates what the first one wrote, so that the controls and modifiers of the next
one see it. It does so after the last step too if handlers of others follow, which then read the right shape.
That costs nothing: else Blender evaluates the same once these handlers have returned. Rigs in a circle have
no right shape: they are solved in turn until nothing moves, or for so many rounds.
"""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext
from threading import current_thread, local, main_thread
from typing import NamedTuple

import bpy
from bpy.types import Depsgraph, Object

from .dependencies import Reads, Relations

_MOST_ROUNDS = 8  # of a circle
_waiting = local()  # of each thread: a render may be evaluated beside the window


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


def others_listen(edit: bool) -> bool:
    """Whether Blender calls other handlers than ours after an edit, or after a change of the frame."""
    handlers = bpy.app.handlers
    return len(handlers.depsgraph_update_post if edit else handlers.frame_change_post) > 1


def begin(depsgraph: Depsgraph, heard: bool = True) -> None:
    """Call before anything is written. Later calls of ``evaluate`` are safe then.

    While a handler runs, Blender still holds its list of what it has updated. If the scene is on it, another
    evaluation copies the scene anew, but not what it computes for the copy, and a later one crashes (3.4.1).
    An evaluation of nothing only ends the list.
    """
    evaluate(depsgraph, heard)


def evaluate(depsgraph: Depsgraph, heard: bool = True) -> None:
    """Let Blender evaluate what was written. It calls the handlers meanwhile, but ``is_waiting`` is true.

    Unless ``heard``, it calls none, as in a change of frame, where Blender does not call those of edits. A
    render thread cannot hold them back, as they belong to the window too.
    """
    _waiting.now = True
    try:
        with nullcontext() if heard or current_thread() is not main_thread() else _unheard():
            depsgraph.update()
    finally:
        _waiting.now = False


@contextmanager
def _unheard() -> Iterator[None]:
    """For a while, nobody hears of evaluations."""
    lists = (bpy.app.handlers.depsgraph_update_pre, bpy.app.handlers.depsgraph_update_post)
    kept = [handlers[:] for handlers in lists]
    try:
        for handlers in lists:
            handlers.clear()
        yield
    finally:
        for handlers, own in zip(lists, kept, strict=True):
            handlers[:] = own


def is_waiting() -> bool:
    """Whether Blender evaluates between two steps."""
    return getattr(_waiting, "now", False)
