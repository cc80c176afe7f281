# SPDX-License-Identifier: GPL-3.0-or-later
"""Solve when something was edited and when the frame changed.

What these handlers write makes Blender evaluate the scene once more, but not again and again.
"""

import bpy
from bpy.app.handlers import persistent
from bpy.types import Depsgraph, Scene

from .. import session
from . import deferred


@persistent
def on_depsgraph_update(_scene: Scene, depsgraph: Depsgraph) -> None:
    """Something was edited.

    With a window, a drag shows previews, and the final shape follows after a pause.
    """
    if bpy.app.background and session.has_copies():
        deferred.separate_copies(depsgraph)
    interactive = depsgraph.mode == "VIEWPORT" and not bpy.app.background
    session.update(depsgraph, preview=interactive, edit=True)
    if interactive:
        deferred.schedule()


@persistent
def on_frame_change(_scene: Scene, depsgraph: Depsgraph) -> None:
    """The frame changed: in playback, scrubbing, renders and motion blur.

    It always computes the final shape.
    """
    if bpy.app.background and session.has_copies():
        deferred.separate_copies(depsgraph)
    session.update(depsgraph)
    if depsgraph.mode == "VIEWPORT":
        deferred.follow_threads()  # an animated setting may have started a bind
