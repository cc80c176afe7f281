# SPDX-License-Identifier: GPL-3.0-or-later
"""The memory of the process, by deformer key.

Nothing in it is truth: any of it may be dropped at any time.
"""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import bpy
import numpy as np

from ...backend import Factor
from ...core import status
from ...core.memory import remember
from ...mesh_io import RestShape
from .background import Work

FIRST_STEPS = 4  # iterations of a drag's first redraw, while the price of one is unknown


@dataclass
class Bound:
    """A factor, and what it was made from."""

    key: tuple
    factor: Factor
    rest: RestShape
    handles: tuple[str, ...]
    indices: tuple[np.ndarray, ...]
    control: str  # what moves the mesh, in words
    milliseconds: float
    is_preview: bool = False  # rough, while a thread computes the real one


@dataclass
class Shown:
    """What one shape mesh (viewport or render) holds."""

    signature: tuple = ()
    incoming: np.ndarray | None = None  # float32 (n, 3); None stands for the rest shape
    shape: np.ndarray | None = None  # float32 (n + 1, 3), a ``shape_array``
    positions: np.ndarray | None = None  # float32 (n, 3), a view of it: positions, or displacements
    displacement: bool = False
    factor: float = 0.0
    converged: bool = True

    def hold(self, shape: np.ndarray | None) -> None:
        """Another shape is shown, or none."""
        self.shape, self.positions = shape, None if shape is None else shape[:-1]


@dataclass
class Session:
    """One deformer."""

    bound: Bound | None = None
    rest: RestShape | None = None
    structure: str | None = None  # what an object that is no mesh was last made of, see ``RestShape``
    failed: tuple | None = None
    shown: dict[str, Shown] = field(default_factory=dict)
    poses: dict[str, np.ndarray] = field(default_factory=dict)
    settle: bool = False  # the final answer of the shown preview is wanted
    work: Work | None = None  # a thread looks for an answer; the subject is its question
    unanswered: Work | None = None  # the last one that failed: the same question is not asked again
    rewire: bool = (
        False  # a control was exchanged: the driver that keeps controls evaluated names the old one
    )
    solve_milliseconds: float = 0.0
    step_milliseconds: float = 0.0  # of a drag: one iteration, or one solve of a method without them
    steps: int = FIRST_STEPS  # iterations that a drag may spend
    lock: threading.RLock = field(default_factory=threading.RLock)

    def drop_work(self) -> None:
        """Something newer is asked for."""
        self.settle = False
        if self.work is not None:
            self.work.cancel()
            self.work = None

    def view(self, mode: str) -> Shown:
        """The record of the viewport's or the render's shape."""
        shown = self.shown.get(mode)
        return self.shown.setdefault(mode, Shown()) if shown is None else shown


@dataclass(frozen=True)
class LastUpdate:
    """Where an object and its controls were when its deformers were last brought up to date.

    ``layout`` names the deformer that each of its modifiers shows, by index and key.
    """

    placed: tuple
    layout: tuple[tuple[int, str] | None, ...]


_sessions: dict[str, Session] = remember({})
_RENDER = " in renders"
_last_updates: dict[str, LastUpdate] = remember({})  # by object
_edited: set[str] = remember(set())
_missed: set[str] = remember(set())
_suspended = 0


def open_session(key: str) -> Session:
    """The session of a deformer, made when first asked for."""
    session = _sessions.get(key)
    return _sessions.setdefault(key, Session()) if session is None else session


def open_render_session(key: str) -> Session:
    """The session of a deformer for renders, where other vertices enter than in viewports."""
    session = open_session(key + _RENDER)
    session.poses = open_session(key).poses
    return session


def find(key: str) -> Session | None:
    """The session, if there is one."""
    return _sessions.get(key)


def drop(key: str) -> None:
    """Forget a deformer."""
    _sessions.pop(key, None)
    _sessions.pop(key + _RENDER, None)
    _last_updates.clear()
    status.clear(key)


def forget_shapes() -> None:
    """Undo may have changed what the shape meshes hold: write them again.

    Factors are kept, their keys tell.
    """
    _last_updates.clear()
    for session in _sessions.values():
        session.shown.clear()
        session.failed = session.unanswered = None


def note_edit(name: str) -> None:
    """An object's mesh, or what stands before Sinew in its stack, was edited."""
    _edited.add(name)


def forget_edit(name: str) -> None:
    """The mesh was looked at just now."""
    _edited.discard(name)


def take_edited() -> list[str]:
    """The objects that were edited since the last call."""
    names = sorted(_edited)
    _edited.clear()
    return names


def has_edited() -> bool:
    """Some object was edited."""
    return bool(_edited)


def last_update(name: str) -> LastUpdate | None:
    """What ``see`` noted of an object."""
    return _last_updates.get(name)


def note_update(name: str, update: LastUpdate) -> None:
    """Note an object whose deformers are up to date now."""
    _last_updates[name] = update


def rewired() -> list[str]:
    """Deformers whose control was exchanged."""
    return [key for key, session in _sessions.items() if session.rewire]


def has_work() -> bool:
    """A shape is looked for in a thread, or waits to be shown."""
    return any(session.work is not None for session in _sessions.values())


def has_answer(key: str) -> bool:
    """A thread has found a shape that is not shown yet."""
    session = _sessions.get(key)
    return session is not None and session.work is not None and session.work.done


def unsettled() -> list[str]:
    """Deformers whose last answer was a preview."""
    return [
        key
        for key, session in _sessions.items()
        if any(not shown.converged for shown in session.shown.values())
    ]


@contextmanager
def suspended() -> Iterator[None]:
    """The handlers rest while Sinew itself changes the scene; what they miss they see afterwards."""
    global _suspended
    _suspended += 1
    try:
        yield
    finally:
        _suspended -= 1
        if not _suspended:
            for name in _missed:
                obj = bpy.data.objects.get(name)
                if obj is not None:
                    obj.update_tag(refresh={"OBJECT"})


def note_missed(name: str) -> None:
    """An object was evaluated while the handlers rested."""
    _missed.add(name)


def take_missed(name: str) -> bool:
    """An evaluation of the object was missed since the last call."""
    missed = name in _missed
    _missed.discard(name)
    return missed


def is_suspended() -> bool:
    """Sinew itself is changing the scene."""
    return _suspended > 0
