# SPDX-License-Identifier: GPL-3.0-or-later
"""Lets the Factor of a deformer follow how far a bone is bent. Main thread only."""

import math

import numpy as np
from bpy.types import Object, ShapeKey

from ...core.errors import SinewError
from ...properties import SinewDeformer, row_at
from ..datablocks.movers import armatures_of

_STRAIGHT = math.radians(1.0)  # what is bent less is not bent


def drive(deformer: SinewDeformer, armature: Object, bone: str, full: float = 0.0) -> float:
    """Let Factor be 0 while the bone is at rest, and 1 where it is bent by the angle ``full``, or as now.

    Returns this angle. How the bone is twisted does not count.
    """
    full = full or bend_of(armature, bone)
    if not full >= _STRAIGHT:  # nor is it a number where a bone has none
        raise SinewError(f"{bone} is not bent now - go to the frame where it is, or set Full At")
    deformer.driver_remove("factor")
    curve = deformer.driver_add("factor")
    for made_with_it in (curve.modifiers, curve.keyframe_points):  # one or the other, as releases differ
        while len(made_with_it):
            made_with_it.remove(made_with_it[0])
    for at, value in ((0.0, 0.0), (full, 1.0)):
        curve.keyframe_points.insert(at, value).interpolation = "LINEAR"
    curve.driver.type = "SUM"
    variable = curve.driver.variables.new()
    variable.name, variable.type = "bend", "TRANSFORMS"
    target = variable.targets[0]
    target.id, target.bone_target = armature, bone
    target.transform_space, target.rotation_mode = "LOCAL_SPACE", "SWING_TWIST_Y"
    target.transform_type = "ROT_W"
    return full


def bend_of(armature: Object, name: str) -> float:
    """By which angle a bone is bent from its rest, as its parent carries that, without its twist."""
    bone = armature.pose.bones.get(name)
    if bone is None:
        raise SinewError(f"{armature.name} has no bone '{name}' - choose another one")
    local = armature.convert_space(pose_bone=bone, matrix=bone.matrix, from_space="POSE", to_space="LOCAL")
    return local.to_quaternion().to_swing_twist("Y")[0].angle


def bent_bone(obj: Object, deformer: SinewDeformer) -> tuple[Object, str] | None:
    """The bone that is bent now whose joint is nearest to the active handle; without one, the most bent."""
    bent = [
        (armature, bone, bend)
        for armature in armatures_of(obj)
        for bone in armature.pose.bones
        if bone.bone.use_deform and (bend := bend_of(armature, bone.name)) >= _STRAIGHT
    ]
    if not bent:
        return None
    handle = row_at(deformer.handles, deformer.active_handle)
    away = [-bend for _armature, _bone, bend in bent]
    if handle is not None and handle.control is not None:
        place = handle.control.matrix_world.translation
        away = [(armature.matrix_world @ bone.head - place).length for armature, bone, _bend in bent]
    armature, bone, _bend = bent[int(np.argmin(away))]
    return armature, bone.name


def take_driver(obj: Object, index: int, key: ShapeKey) -> None:
    """Let the value of a shape key follow what drives the Factor of a deformer, if anything does."""
    path = f"sinew.deformers[{index}].factor"
    driven = obj.animation_data.drivers.find(path) if obj.animation_data is not None else None
    if driven is None:
        return
    keys = obj.data.shape_keys
    data = keys.animation_data or keys.animation_data_create()
    data.drivers.from_existing(src_driver=driven).data_path = key.path_from_id("value")
