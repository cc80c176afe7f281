# SPDX-License-Identifier: GPL-3.0-or-later
"""Binds a deformer to its mesh, and unbinds it. Main thread only."""

from collections.abc import Iterator
from contextlib import contextmanager

import bpy
from bpy.types import Mesh, Object

from ...backend import Progress
from ...compat import read_positions
from ...core import status
from ...core.errors import ConstraintError, SinewError
from ...core.status import Level, Status
from ...properties import SinewDeformer
from ..controls import kinds
from ..controls.handles import keys, riding
from ..controls.kinds import ControlKind
from ..datablocks import rest_frame, vertex_groups
from ..datablocks.owners import forget_owners
from ..datablocks.shapes import capture, shapes
from ..evaluation import binding
from ..state import sessions
from ..state.sessions import Bound
from ..targets import refined_group, targets
from ..targets.kinds import kind_of
from . import companions


@sessions.suspended()
def bind(
    obj: Object,
    deformer: SinewDeformer,
    wait: bool = True,
    progress: Progress | None = None,
    entered: Mesh | None = None,
    renew: bool = False,
) -> None:
    """Take what enters the modifier now as the rest shape and factorise.

    Without ``wait`` a heavy mesh is bound by a thread (``session.job``). On a refusal the deformer is
    unbound, shows the rest shape and keeps every setting. ``entered``: what enters in viewports, if the
    caller has just captured it by ``capture.rest_mesh``; it is used up. With ``renew``, controls that have
    gained or lost points rest as they are now, whatever kind they are of.
    """
    try:
        with _shown_in_panel(deformer):
            binding.require_backend()
        if deformer.bake.is_baked:
            raise SinewError(f"{deformer.name} is baked - Unbake it first")
        try:
            with _shown_in_panel(deformer), _unbound_on_refusal(deformer):
                rest_frame.absorb(deformer)
                kind = _required_kind(obj, deformer)
                vertex_groups.follow_renamed_groups(obj, deformer)
                meshes, entered = capture.rest_meshes(obj, deformer, entered), None
                sizes = [len(mesh.vertices) for mesh in meshes if mesh is not None]
                entering = read_positions(meshes[0])
                keys.turn_with_rest(deformer, _bound(deformer), entering)
                riding.turn_with_rest(obj, deformer, _bound(deformer), entering)
                shapes.hold_rest(deformer, meshes)
                deformer.topology_changed = False
                sessions.open_session(deformer.uid).render_settings = capture.render_signature(obj, deformer)
                status.put_render(deformer.uid, "")
                kind.set_rest(obj, deformer, renew)
                companions.renew(deformer)
                shapes.ensure(obj, deformer, *sizes)
                kinds.keep_evaluated(obj)
                _factorise(deformer, wait, progress)
        finally:
            obj.update_tag()
            bpy.context.view_layer.update()  # new shapes enter
            if refined_group.of(obj) is None:  # else the refined mesh is made anew
                sessions.forget_edit(obj.name)  # the updates above are no edits by the user
    finally:
        if entered is not None:
            bpy.data.meshes.remove(entered)


def _bound(deformer: SinewDeformer) -> Bound | None:
    session = sessions.find(deformer.uid)
    return None if session is None else session.bound


@contextmanager
def _shown_in_panel(deformer: SinewDeformer) -> Iterator[None]:
    """The panel shows why Sinew refuses."""
    try:
        yield
    except SinewError as error:
        status.fail(deformer.uid, error)
        raise


@contextmanager
def _unbound_on_refusal(deformer: SinewDeformer) -> Iterator[None]:
    """If Sinew refuses, the deformer is not bound any more."""
    try:
        yield
    except SinewError:
        _let_go(deformer)
        raise


def _required_kind(obj: Object, deformer: SinewDeformer) -> ControlKind:
    """The kind of control that moves the deformer; refuses what cannot be bound."""
    targets.require_method(obj, deformer.definition)
    kind_of(obj).require(obj)
    kind = kinds.kind_in_use(deformer)
    if not kind.is_set(deformer):
        raise ConstraintError(kind.MISSING)
    return kind


def _factorise(deformer: SinewDeformer, wait: bool, progress: Progress | None) -> None:
    forget_owners()
    session = sessions.open_session(deformer.uid)
    session.failed = None
    with session.lock:  # a render may be solving
        binding.ensure(session, deformer, deformer, wait, progress)
    bpy.context.scene.render.use_lock_interface = True  # renders write shapes while the window draws


def _let_go(deformer: SinewDeformer) -> None:
    binding.abandon(deformer.uid)
    session = sessions.find(deformer.uid)
    if session is not None:
        session.bound = None
    shapes.show_rest(deformer, "VIEWPORT")
    shapes.show_rest(deformer, "RENDER")
    target = kind_of(deformer.id_data)
    if not target.STAYS_UNBOUND:
        target.remove(deformer.id_data, deformer)
    shapes.release_rest(deformer)
    status.put_notes(deformer.uid, ())


@sessions.suspended()
def unbind(obj: Object, deformer: SinewDeformer) -> None:
    """Show the rest shape and forget the rest of the controls: the next bind takes it as they are then."""
    _let_go(deformer)
    sessions.drop(deformer.uid)
    for kind in kinds.every_kind():
        kind.forget_rest(deformer)
    rest_frame.forget(deformer)
    status.put(deformer.uid, Status(Level.INFO, "At rest - press Bind"))
    obj.update_tag()
