# SPDX-License-Identifier: GPL-3.0-or-later
"""A script copies a rig in the background, where no timer runs: the copy is a rig of its own at once.

The scripts call nothing of ours, and they wait for nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from inside import calls_of
from libraries import add_collection, overridden, put_into_a_library
from probe import render
from rigs.kinds import RIGS, HandleRig
from rigs.rig import MATRIX, close, linked, load, make_active, save, update


def by_the_operator(rig: HandleRig) -> bpy.types.Object:
    make_active(rig.obj)
    bpy.ops.object.duplicate()
    return bpy.context.object


def by_the_operator_with_its_control(rig: HandleRig) -> bpy.types.Object:
    make_active(rig.obj)
    rig.control.select_set(True)
    bpy.ops.object.duplicate()
    return bpy.context.object


def by_the_operator_on_the_same_mesh(rig: HandleRig) -> bpy.types.Object:
    make_active(rig.obj)
    bpy.ops.object.duplicate(linked=True)
    return bpy.context.object


def by_the_operator_that_moves_it(rig: HandleRig) -> bpy.types.Object:
    make_active(rig.obj)
    bpy.ops.object.duplicate_move(TRANSFORM_OT_translate={"value": (0.0, 0.0, 0.1)})
    return bpy.context.object


def on_the_same_mesh(rig: HandleRig) -> bpy.types.Object:
    return linked(rig.obj.copy())


def with_a_mesh_of_its_own(rig: HandleRig) -> bpy.types.Object:
    copy = rig.obj.copy()
    copy.data = rig.obj.data.copy()
    return linked(copy)


def of_a_copy_of_a_copy(rig: HandleRig) -> bpy.types.Object:
    return linked(linked(rig.obj.copy()).copy())


def by_a_second_append(rig: HandleRig) -> bpy.types.Object:
    path = save(rig.folder / "library.blend", copy=True)
    with bpy.data.libraries.load(path) as (_source, wanted):
        wanted.objects = [rig.name]
    linked(rig.control_of(wanted.objects[0]))
    return linked(wanted.objects[0])


def by_the_operator_that_appends(rig: HandleRig) -> bpy.types.Object:
    path, known = save(rig.folder / "library.blend", copy=True), set(bpy.data.objects)
    bpy.ops.wm.append(directory=f"{path}/Object/", filename=rig.name)
    return next(obj for obj in bpy.context.scene.objects if obj not in known and obj.sinew.deformers)


COPIES: list[Callable[[HandleRig], bpy.types.Object]] = [
    by_the_operator,
    by_the_operator_with_its_control,
    by_the_operator_on_the_same_mesh,
    by_the_operator_that_moves_it,
    on_the_same_mesh,
    with_a_mesh_of_its_own,
    of_a_copy_of_a_copy,
    by_a_second_append,
    by_the_operator_that_appends,
]


@pytest.mark.parametrize("made", COPIES, ids=lambda made: made.__name__)
def test_a_copy_is_a_rig_of_its_own_at_once(posed: HandleRig, made: Callable):
    """It moves away from its control, and the original does not. Then controls move, and it is rendered."""
    copy = made(posed)
    copy.location.z -= 0.4
    update()
    assert copy.sinew.deformers[0].uid != posed.deformer.uid
    for height in (0.0, 0.25):
        posed.lift(height)
        assert posed.shows(posed.now(copy), copy, tolerance=MATRIX)
        assert posed.is_right()
    assert np.abs(posed.now(copy) - posed.at(posed.height)).max() > 0.1
    seen = render()[-1]
    for obj in (copy, posed.obj):
        assert close(seen[obj.name], posed.now(obj), max(MATRIX, posed.tolerance))


def test_a_copy_made_between_two_frames(posed: HandleRig):
    """Nothing is evaluated before the next frame is."""
    copy = linked(posed.obj.copy())
    copy.location.z -= 0.4
    bpy.context.scene.frame_set(7)
    assert posed.shows(posed.now(copy), copy, tolerance=MATRIX)
    assert posed.is_right()


def test_a_full_copy_of_the_scene(posed: HandleRig):
    first = bpy.context.scene
    bpy.ops.scene.new(type="FULL_COPY")
    second = next(scene for scene in bpy.data.scenes if scene != first)
    copy = next(obj for obj in second.objects if obj.sinew.deformers)
    posed.control_of(copy).location.z += 0.25
    for scene in (second, first):
        scene.view_layers[0].update()
    assert posed.shows_in(second, posed.at(0.75), copy)
    assert posed.shows_in(first, posed.at(0.5))


def test_copies_in_a_file_that_an_autosave_left(posed: HandleRig):
    """No handler ran when it was written, so its copies share their shapes until it is opened."""
    handlers = list(bpy.app.handlers.depsgraph_update_post), list(bpy.app.handlers.save_pre)
    copy = linked(posed.obj.copy()).name
    try:
        for running in (bpy.app.handlers.depsgraph_update_post, bpy.app.handlers.save_pre):
            running.clear()
        path = save(posed.folder / "autosave.blend", copy=True)
    finally:
        for running, before in zip(
            (bpy.app.handlers.depsgraph_update_post, bpy.app.handlers.save_pre), handlers, strict=True
        ):
            running.extend(before)
    load(path)
    bpy.data.objects[copy].location.z -= 0.4
    assert posed.shows(posed.now(bpy.data.objects[copy]), bpy.data.objects[copy], tolerance=MATRIX)
    assert posed.is_right()


def test_an_override_that_a_script_makes(tmp_path: Path):
    """It can be posed at once, without a bind."""
    rig = RIGS["handles"].new().start()
    rig.lift(0.5)
    poses, name = rig.poses, rig.name
    path = put_into_a_library(tmp_path / "library.blend", rig.obj, rig.control)
    asset = add_collection(path, link=True)
    asset.override_hierarchy_create(bpy.context.scene, bpy.context.view_layer)
    obj = overridden()
    assert obj.name == name
    rig.lift_of(obj, 0.25)
    assert rig.shows(poses.lifted(0.75), obj, tolerance=MATRIX)


def test_without_copies_an_update_looks_at_no_object(posed: HandleRig):
    """Only when their number has changed."""
    update()
    found = calls_of(lambda: posed.lift(0.1))
    assert found["has_copies"] > 0
    assert "_scan" not in found
