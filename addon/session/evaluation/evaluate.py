# SPDX-License-Identifier: GPL-3.0-or-later
"""Updates the deformers in the order of the stack. Called in every evaluation: equal inputs cost very little.

In renders, handlers run this outside the main thread. It reads evaluated data from the depsgraph that it is
given, and writes arrays of unchanged size. It never makes or removes a datablock.
"""

from dataclasses import replace
from typing import NamedTuple

import bpy
import numpy as np
from bpy.types import Depsgraph, Object

from ...core import status
from ...core.errors import BackendMissingError, OptionError, SinewError, TopologyChangedError
from ...core.methods import BY_ID
from ...core.status import Level, Remedy, Status
from ...properties import SinewDeformer
from ..controls import kinds
from ..datablocks import vertex_groups
from ..datablocks.owners import owners
from ..datablocks.shapes import baked, shapes
from ..state import sessions
from ..state.evaluation import Chain, ControlState, Evaluation, ObjectEvaluation, Quality, is_shown
from ..state.sessions import LastUpdate
from ..targets import modified, refined_group, targets
from ..targets.kinds import kind_of
from . import applied, binding, incoming, mirroring, refined, renders, schedule, solving
from .changes import Change, Changes
from .schedule import Step

LINKED = "Linked: shows the last solution - make a library override to pose it here"


def update(depsgraph: Depsgraph, preview: bool = False, edit: bool = False, draft: bool = False) -> bool:
    """Solve every deformer whose inputs changed; whether there was one. A ``preview`` may stop early.

    So may the ``draft`` of a frame in playback, where the artist has chosen that. It is the same for a frame
    whatever was shown before.
    After an ``edit``, that is not after a change of the frame, ``refresh`` found at meshes with new geometry.
    If nothing changed, this takes some microseconds per control, however large the meshes are.

    Blender evaluates what was written before this returns if handlers of others follow, else right after.
    """
    found = owners()
    if not found or schedule.is_waiting():
        return False
    changes, moved = Changes(depsgraph), []
    quality = Quality.DRAFT if draft else Quality.DRAG if preview else Quality.FINAL
    for obj in found:
        if edit and depsgraph.mode == "VIEWPORT" and changes.has_edited_mesh(obj):
            sessions.note_edit(obj.name)
        if sessions.is_suspended():
            sessions.note_missed(obj.name)
            continue
        pending = _pending_update(obj, depsgraph, changes)
        if pending is not None:
            moved.append(pending)
    steps = schedule.steps(found) if moved and len(found) > 1 else []
    is_read = bool(moved) and schedule.others_listen(edit)
    may_bind = depsgraph.mode == "VIEWPORT" and any(_may_bind(pending.obj) for pending in moved)
    if steps or ((is_read or may_bind) and (not edit or changes.has_scene)):
        changes.take()
        schedule.begin(depsgraph, heard=edit)
        found = [_pending_update(old.obj, depsgraph, changes) for old in moved]
        moved = [pending for pending in found if pending is not None]
    if steps:
        written = _solve_in_order(steps, depsgraph, changes, quality, edit)
    else:
        written = {pending.obj for pending in moved if _writes(pending, depsgraph, changes, quality)}
    if written and is_read:
        schedule.evaluate(depsgraph, heard=edit)
    if mirroring.mirrored_targets and depsgraph.mode == "VIEWPORT" and not sessions.is_suspended():
        if edit:
            mirroring.note_keyed(changes.is_edited)
        mirroring.note_seen(edit)
    return bool(moved)


def _may_bind(obj: Object) -> bool:
    """Whether handlers may bind what is written now, or refine it, and so evaluate it before they return."""
    return refined_group.of(obj) is not None or any(each.auto_rebind for each in obj.sinew.deformers)


def _solve_in_order(
    steps: list[Step], depsgraph: Depsgraph, changes: Changes, quality: Quality, edit: bool
) -> set[Object]:
    """Update rigs after those that they read: see ``schedule``. Returns those that were written last."""
    written: set[Object] = set()  # since Blender evaluated them last
    for step in steps:
        for _round in range(step.rounds):
            if written & step.read:
                schedule.evaluate(depsgraph, heard=edit)
                for obj, reads in step.rigs.items():
                    if reads.entering & written:
                        changes.add_geometry(obj)
                written.clear()
            before = len(written)
            for pending in [_pending_update(obj, depsgraph, changes) for obj in step.rigs]:
                if pending is not None and _writes(pending, depsgraph, changes, quality):
                    written.add(pending.obj)
            if len(written) == before:
                break
    return written


