# SPDX-License-Identifier: GPL-3.0-or-later
"""Work that has to wait until the artist pauses, done by timers on the main thread.

Timers do not run without a window; tests call ``catch_up`` instead, and copies made by scripts do not wait.
"""

import time
from collections.abc import Iterator
from contextlib import contextmanager

import bpy
from bpy.types import Depsgraph, Object

from .. import bake
from ..core import status
from ..operators import redraw_panels
from ..properties import deformers_of
from ..session.actions import housekeeping, refresh
from ..session.datablocks import owners, traits
from ..session.evaluation import binding, evaluate, mirroring, schedule as live_schedule
from ..session.state import render_writes, sessions
from ..session.targets import lattices

PAUSE = 0.15  # seconds without an edit, after which the final shape replaces a preview
_POLL = 0.1  # seconds between two looks at threads
_IDLE_POLL = 0.2  # seconds between two looks for a render, while none is running
_DRAG_POLL = 0.02  # seconds between two looks at threads, while a drag waits for a shape

_last_edit = 0.0


def schedule() -> None:
    """Start the timers, because something was edited."""
    global _last_edit
    _last_edit = time.monotonic()
    if not bpy.app.timers.is_registered(_tick) and _is_pending():
        _start()
    if _has_rigs_in_windows() and not bpy.app.timers.is_registered(_write_for_renders):
        bpy.app.timers.register(_write_for_renders)


def follow_threads() -> None:
    """Start the timer if a thread is working."""
    if binding.busy() and not bpy.app.timers.is_registered(_tick):
        _start()


def _start() -> None:
    if not bpy.app.background:
        bpy.app.timers.register(_tick, first_interval=PAUSE)


def report_renders() -> None:
    """Report which deformers have shown the rest shape in renders since the last call."""
    told = status.take_unreported()
    found = [deformer for obj in owners.owners() for deformer in obj.sinew.deformers] if told else []
    lines = [f"{deformer.name}: {told[deformer.uid]}" for deformer in found if deformer.uid in told]
    if lines:
        bpy.ops.sinew.report_renders(text="; ".join(lines))


def stop() -> None:
    """Stop all timers."""
    for timer in (_tick, _write_for_renders):
        if bpy.app.timers.is_registered(timer):
            bpy.app.timers.unregister(timer)


def _has_rigs_in_windows() -> bool:
    return not bpy.app.background and bool(owners.owners())


def _write_for_renders() -> float | None:
    """Write what render threads wait for; see ``session/state/render_writes.py``.

    It also looks while the interface is to be locked: nothing calls the add-on when the artist unlocks it.
    """
    if not _has_rigs_in_windows():
        return None
    render_writes.carry_out_writes()
    with _refused_for_now():
        lattices.show_late()
        if not bpy.app.is_job_running("RENDER"):
            if not is_playing():  # settings may be keyed, and renders look at each frame by themselves
                refresh.look_at_renders()
            if sessions.has_counts() and not bpy.app.timers.is_registered(_tick):
                _start()
            report_renders()
    unlocked = any(render_writes.must_hand_over(scene) for scene in bpy.data.scenes)
    return 0.0 if unlocked and bpy.app.is_job_running("RENDER") else _IDLE_POLL


@contextmanager
def _refused_for_now() -> Iterator[None]:
    """For writes of a timer, which it tries again the next time if Blender refuses them now.

    It refuses all writes for a moment while an engine starts in the render thread, and where a panel is drawn
    beside Python of a render: both set and restore one switch.
    """
    try:
        yield
    except AttributeError as refusal:
        if "not allowed" not in str(refusal) and "blend data" not in str(refusal):
            raise


def separate_copies(depsgraph: Depsgraph) -> None:
    """Give the copies that a script has made shapes of their own now, as there is no window and so no timer.

    Blender then evaluates them, which calls the handlers once more.
    """
    if depsgraph.mode != "VIEWPORT" or sessions.is_suspended() or live_schedule.is_waiting():
        return
    live_schedule.begin(depsgraph)
    if housekeeping.separate_copies() and not owners.has_copies():
        depsgraph.update()


def bind_now(depsgraph: Depsgraph) -> None:
    """Bind what has other vertices now than at bind, and let it show in this evaluation.

    Blender evaluates what was written once more when its handlers have run.
    """
    if depsgraph.mode == "VIEWPORT":
        live_schedule.begin(depsgraph)
    if refresh.refresh():
        evaluate.update(depsgraph)


def catch_up() -> bool:
    """Do all deferred work now; True while a thread is still working.

    Collects the results of threads, gives copied objects shapes of their own, reacts to edits of meshes,
    gives keyframes to controls that followed others, replaces previews by final shapes, and looks for files.
    """
    housekeeping.collect()
    housekeeping.tidy()
    refresh.refresh()
    mirroring.key_partners()
    evaluate.settle()
    bake.look()
    return binding.busy()


def is_playing() -> bool:
    """Whether frames play in a window, or the artist scrubs."""
    screens = [window.screen for window in bpy.context.window_manager.windows]
    return any(screen.is_animation_playing or screen.is_scrubbing for screen in screens)


def _is_pending() -> bool:
    waits = binding.busy() or housekeeping.has_pending() or _uncounted() is not None
    return waits or bake.has_files()


def _uncounted() -> Object | None:
    """The active object, if it is a mesh without a deformer whose panel shall suggest tasks."""
    layer = getattr(bpy.context, "view_layer", None)
    active = layer and layer.objects.active
    return active if active and not deformers_of(active) and traits.is_uncounted(active) else None


def _tick() -> float | None:
    if bpy.app.is_job_running("RENDER"):
        return _POLL
    if is_playing() or time.monotonic() - _last_edit < PAUSE:
        housekeeping.collect()
        return _DRAG_POLL if binding.busy() else _POLL
    is_busy = True
    with _refused_for_now():
        is_busy = catch_up()
    fresh = _uncounted()
    if fresh is not None:
        traits.count(fresh.data)
    redraw_panels()
    if not is_busy:
        return None
    _watch_binds()
    return _POLL


def _watch_binds() -> None:
    """Show the progress of binds that started by themselves in the status bar, and let Esc cancel them."""
    windows = bpy.context.window_manager.windows
    for uid in binding.unwatched() if windows else ():
        with bpy.context.temp_override(window=windows[0]):
            bpy.ops.sinew.watch("INVOKE_DEFAULT", uid=uid)
