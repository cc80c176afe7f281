# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of deformers that a .blend file stores. Everything else can be computed from them."""

import bpy
from bpy.props import PointerProperty

from . import bake, bone, companion, control, deformer, drag, handle, key, parameters, scene
from .bake import MAX_FRAME
from .bake import TARGETS as BAKE_TARGETS
from .bone import SinewBone
from .control import SinewControl, StoredCage
from .deformer import SinewDeformer, SinewObject, deformers_of, method_items
from .drag import BALANCE, PIXELS, REACH, UNLIMITED, SinewDrag
from .drag import MODES as DRAG_MODES
from .handle import ROLES as HANDLE_ROLES
from .handle import STANDS_ON, SinewHandle
from .key import SinewKey
from .parameters import BASE
from .scene import SinewScene
from .setting import SHARE, field, row_at

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
