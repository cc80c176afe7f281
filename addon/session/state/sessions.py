# SPDX-License-Identifier: GPL-3.0-or-later
"""What the process remembers of each deformer, by the key of the deformer.

All of it is derived from the settings in the file, so any of it may be dropped at any time.
"""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import bpy
import numpy as np
from mathutils import Matrix

from ...backend import Factor
from ...core import status
from ...core.memory import remember
from ...mesh_io import RestShape
from .background import Work

FIRST_STEPS = 4  # iterations in the first redraw of a drag, before it is known how long one takes


@dataclass
class Bound:
    """A factor, and what it was built from."""

    key: tuple
    factor: Factor
    rest: RestShape
    handles: tuple[str, ...]
    indices: tuple[np.ndarray, ...]
    control: str  # what moves the mesh, as the panel says it
    milliseconds: float
    is_preview: bool = False  # approximate, until a thread has computed the exact one
    # By the key of a handle, the vertices whose motion carries it where it stands on the surface.
    pieces: dict[str, np.ndarray] = field(default_factory=dict)


@dataclass
class Shown:
    """What one shape mesh holds, the one for viewports or the one for renders."""

    signature: tuple = ()
    incoming: np.ndarray | None = None  # float32 (n, 3); None means the rest shape
    shape: np.ndarray | None = None  # float32 (n + 1, 3), a ``shape_array``
    positions: np.ndarray | None = None  # float32 (n, 3), a view of it: positions, or displacements
    control: np.ndarray | None = None  # where the control is, as ``Factor.solve`` takes it
    further: dict[str, Any] = field(default_factory=dict)  # and what belongs to it
    displacement: bool = False
    factor: float = 0.0
    converged: bool = True
    draft: bool = False  # of a frame in playback

    def hold(self, shape: np.ndarray | None) -> None:
        """Note that this shape is shown; None for no shape."""
        self.shape, self.positions = shape, None if shape is None else shape[:-1]


class Asked(NamedTuple):
    """Inputs of the last solve: the control, the keywords with it, and the incoming shape."""

    bound: Bound
    control: np.ndarray
    further: dict[str, Any]
    incoming: np.ndarray | None


@dataclass
class Session:
    """What the process remembers of one deformer."""

    bound: Bound | None = None
    rest: RestShape | None = None
    structure: str | None = (
        None  # of an object that is no mesh, when it was last looked at: see ``RestShape``
    )
    failed: tuple | None = None  # the key of the bind that was refused: it is not tried again
    shown: dict[str, Shown] = field(default_factory=dict)
    poses: dict[str, np.ndarray] = field(default_factory=dict)
    # How the surface has moved from rest under the handles that stand on it, by their keys, in viewports.
    surfaces: dict[str, np.ndarray] = field(default_factory=dict)
    carried: dict[str, np.ndarray] = field(
        default_factory=dict
    )  # the parent inverse that each control was given
    foreign: set[tuple] = field(default_factory=set)  # those that Apply has written, with what it wrote
    told: str = ""  # which control has been taken off the surface
    asked: Asked | None = None  # by the last evaluation for viewports
    render_settings: tuple | None = None  # those that decide what enters in renders, when last looked at
    settle: bool = False  # a preview is shown, and the next evaluation is to solve exactly
    work: Work | None = None  # a solve in a thread; its subject is a ``Question``
    unanswered: Work | None = None  # the last solve in a thread that failed: it is not repeated
    # A control was replaced by another, but the driver that keeps controls evaluated still names the old one.
    rewire: bool = False
    solve_milliseconds: float = 0.0
    step_milliseconds: float = 0.0  # one iteration, or one solve of a method without iterations
    steps: int = FIRST_STEPS  # how many iterations one redraw of a drag may take
    lock: threading.RLock = field(default_factory=threading.RLock)

    def drop_work(self) -> None:
        """Cancel the solve in a thread: another shape is wanted."""
        self.settle = False
        if self.work is not None:
            self.work.cancel()
            self.work = None

    def view(self, mode: str) -> Shown:
        """What the shape mesh of this mode, VIEWPORT or RENDER, holds."""
        shown = self.shown.get(mode)
        return self.shown.setdefault(mode, Shown()) if shown is None else shown


@dataclass(frozen=True)
class LastUpdate:
    """Where an object and its controls were when its deformers were last updated.

    ``world`` is the matrix of the object, a copy.
    ``layout`` has an entry per modifier: the index and key of the deformer that it shows, or None.
    """

    placed: tuple
    layout: tuple[tuple[int, str] | None, ...]
    world: Matrix


