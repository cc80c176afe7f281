# SPDX-License-Identifier: GPL-3.0-or-later
"""One relative shape key per frame, with the keyframed values 0, 1, 0.

Blender computes ``basis + value * (key - its reference)`` in float32. This cannot reproduce every position,
since differences below the last bit of the basis are lost. Exact keys are therefore relative to a key of
zeros, which is itself relative to the basis and always on: basis + (0 - basis) is 0, and 0 + (key - 0) is the
key, both without rounding.
"""

import bpy
import numpy as np
from bpy.types import Action, Key, Object, Scene, ShapeKey

from .. import compat
from ..core.errors import SinewError
from ..properties import SinewDeformer
from .stretching import stretch, times

ZERO = "Zero"
_APART = 0.02  # of a frame: Blender takes keyframes that are closer than half of it for one


def require_keys(obj: Object) -> None:
    """Raise an error if this mesh cannot have keyframed shape keys."""
    require_own_mesh(obj)
    if obj.data.library is not None or obj.data.override_library is not None:
        raise SinewError("The mesh is linked, so no shape keys can be added - bake to PC2")
    keys = obj.data.shape_keys
    if keys is None:
        return
    action = _action(keys)
    if not keys.use_relative:
        raise SinewError("The shape keys of the mesh are absolute - make them relative, or bake to PC2")
    if obj.show_only_shape_key:
        raise SinewError("One shape key is pinned - turn Solo Active Shape Key off, or bake to PC2")
    if action is not None and action.library is not None:
        raise SinewError("The action of the shape keys is linked - make it local, or bake to PC2")


def require_room(scene: Scene, frames: range) -> None:
    """Raise an error if Time Stretching brings the keyframes so close that Blender merges them."""
    if frames.step * stretch(scene) < _APART:
        raise SinewError(
            "Time Stretching leaves no room between keyframes - bake to PC2, or with a larger Step"
        )


def require_own_mesh(obj: Object) -> None:
    """Raise an error if other objects share the mesh, since they would show its shape keys, too."""
    if obj.data.users > 1:
        raise SinewError(
            "Other objects share this mesh, and its shape keys show on all of them - make it single-user "
            "first (Object > Relations)"
        )


def basis(obj: Object) -> np.ndarray:
    """The positions that shape keys are added to, float32 (n, 3)."""
    keys = obj.data.shape_keys
    return compat.read_positions(obj.data) if keys is None else compat.read_key(keys.reference_key)


def install(
    scene: Scene,
    obj: Object,
    deformer: SinewDeformer,
    frames: range,
    shapes: list[tuple[np.ndarray, np.ndarray]],
    exact: bool,
) -> None:
    """Add one key per frame of the scene.

    ``shapes`` are those before and after the deformer, float32 (n, 3), per frame.
    """
    bake, active = deformer.bake, obj.active_shape_key_index
    bake.keys.clear()
    bake.made_basis = obj.data.shape_keys is None
    if bake.made_basis:
        obj.shape_key_add(name="Basis", from_mix=False)
    base = basis(obj)
    is_first = all(np.array_equal(entered, base) for entered, _left in shapes)
    zero = None
    if exact and is_first:
        zero = _add(obj, deformer, f"{deformer.name} {ZERO}", np.zeros_like(base))
        zero.value = 1.0
    added = []
    for frame, (entered, left) in zip(frames, shapes, strict=True):
        shape = left if is_first else base + (left - entered)
        key = _add(obj, deformer, f"{deformer.name} {frame}", shape)
        if zero is not None:
            key.relative_key = zero
        added.append(key.name)
    bake.made_action = _action(obj.data.shape_keys) is None
    _animate(obj, dict(zip(frames, times(scene, frames).tolist(), strict=True)), frames.step, added)
    obj.active_shape_key_index = active


def _add(obj: Object, deformer: SinewDeformer, name: str, positions: np.ndarray) -> ShapeKey:
    key = obj.shape_key_add(name=name, from_mix=False)
    key.relative_key = obj.data.shape_keys.reference_key
    key.slider_min, key.slider_max = 0.0, 1.0
    compat.write_key(key, positions)
    deformer.bake.keys.add().name = key.name
    return key


def _animate(obj: Object, timed: dict[int, float], step: int, names: list[str]) -> None:
    """Let each key be on at its frame and blend into its neighbours. The first and the last key stay on.

    ``timed`` has the time of each frame.
    """
    keys = obj.data.shape_keys
    for time, name in zip(timed.values(), names, strict=True):
        keys.key_blocks[name].value = 1.0
        keys.key_blocks[name].keyframe_insert("value", frame=time)
    curves = {curve.data_path: curve for _action, curve in compat.action_curves(keys)}
    for frame, name in zip(timed, names, strict=True):
        curve = curves[_path(name)]
        for neighbour in (frame - step, frame + step):
            if neighbour in timed:
                curve.keyframe_points.insert(timed[neighbour], 0.0, options={"FAST"})
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
        curve.update()


def _path(name: str) -> str:
    return f'key_blocks["{bpy.utils.escape_identifier(name)}"].value'


def mute(obj: Object, deformer: SinewDeformer, muted: bool) -> None:
    """Switch the keys of a bake off, or on again."""
    for key in _keys(obj, deformer):
        key.mute = muted


def _keys(obj: Object, deformer: SinewDeformer) -> list[ShapeKey]:
    keys = obj.data.shape_keys
    blocks = keys.key_blocks if keys is not None else {}
    return [blocks[baked.name] for baked in deformer.bake.keys if baked.name in blocks]


def remove(obj: Object, deformer: SinewDeformer) -> int:
    """Remove the keys of a bake and their animation. Returns how many are not found under their names."""
    require_own_mesh(obj)
    keys, bake = obj.data.shape_keys, deformer.bake
    names = [key.name for key in _keys(obj, deformer)]
    lost = len(bake.keys) - len(names)
    if keys is not None:
        active = obj.active_shape_key
        kept = active.name if active is not None and active.name not in names else ""
        _remove_animation(keys, {_path(name) for name in names}, bake.made_action)
        for name in reversed(names):
            obj.shape_key_remove(keys.key_blocks[name])
        if bake.made_basis and len(keys.key_blocks) == 1:
            obj.shape_key_clear()
        elif kept:
            obj.active_shape_key_index = keys.key_blocks.find(kept)
    bake.keys.clear()
    bake.made_basis = bake.made_action = False
    return lost


def _action(keys: Key) -> Action | None:
    return keys.animation_data.action if keys.animation_data is not None else None


def _remove_animation(keys: Key, paths: set[str], made_action: bool) -> None:
    for action, curve in compat.action_curves(keys):
        if curve.data_path in paths:
            compat.remove_action_curve(action, curve)
    action = _action(keys)
    if not made_action or action is None or compat.action_curves(keys):
        return
    keys.animation_data.action = None
    if action.users == 0:
        bpy.data.actions.remove(action)
    if not keys.animation_data.drivers and not keys.animation_data.nla_tracks:
        keys.animation_data_clear()
