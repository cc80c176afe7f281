# SPDX-License-Identifier: GPL-3.0-or-later
"""A script copies a rig in the background, where no timer runs: the copy is a rig of its own at once.

The scripts call nothing of ours, and they wait for nothing.
"""

from collections.abc import Callable

import bpy
import numpy as np
import pytest
from inside import calls_of, settle
from probe import render
from rigs.kinds import HandleRig
from rigs.rig import MATRIX, close, duplicated, linked, load, make_active, save, update


def by_the_operator_that_moves_it(rig: HandleRig) -> bpy.types.Object:
    make_active(rig.obj)
    bpy.ops.object.duplicate_move(TRANSFORM_OT_translate={"value": (0.0, 0.0, 0.1)})
    return bpy.context.object


def with_a_mesh_of_its_own(rig: HandleRig) -> bpy.types.Object:
    copy = rig.obj.copy()
    copy.data = rig.obj.data.copy()
    return linked(copy)


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


def by_copy_and_paste(rig: HandleRig) -> bpy.types.Object:
    """With its control, through a file of Blender's own."""
    make_active(rig.obj, rig.control)
    bpy.ops.view3d.copybuffer()
    bpy.ops.view3d.pastebuffer(autoselect=True)
    return next(obj for obj in bpy.data.objects if obj.sinew.deformers and obj != rig.obj)


COPIES: dict[str, Callable[[HandleRig], bpy.types.Object]] = {
    "by_the_operator": lambda rig: duplicated(rig.obj),
    "by_the_operator_with_its_control": lambda rig: duplicated(rig.obj, rig.control),
    "by_the_operator_on_the_same_mesh": lambda rig: duplicated(rig.obj, linked=True),
    "by_the_operator_that_moves_it": by_the_operator_that_moves_it,
    "on_the_same_mesh": lambda rig: linked(rig.obj.copy()),
    "with_a_mesh_of_its_own": with_a_mesh_of_its_own,
    "of_a_copy_of_a_copy": lambda rig: linked(linked(rig.obj.copy()).copy()),
    "by_a_second_append": by_a_second_append,
    "by_the_operator_that_appends": by_the_operator_that_appends,
    "by_copy_and_paste": by_copy_and_paste,
}


@pytest.mark.parametrize("made", COPIES.values(), ids=COPIES)
def test_a_copy_is_a_rig_of_its_own_at_once(posed: HandleRig, made: Callable):
    """It moves away from its control, and the original does not. Then controls move, and it is rendered."""
    copy = made(posed)
    copy.location.z -= 0.4
    update()
    assert copy.sinew.deformers[0].uid != posed.deformer.uid
    for height in (0.0, 0.25, -0.1):
        posed.lift(height)
        assert posed.shows(posed.now(copy), copy, tolerance=MATRIX)
        assert posed.is_right()
        bpy.context.scene.frame_set(bpy.context.scene.frame_current + 1)
        settle()
    assert copy.sinew.deformers[0].proxy != posed.deformer.proxy
    assert np.abs(posed.now(copy) - posed.at(posed.height)).max() > 0.1
    seen = render()[-1]
    for obj in (copy, posed.obj):
        assert close(seen[obj.name], posed.now(obj), max(MATRIX, posed.tolerance))


def test_a_copy_made_between_two_frames(posed: HandleRig):
    copy = linked(posed.obj.copy())
    copy.location.z -= 0.4
    bpy.context.scene.frame_set(7)
    assert posed.shows(posed.now(copy), copy, tolerance=MATRIX)
    assert posed.is_right()


def test_copies_in_a_file_that_an_autosave_left(posed: HandleRig):
    """No handler ran when it was written, so its copies share their shapes until it is opened."""
    copy = linked(posed.obj.copy()).name
    running = (bpy.app.handlers.depsgraph_update_post, bpy.app.handlers.save_pre)
    before = [list(handlers) for handlers in running]
    for handlers in running:
        handlers.clear()
    path = save(posed.folder / "autosave.blend", copy=True)
    for handlers, kept in zip(running, before, strict=True):
        handlers.extend(kept)
    load(path)
    bpy.data.objects[copy].location.z -= 0.4
    assert posed.shows(posed.now(bpy.data.objects[copy]), bpy.data.objects[copy], tolerance=MATRIX)
    assert posed.is_right()


def test_without_copies_an_update_looks_at_no_object(posed: HandleRig):
    update()
    found = calls_of(lambda: posed.lift(0.1))
    assert found["has_copies"] > 0
    assert "_scan" not in found
