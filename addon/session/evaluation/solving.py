# SPDX-License-Identifier: GPL-3.0-or-later
"""Solves when the inputs changed, and writes the shape mesh.

A drag in a window shows previews, which take as many steps as the drag budget allows and start from the last
shape. If a single step takes longer than the budget, a thread solves, and the shape follows the controls a
little later. It starts from the controls alone, which takes longer and is near the final shape at once. When
the drag pauses, the exact shape, which depends on the poses alone, replaces the preview.
Where nothing is known of the shape, after undo for instance, the exact shape is the first to be shown.
"""

import math
import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...backend import Progress
from ...core import status
from ...core.errors import CancelledError, OptionError, SolverError, TopologyChangedError
from ...core.status import Level, Status
from ...mesh_io import shape_array, write_shape
from ..controls import kinds
from ..controls.bind_input import grid_moves, option_values, solve_options
from ..state import render_writes
from ..state.background import Work
from ..state.evaluation import Evaluation
from ..state.sessions import Asked, Bound, Session, Shown
from . import binding, drag, renders
from .incoming import TOPOLOGY_CHANGED

_START = 4  # about as many iterations take as long as a start from the controls alone


@dataclass(frozen=True)
class Question:
    """What a shape depends on. ``early`` asks for a preview, ``final`` for the exact shape after one.

    A ``draft`` is a preview of a frame, which depends on the frame alone.
    """

    signature: tuple
    incoming: np.ndarray | None  # float32 (n, 3), None for rest
    displacement: bool
    control: np.ndarray  # as ``Factor.solve`` takes it
    further: dict[str, Any]  # what belongs to the control, and is among the options
    options: dict[str, Any]
    early: bool
    final: bool
    draft: bool  # of a frame, if it is early

    def matches(self, other: "Question | Shown") -> bool:
        """Whether the other question asks for the same shape, or the same shape is shown."""
        return self.signature == other.signature and _same(self.incoming, other.incoming)


def solve(evaluation: Evaluation, bound: Bound, incoming: np.ndarray | None, displacement: bool) -> None:
    """Update the shape mesh. ``incoming`` is float32 (n, 3), or None if the rest shape enters."""
    shown = evaluation.shown
    question = _question(evaluation, bound, incoming, displacement)
    if question is None:
        renders.show_viewport_shape(evaluation)
        return
    if shown.shape is not None and question.matches(shown) and (shown.converged or question.early):
        if shown.factor != _factor(evaluation):
            _show(evaluation, bound, question, shown.shape, shown.converged)
        return
    if evaluation.in_viewport and _may_be_late(evaluation, bound, question):
        answer = _from_thread(evaluation.session, bound, question)
        if answer is None:
            return
        question, shape = answer
    else:
        if evaluation.in_viewport:
            evaluation.session.drop_work()
        shape = _solve_here(evaluation, bound, question)
    _show(evaluation, bound, question, shape, converged=not question.early)


def _factor(evaluation: Evaluation) -> float:
    """How much of the deformation is shown, 0 to 1. A file may hold any number."""
    factor = evaluation.settings.factor
    if not math.isfinite(factor):
        raise OptionError("Factor is not a number - set it between 0 and 1")
    return min(max(factor, 0.0), 1.0)


def _question(
    evaluation: Evaluation, bound: Bound, incoming: np.ndarray | None, displacement: bool
) -> Question | None:
    """None if the control is lost and its last place is unknown."""
    found = kinds.kind_of_method(bound.factor.recipe.method).pose(evaluation, bound, incoming)
    if found is None:
        return None
    control, further = found
    if evaluation.in_viewport:
        evaluation.session.asked = Asked(bound, control, further, incoming)
    further = {**further, **grid_moves(evaluation.settings)}
    options = solve_options(evaluation.settings)
    posed = (control.tobytes(), *(value.tobytes() for value in further.values()))
    signature = (bound.key, posed, option_values(evaluation.settings, rebinds=False), displacement)
    options.update(further)
    options["incoming"] = incoming
    shown = evaluation.shown
    work = evaluation.session.work
    last = shown if work is None else work.subject
    same = last.signature == signature and _same(last.incoming, incoming)
    wanted = evaluation.session.settle and same
    iterative = evaluation.settings.is_iterative
    in_drag, in_draft = evaluation.preview and iterative, evaluation.draft and iterative
    if in_drag and shown.shape is None:
        wanted = work is None or (same and work.subject.final)
    final = wanted and evaluation.in_viewport
    early = (in_drag or in_draft) and not final
    if early and in_draft:
        options["max_iterations"] = min(evaluation.settings.draft_iterations, options["max_iterations"])
    elif early:
        options["max_iterations"] = min(evaluation.session.steps, options["max_iterations"])
        if shown.positions is not None and not shown.displacement:
            options["start"] = shown.positions
    return Question(signature, incoming, displacement, control, further, options, early, final, in_draft)


