# SPDX-License-Identifier: GPL-3.0-or-later
"""Solve when the signature of the inputs changed, and write the shape mesh.

A drag in a window shows previews: a few steps, started from the shape before. When it pauses, the answer
that depends on the poses alone replaces them; for a heavy mesh it comes from a thread.
"""

import time

import numpy as np

from ..core import status
from ..core.errors import SolverError, TopologyChangedError
from ..core.status import Level, Status
from ..mesh_io import write_shape
from . import binding, poses, regions
from .incoming import TOPOLOGY_CHANGED
from .state import Bound, Session
from .turn import Turn
from .work import Work

PREVIEW_ITERATIONS = 4  # what a drag may spend a step


def solve(turn: Turn, bound: Bound, incoming: np.ndarray | None, displacement: bool) -> None:
    """Bring the shape mesh up to date. ``incoming`` float32 (n, 3), None for rest."""
    shown, session, settings = turn.shown, turn.session, turn.settings
    affine, from_rest = poses.gather(turn, bound)
    options = regions.solve_options(settings)
    signature = (bound.key, affine.tobytes(), from_rest.tobytes(), tuple(options.items()), displacement)
    same = shown.signature == signature and _same(shown.incoming, incoming)
    final = session.settle and same and turn.in_viewport
    early = turn.preview and settings.definition.iterative and not final
    if same and (shown.converged or early):
        if shown.factor == settings.factor:
            return
        positions = shown.positions
    else:
        options["from_rest"] = from_rest
        options["incoming"] = None if incoming is None else incoming.astype(np.float64)
        if final and binding.may_wait(len(bound.rest.points)):
            solved = _from_thread(session, bound, affine, options)
            if solved is None:
                return
        else:
            if turn.in_viewport:
                _drop_final(session)
            if early:
                _spare(options, turn)
            begin = time.perf_counter()
            solved, _report = bound.factor.solve(affine, **options)
            session.solve_milliseconds = (time.perf_counter() - begin) * 1000.0
        if not np.isfinite(solved).all():
            raise SolverError("The solution is not finite - check the scale of the controls")
        positions = (solved - bound.rest.points if displacement else solved).astype(np.float32)
        shown.converged = not early
    if turn.proxy is None or not write_shape(turn.proxy.data, positions, settings.factor, displacement):
        raise TopologyChangedError(TOPOLOGY_CHANGED)
    shown.signature, shown.incoming, shown.positions = signature, incoming, positions
    shown.displacement, shown.factor = displacement, settings.factor
    if turn.in_viewport and status.of(turn.deformer.uid).level is not Level.INFO:
        status.put(turn.deformer.uid, Status(Level.INFO, binding.summary(bound)))


def _same(a: np.ndarray | None, b: np.ndarray | None) -> bool:
    return a is b or (a is not None and b is not None and np.array_equal(a, b))


def _spare(options: dict[str, object], turn: Turn) -> None:
    """A few steps from the shape of the moment before."""
    options["max_iterations"] = min(PREVIEW_ITERATIONS, options.get("max_iterations", PREVIEW_ITERATIONS))
    if turn.shown.positions is not None and not turn.shown.displacement:
        options["start"] = turn.shown.positions.astype(np.float64)


def _from_thread(
    session: Session, bound: Bound, affine: np.ndarray, options: dict[str, object]
) -> np.ndarray | None:
    """The final answer for what is shown as a preview; None until the thread has it.

    Any other input in between is a signature of its own, which drops the thread's answer.
    """
    work = session.final
    if work is None:
        session.final = Work(lambda progress: bound.factor.solve(affine, progress=progress, **options))
        return None
    if not work.done:
        return None
    session.settle, session.final = False, None
    if work.error is not None:
        raise work.error
    session.solve_milliseconds = work.seconds * 1000.0
    return work.result[0]


def _drop_final(session: Session) -> None:
    """Something newer is asked for."""
    session.settle = False
    if session.final is not None:
        session.final.cancel()
        session.final = None
