# SPDX-License-Identifier: GPL-3.0-or-later
"""The record of a bake in the settings of a deformer, and how a deformer becomes live again."""

from bpy.types import Object

from ..core import status
from ..core.status import Level, Status
from ..properties import SinewDeformer
from ..session.datablocks.shapes import baked
from ..session.evaluation import binding
from ..session.state import sessions
from ..session.targets import modified
from . import cache, shape_keys


def mark_baked(obj: Object, deformer: SinewDeformer, target: str, frames: range, filepath: str) -> None:
    """Record that a deformer is baked: switch its modifier off, and remember where it was shown."""
    bake, modifier = deformer.bake, modified.shown_by(obj, deformer)
    bake.result, bake.first, bake.last = target, frames[0], frames[-1]
    bake.filepath = filepath or bake.filepath
    bake.show_viewport, bake.show_render = modifier.show_viewport, modifier.show_render
    modifier.show_viewport = modifier.show_render = False
    status.put(deformer.uid, Status(Level.INFO, bake.summary))
    obj.update_tag()


def remove(obj: Object, deformer: SinewDeformer) -> list[str]:
    """Make a deformer live again and remove what its bake added. Returns warnings for the user."""
    bake, warnings = deformer.bake, []
    if not bake.is_baked:
        return warnings
    if bake.result == "SHAPE_KEYS":
        lost = shape_keys.remove(obj, deformer)
        if lost:
            warnings = [f"{lost} baked shape keys were renamed or removed; renamed ones stay on the mesh"]
    else:
        cache.remove(obj, deformer)
    _show(obj, deformer)
    bake.result = "NONE"
    known = sessions.find(deformer.uid)
    bound = known.bound if known is not None else None
    status.put(deformer.uid, Status(Level.INFO, binding.summary(bound)) if bound else status.EMPTY)
    obj.update_tag()
    return warnings


def remove_keys(obj: Object, deformer: SinewDeformer) -> list[str]:
    """Do the same as ``remove`` if the deformer was baked to shape keys."""
    return remove(obj, deformer) if deformer.bake.result == "SHAPE_KEYS" else []


def suspend(obj: Object, deformer: SinewDeformer) -> None:
    """Make a baked deformer live until ``resume``, and hide what the bake added."""
    if deformer.bake.is_baked:
        _show(obj, deformer)
        _hide_baked(obj, deformer, True)
        status.put(deformer.uid, status.EMPTY)


def resume(obj: Object, deformer: SinewDeformer) -> None:
    """Undo ``suspend``."""
    modifier = modified.shown_by(obj, deformer)
    if deformer.bake.is_baked and modifier is not None:
        modifier.show_viewport = modifier.show_render = False
        _hide_baked(obj, deformer, False)


def _show(obj: Object, deformer: SinewDeformer) -> None:
    modifier = modified.shown_by(obj, deformer)
    if modifier is not None:
        modifier.show_viewport, modifier.show_render = deformer.bake.show_viewport, deformer.bake.show_render


def _hide_baked(obj: Object, deformer: SinewDeformer, hidden: bool) -> None:
    if deformer.bake.result == "SHAPE_KEYS":
        shape_keys.mute(obj, deformer, hidden)
        return
    playing = baked.find_cache(obj, deformer)
    if playing is not None:
        playing.show_viewport = deformer.bake.show_viewport and not hidden
        playing.show_render = deformer.bake.show_render and not hidden
