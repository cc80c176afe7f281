# SPDX-License-Identifier: GPL-3.0-or-later
"""Binds a deformer to its mesh, and lets it go. Main thread only."""

import bpy
from bpy.types import Object

from ...backend import Progress
from ...core import status
from ...core.errors import ConstraintError, SinewError
from ...core.status import Level, Status
from ...properties import SinewDeformer
from ..blocks import capture, shapes, targets, vertex_groups
from ..blocks.owners import forget_owners
from ..control import kinds
from ..live import binding
from ..memory import sessions


@sessions.suspended()
def bind(obj: Object, deformer: SinewDeformer, wait: bool = True, progress: Progress | None = None) -> None:
    """Take what enters the modifier now as the rest shape and factorise.

    Without ``wait`` a heavy mesh is bound by a thread (``session.job``). On a refusal the deformer is
    unbound, shows the rest shape and keeps every setting.
    """
    try:
        binding.require_backend()
    except SinewError as error:
        status.fail(deformer.uid, error)
        raise
    if deformer.bake.is_baked:
        raise SinewError(f"{deformer.name} is baked - Unbake it first")
    try:
        targets.require_method(obj, deformer.definition)
        kind = kinds.kind_in_use(deformer)
        if not kind.is_set(deformer):
            raise ConstraintError(kind.MISSING)
        vertex_groups.follow_renamed_groups(obj, deformer)
        meshes = capture.rest_meshes(obj, deformer)
        sizes = [len(mesh.vertices) for mesh in meshes if mesh is not None]
        shapes.hold_rest(deformer, meshes)
        deformer.topology_changed = False
        kind.set_rest(obj, deformer)
        shapes.ensure(obj, deformer, *sizes)
        kinds.keep_evaluated(obj)
        bpy.context.scene.render.use_lock_interface = True  # renders write shapes while the window draws
        forget_owners()
        session = sessions.open_session(deformer.uid)
        session.failed = None
        with session.lock:  # a render may be solving
            binding.ensure(session, deformer, deformer, wait, progress)
    except SinewError as error:
        _let_go(deformer)
        status.fail(deformer.uid, error)
        raise
    finally:
        obj.update_tag()
        bpy.context.view_layer.update()  # new shapes enter
        sessions.forget_edit(obj.name)  # which was no edit of the user's


def _let_go(deformer: SinewDeformer) -> None:
    binding.abandon(deformer.uid)
    shapes.show_rest(deformer, "VIEWPORT")
    shapes.show_rest(deformer, "RENDER")
    shapes.release_rest(deformer)
    status.put_notes(deformer.uid, ())


@sessions.suspended()
def unbind(obj: Object, deformer: SinewDeformer) -> None:
    """Show the rest shape and forget where the controls rested: the next bind starts where they are."""
    _let_go(deformer)
    sessions.drop(deformer.uid)
    for kind in kinds.every_kind():
        kind.forget_rest(deformer)
    status.put(deformer.uid, Status(Level.INFO, "Not bound - press Bind"))
    obj.update_tag()
