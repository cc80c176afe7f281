# SPDX-License-Identifier: GPL-3.0-or-later
"""Apply makes the shape permanent, the way Blender applies its own modifiers."""

import bpy
import numpy as np
import pytest
from registry import WITH_HANDLES
from rigs import rig as scenes


@pytest.fixture
def posed(plate: scenes.Rig) -> scenes.Rig:
    plate.bind("arap").lift(0.7)
    scenes.make_active(plate.obj)
    return plate


def test_apply_keeps_what_is_shown_with_factor_and_mask(posed: scenes.Rig):
    scenes.add_group(posed.obj, "Right", lambda point: point[0] > 0.1)
    posed.deformer.mask_group, posed.deformer.factor = "Right", 0.4
    shown = posed.points()
    bpy.ops.sinew.apply()
    assert np.array_equal(posed.rest(), shown)
    assert not posed.obj.sinew.deformers
    assert not posed.obj.modifiers
    assert [obj.name for obj in bpy.data.objects] == ["Plate"]


def test_later_modifiers_stay_and_show_the_same(posed: scenes.Rig):
    posed.obj.modifiers.new("Subdivision", "SUBSURF").levels = 1
    shown = posed.points()
    bpy.ops.sinew.apply()
    assert [modifier.name for modifier in posed.obj.modifiers] == ["Subdivision"]
    assert np.array_equal(posed.points(), shown)


@pytest.mark.parametrize("method", WITH_HANDLES)
def test_below_an_armature_the_mesh_itself_is_deformed(plate: scenes.Rig, method: str):
    """As Blender applies a modifier that is not first: to the mesh alone."""
    armature = scenes.add_armature(plate.obj)
    plate.bind(method).lift(0.5)
    alone = scenes.Rig(scenes.grid_object("Alone")).bind(method)
    alone.lift(0.5)
    bone = armature.pose.bones["high"]
    bone.location = (0.0, 0.2, 0.1)
    scenes.press(plate.obj, "apply")
    assert np.abs(plate.rest() - alone.points()).max() < scenes.FLOAT32
    assert [modifier.type for modifier in plate.obj.modifiers] == ["ARMATURE"]
    assert plate.obj.modifiers[0].show_viewport
    assert np.abs(plate.points() - plate.rest()).max() > 0.1  # the armature goes on


def test_as_shape_key_adds_a_key_and_leaves_the_mesh(posed: scenes.Rig):
    """One after another while the deformer is kept."""
    rest, shapes = posed.rest(), []
    for keep in (True, False):
        shapes.append(posed.points())
        bpy.ops.sinew.apply(as_shape_key=True, keep_deformer=keep)
        assert np.array_equal(posed.rest(), rest)
        if keep:
            posed.lift(0.2)
    keys = posed.obj.data.shape_keys.key_blocks
    assert [(key.name, key.value) for key in keys[1:]] == [("Sinew", 0.0), ("Sinew.001", 0.0)]
    assert shapes[1][posed.top, 2].max() == pytest.approx(0.9, abs=1e-5)
    assert not posed.obj.modifiers
    assert np.array_equal(posed.points(), rest)
    for key, shape in zip(keys[1:], shapes, strict=True):
        assert np.array_equal(scenes.coordinates(key.data), shape)
        key.value = 1.0
        assert np.abs(posed.points() - shape).max() < scenes.FLOAT32
        key.value = 0.0


def test_apply_in_edit_mode_comes_back_to_edit_mode(posed: scenes.Rig):
    shown = posed.points()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.sinew.apply()
    assert posed.obj.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    assert np.array_equal(posed.rest(), shown)


def test_as_shape_key_beside_keys_of_the_user(plate: scenes.Rig):
    obj = plate.obj
    wave = scenes.add_key(obj, "Wave", scenes.slope(0.2))
    wave.value = 0.5
    waving = plate.points()
    plate.bind().lift(0.7)
    shown = plate.points()
    scenes.refused("Apply as Shape Key", "apply", obj)
    bpy.ops.sinew.apply(as_shape_key=True)
    keys = obj.data.shape_keys.key_blocks
    assert [key.name for key in keys] == ["Basis", "Wave", "Sinew"]
    keys["Sinew"].value = 1.0
    assert np.abs(plate.points() - shown).max() < scenes.FLOAT32
    wave.value = 0.0
    assert np.abs(plate.points() - shown - (plate.rest() - waving)).max() < scenes.FLOAT32
