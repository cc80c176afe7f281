# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of deformers that a .blend file stores. Everything else can be computed from them."""

import bpy
from bpy.props import PointerProperty

from . import bake, bone, companion, control, deformer, drag, handle, key, parameters, scene
from .bake import BAKE_TARGETS as BAKE_TARGETS, MAX_FRAME as MAX_FRAME
from .bone import SinewBone
from .control import SinewControl as SinewControl, StoredCage as StoredCage
from .deformer import (
    SinewDeformer as SinewDeformer,
    SinewObject,
    deformers_of as deformers_of,
    method_items as method_items,
)
from .drag import (
    BALANCE as BALANCE,
    DRAG_MODES as DRAG_MODES,
    PIXELS as PIXELS,
    REACH as REACH,
    UNLIMITED as UNLIMITED,
    SinewDrag as SinewDrag,
)
from .handle import HANDLE_ROLES as HANDLE_ROLES, STANDS_ON as STANDS_ON, SinewHandle as SinewHandle
from .key import SinewKey as SinewKey
from .parameters import BASE as BASE
from .scene import SinewScene
from .setting import field as field, row_at as row_at

_CLASSES = (
    *parameters.GROUPS.values(),
    bake.SinewBakedKey,
    bake.SinewBake,
    control.SinewControl,
    companion.SinewCompanion,
    handle.SinewHandle,
    key.SinewEdit,
    key.SinewKey,
    deformer.SinewDeformer,
    deformer.SinewObject,
    drag.SinewDrag,
    scene.SinewScene,
    bone.SinewBone,
)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Object.sinew = PointerProperty(type=SinewObject, override={"LIBRARY_OVERRIDABLE"})
    bpy.types.Scene.sinew = PointerProperty(type=SinewScene)
    bpy.types.PoseBone.sinew = PointerProperty(type=SinewBone, override={"LIBRARY_OVERRIDABLE"})


def unregister() -> None:
    del bpy.types.PoseBone.sinew
    del bpy.types.Scene.sinew
    del bpy.types.Object.sinew
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
