# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders where nothing solves, as on a farm, show what the viewport shows, not rest or an older pose."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import addon_utils
import bpy
import numpy as np
import pytest
from libraries import put_into_a_library, read
from mathutils import Matrix
from probe import render, render_points
from rigs import rig as scenes
from rigs.kinds import HandleRig
from second_blender import look_elsewhere as elsewhere

NO_MODULE = """
class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.rpartition(".")[2] == "sinew_native":
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
sys.meta_path.insert(0, Missing())
"""


@contextmanager
def without_our_save_handler() -> Iterator[None]:
    """As an older version, or Blender's timer, saves."""
    handlers = list(bpy.app.handlers.save_pre)
    bpy.app.handlers.save_pre.clear()
    try:
        yield
    finally:
        bpy.app.handlers.save_pre.extend(handlers)


@pytest.fixture
def rendered(posed: HandleRig) -> HandleRig:
    """A render came first, so the shape for renders holds an older pose."""
    assert posed.renders(posed.at(0.5))
    posed.lift(0.25)
    return posed


def seen_elsewhere(rig: HandleRig, *how: str) -> list[np.ndarray]:
    """What another Blender shows of the rig, saved as it is now."""
    return elsewhere(scenes.save(rig.folder / "shot.blend"), rig.name, rig.folder, *how)


def agree(rig: HandleRig, seen: list[np.ndarray], height: float = 0.75) -> None:
    for shape in seen:
        assert scenes.close(shape, rig.at(height), rig.tolerance)


# --- without the add-on


def test_a_render_without_the_add_on_shows_the_pose(posed: HandleRig):
    """That no render has shown before; no older one; and one that a script has moved and saved at once."""
    agree(posed, seen_elsewhere(posed), 0.5)
    assert posed.renders(posed.at(0.5))
    posed.lift(0.25)
    agree(posed, seen_elsewhere(posed))
    assert posed.renders(posed.at(0.75))
    posed.control.location.z += 0.25
    agree(posed, seen_elsewhere(posed), 1.0)
    posed.height += 0.25
    assert posed.is_right()
    assert posed.renders(posed.at(1.0))


def test_factor_and_mask_are_those_of_the_viewport(posed_plate: HandleRig):
    assert posed_plate.renders(posed_plate.at(0.5))
    scenes.add_group(posed_plate.obj, "Left", lambda point: point[0] < 0.0)
    posed_plate.deformer.mask_group, posed_plate.deformer.factor = "Left", 0.25
    shown = posed_plate.points()
    assert not scenes.close(shown, posed_plate.at(0.5), 0.1)
    for shape in seen_elsewhere(posed_plate):
        assert scenes.close(shape, shown)


def test_a_render_after_the_add_on_was_switched_off(rendered: HandleRig, addon_name: str):
    addon_utils.disable(addon_name)
    try:
        shape = render_points(rendered.obj)
    finally:
        addon_utils.enable(addon_name)
    agree(rendered, [shape])


@pytest.mark.parametrize("below", ["rest", "armature"])
def test_other_vertices_in_renders_than_in_the_viewport(plate: scenes.Rig, tmp_path: Path, below: str):
    """They are solved at the save, for what enters then."""
    bone = scenes.add_armature(plate.obj).pose.bones["high"] if below == "armature" else None
    scenes.subdivided(plate.obj, 1, 2)
    plate.bind("thin_shell")
    render_points(plate.obj)
    plate.lift(0.5)
    if bone is not None:
        bone.rotation_euler.x = 0.5
        scenes.update()
    path = scenes.save(tmp_path / "shot.blend")
    shown, rendered = plate.points(), render_points(plate.obj)
    assert len(rendered) > len(shown)
    seen = elsewhere(path, plate.name, tmp_path)
    assert scenes.close(seen[0], shown)
    assert scenes.close(seen[1], rendered)


def test_a_modifier_that_only_renders_show(posed_plate: HandleRig):
    posed_plate.obj.modifiers[0].show_viewport = False
    posed_plate.lift(0.25)
    shown, rendered = seen_elsewhere(posed_plate)
    assert scenes.close(shown, posed_plate.rest())
    assert scenes.close(rendered, posed_plate.at(0.75))


