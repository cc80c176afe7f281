# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that bind. With a window, a thread binds, Blender stays responsive, and Esc cancels."""

from bpy.types import Context, Event

from .. import session
from ..core import status
from ..core.errors import SinewError
from ..core.status import Level
from ..properties import SinewDeformer
from .target import target_of

# Deformers, each with the reason if its bind was refused.
Bound = list[tuple[SinewDeformer, SinewError | None]]


class WaitsForBind:
    """Mixin for an operator. Its ``invoke`` ends with ``return self.wait_for(...)``."""

    _reports = False  # whether the bind that a thread computes is to be reported
    _words = ("", "")

    def report_state(self, uid: str, subject: str = "", more: str = "") -> None:
        """Report the state of a deformer between ``subject`` and ``more``, as soon as no thread binds it."""
        self._reports, self._words = session.job(uid) is not None, (subject, more)
        line = status.current(uid)
        if not self._reports and line.text:
            level = "WARNING" if line.level is Level.ERROR else "INFO"
            self.report({level}, (f"{subject}: " if subject else "") + line.text + more)

    def wait_for(self, context: Context, uid: str, result: set[str]) -> set[str]:
        """Continue as a modal operator while a thread binds the deformer; else return ``result``."""
        if session.job(uid) is None:
            return result
        self._uid = uid
        session.watch(uid)
        self.begin(context)
        return {"RUNNING_MODAL"}

    def begin(self, context: Context) -> None:
        """Let Blender call ``modal`` for events, and every tenth of a second."""
        self._timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.modal_handler_add(self)

    def end(self, context: Context) -> None:
        """Stop the calls of ``modal``."""
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)

    def modal(self, context: Context, event: Event) -> set[str]:
        session.collect()
        job = session.job(self._uid)
        if job is None:
            return self._finish(context)
        if event.type == "ESC" and event.value == "PRESS":
            session.cancel(self._uid)
            self.report({"WARNING"}, session.CANCELLED)
            self._reports = False
            return self._finish(context)
        context.workspace.status_text_set(f"Sinew is binding: {job.fraction:.0%} {job.stage}   (Esc cancels)")
        return {"PASS_THROUGH"}

    def _finish(self, context: Context) -> set[str]:
        session.watch(self._uid, False)
        self.end(context)
        if self._reports:
            self.report_state(self._uid, *self._words)
        return {"FINISHED"}


class BindingOperator(WaitsForBind):
    """Mixin for an operator whose ``run`` changes the active deformer and binds it.

    Without ``wait``, ``run`` may let a thread bind.
    """

    def execute(self, context: Context) -> set[str]:
        return self.run(context, wait=True)

    def invoke(self, context: Context, _event: Event) -> set[str]:
        return self.watched(context, self.run(context, wait=False))

    def watched(self, context: Context, result: set[str]) -> set[str]:
        """Continue while a thread binds the active deformer; else return ``result``."""
        obj = target_of(context)
        deformer = None if obj is None else obj.sinew.active
        return result if deformer is None else self.wait_for(context, deformer.uid, result)

    def report_bind(self, refusal: SinewError | None, uid: str, subject: str, more: str = "") -> None:
        """Report the result. A refused bind is only a warning, since the change itself is kept."""
        if refusal is not None:
            self.report({"WARNING"}, str(refusal))
        else:
            self.report_state(uid, subject, more)

    def report_shared(self, bound: Bound, subject: str, more: str = "") -> None:
        """Report the same for several objects: the state of the first, or the first refusal."""
        refusal = next((error for _deformer, error in bound if error is not None), None)
        moves = f", moves {len(bound)} objects" if len(bound) > 1 else ""
        self.report_bind(refusal, bound[0][0].uid, subject, moves + more)
