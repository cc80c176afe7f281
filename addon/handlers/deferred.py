# SPDX-License-Identifier: GPL-3.0-or-later
"""What has to wait for a quiet moment on the main thread.

Timers never fire without a window: tests call ``catch_up``.
"""

import time

import bpy

from .. import session

PAUSE = 0.15  # seconds without an edit, after which a preview becomes final
_POLL = 0.1
_STAND_BY = 0.2  # no render is running
_FRAME = 0.02  # while a drag waits for the shape of a thread

_last_edit = 0.0


def schedule() -> None:
    """Look again soon, as something was edited."""
    global _last_edit
    _last_edit = time.monotonic()
    if not bpy.app.timers.is_registered(_tick) and _is_pending():
        _start()
    if _has_unlocked_renders() and not bpy.app.timers.is_registered(_serve):
        bpy.app.timers.register(_serve)


def follow_threads() -> None:
    """Look again soon where a thread is at work."""
    if session.busy() and not bpy.app.timers.is_registered(_tick):
        _start()


def _start() -> None:
    if not bpy.app.background:
        bpy.app.timers.register(_tick, first_interval=PAUSE)


def stop() -> None:
    """No more timers."""
    for timer in (_tick, _serve):
        if bpy.app.timers.is_registered(timer):
            bpy.app.timers.unregister(timer)


def _has_unlocked_renders() -> bool:
    return bool(session.owners()) and any(session.must_hand_over(scene) for scene in bpy.data.scenes)


def _serve() -> float | None:
    """Stand ready for render threads; see ``session.relay``."""
    if not _has_unlocked_renders():
        return None
    session.carry_out_writes()
    return 0.0 if bpy.app.is_job_running("RENDER") else _STAND_BY


def catch_up() -> bool:
    """Do all of it now: finished threads, copies, edits, final answers. True while a thread is at work."""
    session.collect()
    session.tidy()
    session.refresh()
    session.settle()
    return session.busy()


def _is_pending() -> bool:
    return session.busy() or session.has_pending()


def _tick() -> float | None:
    if bpy.app.is_job_running("RENDER"):
        return _POLL
    if time.monotonic() - _last_edit < PAUSE:
        session.collect()
        return _FRAME if session.busy() else _POLL
    is_busy = True
    try:
        is_busy = catch_up()
    except AttributeError as refusal:
        # While an engine starts in the render thread, Blender refuses all writes for a moment.
        if "not allowed" not in str(refusal) and "blend data" not in str(refusal):
            raise
    _redraw()
    if not is_busy:
        return None
    _watch()
    return _POLL


def _watch() -> None:
    """Binds that started by themselves get a progress in the status bar and heed Esc, like any other."""
    windows = bpy.context.window_manager.windows
    for uid in session.unwatched() if windows else ():
        with bpy.context.temp_override(window=windows[0]):
            bpy.ops.sinew.watch("INVOKE_DEFAULT", uid=uid)


def _redraw() -> None:
    """Show the progress of a bind, and its end, in the panels too."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in ("VIEW_3D", "PROPERTIES"):
                area.tag_redraw()
