# SPDX-License-Identifier: GPL-3.0-or-later
"""The objects and bones that handles follow."""

from collections.abc import Iterator

from bpy.types import Object

from ....properties import SinewDeformer
from ...datablocks.evaluation_driver import Link, find_driver
from .points import are_apart


def links(deformer: SinewDeformer) -> Iterator[Link]:
    """The object or bone of each handle that has a control."""
    for handle in deformer.handles:
        if handle.kind == "HANDLE" and handle.control is not None:
            by_shape = are_apart(deformer, handle) and not handle.bone
            yield Link(handle.control, handle.bone, by_shape)


def follow_renamed_bones(obj: Object) -> bool:
    """Take over the new names of bones, which Blender changes in drivers but not in Sinew's settings.

    Returns whether there were any.
    """
    curve = find_driver(obj)
    kept = list(dict.fromkeys(link for deformer in obj.sinew.deformers for link in links(deformer)))
    if curve is None or len(curve.driver.variables) < len(kept):
        return False
    renamed = False
    for link, variable in zip(kept, curve.driver.variables, strict=False):
        target = variable.targets[0]
        bones = link.object.pose.bones if link.object.pose is not None else ()
        if target.id != link.object or not link.bone or link.bone in bones or target.bone_target not in bones:
            continue
        for deformer in obj.sinew.deformers:
            for handle in deformer.handles:
                if handle.control == link.object and handle.bone == link.bone:
                    had_rest, rest = handle.has_rest, handle.rest
                    handle.bone = target.bone_target
                    handle.has_rest, handle.rest = had_rest, rest
                    renamed = True
    return renamed
