# SPDX-License-Identifier: GPL-3.0-or-later
"""Adds a region or a cage in one call, with a deformer if there is none yet, and binds it. Main thread only.

If the bind is refused, what was added stays, and the panel says what to do. So the error is returned.
"""

from bpy.types import Mesh, Object

from ...core.errors import SinewError
from ...core.methods import DEFAULT_CAGE_METHOD, DEFAULT_METHOD
from ...properties import SinewDeformer, SinewHandle
from .bind import bind
from .cages import CAGE_METHODS, set_cage
from .deformers import add_deformer, remove_deformer
from .handles.bones import is_moved_by_control
from .handles.handles import add_captured_handle


def rig_region(
    obj: Object,
    role: str,
    vertex_group: str,
    method: str = DEFAULT_METHOD,
    *,
    control: Object | None = None,
    bone: str = "",
    owns_group: bool = False,
    name: str = "",
    weight: float = 1.0,
    from_rest: bool | None = None,
    wait: bool = True,
) -> tuple[SinewHandle, SinewError | None]:
    """A region of the active deformer, or of a new one with ``method``; and the error if it is not bound.

    ``role``, ``control`` and ``bone`` are those of ``add_handle``. If ``from_rest`` is None, a bone that
    moves the mesh already is to move its rest shape. What is refused before the bind leaves nothing behind.
    """
    is_first = obj.sinew.active is None
    deformer = obj.sinew.active or add_deformer(obj, method)
    try:
        handle, entered = add_captured_handle(obj, deformer, role, vertex_group, control, bone, owns_group)
    except SinewError:
        if is_first:
            remove_deformer(obj, len(obj.sinew.deformers) - 1)
        if owns_group:
            obj.vertex_groups.remove(obj.vertex_groups[vertex_group])
        raise
    handle.weight = weight
    handle.name = name or handle.name
    handle.from_rest = is_moved_by_control(obj, deformer, handle) if from_rest is None else from_rest
    return handle, try_bind(obj, deformer, wait, entered)


def rig_cage(
    obj: Object,
    cage: Object,
    method: str = DEFAULT_CAGE_METHOD,
    *,
    owns_cage: bool = False,
    wait: bool = True,
) -> tuple[SinewDeformer, SinewError | None]:
    """The deformer that follows ``cage``, a new one unless one needs a cage; and the error if not bound."""
    deformer = waiting_for_cage(obj)
    is_new = deformer is None
    deformer = deformer or add_deformer(obj, method)
    try:
        set_cage(obj, deformer, cage)
    except SinewError:
        if is_new:
            remove_deformer(obj, len(obj.sinew.deformers) - 1)
        raise
    deformer.owns_cage = owns_cage
    return deformer, try_bind(obj, deformer, wait)


def waiting_for_cage(obj: Object) -> SinewDeformer | None:
    """The active deformer, if it needs a cage and has none yet."""
    active = obj.sinew.active
    waits = active is not None and active.definition in CAGE_METHODS and active.cage is None
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
