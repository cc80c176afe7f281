# SPDX-License-Identifier: GPL-3.0-or-later
"""Adds a region or a control in one call, with a deformer if there is none, and binds it. Main thread only.

If the bind is refused, what was added stays, and the panel says what to do. So the error is returned.
"""

from collections.abc import Sequence

from bpy.types import Mesh, Object

from ...core.errors import ConstraintError, SinewError
from ...core.labels import label_of, names_of
from ...core.methods import BY_ID, DEFAULT_CAGE_METHOD, DEFAULT_METHOD, DEFAULT_POINT_METHOD, METHODS
from ...properties import SinewDeformer, SinewHandle
from ..controls import kinds
from ..controls.handles.points import takes_segments
from ..state import sessions
from .bind import bind
from .deformers import add_deformer, remove_deformer
from .handles.bones import is_moved_by_control
from .handles.handles import NewRegion, add_captured_handle
from .handles.points import add_point
from .sharing import copy_settings


@sessions.suspended()
def rig_region(
    obj: Object,
    region: NewRegion,
    method: str = DEFAULT_METHOD,
    *,
    from_rest: bool | None = None,
    wait: bool = True,
) -> tuple[SinewHandle, SinewError | None]:
    """A region of the active deformer, or of a new one with ``method``; and the error if it is not bound.

    If ``from_rest`` is None, a bone that moves the mesh already is to move its rest shape. What is refused
    before the bind leaves nothing behind.
    """
    is_first = obj.sinew.active is None
    deformer = obj.sinew.active or add_deformer(obj, method)
    try:
        handle, entered = add_captured_handle(obj, deformer, region)
    except SinewError:
        if is_first:
            remove_deformer(obj, len(obj.sinew.deformers) - 1)
        if region.owns_group:
            obj.vertex_groups.remove(obj.vertex_groups[region.vertex_group])
        raise
    handle.from_rest = is_moved_by_control(obj, deformer, handle) if from_rest is None else from_rest
    return handle, try_bind(obj, deformer, wait, entered)


@sessions.suspended()
def rig_points(
    objects: Sequence[Object],
    controls: Sequence[tuple[Object, str]],
    method: str,
    *,
    owned: bool = False,
    acts_as: str = "PLACE",
    wait: bool = True,
) -> list[tuple[SinewDeformer, int, SinewError | None]]:
    """Handles of several objects that act where their controls, objects or bones, are.

    They belong to the active deformer of each object, or to a new one with ``method``; an active one that
    cannot take points is refused. ``owned``: the controls were made for the handles of the first object.
    ``acts_as``: PLACE, POINTS or SEGMENTS, for bones and for objects that have points. For each object its
    deformer, the number of new handles and the error of the bind. What is refused before that leaves nothing
    of the object behind.
    """
    rigged = []
    for obj in objects:
        count = _add_points(obj, controls, method, owned and obj == objects[0], acts_as)
        rigged.append((obj.sinew.active, count, try_bind(obj, obj.sinew.active, wait)))
    # Handles that lack a place on one object may have one on another that was bound later.
    return [
        (deformer, count, refusal and try_bind(deformer.id_data, deformer, wait))
        for deformer, count, refusal in rigged
    ]


def _add_points(
    obj: Object, controls: Sequence[tuple[Object, str]], method: str, owned: bool, acts_as: str
) -> int:
    """Add handles of one object; how many."""
    active = obj.sinew.active
    deformer = active or add_deformer(obj, method)
    try:
        if not takes_points(deformer):
            raise ConstraintError(
                f"{label_of(deformer.definition)} needs regions, not points - "
                f"choose {label_of(BY_ID[DEFAULT_POINT_METHOD])}, or another method of space, first"
            )
        if acts_as == "SEGMENTS" and not takes_segments(deformer):
            others = names_of(row for row in METHODS if row.takes_segments)
            raise ConstraintError(
                f"{label_of(deformer.definition)} has no segments - choose {others} first, or use points"
            )
        for control, bone in controls:
            add_point(obj, deformer, control, bone, owned, acts_as)
    except SinewError:
        if active is None:
            remove_deformer(obj, len(obj.sinew.deformers) - 1)
        raise
    return len(controls)


def takes_points(deformer: SinewDeformer) -> bool:
    """Whether handles of the deformer act where their controls are, if they have no region."""
    method = deformer.definition
    return method.is_space and kinds.marks_regions(method)


def rig_control(
    obj: Object,
    control: Object,
    method: str = DEFAULT_CAGE_METHOD,
    *,
    owned: bool = False,
    like: SinewDeformer | None = None,
    wait: bool = True,
) -> tuple[SinewDeformer, SinewError | None]:
    """The deformer that follows an object, a new one unless one needs a control; and the error if not bound.

    The object becomes a control of the kind that ``method`` asks for, such as a cage. ``owned``: it was made
    for the deformer, and is removed with it. ``like``: a deformer that has the settings for this one.
    """
    deformer = waiting_for_control(obj, method)
    is_new = deformer is None
    deformer = deformer or add_deformer(obj, method)
    if like is not None:
        copy_settings(like, deformer)
    try:
        use_control(obj, deformer, control, owned)
    except SinewError:
        if is_new:
            remove_deformer(obj, len(obj.sinew.deformers) - 1)
        raise
    return deformer, try_bind(obj, deformer, wait)


def rig_controls(
    objects: Sequence[Object], control: Object, method: str, *, owned: bool, wait: bool
) -> list[tuple[SinewDeformer, SinewError | None]]:
    """``rig_control`` for several objects. The deformers of the others get the settings of the first."""
    first = rig_control(objects[0], control, method, owned=owned, wait=wait)
    return [
        first,
        *(rig_control(obj, control, method, owned=owned, like=first[0], wait=wait) for obj in objects[1:]),
    ]


@sessions.suspended()
def use_control(obj: Object, deformer: SinewDeformer, control: Object, owned: bool = False) -> None:
    """Let an object control a deformer. ``bind`` must follow."""
    kinds.kind_in_use(deformer).use(obj, deformer, control, owned)
    kinds.keep_evaluated(obj)


def waiting_for_control(obj: Object, method: str) -> SinewDeformer | None:
    """The active deformer, if it has no control yet and needs one of the kind that ``method`` asks for."""
    active = obj.sinew.active
    if active is None or method not in BY_ID:
        return None
    kind = kinds.kind_in_use(active)
    waits = kind is kinds.kind_of_method(BY_ID[method]) and not any(kind.links(active))
    return active if waits else None


def try_bind(
    obj: Object, deformer: SinewDeformer, wait: bool = True, entered: Mesh | None = None
) -> SinewError | None:
    """Bind; the reason if that is refused. ``entered`` as ``bind`` takes it."""
    try:
        bind(obj, deformer, wait, entered=entered)
    except SinewError as error:
        return error
    return None
