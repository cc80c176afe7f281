# SPDX-License-Identifier: GPL-3.0-or-later
"""The memory of the process, by deformer key.

Nothing in it is truth: any of it may be dropped at any time.
"""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

from ..backend import Factor
from ..core import status
from ..mesh_io import RestShape
from .work import Work


@dataclass
class Bound:
    """A factor, and what it was made from."""

    key: tuple
    factor: Factor
    rest: RestShape
    handles: tuple[str, ...]
    indices: tuple[np.ndarray, ...]
    milliseconds: float


@dataclass
class Shown:
    """What one shape mesh (viewport or render) holds."""

    signature: tuple = ()
    incoming: np.ndarray | None = None  # float32 (n, 3); None stands for the rest shape
    positions: np.ndarray | None = None  # float32 (n, 3): positions, or displacements
    displacement: bool = False
    factor: float = 0.0
    converged: bool = True


@dataclass
class Session:
    """One deformer."""

    bound: Bound | None = None
    rest: RestShape | None = None
    failed: tuple | None = None
    shown: dict[str, Shown] = field(default_factory=dict)
    poses: dict[str, np.ndarray] = field(default_factory=dict)
    settle: bool = False  # the final answer of the shown preview is wanted
    final: Work | None = None  # it is under way in a thread
    rewire: bool = (
        False  # a control was exchanged: the driver that keeps controls evaluated names the old one
    )
    solve_milliseconds: float = 0.0
    lock: threading.RLock = field(default_factory=threading.RLock)

    def view(self, mode: str) -> Shown:
        """The record of the viewport's or the render's shape."""
        return self.shown.setdefault(mode, Shown())


_sessions: dict[str, Session] = {}
_suspended = 0


def of(key: str) -> Session:
    """The session of a deformer, made when first asked for."""
    return _sessions.setdefault(key, Session())


def find(key: str) -> Session | None:
    """The session, if there is one."""
    return _sessions.get(key)


def drop(key: str) -> None:
    """Forget a deformer."""
    _sessions.pop(key, None)
    status.clear(key)


def drop_all() -> None:
    """Forget everything, as another file is opened."""
    _sessions.clear()
    status.clear()


def distrust() -> None:
    """Undo may have changed what the shape meshes hold: write them again.

    Factors are kept, their keys tell.
    """
    for session in _sessions.values():
        session.shown.clear()
        session.failed = None


def rewired() -> list[str]:
    """Deformers whose control was exchanged."""
    return [key for key, session in _sessions.items() if session.rewire]


def has_final() -> bool:
    """A final answer is under way, or waits to be shown."""
    return any(session.final is not None for session in _sessions.values())


def unsettled() -> list[str]:
    """Deformers whose last answer was a preview."""
    return [
        key
        for key, session in _sessions.items()
        if any(not shown.converged for shown in session.shown.values())
    ]


@contextmanager
def suspended() -> Iterator[None]:
    """The handlers rest while Sinew itself changes the scene."""
    global _suspended
    _suspended += 1
    try:
        yield
    finally:
        _suspended -= 1


def is_suspended() -> bool:
    """Sinew itself is changing the scene."""
    return _suspended > 0
