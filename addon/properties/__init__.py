# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings saved in the .blend: the only truth about a deformer."""

import bpy
from bpy.props import PointerProperty

from . import deformer, handle, parameters
from .deformer import SinewDeformer, SinewObject, method_items
from .handle import KINDS as HANDLE_KINDS
from .handle import SinewHandle

__all__ = (
    "HANDLE_KINDS",
    "SinewDeformer",
    "SinewHandle",
    "SinewObject",
    "method_items",
    "register",
    "unregister",
)

_CLASSES = (*parameters.GROUPS.values(), handle.SinewHandle, deformer.SinewDeformer, deformer.SinewObject)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Object.sinew = PointerProperty(type=SinewObject, override={"LIBRARY_OVERRIDABLE"})


def unregister() -> None:
    del bpy.types.Object.sinew
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
