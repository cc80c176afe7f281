# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the selected control active as soon as the artist leaves Edit Mode.

An operator that works in Edit Mode selects the control that it made, but the mesh has to be active there. If
the mesh stayed active afterwards, numbers typed into the Item tab would move it instead of the control.
"""

import bpy
from bpy.types import Object, ViewLayer

from ..core.memory import remember
from ..properties import deformers_of

waiting: dict[str, str] = remember({})  # the control to make active, by the object in Edit Mode
_followed: dict[str, str] = remember({})  # the control that was made active, by the object


def note(obj: Object, control: str) -> None:
    """Make the object of the name ``control``, if there is one, active once ``obj`` leaves Edit Mode."""
    if control:
        waiting[obj.name] = control


def take(obj: Object) -> str:
    """Forget and return what is noted: an operator is about to leave Edit Mode for a moment."""
    return waiting.pop(obj.name, "")


def follow(view_layer: ViewLayer) -> None:
    """Make the noted control active if Edit Mode was left. Called after every edit."""
    for name in list(waiting):
        obj, control = bpy.data.objects.get(name), bpy.data.objects.get(waiting[name])
        if obj is not None and obj.mode == "EDIT":
            continue
        del waiting[name]
        if obj is not None and control is not None:
            _activate(view_layer, obj, control)


def restore(view_layer: ViewLayer) -> None:
    """Do the same after undo and redo: Blender made the step of leaving Edit Mode before ``follow``."""
    obj = view_layer.objects.active
    control = None if obj is None else view_layer.objects.get(_followed.get(obj.name, ""))
    if control is not None:
        _activate(view_layer, obj, control)


def _activate(view_layer: ViewLayer, obj: Object, control: Object) -> None:
    """Make the control active if it is selected and the object, which is active in Object Mode, is not.

    So is its row then: a fixed region that was added last would be mirrored in place of the handle.
    """
    if view_layer.objects.active != obj or obj.mode != "OBJECT" or control.name not in view_layer.objects:
        return
    if control.select_get(view_layer=view_layer) and not obj.select_get(view_layer=view_layer):
        view_layer.objects.active = control
        _followed[obj.name] = control.name
        for deformer in deformers_of(obj):
            rows = [index for index, handle in enumerate(deformer.handles) if handle.control == control]
            if rows:
                deformer.active_handle = rows[0]
