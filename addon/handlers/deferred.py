# SPDX-License-Identifier: GPL-3.0-or-later
"""What has to wait for a quiet moment on the main thread.

Timers never fire without a window: tests call ``catch_up``.
"""

import time

import bpy

from .. import session

PAUSE = 0.15  # seconds without an edit, after which a preview becomes final
_POLL = 0.1

_last_edit = 0.0


def schedule() -> None:
    """Look again soon."""
    global _last_edit
    _last_edit = time.monotonic()
    if not bpy.app.background and not bpy.app.timers.is_registered(_tick) and _is_pending():
        bpy.app.timers.register(_tick, first_interval=PAUSE)


def stop() -> None:
    """No more timers."""
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)


def catch_up() -> bool:
    """Do all of it now: finished binds, copies, final answers. True while something is still under way."""
    session.collect()
    session.tidy()
    session.settle()
    return session.busy()


def _is_pending() -> bool:
    return session.busy() or bool(session.unsettled()) or session.has_copies() or bool(session.rewired())


def _tick() -> float | None:
    if time.monotonic() - _last_edit < PAUSE and not session.busy():
        return _POLL
    busy = catch_up()
    if busy:
        _redraw()
        return _POLL
    return None


def _redraw() -> None:
    """Show the progress of a bind."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()
