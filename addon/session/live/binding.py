# SPDX-License-Identifier: GPL-3.0-or-later
"""When to factorise. Light meshes bind where they stand, heavy ones in a thread of their own."""

import logging
import time
from dataclasses import replace
from functools import partial

import bpy

from ...backend import Factor, Inheritance, Progress, availability, build_factor
from ...core import status
from ...core.errors import BackendMissingError, CancelledError, SinewError
from ...core.kinds import MESH
from ...core.status import Level, Remedy, Status
from ...ids import Keys
from ...mesh_io import read_rest
from ...properties import SinewDeformer
from ..blocks import targets
from ..control import kinds
from ..control.bind_input import BindInput
from ..memory import sessions
from ..memory.background import Work
from ..memory.sessions import Bound, Session
from . import mesh_notes

logger = logging.getLogger(__name__)

HEAVY = 20_000  # vertices; below, a bind takes some tens of milliseconds and needs no thread

CANCELLED = "Binding was cancelled - press Bind to start again"


_jobs: dict[str, Work] = {}  # by deformer key; the subject is a BindInput
_watched: set[str] = set()


def require_backend() -> None:
    """Without the native module nothing is bound, and the last solution stays."""
    found = availability()
    if found.module is None:
        raise BackendMissingError(found.remedy)


def ensure(
    session: Session,
    deformer: SinewDeformer,
    settings: SinewDeformer,
    wait: bool,
    progress: Progress | None = None,
    mode: str = "VIEWPORT",
) -> Bound | None:
    """The factor for these settings; None while a thread builds it, or where an earlier refusal still stands.

    Where few things changed, the factor so far becomes the new one; the last shape stays meanwhile. The
    caller holds the session's lock.

    ``deformer`` is the original settings, ``settings`` the evaluated ones (animated values); ``session`` is
    that of the mode.
    """
    rest = deformer.rest_in(mode)
    token = rest.get(Keys.REST_TOKEN, "")
    key = kinds.bind_key(settings, token)
    bound, job = session.bound, _jobs.get(deformer.uid)
    if bound is not None and bound.key == key and not bound.factor.is_spent:
        followed = not wait and job is not None and job.subject.key == key
        if followed or not bound.is_preview:
            return bound
    require_backend()
    if session.failed == key:
        return None
    request = None
    try:
        if session.rest is None or session.rest.token != token:
            session.rest = read_rest(rest)
        if job is not None and job.subject.key == key and not wait:
            return None
        kind, base_count = kinds.kind_in_use(settings), targets.vertex_count(deformer.id_data)
        request = kind.request(settings, rest, session.rest, key, base_count)
        if rest == deformer.rest:
            abandon(deformer.uid)
        session.drop_work()  # its answer would be one of the old factor
        inherited = None if session.bound is None else session.bound.factor.hand_over(request.recipe)
        if not wait and may_wait(len(request.rest.points)):
            _jobs[deformer.uid] = _begin(request, inherited)
            return None
        begin = time.perf_counter()
        factor = build_factor(request.recipe, progress, inherited)
    except SinewError as error:
        _refuse(session, deformer.uid, key, error, request)
        raise
    return _install(
        session, deformer.uid, request, factor, time.perf_counter() - begin, rest == deformer.rest
    )


def _begin(request: BindInput, inherited: Inheritance | None) -> Work:
    """A thread that builds a factor; where a quick one is worth showing, that one first."""
    preview = request.recipe.preview()
    if preview is not None and inherited is None:
        return Work(partial(build_factor, preview), replace(request, recipe=preview, after=request))
    return Work(partial(build_factor, request.recipe, inherited=inherited), request)


def _refuse(session: Session, uid: str, key: tuple, error: SinewError, request: BindInput | None) -> None:
    session.bound, session.failed = None, key
    if request is not None and error.element_kind == "handle":
        regions_at_fault = [request.indices[row] for row in error.elements]
        error.elements = tuple(int(vertex) for members in regions_at_fault for vertex in members)
        error.element_kind = "vertex"
    if request is not None and request.rest.kind is not MESH and not error.element_kind.startswith("cage"):
        error.elements, error.remedy = (), Remedy.NONE  # nothing of it can be selected, or repaired
    status.put_notes(uid, ())
    status.fail(uid, error)


