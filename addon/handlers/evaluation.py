# SPDX-License-Identifier: GPL-3.0-or-later
"""Solve when something was edited and when the frame changed.

Writing in these triggers one more pass, no recursion.
"""

import bpy
from bpy.app.handlers import persistent
from bpy.types import Depsgraph, Scene

from .. import session
from . import deferred


@persistent
def on_depsgraph_update(_scene: Scene, depsgraph: Depsgraph) -> None:
    """Something was edited. With a window, a drag shows previews; the final answer follows when it pauses."""
    interactive = depsgraph.mode == "VIEWPORT" and not bpy.app.background
    session.update(depsgraph, preview=interactive, edit=True)
    if interactive:
        deferred.schedule()


@persistent
def on_frame_change(_scene: Scene, depsgraph: Depsgraph) -> None:
    """Playback, scrubbing, renders, motion blur: always the final answer."""
    session.update(depsgraph)
    if depsgraph.mode == "VIEWPORT":
        deferred.follow_threads()  # an animated setting may have started a bind