# --- with the add-on, but without a solve


def test_a_render_without_the_native_module(rendered: HandleRig, addon_name: str):
    """Also of a file that was saved without our handler."""
    with without_our_save_handler():
        agree(rendered, seen_elsewhere(rendered, addon_name, NO_MODULE))


def test_a_linked_rig_without_an_override(rendered: HandleRig):
    name = rendered.name
    path = put_into_a_library(rendered.folder / "library.blend", rendered.obj, rendered.control)
    obj = read(path, True, "objects", name)
    bpy.context.scene.collection.objects.link(obj)
    scenes.update()
    agree(rendered, [scenes.evaluated_points(obj), render()[-1][name]])


def test_a_render_while_live_is_off(rendered: HandleRig):
    """Whatever the control does, also since the file was opened; and as before when it is on again."""
    before, rendered.deformer.live = rendered.points(), False
    rendered.lift(0.25)
    assert np.array_equal(rendered.points(), before)
    agree(rendered, [before, render_points(rendered.obj), rendered.points()])
    with without_our_save_handler():
        path = scenes.save(rendered.folder / "shot.blend")
    scenes.load(path)
    agree(rendered, [rendered.points(), render_points(rendered.obj)])
    rendered.deformer.live = True
    assert rendered.renders(rendered.at(1.0))
    assert rendered.is_right()


def test_live_is_off_and_renders_have_other_vertices(plate: scenes.Rig, tmp_path: Path):
    """They show the poses that the viewport shows."""
    scenes.subdivided(plate.obj, 1, 2)
    plate.bind("thin_shell").lift(0.25)
    render_points(plate.obj)
    plate.lift(0.25)
    shown, rendered = plate.points(), render_points(plate.obj)
    plate.lift(-0.5)
    render_points(plate.obj)
    plate.lift(0.5)
    scenes.update()
    plate.deformer.live = False
    plate.lift(0.25)
    assert scenes.close(plate.points(), shown)
    assert scenes.close(render_points(plate.obj), rendered)
    scenes.load(scenes.save(tmp_path / "shot.blend"))
    assert scenes.close(plate.points(), shown)
    assert scenes.close(render_points(plate.obj), rendered, scenes.MATRIX)


def test_frames_that_switch_live_off_keep_the_shape_of_the_frame_before(posed_plate: HandleRig):
    """While an animation is rendered the viewport stays at a frame where it is on."""
    plate, scene = posed_plate, bpy.context.scene
    scenes.key(plate.deformer, {1: {"live": True}, 11: {"live": False}})
    height = plate.control.location.z
    scenes.key_heights(plate.control, {1: height, 10: height + 0.5, 12: height + 0.5})
    scene.frame_set(1)
    scene.frame_start, scene.frame_end = 10, 12
    for shapes in render(animation=True):
        assert scenes.close(shapes[plate.name], plate.at(1.0), scenes.MATRIX)


def test_a_control_that_is_lost_since_the_file_was_opened(rendered: HandleRig):
    shown = rendered.points()
    bpy.data.objects.remove(rendered.control)
    assert rendered.shows(shown)
    with without_our_save_handler():
        path = scenes.save(rendered.folder / "shot.blend")
    scenes.new_file()
    scenes.load(path)
    assert rendered.shows(shown, tolerance=scenes.MATRIX)
    assert rendered.renders(shown, scenes.MATRIX)
    assert rendered.shows(shown, tolerance=scenes.MATRIX)


def test_a_second_deformer_above(posed_plate: HandleRig):
    plate = posed_plate
    plate.bind("arap")
    plate.obj.modifiers.new("Cast", "CAST").factor = 0.2
    plate.obj.modifiers.move(2, 1) if hasattr(plate.obj.modifiers, "move") else None
    render_points(plate.obj)
    plate.control.matrix_world = Matrix.Translation((0.1, 0.0, 0.3)) @ plate.control.matrix_world
    shown = plate.points()
    scenes.make_active(plate.obj)
    for shape in seen_elsewhere(plate):
        assert scenes.close(shape, shown, scenes.FLOAT32)