def _writes(pending: "PendingUpdate", depsgraph: Depsgraph, changes: Changes, quality: Quality) -> bool:
    """Update the deformers of an object; whether one of them shows another shape now."""
    before = _shown(pending.obj, depsgraph.mode)
    _solve(pending, depsgraph, changes, quality)
    after = _shown(pending.obj, depsgraph.mode)
    return len(before) != len(after) or any(
        one is not other for one, other in zip(before, after, strict=True)
    )


def _shown(obj: Object, mode: str) -> list[object]:
    """What identifies the shapes that the deformers of an object show: each write makes another one."""
    views = [shapes.session_of(deformer, mode).view(mode) for deformer in obj.sinew.deformers]
    return [part for view in views for part in (view.signature, view.shape, view.factor)]


class PendingUpdate(NamedTuple):
    """An object whose deformers are to be updated, and the last time that they were."""

    obj: Object
    evaluated: Object
    placed: tuple
    controls: list[ControlState]
    change: Change
    last: LastUpdate | None


def _pending_update(obj: Object, depsgraph: Depsgraph, changes: Changes) -> PendingUpdate | None:
    """Where an object and its controls are; None if that is as before, or if nothing shows it."""
    evaluated = obj.evaluated_get(depsgraph)
    if not evaluated.is_evaluated:
        return None
    change, last = changes.change_of(obj), changes.last_update(obj)
    placed, controls = changes.read(obj, evaluated)
    if last is not None and change is Change.NOTHING and last.placed == placed:
        return None
    if sessions.take_missed(obj.name):
        changes.add_geometry(obj)
        change = Change.GEOMETRY
    return PendingUpdate(obj, evaluated, placed, controls, change, last)


def _solve(pending: PendingUpdate, depsgraph: Depsgraph, changes: Changes, quality: Quality) -> None:
    """Update the deformers of an object."""
    obj, evaluated, placed, controls, change, last = pending
    layout = last.layout if last is not None and change <= Change.DRIVEN else None
    new_geometry = change is Change.GEOMETRY
    expected: applied.Expected = {}
    in_viewport = depsgraph.mode == "VIEWPORT"
    if in_viewport and obj.library is None and (last is None or changes.has_edited_mesh(obj)):
        expected = applied.follow(obj, evaluated, last)
    shared = ObjectEvaluation(obj, evaluated, depsgraph, depsgraph.mode, quality, new_geometry)
    layout = _update_object(shared, controls, layout)
    changes.note(obj, LastUpdate(placed, layout, evaluated.matrix_world.copy()))
    if expected:
        applied.report(obj, evaluated, expected)


def update_renders(obj: Object, depsgraph: Depsgraph, entered: np.ndarray) -> None:
    """Solve what a render would show of an object now, in the depsgraph of the viewport. Main thread only.

    ``entered`` float32 (n, 3) is what enters the first deformer in renders.
    """
    evaluated = obj.evaluated_get(depsgraph)
    _placed, controls = Changes(depsgraph).read(obj, evaluated)
    shared = ObjectEvaluation(obj, evaluated, depsgraph, "RENDER", Quality.FINAL, new_geometry=True)
    _update_object(shared, controls, None, entered)


