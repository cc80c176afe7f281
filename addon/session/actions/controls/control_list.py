# SPDX-License-Identifier: GPL-3.0-or-later
"""Adds and removes the objects that control a deformer together, such as wires or tools. Main thread only."""

from collections.abc import Mapping

import bpy
import numpy as np
from bpy.types import Object
from mathutils import Matrix, Vector

from ....core.errors import SinewError
from ....core.geometry import frames
from ....core.geometry.paths import AXES
from ....core.methods import BY_ID
from ....properties import SinewControl, SinewDeformer, row_at
from ...controls import kinds, objects
from ...controls.multi_object import SeveralKind
from ...controls.tools.kind import KIND as TOOLS
from ...datablocks import rest_frame
from ...state import sessions
from ..deformers import add_deformer, remove_deformer
from ..rigging import try_bind
from .around import follow

_SIZE = "SPHERE"  # how an empty shows the reach of a tool


def rows_of(deformer: SinewDeformer) -> list[SinewControl]:
    """The objects that control the deformer with its method; none if that has another kind of control."""
    kind = kinds.kind_in_use(deformer)
    return kind.rows(deformer) if isinstance(kind, SeveralKind) else []


def active_row(deformer: SinewDeformer) -> SinewControl | None:
    """The active one of these; None if there are none."""
    rows = rows_of(deformer)
    chosen = row_at(deformer.controls, deformer.active_control)
    return chosen if chosen in rows else next(iter(rows), None)


def add_to(
    obj: Object,
    controls: Mapping[Object, Mapping[str, object]],
    method: str,
    owned: bool,
    wait: bool = True,
) -> tuple[SinewDeformer, SinewError | None]:
    """Let objects control the active deformer, or a new one with ``method``; and the error if not bound.

    The active one, if its method asks for the same kind of control. Each object comes with its values, by the
    names of the method's parameters.
    """
    active = obj.sinew.active
    kind = kinds.kind_of_method(BY_ID[method])
    is_new = active is None or kinds.kind_in_use(active) is not kind
    deformer = add_deformer(obj, method) if is_new else active
    before = len(deformer.controls)
    try:
        with sessions.suspended():
            for control, values in controls.items():
                kind.use(obj, deformer, control, owned)
                for name, value in values.items():
                    setattr(deformer.controls[-1], name, value)
            kinds.keep_evaluated(obj)
    except SinewError:
        if is_new:
            remove_deformer(obj, len(obj.sinew.deformers) - 1)
        else:
            while len(deformer.controls) > before:
                deformer.controls.remove(len(deformer.controls) - 1)
        raise
    return deformer, try_bind(obj, deformer, wait)


@sessions.suspended()
def remove_row(obj: Object, deformer: SinewDeformer, index: int) -> None:
    """Remove a control, and its object if that was made for the deformer. ``bind`` must follow."""
    row = deformer.controls[index]
    objects.release([row])
    deformer.controls.remove(index)
    deformer.active_control = max(min(index, len(deformer.controls) - 1), 0)
    kinds.keep_evaluated(obj)
    obj.update_tag()


def tool_reach(size: float) -> float:
    """How far a new tool reaches that moves something of a size."""
    return size / 3.0


@sessions.suspended()
def new_tool(obj: Object, place: np.ndarray, axis: np.ndarray, size: float, name: str) -> Object:
    """An empty that follows ``obj``: at a ``place`` (3,) in the world, its z axis along ``axis`` (3,)."""
    empty = bpy.data.objects.new(f"{obj.name} {name}", None)
    for collection in obj.users_collection or (bpy.context.scene.collection,):
        collection.objects.link(empty)
    empty.empty_display_type, empty.empty_display_size = _SIZE, size
    empty.show_in_front = True
    follow(empty, obj, _frame(place, axis))
    bpy.context.view_layer.update()
    return empty


def _frame(place: np.ndarray, axis: np.ndarray) -> Matrix:
    turned = Vector((0.0, 0.0, 1.0)).rotation_difference(Vector(axis)).to_matrix().to_4x4()
    return Matrix.Translation(Vector(place)) @ turned


@sessions.suspended()
def stop_here(obj: Object, deformer: SinewDeformer, row: SinewControl) -> None:
    """Let the path of a tool lead through where it is now."""
    if row.rest is None or row.missing:
        raise SinewError(f"{row.name} is not bound yet - press Rebind")
    depsgraph = bpy.context.evaluated_depsgraph_get()
    world = np.array(row.object.evaluated_get(depsgraph).matrix_world, dtype=np.float64)
    target = np.array(obj.evaluated_get(depsgraph).matrix_world, dtype=np.float64)
    frame = frames.transformed(frames.inverse(target, obj.name) @ world, AXES)
    frame = frames.transformed(frames.inverse(rest_frame.matrix(deformer), obj.name), frame)
    TOOLS.set_stops(row, np.concatenate((TOOLS.stops(row), frame)))
    obj.update_tag()


@sessions.suspended()
def forget_stops(obj: Object, row: SinewControl) -> None:
    """Let a tool go straight from rest to where it is."""
    if row.rest is not None:
        TOOLS.set_stops(row, np.zeros((0, 3)))
        obj.update_tag()


def stop_count(row: SinewControl) -> int:
    """How many stops the path of a tool has."""
    return 0 if row.rest is None else len(row.rest.vertices) // len(AXES) - 1
