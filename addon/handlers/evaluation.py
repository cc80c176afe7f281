# SPDX-License-Identifier: GPL-3.0-or-later
"""Solve when something was edited and when the frame changed.

What these handlers write makes Blender evaluate the scene once more, but not again and again.
"""

import threading

import bpy
from bpy.app.handlers import persistent
from bpy.types import Depsgraph, Scene

from ..operators import entering, redraw_panels
from ..session.actions import refresh, try_it
from ..session.datablocks import owners
from ..session.evaluation import evaluate, mirroring, schedule
from ..session.state import sessions
from . import deferred


@persistent
def before_depsgraph_update(*_args: object) -> None:
    """Something was edited, and is not evaluated yet: what an artist moves takes its mirror image along.

    Blender calls it only while posing is mirrored for some object.
    """
    if threading.current_thread() is threading.main_thread():
        mirroring.move_partners()


_before_updates = bpy.app.handlers.depsgraph_update_pre


def listen(wanted: bool) -> None:
    """Let Blender call ``before_depsgraph_update``, or no more."""
    if before_depsgraph_update in _before_updates:
        _before_updates.remove(before_depsgraph_update)
    if wanted:
        _before_updates.append(before_depsgraph_update)


def _update(depsgraph: Depsgraph, draft: bool = False) -> None:
    """Solve a frame, or anything in a render."""
    if depsgraph.mode == "RENDER" and _may_bind():
        refresh.look_at_renders()
    if evaluate.update(depsgraph, draft=draft):
        _bind_counts(depsgraph)


def _bind_counts(depsgraph: Depsgraph) -> None:
    """Bind what has other vertices now than at bind, where that cannot wait.

    So it is in renders, with *Automatic Rebind* in the viewport, and where Apply has turned faces.
    """
    if sessions.has_counts() and _may_bind():
        deferred.bind_now(depsgraph)


def _may_bind() -> bool:
    """Whether datablocks may be made now, which the thread of a render may not do."""
    return (
        threading.current_thread() is threading.main_thread()
        and not sessions.is_suspended()
        and not schedule.is_waiting()
        and not bpy.app.is_job_running("RENDER")
    )


@persistent
def on_depsgraph_update(scene: Scene, depsgraph: Depsgraph) -> None:
    """Something was edited.

    With a window, a drag shows previews, and the final shape follows after a pause. Without one there is no
    pause: copies and library overrides get shapes of their own at once.
    """
    if bpy.app.background and owners.has_copies():
        deferred.separate_copies(depsgraph)
    interactive = depsgraph.mode == "VIEWPORT" and not bpy.app.background
    if depsgraph.mode == "RENDER":
        _update(depsgraph)
    elif evaluate.update(depsgraph, preview=interactive, edit=True):
        _bind_counts(depsgraph)
    if bool(mirroring.mirrored_targets) != (before_depsgraph_update in _before_updates):
        listen(bool(mirroring.mirrored_targets))
    if entering.waiting and depsgraph.mode == "VIEWPORT":
        entering.follow(depsgraph.view_layer)
    if interactive:
        deferred.schedule()
    if scene.sinew.rig:
        _look_at_steps(scene, depsgraph)


@persistent
def on_frame_change(scene: Scene, depsgraph: Depsgraph) -> None:
    """The frame changed: in playback, scrubbing, renders and motion blur.

    It computes the final shape, but where the artist wants drafts in playback, those; the final shape follows
    when playback rests.
    """
    if bpy.app.background and owners.has_copies():
        deferred.separate_copies(depsgraph)
    draft = depsgraph.mode == "VIEWPORT" and deferred.is_playing()
    _update(depsgraph, draft)
    if draft:
        deferred.schedule()
    if depsgraph.mode == "VIEWPORT":
        if mirroring.mirrored_targets and before_depsgraph_update not in _before_updates:
            listen(True)
        deferred.follow_threads()  # an animated setting may have started a bind
    if scene.sinew.rig:
        _look_at_steps(scene, depsgraph)


def _look_at_steps(scene: Scene, depsgraph: Depsgraph) -> None:
    """Tick the steps of a rig of Try It."""
    if depsgraph.mode == "VIEWPORT" and try_it.look(scene, depsgraph):
        redraw_panels()
