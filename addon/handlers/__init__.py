# SPDX-License-Identifier: GPL-3.0-or-later
"""The functions that Blender calls by itself."""

import bpy

from ..session.actions import saving
from . import deferred, evaluation, history

# Those of evaluations come first, so that the handlers of other add-ons find the shapes of the frame.
_FIRST = ("depsgraph_update_post", "frame_change_post")
_HANDLERS = (
    ("depsgraph_update_post", evaluation.on_depsgraph_update),
    ("frame_change_post", evaluation.on_frame_change),
    ("undo_post", history.on_undo),
    ("redo_post", history.on_undo),
    ("load_post", history.on_load),
    ("save_pre", history.before_save),
    ("render_init", history.before_render),
    ("render_complete", history.after_render),
    ("render_cancel", history.after_render),
)


def register() -> None:
    for event, handler in _HANDLERS:
        handlers = getattr(bpy.app.handlers, event)
        handlers.insert(0 if event in _FIRST else len(handlers), handler)


def unregister() -> None:
    deferred.stop()
    evaluation.listen(False)
    saving.store_shown()  # renders without Sinew show it
    for event, handler in _HANDLERS:
        handlers = getattr(bpy.app.handlers, event)
        if handler in handlers:
            handlers.remove(handler)