def _install(
    session: Session, uid: str, request: BindInput, factor: Factor, seconds: float, say: bool = True
) -> Bound:
    """Take a factor in; ``say`` so in the panel, which speaks of the viewport."""
    session.bound = Bound(
        request.key,
        factor,
        request.rest,
        request.handles,
        request.indices,
        request.control,
        seconds * 1000.0,
        request.after is not None,
    )
    session.failed = None
    session.shown.clear()
    if say:
        status.put(uid, Status(Level.INFO, summary(session.bound)))
        status.put_notes(uid, _notes(factor, request))
    logger.info("bound %d vertices in %.1f ms", len(request.rest.points), session.bound.milliseconds)
    return session.bound


def summary(bound: Bound) -> str:
    """The status line of a deformer that is well."""
    time_spent = duration(bound.milliseconds)
    return f"{len(bound.rest.points):,} {bound.rest.kind.nouns[1]}, {bound.control}, bound in {time_spent}"


def duration(milliseconds: float) -> str:
    """As a person says it."""
    if milliseconds >= 1000.0:
        return f"{milliseconds / 1000.0:.1f} s"
    return f"{milliseconds:.0f} ms" if milliseconds >= 10.0 else f"{milliseconds:.1f} ms"


def _notes(factor: Factor, request: BindInput) -> tuple[Status, ...]:
    """What is unusual about the mesh. Elements count the vertices that enter: Select shows the base mesh."""
    warnings = kinds.kind_of_method(request.recipe.method).notes(factor.report, request)
    if request.rest.kind is not MESH:
        return warnings  # there is nothing to repair
    diagnosis = replace(factor.diagnosis, not_finite=request.rest.not_finite)
    return (*warnings, *mesh_notes.notes(diagnosis, request.on_base))


def may_wait(vertex_count: int) -> bool:
    """A bind may run in a thread: there is a window to keep alive, and the mesh is heavy."""
    return not bpy.app.background and vertex_count >= HEAVY


def job(uid: str) -> Work | None:
    """The bind under way for a deformer."""
    return _jobs.get(uid)


def watch(uid: str, watched: bool = True) -> None:
    """An operator waits for the bind of this deformer, or does so no more."""
    (_watched.add if watched else _watched.discard)(uid)


def unwatched() -> list[str]:
    """Binds under way that nobody waits for: they started by themselves."""
    return [uid for uid in _jobs if uid not in _watched]


def abandon(uid: str) -> None:
    """Stop a bind under way, if there is one; its result is dropped."""
    stopped = _jobs.pop(uid, None)
    if stopped is not None:
        stopped.cancel()


def cancel(uid: str) -> None:
    """Stop a bind at the user's wish and say so; Bind starts it again."""
    stopped = _jobs.get(uid)
    if stopped is None:
        return
    abandon(uid)
    _refuse(sessions.open_session(uid), uid, stopped.subject.key, CancelledError(CANCELLED), None)


def collect() -> list[str]:
    """Take finished jobs in; the keys of the deformers that may solve now. For timers, and for tests."""
    ready = []
    for uid, done in list(_jobs.items()):
        if not done.done:
            continue
        del _jobs[uid]
        ready.append(uid)
        if done.result is not None:
            _install(sessions.open_session(uid), uid, done.subject, done.result, done.seconds)
            if done.subject.after is not None:
                real = done.subject.after
                _jobs[uid] = Work(partial(build_factor, real.recipe), real)
        elif done.error is not None:
            _refuse(sessions.open_session(uid), uid, done.subject.key, done.error, done.subject)
    return ready


def busy() -> bool:
    """A thread is at work."""
    return bool(_jobs) or sessions.has_work()
