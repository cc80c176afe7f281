# SPDX-License-Identifier: GPL-3.0-or-later
"""Removes controls and vertex groups that were made for handles. Main thread only."""

import bpy
from bpy.types import Object

from ....properties import SinewDeformer, SinewHandle, deformers_of
from ..objects import forget_row_rest


def release(obj: Object, deformer: SinewDeformer) -> None:
    """Remove the controls and the vertex groups that were made for the handles of a deformer."""
    for handle in deformer.handles:
        forget_row_rest(handle)
        release_control(handle)
        release_group(obj, deformer, handle)


def release_control(handle: SinewHandle) -> None:
    """Remove the empty that was made for a handle, unless another handle uses it."""
    control, handle.control = handle.control, None
    if control is None or not handle.owns_control or control.library is not None or deformers_of(control):
        return
    used = any(
        other.control == control
        for obj in bpy.data.objects
        for deformer in deformers_of(obj)
        for other in deformer.handles
    )
    if not used:
        bpy.data.objects.remove(control)


def release_group(obj: Object, deformer: SinewDeformer, handle: SinewHandle) -> None:
    """Remove the vertex group that was made for a handle, unless another handle uses it."""
    if not handle.owns_group:
        return
    shared = any(
        other.vertex_group == handle.vertex_group and other.uid != handle.uid
        for any_deformer in obj.sinew.deformers
        for other in any_deformer.handles
    )
    group = obj.vertex_groups.get(handle.vertex_group)
    if group is not None and not shared:
        obj.vertex_groups.remove(group)
