# SPDX-License-Identifier: GPL-3.0-or-later
"""Undo, redo, load and save: bring what the process remembers in line with the properties of the file."""

import threading

import bpy
from bpy.app.handlers import persistent

from ..core.memory import forget_all
from ..operators import entering
from ..session.actions import deformers, housekeeping, refresh, saving, surveying
from ..session.datablocks import owners
from ..session.evaluation import evaluate, mirroring
from ..session.state import sessions
from . import deferred, evaluation


@persistent
def on_undo(*_args: object) -> None:
    """Undo or redo may have changed the shape meshes, so the next evaluation writes them again."""
    owners.forget_owners()
    sessions.forget_shapes()
    surveying.forget_counts()
    housekeeping.restore_shapes()
    mirroring.complete_undo()
    evaluation.listen(bool(mirroring.mirrored_targets))
    _evaluate_all()
    entering.restore(bpy.context.view_layer)


@persistent
def on_load(*_args: object) -> None:
    """Another file was opened: forget everything about the previous one."""
    forget_all()
    deformers.keep_earlier_defaults()
    for obj in owners.owners():
        if any(deformer.topology_changed for deformer in obj.sinew.deformers):
            sessions.note_edit(obj.name)  # to look once more: Sinew once took turned faces for other ones
    if owners.owners():  # the first evaluation after a load calls no handlers
        depsgraph = bpy.context.evaluated_depsgraph_get()
        if bpy.app.background and owners.has_copies():
            deferred.separate_copies(depsgraph)
        evaluate.update(depsgraph)
        deferred.schedule()
    evaluation.listen(bool(mirroring.mirrored_targets))


@persistent
def before_save(*_args: object) -> None:
    """Do all deferred edits, and store the last solutions for computers without Sinew.

    Beside a render that leaves the window unlocked, nothing of what it reads may change.
    """
    if not bpy.app.is_job_running("RENDER"):
        before_render()
        saving.store()


@persistent
def before_render(*_args: object) -> None:
    """Give copied objects shapes of their own and react to edits.

    A render from a window runs in another thread, which cannot make datablocks. Then a timer has done this.
    """
    if threading.current_thread() is not threading.main_thread():
        return
    housekeeping.tidy()
    refresh.bind_renders()


@persistent
def after_render(*_args: object) -> None:
    """Report what the render could not show. In a window a timer does this."""
    if bpy.app.background:
        deferred.report_renders()


def _evaluate_all() -> None:
    for obj in owners.owners():
        if obj.library is None:
            sessions.note_edit(obj.name)  # undo may have restored another mesh
            obj.update_tag()
    deferred.schedule()