def _same(a: np.ndarray | None, b: np.ndarray | None) -> bool:
    return a is b or (a is not None and b is not None and np.array_equal(a, b))


def _show(
    evaluation: Evaluation, bound: Bound, question: Question, shape: np.ndarray, converged: bool
) -> None:
    shown, factor = evaluation.shown, _factor(evaluation)
    mesh = None if evaluation.proxy is None else evaluation.proxy.data
    fits = mesh is not None and render_writes.write(
        evaluation.depsgraph.scene,
        lambda: write_shape(mesh, shape, factor, question.displacement),
        evaluation.session.lock,
    )
    if not fits:
        raise TopologyChangedError(TOPOLOGY_CHANGED)
    shown.signature, shown.incoming = question.signature, question.incoming
    shown.control, shown.further = question.control, question.further
    shown.hold(shape)
    shown.displacement, shown.factor, shown.converged = question.displacement, factor, converged
    shown.draft = question.draft and not converged
    if evaluation.in_viewport and status.current(evaluation.deformer.uid).level is not Level.INFO:
        missing = kinds.missing_control(evaluation.deformer)
        line = Status(Level.WARNING, missing) if missing else Status(Level.INFO, binding.summary(bound))
        status.put(evaluation.deformer.uid, line)


def _solve_here(evaluation: Evaluation, bound: Bound, question: Question) -> np.ndarray:
    begin = time.perf_counter()
    shape = _answer(bound, question)
    _learn_price(evaluation.session, question, time.perf_counter() - begin)
    return shape


def _answer(bound: Bound, question: Question, progress: Progress | None = None) -> np.ndarray:
    """A ``shape_array`` with the solution. It uses no Blender data, so any thread may call it."""
    shape = shape_array(len(bound.rest.points))
    out = shape[:-1]
    if not question.displacement:
        bound.factor.solve(question.control, out=out, progress=progress, **question.options)
        return shape
    solved, _report = bound.factor.solve(question.control, progress=progress, **question.options)
    with np.errstate(over="ignore"):
        np.subtract(solved, bound.rest.points, out=out, casting="same_kind")
    if not np.isfinite(out).all():
        raise SolverError("The solution is not finite - check the scale of the controls")
    return shape


def _learn_price(session: Session, question: Question, seconds: float) -> None:
    """Note how long a step of a drag takes, and how many of them the drag budget allows."""
    session.solve_milliseconds = seconds * 1000.0
    if question.draft:
        return
    if not question.early:
        session.step_milliseconds = session.solve_milliseconds
        return
    steps = question.options["max_iterations"] + (0 if "start" in question.options else _START)
    session.step_milliseconds = session.solve_milliseconds / steps
    session.steps = drag.affordable_steps(session.step_milliseconds)


def _may_be_late(evaluation: Evaluation, bound: Bound, question: Question) -> bool:
    """Whether a thread may solve: for a final shape, and for a preview that takes longer than the budget."""
    if not binding.may_wait(binding.solve_seconds(len(bound.rest.points))):
        return False
    session = evaluation.session
    iterative = evaluation.settings.is_iterative
    dear = session.step_milliseconds > drag.budget() and (question.early or not iterative)
    return question.final or (evaluation.preview and dear)


def _from_thread(session: Session, bound: Bound, question: Question) -> tuple[Question, np.ndarray] | None:
    """The shape that a thread has computed, perhaps for an earlier question; None while there is none."""
    work = session.work
    if work is not None and question.final and not work.subject.final:  # the drag has ended
        work.cancel()
        work = None
    elif work is not None and not work.done:
        if question.matches(work.subject) or not work.subject.final:
            return None
        work.cancel()
        work = None
    if work is None:
        failed = session.unanswered
        if failed is not None and failed.error is not None and question.matches(failed.subject):
            raise failed.error
        _ask(session, bound, question)
        return None
    session.work = None
    if work.error is not None:
        session.settle = False
        if not isinstance(work.error, CancelledError):
            session.unanswered = work
        raise work.error
    answered = work.subject
    _learn_price(session, answered, work.seconds)
    if answered.final:
        session.settle = False
    if not question.matches(answered):
        _ask(session, bound, question)
        if answered.final:
            return None
    return answered, work.result


def _ask(session: Session, bound: Bound, question: Question) -> None:
    if question.early:
        alone = {name: value for name, value in question.options.items() if name != "start"}
        question = replace(question, options=alone)
    session.work = Work(lambda progress: _answer(bound, question, progress), question)
