# SPDX-License-Identifier: GPL-3.0-or-later
"""The timer and the modal handler of an operator that stays in a window, in one place for all of them."""

from bpy.types import Context, Timer

from ..reporting import Reports


class StaysInWindow(Reports):
    """Mixin for an operator. While it stays, Blender calls its ``modal`` for events and at each tick.

    Blender frees an operator with the first of its modal handlers that ends, and a second one would then
    call what is freed. So there is one for the whole stay, however many works the operator waits for.
    """

    TICK = 0.1  # seconds between two calls without an event

    _timer: Timer | None = None

    def stay(self, context: Context) -> set[str]:
        """Stay in the window of the context from now on, or go on staying there."""
        if self._timer is None:
            manager = context.window_manager
            self._timer = manager.event_timer_add(self.TICK, window=context.window)
            manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def leave(self, context: Context) -> None:
        """End the ticks. ``modal`` or ``cancel`` ends as well, and with it the handler."""
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            self._timer = None
        if context.workspace is not None:
            context.workspace.status_text_set(None)
