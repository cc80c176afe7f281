# SPDX-License-Identifier: GPL-3.0-or-later
"""Deformation transfer from one mesh to another with the same faces."""

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import Mock

import bpy
import numpy as np
import pytest
from baking import FRAMES, STRETCHES, animate, played, stretch_time
from inside import inner
from mathutils import Matrix
from rigs.rig import Rig, add_key, fails, key, linked, make_active, save
from second_blender import look_elsewhere


def transfer(source: bpy.types.Object, target: bpy.types.Object, path: Path, /, **keywords) -> set[str]:
    make_active(target, source)
    return bpy.ops.sinew.transfer_deformation(filepath=str(path), **keywords)


@pytest.fixture
def pair(plate: Rig) -> tuple[Rig, bpy.types.Object]:
    """A plate that Sinew moves through the frames, and one of twice the size."""
    plate.bind("arap")
    animate(plate.control)
    stout = linked(bpy.data.objects.new("Stout", plate.obj.data.copy()))
    stout.data.transform(Matrix.Scale(2.0, 4))
    return plate, stout


SPOILED: dict[str, Callable[[bpy.types.Object], object]] = {
    "as it is": lambda target: None,
    "with its faces turned": lambda target: target.data.flip_normals(),
    **{f"in time {old}:{new}": lambda _, old=old, new=new: stretch_time(old, new) for old, new in STRETCHES},
}


@pytest.mark.parametrize("how", SPOILED)
def test_a_target_of_twice_the_size_moves_as_the_source_at_every_frame(pair, tmp_path: Path, how: str):
    plate, target = pair
    SPOILED[how](target)
    bpy.context.scene.frame_set(3)
    assert transfer(plate.obj, target, tmp_path / "stout") == {"FINISHED"}
    assert bpy.context.scene.frame_current == 3
    assert [modifier.type for modifier in target.modifiers] == ["MESH_CACHE"]
    moved = played(target)
    for frame, points in played(plate.obj).items():
        assert np.abs(moved[frame] - 2.0 * points).max() < 1e-5, frame  # float32
    assert np.abs(moved[FRAMES[-1]] - moved[FRAMES[0]]).max() > 0.5


def test_another_transfer_replaces_the_first_and_the_other_modifiers_stay(pair, tmp_path: Path):
    plate, target = pair
    target.modifiers.new("Later", "SMOOTH").factor = 0.0
    for frames in ({}, {"frame_start": 2, "frame_end": 6, "step": 2}):
        transfer(plate.obj, target, tmp_path / "stout.pc2", source=plate.obj.name, **frames)
    assert [modifier.name for modifier in target.modifiers] == [f"{plate.obj.name} Transfer", "Later"]
    content = (tmp_path / "stout.pc2").read_bytes()
    assert len(content) == 32 + 3 * 12 * len(target.data.vertices)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["stout.pc2"]
    for frame, points in played(plate.obj, (2, 4, 6)).items():
        assert np.abs(played(target, (frame,))[frame] - 2.0 * points).max() < 1e-5


def test_a_source_that_is_not_finite_in_a_frame_is_refused_and_no_file_stays(pair, tmp_path: Path):
    plate, target = pair
    broken = add_key(plate.obj, "Broken", Matrix())
    broken.data[3].co.z = float("nan")
    key(broken, {3: {"value": 0.0}, 4: {"value": 1.0}})
    plate.obj.modifiers.clear()
    fails("NaN or infinite", transfer, plate.obj, target, tmp_path / "stout")
    assert not list(tmp_path.iterdir())
    assert not target.modifiers


def test_escape_in_the_middle_leaves_the_disk_and_the_scene_as_they_were(pair, tmp_path: Path):
    """What a window does: some frames at each tick of a timer, until Esc is pressed."""
    plate, target = pair
    bpy.context.scene.frame_set(3)
    said: list[str] = []

    class Operator(inner.frame_by_frame.FrameByFrame):
        doing, did, cancelled = "transferring", "Transferred", "It was cancelled"

        def report(self, _kind: set[str], text: str) -> None:
            said.append(text)

    path, operator = str(tmp_path / "stout"), Operator()
    job = inner.bake.Transferring(plate.obj, target, bpy.context.scene, range(1, 50_000), path)
    operator._job, operator._timer = job, object()
    manager, space = Mock(), Mock()
    context = SimpleNamespace(window_manager=manager, workspace=space)

    def send(kind: str, value: str = "PRESS") -> set[str]:
        return operator.modal(context, SimpleNamespace(type=kind, value=value))

    assert send("TIMER") == send("MOUSEMOVE") == send("ESC", "RELEASE") == {"RUNNING_MODAL"}
    assert 0 < job.done < job.total
    assert list(tmp_path.iterdir())  # a part of the file
    assert send("ESC") == {"CANCELLED"}
    assert said == ["It was cancelled"]
    manager.progress_end.assert_called_once()
    manager.event_timer_remove.assert_called_once()
    assert not list(tmp_path.iterdir())
    assert not target.modifiers
    assert bpy.context.scene.frame_current == 3
    assert transfer(plate.obj, target, tmp_path / "stout") == {"FINISHED"}


def test_a_render_without_the_add_on_shows_the_transfer(pair, tmp_path: Path):
    plate, target = pair
    transfer(plate.obj, target, tmp_path / "stout")
    expected = played(target, (6,))[6]
    bpy.context.scene.frame_set(6)
    path = save(tmp_path / "shot.blend")
    for shape in look_elsewhere(path, target.name, tmp_path):
        assert np.array_equal(shape.astype(np.float32), expected)
