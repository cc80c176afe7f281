# SPDX-License-Identifier: GPL-3.0-or-later
"""The modal half of operators that bind: a thread works, Blender stays responsive, Esc cancels."""

from bpy.types import Context, Event

from .. import session


class WaitsForBind:
    """Mixed into an operator. ``wait_for`` ends its ``invoke``."""

    def wait_for(self, context: Context, uid: str, result: set[str]) -> set[str]:
        """Go on as a modal operator while a thread binds the deformer, else end with ``result``."""
        if session.job(uid) is None:
            return result
        self._uid = uid
        session.watch(uid)
        self.begin(context)
        return {"RUNNING_MODAL"}

    def begin(self, context: Context) -> None:
        """Be called for events, and every tenth of a second."""
        self._timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.modal_handler_add(self)

    def end(self, context: Context) -> None:
        """Be called no more."""
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
            return self._finish(context)
        context.workspace.status_text_set(f"Sinew is binding: {job.fraction:.0%} {job.stage}   (Esc cancels)")
        return {"PASS_THROUGH"}

    def _finish(self, context: Context) -> set[str]:
        session.watch(self._uid, False)
        self.end(context)
        return {"FINISHED"}
