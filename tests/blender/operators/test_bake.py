# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked shapes equal the live ones to the last bit, and go without a trace."""

from itertools import product
from pathlib import Path

import bpy
import numpy as np
import pytest
from baking import (
    CACHES,
    FRAMES,
    STRETCHES,
    TARGETS,
    animate,
    assert_same,
    bake,
    footprint,
    played,
    stretch_time,
)
from inside import inner
from mathutils import Matrix
from probe import render_points
from registry import WITH_HANDLES
from rigs import rig as scenes


@pytest.mark.parametrize("method", WITH_HANDLES)
@pytest.mark.parametrize("target", TARGETS)
def test_baked_frames_equal_live_ones_to_the_last_bit(
    plate: scenes.Rig, tmp_path: Path, target: str, method: str
):
    plate.bind(method)
    animate(plate.control)
    before, live = footprint(plate), played(plate.obj)
    bake(plate, target, tmp_path / "plate")
    assert "Baked frames 1-8" in plate.deformer.status
    assert_same(played(plate.obj), live)
    bpy.ops.sinew.unbake()
    assert_same(played(plate.obj), live)
    bpy.context.scene.frame_set(before["frame"])
    assert footprint(plate) == before
    assert "bound in" in plate.deformer.status


@pytest.mark.parametrize("target", TARGETS)
def test_controls_have_no_effect_while_baked_and_nothing_is_solved(
    moving: scenes.Rig, tmp_path: Path, target: str, monkeypatch: pytest.MonkeyPatch
):
    """Between frames the shape is blended, and outside it holds."""
    live = played(moving.obj)
    bake(moving, target, tmp_path / "plate")
    calls = []
    monkeypatch.setattr(inner.solving, "solve", lambda *_: calls.append(1))
    control = moving.control
    control.animation_data_clear()
    scenes.move_world(control, Matrix.Translation((0.0, 0.0, 3.0)))
    assert_same(played(moving.obj), live)
    found = played(moving.obj, [3.25, -4, 20])
    assert np.abs(found[3.25] - (live[3] * 0.75 + live[4] * 0.25)).max() < 1e-6
    assert np.array_equal(found[-4], live[1])
    assert np.array_equal(found[20], live[8])
    assert not calls


HEADS = {  # of the formats: the numbers before the samples, and their types
    "PC2": ("S12,<i4,<i4,<f4,<f4,<i4", (b"POINTCACHE2", 1, 121, 1.0, 1.0, 8)),
    "MDD": (">i4,>i4," + ",".join([">f4"] * 8), (8, 121, *(np.arange(1, 9, dtype="f4") / 24.0))),
}


@pytest.mark.parametrize("target", CACHES)
def test_a_file_holds_what_its_format_says_and_renders_show_it(
    moving: scenes.Rig, tmp_path: Path, target: str
):
    """Also where it is invoked without a window."""
    bpy.context.scene.render.fps = 24
    live = played(moving.obj)
    scenes.make_active(moving.obj)
    path = tmp_path / f"plate.{target.lower()}"
    assert bpy.ops.sinew.bake("INVOKE_DEFAULT", target=target, filepath=str(path)) == {"FINISHED"}
    assert_same(played(moving.obj), live)
    (kinds, wanted), content = HEADS[target], path.read_bytes()
    head = np.frombuffer(content, dtype=kinds, count=1)
    assert head[0].item()[:3] == wanted[:3]
    assert head[0].item()[3:] == pytest.approx(wanted[3:], abs=1e-7)
    samples = np.frombuffer(content, dtype=kinds[0:1].replace("S", "<") + "f4", offset=head.nbytes)
    assert np.array_equal(samples.reshape(8, -1, 3), np.array([live[frame] for frame in FRAMES]))
    bpy.context.scene.frame_set(5)
    assert np.array_equal(render_points(moving.obj), live[5])


