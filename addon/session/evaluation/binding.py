# SPDX-License-Identifier: GPL-3.0-or-later
"""Decides when to factorise. Small meshes are bound at once, large ones in a thread of their own."""

import logging
import re
import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import bpy
import numpy as np
from bpy.types import Object

from ...backend import Factor, PreparedBind, Progress, Recipe, availability, bind_seconds, build_factor
from ...core import status
from ...core.elements import NO_ELEMENTS, Elements, Owner
from ...core.errors import BackendMissingError, CancelledError, OutsideError, SinewError
from ...core.memory import remember
from ...core.methods import Method
from ...core.point_types import MESH
from ...core.status import Level, Remedy, Status
from ...properties import SinewDeformer
from ..controls import kinds
from ..controls.bind_input import BindInput
from ..datablocks import rest_frame
from ..datablocks.owners import owners
from ..state import sessions
from ..state.background import Work, Works
from ..state.sessions import Bound, Session
from ..targets import targets
from . import mesh_notes

logger = logging.getLogger(__name__)

HEAVY = (
    0.2  # seconds. What takes less is felt as a hitch, so it needs no thread; what takes more, as a freeze
)
_SOLVE = 1e-5  # seconds for each vertex of an iterative method, with the steps that large poses need

CANCELLED = "Binding was cancelled - press Rebind to start again"
_ROW = re.compile(r"\bhandle (\d+)\b")  # how the native module names a handle


_jobs = remember(Works())  # binds under way by deformer key; the subject of each is a ``BindInput``
_watched: set[str] = remember(set())


def require_backend() -> None:
    """Refuse if the native module is missing: nothing can be bound then."""
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
    """The factor for these settings; None while a thread builds it, or if the same bind was refused before.

    If few settings changed, parts of the last factor are used for the new one. The last shape stays
    meanwhile. The caller holds the lock of the session, and shows the error if the bind is refused.

    ``deformer`` has the original settings, ``settings`` the evaluated ones with animated values. ``session``
    is the one of the mode.
    """
    rest = deformer.rest_in(mode)
    token = rest_frame.token(deformer, rest)
    key = kinds.bind_key(settings, token)
    under_way = None
    if mode == "VIEWPORT":
        _keep_job_for(deformer.uid, key)
        under_way = None if wait else _jobs.get(deformer.uid)
    bound = session.bound
    is_wanted = bound is not None and bound.key == key and not bound.factor.is_released
    if is_wanted and (under_way is not None or not bound.is_preview):
        return bound
    require_backend()
    if session.failed == key or under_way is not None:
        return None
    request = None
    try:
        if session.rest is None or session.rest.token != token:
            session.rest = rest_frame.read(deformer, rest)
        kind, base_count = kinds.kind_in_use(settings), targets.vertex_count(deformer.id_data)
        request = kind.request(settings, rest, session.rest, key, base_count)
        if rest == deformer.rest:
            abandon(deformer.uid)
        session.drop_work()  # it solves with the old factor
        prepared = None if session.bound is None else session.bound.factor.prepare_rebind(request.recipe)
        if not wait and takes_long(request.recipe):
            _jobs[deformer.uid] = _begin(request, prepared)
            return None
        begin = time.perf_counter()
        factor = build_factor(request.recipe, progress, prepared)
    except SinewError as error:
        _note_refusal(session, deformer.uid, key)
        raise _with_selectable(error, request) from error
    return _install(
        session, deformer.uid, request, factor, time.perf_counter() - begin, rest == deformer.rest
    )


def _begin(request: BindInput, prepared: PreparedBind | None) -> Work:
    """Start a thread that builds a factor. If the recipe has a preview, the thread builds that one first."""
    preview = request.recipe.preview()
    if preview is not None and prepared is None:
        return Work(partial(build_factor, preview), replace(request, recipe=preview, after=request))
    return Work(partial(build_factor, request.recipe, prepared=prepared), request)


def _with_selectable(error: SinewError, request: BindInput | None) -> SinewError:
    """The error of a bind, naming handles as the artist does, and elements that can be selected."""
    if request is None:
        return error
    text = str(error)
    if request.names:
        text = _ROW.sub(lambda row: _name(request.recipe, request.names, int(row[1])), text)
    elements = kinds.kind_of_method(request.recipe.method).selectable(error.elements, request)
    if isinstance(error, OutsideError):
        text, elements = request.outside(tuple(elements.indices), "cage")
        text += " - enlarge it there, or set Outside"
    if request.rest.point_type is not MESH and elements.owner is Owner.TARGET:
        # Nothing of it can be selected, or repaired.
        remedy = Remedy.NONE if error.remedy is Remedy.REPAIR else error.remedy
        return error.with_elements(NO_ELEMENTS, remedy, text)
    return error.with_elements(elements, error.remedy, text)


def with_names(error: SinewError, deformer: SinewDeformer, bound: Bound) -> SinewError:
    """The error of a solve, with the names that handles have now."""
    names = {handle.uid: handle.name for handle in deformer.handles}
    by_row = [names.get(uid, "a region") for uid in bound.handles]
    recipe = bound.factor.recipe
    text = _ROW.sub(lambda row: _name(recipe, by_row, int(row[1])), str(error))
    elements = error.elements
    if elements.element == "handle":
        rows = [recipe.located(row)[0] for row in elements.indices]
        members = [bound.indices[row] for row in rows if row < len(bound.indices)]
        vertices = np.concatenate(members) if members else np.empty(0, dtype=int)
        elements = Elements(Owner.TARGET, "vertex", vertices) if len(vertices) else NO_ELEMENTS
    return error.with_elements(elements, error.remedy, text)


