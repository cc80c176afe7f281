# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts the controls of handles back to where they rest."""

from collections.abc import Callable, Iterator
from itertools import groupby

import bpy
import numpy as np
from bpy.types import Depsgraph, Object
from mathutils import Matrix

from ....core.geometry import frames
from ....properties import SinewDeformer, SinewHandle
from ...datablocks.evaluation_driver import Link
from .. import movers
from ..objects import UNPOSED, is_posed, reset_object
from . import points, poses, riding


def reset(obj: Object, deformer: SinewDeformer, wanted: Callable[[Link], bool]) -> list[Link]:
    """Put the controls that are wanted back to where they rest. Bones come after those that carry them."""
    found: list[Link] = []
    rows = [(handle, link) for handle, link in _resting(deformer) if wanted(link)]
    for _depth, together in groupby(sorted(rows, key=_depth_of), key=_depth_of):
        if found:
            bpy.context.view_layer.update()
        for handle, link in together:
            _reset(obj, deformer, handle)
            found.append(link)
    return found


def not_at_rest(obj: Object, deformer: SinewDeformer, depsgraph: Depsgraph) -> list[Link]:
    """The controls that are not at rest."""
    return [link for handle, link in _resting(deformer) if _is_posed(obj, deformer, handle, depsgraph)]


def _resting(deformer: SinewDeformer) -> Iterator[tuple[SinewHandle, Link]]:
    """The handles whose control is there, can be moved, and has a rest."""
    for handle in deformer.handles:
        if handle.kind != "HANDLE" or handle.control_missing or not handle.has_rest:
            continue
        control, bone = handle.control, handle.bone
        if control is not None and control.library is None and (not bone or bone in control.pose.bones):
            yield handle, Link(control, bone)


def _depth_of(row: tuple[SinewHandle, Link]) -> int:
    """How many bones carry the control."""
    link = row[1]
    return len(link.object.pose.bones[link.bone].parent_recursive) + 1 if link.bone else 0


def _reset(obj: Object, deformer: SinewDeformer, handle: SinewHandle) -> None:
    if points.are_apart(deformer, handle) and not handle.bone and handle.rest is not None:
        reset_object(obj, deformer, handle.control, handle.rest)
        return
    rest = riding.rest_of(handle)
    if riding.is_carried(obj, handle):
        basis = frames.inverse(riding.stand_of(handle), handle.name) @ rest
        movers.move_by_itself(handle.control, Matrix(basis.tolist()))
        return
    world = np.array(obj.matrix_world, dtype=np.float64) @ riding.surface_of(deformer, handle) @ rest
    movers.move_to(handle.control, handle.bone, Matrix(world.tolist()))


def _is_posed(obj: Object, deformer: SinewDeformer, handle: SinewHandle, depsgraph: Depsgraph) -> bool:
    if points.are_apart(deformer, handle):
        place = points.place_of(deformer, handle, depsgraph)
        return place is not None and handle.rest is not None and is_posed(obj, deformer, place, handle.rest)
    control = poses.present(obj, deformer, handle, depsgraph)
    rest = riding.rest_of(handle)
    return control is not None and not np.abs(control - rest).max() <= UNPOSED * np.abs(rest).max()