@pytest.mark.parametrize("target", CACHES)
def test_what_comes_before_and_factor_and_mask_are_in_the_cache(
    plate: scenes.Rig, tmp_path: Path, target: str
):
    """An armature, and a subdivision, whose fine mesh it holds."""
    armature = scenes.add_armature(plate.obj)
    scenes.subdivided(plate.obj)
    plate.bind("arap")
    animate(plate.control)
    bone = armature.pose.bones["high"]
    scenes.key(bone, {1: {"location": (0.0, 0.0, 0.0)}, 8: {"location": (0.03, 0.0, 0.3)}})
    scenes.add_group(plate.obj, "Right", lambda point: point[0] > 0.1)
    plate.deformer.mask_group, plate.deformer.factor = "Right", 0.6
    live = played(plate.obj)
    assert np.abs(live[8] - live[1]).max() > 0.3
    bake(plate, target, tmp_path / "plate")
    plate.deformer.factor = 0.1
    armature.animation_data_clear()
    bone.location = (5.0, 5.0, 5.0)
    assert_same(played(plate.obj), live)


@pytest.mark.parametrize("target", TARGETS)
def test_later_modifiers_act_on_the_baked_shape(plate: scenes.Rig, tmp_path: Path, target: str):
    plate.bind("thin_shell")
    animate(plate.control)
    armature = scenes.add_armature(plate.obj)
    armature.pose.bones["high"].location = (0.0, 0.1, 0.4)
    plate.obj.modifiers.new("Subdivision", "SUBSURF").levels = 1
    live, objects = played(plate.obj), len(bpy.data.objects)
    assert len(live[1]) > len(plate.rest())
    bake(plate, target, tmp_path / "plate")
    assert len(bpy.data.objects) == objects
    assert_same(played(plate.obj), live)
    if target == "PC2":
        assert (tmp_path / "plate.pc2").stat().st_size == 32 + 8 * len(plate.rest()) * 12
    armature.pose.bones["high"].location = (0.0, 0.0, 0.0)
    assert not np.array_equal(played(plate.obj, [8])[8], live[8])


def fill_at_random(path: Path, frames: range) -> np.ndarray:
    """The shapes of a baked cache, whose neighbours then differ in every bit."""
    samples = np.memmap(path, dtype="<f4", offset=32, mode="r+").reshape(len(frames), -1, 3)
    samples[:] = np.random.default_rng(1).normal(size=samples.shape)
    samples.flush()
    return samples


def test_shape_keys_are_what_an_artist_expects(moving: scenes.Rig):
    live = played(moving.obj)
    bake(moving, "SHAPE_KEYS", exact_keys=False)
    keys = moving.obj.data.shape_keys
    assert [key.name for key in keys.key_blocks] == ["Basis", *(f"Sheet {frame}" for frame in FRAMES)]
    bpy.context.scene.frame_set(3)
    assert [key.value for key in keys.key_blocks][1:] == [0, 0, 1, 0, 0, 0, 0, 0]
    assert np.array_equal(scenes.coordinates(keys.key_blocks["Sheet 5"].data), live[5])
    now = played(moving.obj)
    assert max(np.abs(now[frame] - live[frame]).max() for frame in FRAMES) < 2e-7  # Blender's float32 sum


def test_shape_keys_of_the_user_stay_as_they_are(plate: scenes.Rig):
    obj = plate.obj
    wave = scenes.add_key(obj, "Wave", scenes.slope(0.2))
    scenes.key(wave, {1: {"value": 0.0}, 8: {"value": 1.0}})
    obj.active_shape_key_index = 1
    plate.bind("thin_shell")
    animate(plate.control)

    def keyed() -> list[tuple]:
        assert obj.active_shape_key.name == "Wave"
        return [tuple(point.co) for point in scenes.curves_of(obj.data.shape_keys)[0].keyframe_points]

    live = played(obj)
    bpy.context.scene.frame_set(1)
    before, curves = footprint(plate), keyed()
    bake(plate, "SHAPE_KEYS")
    now = played(obj)
    off = max(np.abs(now[frame] - live[frame]).max() for frame in FRAMES)
    assert off < 5e-7  # the sum of two keys in float32
    bpy.ops.sinew.unbake()
    bpy.context.scene.frame_set(before["frame"])
    assert footprint(plate) == before
    assert keyed() == curves
    assert_same(played(obj), live)


