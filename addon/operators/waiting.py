# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that bind. With a window, a thread binds, Blender stays responsive, and Esc cancels."""

import bpy
from bpy.types import Context, Event

from .. import compat
from ..core import status
from ..core.errors import SinewError
from ..core.status import Level
from ..properties import SinewDeformer
from ..session.actions import housekeeping
from ..session.evaluation import binding
from ..session.evaluation.binding import CANCELLED
from .modal.staying import StaysInWindow
from .target import target_of

_GOING_ON = {"RUNNING_MODAL", "PASS_THROUGH"}

# Deformers, each with the reason if its bind was refused.
Bound = list[tuple[SinewDeformer, SinewError | None]]


class WaitsForBind(StaysInWindow):
    """Mixin for an operator. Its ``invoke`` ends with ``return self.wait_for(...)``."""

    _uid = ""  # the key of the deformer that it waits for
    _reports = False  # whether the bind that a thread computes is to be reported
    _words = ("", "")

    def report_state(self, uid: str, subject: str = "", more: str = "") -> None:
        """Report the state of a deformer between ``subject`` and ``more``, as soon as no thread binds it."""
        self._reports, self._words = binding.job(uid) is not None, (subject, more)
        line = status.current(uid)
        if not self._reports and line.text:
            left_out = status.left_out(uid)
            level = "WARNING" if left_out or line.level is Level.ERROR else "INFO"
            text = (f"{subject}: " if subject else "") + line.text + more
            self.tell({level}, ". ".join((text, *left_out)))

    def wait_for(self, context: Context, uid: str, result: set[str]) -> set[str]:
        """Stay while a thread binds the deformer; else return ``result``."""
        if binding.job(uid) is None:
            return result
        self._uid = uid
        binding.watch(uid)
        return self.stay(context)

    def modal(self, context: Context, event: Event) -> set[str]:
        if event.type == "TIMER":
            redraw_panels()
        result = self.look(context, event.type == "ESC" and event.value == "PRESS")
        if result.isdisjoint(_GOING_ON):
            self.leave(context)
        return result

    def look(self, context: Context, is_cancelled: bool) -> set[str]:
        """Look at what the operator waits for. ``is_cancelled``: Esc was pressed."""
        housekeeping.collect()
        job = binding.job(self._uid)
        if job is not None and not is_cancelled:
            context.workspace.status_text_set(
                compat.told(f"Sinew is binding: {job.fraction:.0%} {job.stage}   (Esc cancels)")
            )
            return {"PASS_THROUGH"}
        if job is not None:
            binding.cancel(self._uid)
            self.tell({"WARNING"}, CANCELLED)
        elif self._reports:
            self.report_state(self._uid, *self._words)
        return {"FINISHED"}

    def cancel(self, context: Context) -> None:
        """Blender ends the operator, because its window is closed or another file is opened."""
        self.leave(context)

    def leave(self, context: Context) -> None:
        binding.watch(self._uid, False)
        super().leave(context)


class BindingOperator(WaitsForBind):
    """Mixin for an operator whose ``run`` changes the active deformer and binds it.

    Without ``wait``, ``run`` may let a thread bind.
    """

    def execute(self, context: Context) -> set[str]:
        return self.run(context, wait=True)

    def invoke(self, context: Context, _event: Event) -> set[str]:
        return self.watched(context, self.run(context, wait=False))

    def watched(self, context: Context, result: set[str]) -> set[str]:
        """Stay while a thread binds the active deformer; else return ``result``."""
        obj = target_of(context)
        deformer = None if obj is None else obj.sinew.active
        return result if deformer is None else self.wait_for(context, deformer.uid, result)

    def report_bind(self, refusal: SinewError | None, uid: str, subject: str, more: str = "") -> None:
        """Report the result. A refused bind is only a warning, since the change itself is kept."""
        if refusal is not None:
            self.tell({"WARNING"}, str(refusal))
        else:
            self.report_state(uid, subject, more)

    def report_shared(self, bound: Bound, subject: str, more: str = "") -> None:
        """Report the same for several objects: the state of the first, or the first refusal."""
        refusal = next((error for _deformer, error in bound if error is not None), None)
        moves = f", moves {len(bound)} objects" if len(bound) > 1 else ""
        self.report_bind(refusal, bound[0][0].uid, subject, moves + more)


def redraw_panels() -> None:
    """Redraw the panels, which show the progress and the result of a thread."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in ("VIEW_3D", "PROPERTIES"):
                area.tag_redraw()
