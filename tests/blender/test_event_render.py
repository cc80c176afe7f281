# SPDX-License-Identifier: GPL-3.0-or-later
"""Playback, subframes, motion blur, F12 while the viewport differs, and renders by another Blender.

A viewport render (``render.opengl``) needs a window: ``tests/gui`` has it. Playback by
``screen.animation_play`` needs one, too; what it does in the background is the same change of frames.
"""

import json
import math
import os
import subprocess
from pathlib import Path

import bpy
import numpy as np
import pytest
from expected import Expected, Poses
from mathutils import Euler, Matrix
from probe import Probe, render, render_points
from registry import BY_ID, WITH_CAGE, WITH_HANDLES
from rig import MATRIX, Rig, close, make_active, update
from rigs import RIGS, HandleRig
from second_blender import another_blender, is_executable
from test_time import curves_of, glow, render_image

LAST = 20


def animate(rig: HandleRig) -> None:
    """A straight, even motion: turned by 60 degrees and lifted by one at the last frame."""
    control = rig.control
    control.rotation_mode = "XYZ"
    for frame, share in ((1, 0.0), (LAST, 1.0)):
        control.location = (0.0, 0.0, share)
        control.rotation_euler = (math.radians(60.0) * share, 0.0, 0.0)
        control.keyframe_insert("location", frame=frame)
        control.keyframe_insert("rotation_euler", frame=frame)
    for curve in curves_of(control):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
        curve.extrapolation = "LINEAR"


def pose_at(rig: HandleRig, frame: float) -> Matrix:
    """The motion in closed form, about the control's place at rest."""
    share = (frame - 1.0) / (LAST - 1.0)
    rest = rig.control.matrix_parent_inverse
    turn = Euler((math.radians(60.0) * share, 0.0, 0.0)).to_matrix().to_4x4()
    return rest @ Matrix.Translation((0.0, 0.0, share)) @ turn @ rest.inverted()


RIGS_AND_METHODS = [("handles", method) for method in WITH_HANDLES]
RIGS_AND_METHODS += [(kind, new.methods[0]) for kind, new in RIGS.items() if kind != "handles"]


@pytest.fixture(params=RIGS_AND_METHODS, ids=" ".join)
def animated(request: pytest.FixtureRequest) -> tuple[HandleRig, Poses, float]:
    """A rig, what to expect of it, and how exactly: an iterative method answers within its own tolerance."""
    kind, method = request.param
    rig = RIGS[kind].new()
    expected = rig.start(method)
    animate(rig)
    bpy.context.scene.frame_set(1)
    return rig, expected, 1e-3 if BY_ID[method].iterative else max(MATRIX, 2 * rig.tolerance)


def test_playback_in_every_direction_and_speed(animated):
    """Forward, backward, jumps, subframes, frames before and after the keys."""
    plate, expected, limit = animated
    forward = [float(frame) for frame in range(1, LAST + 1)]
    slow = [3.0 + 0.25 * step for step in range(9)]
    for frame in (*forward, *forward[::-3], 17.0, 2.0, -5.0, 40.0, *slow, 1.0):
        whole = math.floor(frame)
        bpy.context.scene.frame_set(whole, subframe=frame - whole)
        assert close(plate.points(), expected.shape(pose_at(plate, frame)), limit), frame


def away(rig: HandleRig) -> Matrix:
    """Where the target has gone from a control that does not ride along."""
    return Matrix.Identity(4) if rig.control.parent else rig.obj.matrix_world.inverted()


def test_scrubbing_and_edits_in_turn(animated):
    """The frame changes, the user moves something else, drags the control without a key, scrubs on."""
    plate, expected, limit = animated
    scene = bpy.context.scene
    for frame in (5, 12):
        scene.frame_set(frame)
        plate.obj.location.x += 0.5
        update()
        assert close(plate.points(), expected.shape(away(plate) @ pose_at(plate, frame)), limit)
        plate.lift(0.3)
        assert close(plate.points(), expected.now(plate.obj, plate.control), limit)
        assert not close(plate.points(), expected.shape(away(plate) @ pose_at(plate, frame)), 0.1)
    scene.frame_set(8)
    assert close(plate.points(), expected.shape(away(plate) @ pose_at(plate, 8.0)), limit)