@pytest.mark.parametrize("step", [2, 3, 7])
@pytest.mark.parametrize("target", TARGETS)
def test_a_step_keeps_its_frames_exact_and_blends_between(
    moving: scenes.Rig, tmp_path: Path, target: str, step: int
):
    """The current frame comes back."""
    scene, frames = bpy.context.scene, range(2, 10, step)
    live = played(moving.obj, frames)
    scene.frame_set(3, subframe=0.25)
    bake(moving, target, tmp_path / "plate", step=step, frame_start=2, frame_end=9)
    assert (scene.frame_current, scene.frame_subframe) == (3, 0.25)
    assert_same(played(moving.obj, frames), live)
    between = played(moving.obj, [3])[3]
    expected = live[2] * (1.0 - 1.0 / step) + live[2 + step] * (1.0 / step)
    assert np.abs(between - expected).max() < 1e-5
    assert moving.deformer.bake.last == max(frames)


@pytest.mark.parametrize("stretch", STRETCHES)
@pytest.mark.parametrize("target", TARGETS)
def test_time_stretching_plays_the_frames_of_the_scene(
    moving: scenes.Rig, tmp_path: Path, target: str, stretch: tuple[int, int]
):
    stretch_time(*stretch)
    live = played(moving.obj)
    assert np.abs(live[8] - live[1]).max() > 0.3
    bake(moving, target, tmp_path / "plate")
    assert_same(played(moving.obj), live)
    bpy.ops.sinew.unbake()
    assert_same(played(moving.obj), live)


LATE = (range(1001, 1122, 3), range(9000, 9281, 7), range(-50, 151, 5), range(30000, 30041))
LONG = (range(1, 251), range(1001, 1100, 2), range(-50, 60, 5))


@pytest.mark.parametrize(
    ("stretch", "frames"), [*product([(100, 100)], LATE), *product(STRETCHES, LONG)], ids=str
)
def test_caches_of_long_and_late_shots_play_exactly_or_are_refused(
    moving: scenes.Rig, tmp_path: Path, stretch: tuple[int, int], frames: range
):
    stretch_time(*stretch)
    moving.control.animation_data_clear()
    ends = {"frame_start": frames[0], "frame_end": frames[-1], "step": frames.step}
    try:
        bake(moving, "PC2", tmp_path / "plate", **ends)
    except RuntimeError as error:
        refusals = {1001: "Time Stretching", 9000: "step of 1, 2 or 4"}
        assert refusals[frames[0]] in str(error)  # noqa: PT017
        assert (frames[0] == 1001) == (stretch != (100, 100))
        assert not moving.deformer.bake.is_baked
        return
    samples = fill_at_random(tmp_path / "plate.pc2", frames)
    for frame, points in played(moving.obj, frames).items():
        assert np.array_equal(points, samples[frames.index(frame)])


# Alembic


def test_alembic_holds_the_result_or_says_why_not(saved: scenes.Rig, tmp_path: Path):
    scenes.make_active(saved.obj)
    saved.obj.modifiers.new("Subdivision", "SUBSURF").levels = 1
    saved.obj.modifiers["Subdivision"].render_levels = 1
    if not bpy.app.build_options.alembic:
        scenes.refused("without Alembic", "bake", target="ALEMBIC")
        return
    live = played(saved.obj)
    bpy.context.scene.frame_set(3)
    before = footprint(saved)
    assert bpy.ops.sinew.bake(target="ALEMBIC") == {"FINISHED"}
    assert footprint(saved) == before
    assert saved.obj.select_get()
    (file,) = tmp_path.rglob("*.abc")
    assert [path for path in tmp_path.rglob("*") if "part" in path.name] == []
    bpy.ops.wm.alembic_import(filepath=str(file), as_background_job=False)
    imported = next(
        obj for obj in bpy.data.objects if any(m.type == "MESH_SEQUENCE_CACHE" for m in obj.modifiers)
    )
    for frame, points in played(imported).items():
        assert np.array_equal(points, live[frame])
    scenes.make_active(saved.obj)
    saved.obj.hide_render = True
    scenes.refused("hidden in renders", "bake", target="ALEMBIC")
    saved.obj.hide_render = False
    scenes.refused("Step", "bake", target="ALEMBIC", step=2)
