# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's undo may bring back a pointer to a removed object as one to the object that holds the pointer.

Whether it does depends on where Blender puts things in memory, so the tests make such a step themselves.
"""

import bpy
import numpy as np
import pytest
from inside import settle
from rigs.rig import Rig, close, duplicated, evaluated_points, push


@pytest.mark.parametrize("lost", [("VIEWPORT",), ("RENDER",), ("VIEWPORT", "RENDER")], ids=str)
def test_a_deformer_finds_its_hidden_shapes_again(plate: Rig, lost: tuple[str, ...]):
    plate.bind()
    plate.lift(0.5)
    moved, shapes = plate.points(), (plate.deformer.proxy.name, plate.deformer.proxy_render.name)
    push("moved")
    for mode in lost:
        plate.deformer.shape(mode).user_remap(plate.obj)
    push("with pointers to the target itself")
    bpy.ops.ed.undo()
    bpy.ops.ed.redo()
    assert (plate.deformer.proxy.name, plate.deformer.proxy_render.name) == shapes
    assert plate.deformer.proxy.users
    assert plate.deformer.proxy_render.users
    assert np.array_equal(plate.points(), moved)
    assert plate.deformer.status_level == "INFO"
    plate.lift(0.5)
    assert close(plate.points()[plate.top], plate.rest()[plate.top] + (0.0, 0.0, 1.0))


def test_a_copy_finds_its_own_shapes_again(plate: Rig):
    plate.bind()
    copy = duplicated(plate.obj)
    settle()
    plate.lift(0.5)
    shapes = [(obj.sinew.deformers[0].proxy.name, evaluated_points(obj)) for obj in (plate.obj, copy)]
    assert shapes[0][0] != shapes[1][0]
    names = plate.obj.name, copy.name
    push("moved")
    for name in names:
        obj = bpy.data.objects[name]
        obj.sinew.deformers[0].proxy.user_remap(obj)
    push("with pointers to the targets themselves")
    bpy.ops.ed.undo()
    bpy.ops.ed.redo()
    for name, (shape, points) in zip(names, shapes, strict=True):
        obj = bpy.data.objects[name]
        assert obj.sinew.deformers[0].proxy.name == shape
        assert np.array_equal(evaluated_points(obj), points)
