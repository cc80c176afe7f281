# SPDX-License-Identifier: GPL-3.0-or-later
"""Undo, redo, load and save: bring what the process remembers in line with the properties of the file."""

import threading

import bpy
from bpy.app.handlers import persistent

from .. import session
from ..core.memory import forget_all
from ..operators import entering
from . import deferred, evaluation


@persistent
def on_undo(*_args: object) -> None:
    """Undo or redo may have changed the shape meshes, so the next evaluation writes them again."""
    session.forget_owners()
    session.forget_shapes()
    session.restore_shapes()
    session.complete_undo()
    evaluation.listen(bool(session.mirrored_targets))
    _evaluate_all()
    entering.restore(bpy.context.view_layer)


@persistent
def on_load(*_args: object) -> None:
    """Another file was opened: forget everything about the previous one."""
    forget_all()
    session.keep_earlier_defaults()
    for obj in session.owners():
        if any(deformer.topology_changed for deformer in obj.sinew.deformers):
            session.note_edit(obj.name)  # to look once more: Sinew once took turned faces for other ones
    if session.owners():  # the first evaluation after a load calls no handlers
        depsgraph = bpy.context.evaluated_depsgraph_get()
        if bpy.app.background and session.has_copies():
            deferred.separate_copies(depsgraph)
        session.update(depsgraph)
        deferred.schedule()
    evaluation.listen(bool(session.mirrored_targets))


@persistent
def before_save(*_args: object) -> None:
    """Do all deferred edits, and store the last solutions for computers without Sinew.

    Beside a render that leaves the window unlocked, nothing of what it reads may change.
    """
    if not bpy.app.is_job_running("RENDER"):
        before_render()
        session.store()


@persistent
def before_render(*_args: object) -> None:
    """Give copied objects shapes of their own and react to edits.

    A render from a window runs in another thread, which cannot make datablocks. Then a timer has done this.
    """
    if threading.current_thread() is not threading.main_thread():
        return
    session.tidy()
    session.bind_renders()


@persistent
def after_render(*_args: object) -> None:
    """Report what the render could not show. In a window a timer does this."""
    if bpy.app.background:
        deferred.report_renders()


def _evaluate_all() -> None:
    for obj in session.owners():
        if obj.library is None:
            session.note_edit(obj.name)  # undo may have restored another mesh
            obj.update_tag()
    deferred.schedule()