def test_motion_blur_sees_the_shapes_between_frames(animated):
    """As Cycles asks for them: before, at, and after the frame."""
    plate, expected, limit = animated
    scene = bpy.context.scene
    scene.frame_set(10)
    viewport = plate.points()
    subframes = (0.75, 0.25, 0.0, 0.5)
    for subframe, seen in zip(subframes, render(subframes=subframes), strict=True):
        assert close(seen[plate.name], expected.shape(pose_at(plate, 10.0 + subframe)), limit)
    update()
    assert np.array_equal(plate.points(), viewport)
    assert scene.frame_current == 10
    assert scene.frame_subframe == 0.0


def test_motion_blur_in_a_picture(plate: Rig):
    """Half a frame of shutter on each side smears the plate over the way it goes in one frame."""
    plate.bind(fixed=False)
    glow(plate.obj)
    for frame, height in ((1, -1.0), (2, 1.0)):
        plate.control.location.z = height
        plate.control.keyframe_insert("location", frame=frame)
    for curve in curves_of(plate.control):
        curve.extrapolation = "LINEAR"
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    plate.obj.rotation_euler.x = 0.1
    scene = bpy.context.scene
    rows = []
    for blurred in (False, True):
        scene.render.use_motion_blur = blurred
        if hasattr(scene.render, "motion_blur_shutter"):
            scene.render.motion_blur_shutter = 1.0
        scene.frame_set(1, subframe=0.5)
        pixels = render_image(48)
        lit = np.flatnonzero(pixels.max(axis=1) - pixels[0, 0] > 0.02)
        rows.append(lit.max() - lit.min() + 1)
    travelled = 2.0 * 48 / 6.0  # two units a frame, the picture is six units high
    assert rows[1] - rows[0] == pytest.approx(travelled, abs=4.0)  # four samples a pixel


def test_f12_while_the_viewport_shows_an_unkeyed_pose(animated):
    """The render shows the keys. In the background Blender then sets the frame again, and so takes the drag
    back; a window goes on showing it (``tests/gui``).
    """
    plate, expected, limit = animated
    bpy.context.scene.frame_set(7)
    plate.lift(0.4)
    assert close(plate.points(), expected.now(plate.obj, plate.control), limit)
    assert not close(plate.points(), expected.shape(pose_at(plate, 7.0)), 0.1)
    assert close(render_points(plate.obj), expected.shape(pose_at(plate, 7.0)), limit)
    assert close(plate.points(), expected.now(plate.obj, plate.control), limit)


def test_f12_right_after_an_edit_that_nothing_evaluated(plate: Rig):
    plate.bind()
    expected = Expected.of_rig(plate)
    plate.control.location.z += 0.5
    assert close(render_points(plate.obj), expected.lifted(0.5))
    plate.deformer.factor = 0.5
    assert close(render_points(plate.obj), 0.5 * plate.rest() + 0.5 * expected.lifted(0.5))
    assert close(plate.points(), 0.5 * plate.rest() + 0.5 * expected.lifted(0.5))


@pytest.mark.parametrize("persistent", [False, True])
def test_an_animation_leaves_the_viewport_at_its_frame(animated, persistent: bool):
    """``persistent``: Blender keeps the render's own scene between frames."""
    plate, expected, limit = animated
    scene = bpy.context.scene
    scene.render.use_persistent_data = persistent
    scene.frame_set(4)
    viewport = plate.points()
    scene.frame_start, scene.frame_end, scene.frame_step = 9, 13, 2
    for _ in range(2):
        seen = render(animation=True)
        assert Probe.frames == [9, 11, 13]
        for frame, shapes in zip(Probe.frames, seen, strict=True):
            assert close(shapes[plate.name], expected.shape(pose_at(plate, frame)), limit)
        update()
        assert scene.frame_current == 4
        assert np.array_equal(plate.points(), viewport)


def test_edits_between_renders_with_persistent_data(plate: Rig):
    plate.bind()
    expected = Expected.of_rig(plate)
    bpy.context.scene.render.use_persistent_data = True
    for height in (0.25, 0.5, 0.75):
        plate.lift(0.25)
        assert close(render_points(plate.obj), expected.lifted(height))
        assert close(plate.points(), expected.lifted(height))
    make_active(plate.obj)
    bpy.ops.sinew.unbind()
    assert close(render_points(plate.obj), plate.rest())