def _update_object(
    shared: ObjectEvaluation,
    controls: list[ControlState],
    layout: tuple | None,
    entered: np.ndarray | None = None,
) -> tuple:
    """Update the deformers of an object in a mode; returns its layout, as in ``LastUpdate``.

    The ``layout`` of the last update is given if nothing but controls has changed since. Then the settings
    and modifiers need no check. ``entered`` float32 (n, 3) is what enters the first deformer, if it is known.
    """
    obj, mode, depsgraph = shared.obj, shared.mode, shared.depsgraph
    changed = False
    kind = kind_of(obj)
    if mode == "VIEWPORT":
        kind.follow_renamed(obj)
    if layout is None or not _still_holds(layout, obj):
        changed = True
        if mode == "VIEWPORT" and modified.tell_copies_apart(obj):
            shared = replace(shared, new_geometry=False)  # what was evaluated belongs to another modifier
        layout = _layout(obj, mode)
        if mode == "VIEWPORT":
            mirroring.note_target(obj)
            for deformer in obj.sinew.deformers:
                status.put_refined(deformer.uid, "")
    chain = Chain()
    for modifier, shows in zip(kind.stack(obj), layout, strict=True):
        if not is_shown(modifier, mode):
            continue
        if shows is None:
            if refined_group.is_refining(modifier):
                refined.update(shared, modifier, chain, changed)
            chain = Chain() if baked.overwrites(modifier) else chain.after_other_modifier()
            continue
        if entered is not None:
            chain, entered = Chain(points=entered), None
        index = shows[0]
        deformer = obj.sinew.deformers[index]
        settings = _evaluated_settings(shared.evaluated, index, deformer)
        session, control = shapes.session_of(deformer, mode), controls[index]
        if settings.method != deformer.method:  # an animated method may ask for another kind of control
            control = kinds.kind_in_use(settings).read_state(deformer, depsgraph)
        evaluation = Evaluation(
            obj,
            shared.evaluated,
            depsgraph,
            mode,
            shared.quality,
            shared.new_geometry,
            modifier,
            deformer,
            settings,
            session,
            control,
            chain,
        )
        if evaluation.in_viewport and changed:
            deformer.complete()
            if vertex_groups.follow_renamed_groups(obj, deformer):
                session.rest = None  # it knows its weights by the old names
            lost = deformer.mask_group and deformer.mask_group not in obj.vertex_groups
            if kind.connect_mask(modifier, "" if lost else deformer.mask_group):
                obj.update_tag()
            text = (
                f"The mask is not used: {obj.name} has no vertex group '{deformer.mask_group}' - pick another"
            )
            status.put_mask(deformer.uid, text if lost else "")
        with session.lock:
            try:
                chain = _update_deformer(evaluation)
            except SinewError as error:
                chain = _refuse(evaluation, error)
    kind.show(obj, mode, depsgraph.scene)
    if mode == "VIEWPORT" and changed:
        _report_lost(obj)
        baked.report(obj)
    return layout


def _layout(obj: Object, mode: str) -> tuple[tuple[int, str] | None, ...]:
    """The index and key of the deformer that each modifier or shape key shows, or None."""
    kind, deformers, found = kind_of(obj), obj.sinew.deformers, []
    by_mark = {kind.mark_of(deformers[index]): index for index in _whole(obj)}
    for shows in kind.stack(obj):
        index = by_mark.pop(kind.mark(shows), None) if is_shown(shows, mode) else None
        found.append(None if index is None else (index, deformers[index].uid))
    return tuple(found)


def _still_holds(layout: tuple, obj: Object) -> bool:
    """Whether a layout is still valid: scripts may change Sinew's lists, and Blender lists no update."""
    deformers = obj.sinew.deformers
    return len(layout) == len(kind_of(obj).stack(obj)) and all(
        shows is None or (shows[0] < len(deformers) and deformers[shows[0]].uid == shows[1])
        for shows in layout
    )


def _whole(obj: Object) -> list[int]:
    """The indices of deformers that have both shape objects.

    A copied deformer, which still has the key of another, is left out until it gets a key of its own.
    """
    found, keys = {}, set()  # by the shape for viewports
    for index, deformer in enumerate(obj.sinew.deformers):
        shape = deformer.shape("VIEWPORT")
        whole = shape is not None and deformer.shape("RENDER") is not None
        if whole and shape not in found and deformer.uid not in keys:
            found[shape] = index
        keys.add(deformer.uid)
    return list(found.values())


def _report_lost(obj: Object) -> None:
    """Tell in the panel which controls and which hidden data are missing. Bind makes the data again."""
    for deformer in obj.sinew.deformers:
        missing = kinds.missing_control(deformer) if bpy.data.libraries else ""
        if missing and status.current(deformer.uid).level is not Level.ERROR:
            status.put(deformer.uid, Status(Level.WARNING, missing))
        session = sessions.find(deformer.uid)
        was_bound = deformer.is_bound or (session is not None and session.bound is not None)
        if not was_bound or binding.job(deformer.uid) is not None:
            continue
        if not deformer.is_bound:
            lost = "rest shape"
        elif deformer.shape("VIEWPORT") is None or deformer.shape("RENDER") is None:
            lost = "hidden shape"
        elif kind_of(obj).shown_by(obj, deformer) is None:
            lost = kind_of(obj).NOUN
        else:
            continue
        text = f"The {lost} was deleted - Rebind"
        status.put(deformer.uid, Status(Level.ERROR, text, remedy=Remedy.BIND))