def _name(recipe: Recipe, names: Sequence[str], row: int) -> str:
    """What an artist calls a handle of the native module, or an object among several that control."""
    handle, point = recipe.located(row)
    if handle >= len(names):
        return f"handle {row}"
    return names[handle] if point is None else f"point {point} of {names[handle]}"


def _keep_job_for(uid: str, key: tuple) -> None:
    """Stop the bind under way if another one is wanted; take in its result if it has ended."""
    job = _jobs.get(uid)
    if job is None:
        return
    if job.subject.key != key:
        abandon(uid)
    elif job.done:
        _take_in(uid)


def _note_refusal(session: Session, uid: str, key: tuple) -> None:
    """Note that this bind was refused, so that it is not tried again."""
    session.bound, session.failed = None, key
    status.put_notes(uid, ())


def _install(
    session: Session, uid: str, request: BindInput, factor: Factor, seconds: float, say: bool = True
) -> Bound:
    """Use a new factor. ``say`` whether the panel tells so: it is about viewports, not about renders."""
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
    session.failed = session.unanswered = None
    session.shown.clear()
    if say:
        status.put(uid, Status(Level.INFO, summary(session.bound)))
        status.put_notes(uid, _notes(factor, request))
    logger.info("bound %d vertices in %.1f ms", len(request.rest.points), session.bound.milliseconds)
    return session.bound


def summary(bound: Bound) -> str:
    """The line in the panel about a deformer that is bound."""
    time_spent = duration(bound.milliseconds)
    return (
        f"{len(bound.rest.points):,} {bound.rest.point_type.nouns[1]}, {bound.control}, bound in {time_spent}"
    )


def duration(milliseconds: float) -> str:
    """A time as people say it."""
    if milliseconds < 0.1:
        return "less than 0.1 ms"
    if milliseconds >= 1000.0:
        return f"{milliseconds / 1000.0:.1f} s"
    return f"{milliseconds:.0f} ms" if milliseconds >= 10.0 else f"{milliseconds:.1f} ms"


def _notes(factor: Factor, request: BindInput) -> tuple[Status, ...]:
    """What is unusual about the mesh, one line each."""
    of_control = kinds.kind_of_method(request.recipe.method).notes(factor.report, request)
    rings = mesh_notes.of_folded_rings(factor.folded_rings, request.on_base)
    warnings = (*of_control, *request.unpainted, *rings)
    if request.rest.point_type is not MESH:
        return warnings  # there is nothing to repair
    diagnosis = replace(factor.diagnosis, not_finite=request.rest.not_finite)
    return (*warnings, *mesh_notes.notes(diagnosis, request.on_base))


def takes_long(recipe: Recipe) -> bool:
    """Whether a thread should compute this bind.

    Loose parts are only counted where the bind is quick without them, as that takes a look at all faces.
    """
    return may_wait(recipe.seconds) or may_wait(bind_seconds(recipe))


def expected_seconds(obj: Object, method: Method) -> float:
    """About how long a bind of the object by another method would take, as far as its last bind tells."""
    deformer = obj.sinew.active
    session = None if deformer is None else sessions.find(deformer.uid)
    if session is None or session.bound is None:
        return method.expected_seconds(targets.size(obj))
    size = session.bound.factor.recipe.control.size or sum(map(len, session.bound.indices))
    held = {"size": size} if size else {}
    return method.expected_seconds(len(session.bound.rest.points), getattr(deformer, method.id), **held)


def may_wait(seconds: float) -> bool:
    """Whether work that takes about so long may run in a thread: there is a window, and it would freeze."""
    return not bpy.app.background and seconds >= HEAVY


def solve_seconds(vertex_count: int) -> float:
    """About how long it takes to solve for so many vertices."""
    return _SOLVE * vertex_count


def job(uid: str) -> Work | None:
    """The bind under way for a deformer."""
    return _jobs.get(uid)


def watch(uid: str, watched: bool = True) -> None:
    """Note that an operator waits for the bind of this deformer, or no longer does."""
    (_watched.add if watched else _watched.discard)(uid)


def unwatched() -> list[str]:
    """The keys of deformers with a bind under way that no operator waits for: an evaluation started it."""
    return [uid for uid in _jobs if uid not in _watched]


def abandon(uid: str) -> None:
    """Stop the bind under way, if there is one, and drop its result."""
    _jobs.drop(uid)


def cancel(uid: str) -> None:
    """Stop a bind because the user wants it, and say so in the panel. Bind starts it again."""
    stopped = _jobs.drop(uid)
    if stopped is None:
        return
    _note_refusal(sessions.open_session(uid), uid, stopped.subject.key)
    status.fail(uid, CancelledError(CANCELLED))


def collect() -> list[str]:
    """Take in the binds that have ended; the keys of the deformers that may solve now. For timers and tests.

    If a deformer was removed meanwhile, by undo for instance, the result is dropped.
    """
    finished = [uid for uid, job in _jobs.items() if job.done]
    known = {deformer.uid for obj in owners() for deformer in obj.sinew.deformers} if finished else set()
    for uid in finished:
        if uid in known:
            _take_in(uid)
        else:
            abandon(uid)
    return [uid for uid in finished if uid in known]


def _take_in(uid: str) -> None:
    """Take in a bind that has ended, with a factor or an error. After a preview the exact bind starts."""
    job, session = _jobs.pop(uid), sessions.open_session(uid)
    if job.error is not None:
        _note_refusal(session, uid, job.subject.key)
        status.fail(uid, _with_selectable(job.error, job.subject))
        return
    _install(session, uid, job.subject, job.result, job.seconds)
    exact = job.subject.after
    if exact is not None:
        _jobs[uid] = Work(partial(build_factor, exact.recipe), exact)


def busy() -> bool:
    """Whether a thread binds or solves."""
    return bool(_jobs) or sessions.has_work()
