# SPDX-License-Identifier: GPL-3.0-or-later
"""Undo, redo, load, save: properties are the truth, the session follows."""

import threading

import bpy
from bpy.app.handlers import persistent

from .. import session
from ..core.memory import forget_all
from . import deferred


@persistent
def on_undo(*_args: object) -> None:
    """Shape meshes may hold another state now: the next evaluation writes them again."""
    session.forget_owners()
    session.forget_shapes()
    _evaluate_again()


@persistent
def on_load(*_args: object) -> None:
    """Another file: nothing of the old one counts."""
    forget_all()
    if session.owners():  # the first evaluation after a load calls no handlers
        session.update(bpy.context.evaluated_depsgraph_get())
        deferred.schedule()


@persistent
def before_use(*_args: object) -> None:
    """Before a save or a render: copies get shapes of their own, edits take effect.

    A window renders in a thread of its own, where datablocks cannot be made: there a timer did it.
    """
    if threading.current_thread() is not threading.main_thread():
        return
    session.tidy()
    if session.refresh():
        bpy.context.view_layer.update()


def _evaluate_again() -> None:
    for obj in session.owners():
        if obj.library is None:
            session.note_edit(obj.name)  # the mesh may be another one now
            obj.update_tag()
    deferred.schedule()