SET_UP = """
import sys
sys.path.insert(0, {here!r})
import addon_utils, bpy
addon_utils.enable({addon!r}, default_set=True)
import probe
bpy.context.scene.render.engine = probe.Probe.bl_idname
"""

TELL = """
import json, probe
names = [shapes[{name!r}].tolist() for shapes in probe.Probe.seen]
open({answer!r}, "w", encoding="utf-8").write(json.dumps([probe.Probe.frames, names]))
"""


def by_command_line(path: str, folder: Path, addon_name: str, name: str, *arguments: str) -> tuple:
    """``blender -b FILE -P set_up -a -P tell``: frames, and the points of the object at each."""
    answer = folder / "answer.json"
    set_up, tell = folder / "set_up.py", folder / "tell.py"
    set_up.write_text(SET_UP.format(here=str(Path(__file__).parent), addon=addon_name), encoding="utf-8")
    tell.write_text(TELL.format(name=name, answer=str(answer)), encoding="utf-8")
    command = [bpy.app.binary_path, "-b", "--factory-startup"]
    command += ["--python-use-system-env"] if "PYTHONPATH" in os.environ else []
    command += [path, "-P", str(set_up), *arguments, "-P", str(tell)]
    ended = subprocess.run(command, timeout=120, capture_output=True, text=True, check=False)
    said = ended.stdout + ended.stderr
    assert "Traceback" not in said, said
    frames, shapes = json.loads(answer.read_text(encoding="utf-8"))
    return frames, [np.array(shape) for shape in shapes]


@pytest.fixture
def render_file(animated, tmp_path: Path) -> tuple[str, Rig, Expected, float]:
    """A saved file whose animation is to be rendered; the viewport stands at another frame."""
    plate, expected, limit = animated
    scene = bpy.context.scene
    render()  # gives it a camera
    scene.frame_start, scene.frame_end, scene.frame_step = 5, 14, 3
    scene.render.filepath = str(tmp_path / "picture")
    scene.frame_set(2)
    path = str(tmp_path / "shot.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    return path, plate, expected, limit


@pytest.mark.parametrize("animated", [("handles", WITH_HANDLES[-1])], indirect=True, ids=" ".join)
def test_blender_b_a(render_file, tmp_path: Path, addon_name: str):
    """The farm's way: the whole animation by one process; one frame by a process of its own, bit for bit."""
    if not is_executable():
        pytest.skip("Blender as a module has no command line")
    path, plate, expected, limit = render_file
    frames, shapes = by_command_line(path, tmp_path, addon_name, plate.name, "-a")
    assert frames == [5, 8, 11, 14]
    for frame, shape in zip(frames, shapes, strict=True):
        assert close(shape, expected.shape(pose_at(plate, frame)), limit)
    alone = by_command_line(path, tmp_path, addon_name, plate.name, "-f", "11")
    assert alone[0] == [11]
    assert np.array_equal(alone[1][0], shapes[2])


@pytest.mark.parametrize(
    "animated", [("handles", WITH_HANDLES[-1]), ("cage", WITH_CAGE[0])], indirect=True, ids=" ".join
)
def test_another_process_renders_the_same_bits(render_file, tmp_path: Path, addon_name: str):
    """A frame that a farm's machine renders first equals the one reached here by playing."""
    path, plate, _expected, _limit = render_file
    here = {}
    for frame in range(5, 15):
        bpy.context.scene.frame_set(frame)
        here[frame] = plate.points()
    found = another_blender(
        f"""
        import probe
        bpy.ops.wm.open_mainfile(filepath={path!r})
        seen["shapes"] = [shapes[{plate.name!r}].tolist() for shapes in probe.render(animation=True)]
        seen["frames"] = list(probe.Probe.frames)
        """,
        tmp_path,
        addon_name,
    )
    assert found["frames"] == [5, 8, 11, 14]
    for frame, shape in zip(found["frames"], found["shapes"], strict=True):
        assert np.array_equal(np.array(shape), here[frame])