_sessions: dict[str, Session] = remember({})
_RENDER = " in renders"
_last_updates: dict[str, LastUpdate] = remember({})  # by object
_edited: set[str] = remember(set())
_urgent: set[str] = remember(set())
_missed: set[str] = remember(set())
_suspended = 0
_evaluates = False  # whether the scene is to be evaluated while the handlers still do nothing


def open_session(key: str) -> Session:
    """The session of a deformer, a new one if there is none yet."""
    session = _sessions.get(key)
    return _sessions.setdefault(key, Session()) if session is None else session


def open_render_session(key: str) -> Session:
    """The session for renders of a deformer into which other vertices enter there than in viewports."""
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


def forget_shape(key: str, mode: str) -> None:
    """Call when the shape mesh of a deformer for a mode has lost what it held: the next evaluation writes it.

    In renders, two sessions may have written it.
    """
    for session in (_sessions.get(key), _sessions.get(key + _RENDER)):
        if session is not None:
            session.shown.pop(mode, None)


def forget_shapes() -> None:
    """Call after undo and redo, which may have changed the shape meshes.

    The next evaluation writes them again. Factors are kept: their keys are compared with the settings.
    """
    _last_updates.clear()
    for session in _sessions.values():
        session.shown.clear()
        session.carried.clear()
        session.failed = session.unanswered = None


def note_edit(name: str) -> None:
    """Note that the mesh of an object, or a modifier before Sinew's, was edited."""
    _edited.add(name)


def note_count(name: str) -> None:
    """Note that other vertices enter an object in this evaluation than at bind, and that this cannot wait."""
    _edited.add(name)
    _urgent.add(name)


def has_counts() -> bool:
    """Whether ``note_count`` was called since the edits were taken."""
    return bool(_urgent)


def forget_edit(name: str) -> None:
    """Note that the mesh of an object was compared with its rest mesh just now."""
    _edited.discard(name)


def take_edited() -> list[str]:
    """The names of the objects that were edited since the last call."""
    names = sorted(_edited)
    _edited.clear()
    _urgent.clear()
    return names


def has_edited() -> bool:
    """Whether an object was edited and not looked at since."""
    return bool(_edited)


def last_update(name: str) -> LastUpdate | None:
    """What ``note_update`` noted of an object."""
    return _last_updates.get(name)


def note_update(name: str, update: LastUpdate) -> None:
    """Note that the deformers of an object are up to date."""
    _last_updates[name] = update


def rewired() -> list[str]:
    """The keys of the deformers of which a control was replaced by another."""
    return [key for key, session in _sessions.items() if session.rewire]


def has_work() -> bool:
    """Whether a thread solves, or its shape waits to be shown."""
    return any(session.work is not None for session in _sessions.values())


def has_answer(key: str) -> bool:
    """Whether a thread has solved for this deformer, and the shape is not shown yet."""
    session = _sessions.get(key)
    return session is not None and session.work is not None and session.work.done


def is_refining(key: str) -> bool:
    """Whether the shape shown is not final: the final one is being computed, or will be after a pause."""
    session = _sessions.get(key)
    return session is not None and (session.work is not None or key in unsettled())


def is_draft(key: str) -> bool:
    """Whether the viewports show a draft of a frame."""
    session = _sessions.get(key)
    return session is not None and session.view("VIEWPORT").draft


def unsettled() -> list[str]:
    """The keys of the deformers that show a preview."""
    return [
        key
        for key, session in _sessions.items()
        if any(not shown.converged for shown in session.shown.values())
    ]


@contextmanager
def suspended() -> Iterator[None]:
    """While Sinew itself changes the scene, its handlers do nothing.

    Objects that were evaluated meanwhile are evaluated again afterwards.
    """
    global _suspended, _evaluates
    _suspended += 1
    try:
        yield
    finally:
        if _suspended == 1 and _evaluates:
            _evaluates = False
            bpy.context.view_layer.update()
        _suspended -= 1
        if not _suspended:
            for name in list(_missed):
                obj = bpy.data.objects.get(name)
                if obj is not None and obj.sinew.deformers:
                    obj.update_tag(refresh={"OBJECT"})
                else:  # nothing would take it
                    _missed.discard(name)


def evaluate_at_end() -> None:
    """Evaluate the scene when the handlers are about to act again, unless that has been done by then."""
    global _evaluates
    _evaluates = True


def note_missed(name: str) -> None:
    """Note that an object was evaluated while the handlers did nothing."""
    _missed.add(name)


def take_missed(name: str) -> bool:
    """Whether the handlers missed an evaluation of the object since the last call."""
    missed = name in _missed
    _missed.discard(name)
    return missed


def is_suspended() -> bool:
    """Whether Sinew itself is changing the scene."""
    return _suspended > 0