def _evaluated_settings(evaluated: Object, index: int, deformer: SinewDeformer) -> SinewDeformer:
    """The deformer with its animated values, or the original if Blender has not copied it yet."""
    copies = evaluated.sinew.deformers
    if index < len(copies) and copies[index].uid == deformer.uid:
        return copies[index]
    return deformer


def _update_deformer(evaluation: Evaluation) -> Chain:
    """Update one deformer; returns what it passes on to the next."""
    deformer, session = evaluation.deformer, evaluation.session
    if not evaluation.settings.live:
        held = renders.while_not_live(evaluation)
        if held is None:
            return incoming.after(evaluation)
        evaluation = held
    if shapes.is_linked(deformer.proxy):
        status.put(deformer.uid, Status(Level.INFO, LINKED))
        return Chain(broken=True)
    if deformer.method in BY_ID:
        targets.require_method(evaluation.obj, deformer.definition)
    kind_of(evaluation.obj).require(evaluation.obj)
    if not deformer.is_bound or not kinds.kind_in_use(evaluation.settings).is_set(evaluation.settings):
        if evaluation.in_viewport:
            binding.abandon(deformer.uid)
        shapes.show_rest(deformer, evaluation.mode, evaluation.depsgraph.scene)
        return evaluation.chain.through(deformer.uid)
    wait = bpy.app.background or not evaluation.in_viewport
    if deformer.method not in BY_ID:
        raise OptionError("The method is unknown here - choose one in the menu")
    if deformer.topology_changed and evaluation.in_viewport:  # renders are bound for their own vertices
        raise TopologyChangedError(incoming.TOPOLOGY_CHANGED)
    bound = binding.ensure(session, deformer, evaluation.settings, wait, mode=evaluation.mode)
    if bound is None:
        if session.failed is not None:
            shapes.show_rest(deformer, evaluation.mode, evaluation.depsgraph.scene)
        return evaluation.chain.through(deformer.uid)
    entering = incoming.find(evaluation, bound)
    try:
        solving.solve(evaluation, bound, *entering)
    except SinewError as error:
        if not bound.handles:
            raise
        raise binding.with_names(error, deformer, bound) from error
    if not evaluation.in_viewport:
        status.put_render(deformer.uid, "")
    return incoming.after(evaluation)


def _refuse(evaluation: Evaluation, error: SinewError) -> Chain:
    """Show an error, and the rest shape; returns what the deformer passes on to the next."""
    # A bind that was refused in a render is refused in viewports too.
    if evaluation.in_viewport or evaluation.session.failed is not None:
        status.fail(evaluation.deformer.uid, error)
    if evaluation.in_viewport:
        deformer = evaluation.deformer
        if deformer.auto_rebind and (
            isinstance(error, TopologyChangedError)
            or kinds.kind_in_use(deformer).is_stale(deformer, evaluation.depsgraph)
        ):
            note = sessions.note_edit if evaluation.quality is Quality.DRAG else sessions.note_count
            note(evaluation.obj.name)
    else:
        status.put_render(evaluation.deformer.uid, f"In the render: {error}")
        if isinstance(error, TopologyChangedError):
            sessions.note_count(evaluation.obj.name)
    if isinstance(error, BackendMissingError):
        renders.show_viewport_shape(evaluation)
        return incoming.after(evaluation)  # the last solution stays
    shapes.show_rest(evaluation.deformer, evaluation.mode, evaluation.depsgraph.scene)
    return evaluation.chain.through(evaluation.deformer.uid)


def settle() -> bool:
    """Let the next evaluation replace every preview by the exact shape; whether there was one.

    For timers and tests.
    """
    asked = False
    for obj in owners():
        for deformer in obj.sinew.deformers:
            session = sessions.find(deformer.uid)
            if session is None or (session.work is not None and session.work.subject.final):
                continue
            if any(not shown.converged for shown in session.shown.values()):
                session.settle = asked = True
                obj.update_tag(refresh={"OBJECT"})
    return asked
