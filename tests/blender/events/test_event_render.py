# SPDX-License-Identifier: GPL-3.0-or-later
"""Playback, subframes, motion blur, F12 while the viewport differs, pictures, and renders by another Blender.

A viewport render (``render.opengl``) needs a window: ``tests/gui`` has it. Playback by
``screen.animation_play`` needs one, too; what it does in the background is the same change of frames.
"""

import math
from pathlib import Path

import bpy
import numpy as np
import pytest
from events import ALL, REGIONS, Event, Table, every, is_over
from mathutils import Euler, Matrix
from probe import Probe, render
from registry import BY_ID, WITH_CAGE, WITH_HANDLES
from rigs import rig as scenes
from rigs.kinds import RIGS, HandleRig
from second_blender import another_blender, by_command_line, is_executable, is_wine

LAST = 20
EVENTS = Table()


# --- an animated control

RIGS_AND_METHODS = [("handles", method) for method in WITH_HANDLES]
RIGS_AND_METHODS += [(kind, new.methods[0]) for kind, new in RIGS.items() if kind != "handles"]


@pytest.fixture(params=RIGS_AND_METHODS, ids=" ".join)
def animated(request: pytest.FixtureRequest) -> HandleRig:
    """An even motion, turned by 60 degrees and lifted by one at the last frame."""
    kind, method = request.param
    rig = RIGS[kind].new().start(method)
    rig.control.rotation_mode = "XYZ"
    still = {"location": (0.0, 0.0, 0.0), "rotation_euler": (0.0, 0.0, 0.0)}
    turned = {"location": (0.0, 0.0, 1.0), "rotation_euler": (math.radians(60.0), 0.0, 0.0)}
    scenes.key(rig.control, {1: still, LAST: turned}, linear=True)
    bpy.context.scene.frame_set(1)
    # an iterative method answers within its own tolerance
    rig.exactness = 1e-3 if BY_ID[method].iterative else max(scenes.MATRIX, 2 * rig.tolerance)
    return rig


def at_frame(rig: HandleRig, frame: float, away: Matrix | None = None) -> np.ndarray:
    """What to see by the motion in closed form, about the control's place at rest."""
    share = (frame - 1.0) / (LAST - 1.0)
    rest = rig.control.matrix_parent_inverse
    turn = Euler((math.radians(60.0) * share, 0.0, 0.0)).to_matrix().to_4x4()
    pose = rest @ Matrix.Translation((0.0, 0.0, share)) @ turn @ rest.inverted()
    return rig.poses.shape(pose if away is None else away @ pose)


def test_playback_in_every_direction_and_speed(animated: HandleRig):
    """Forward, backward, jumps, subframes, frames before and after the keys."""
    forward = [float(frame) for frame in range(1, LAST + 1)]
    slow = [3.0 + 0.25 * step for step in range(9)]
    for frame in (*forward, *forward[::-3], 17.0, 2.0, -5.0, 40.0, *slow, 1.0):
        whole = math.floor(frame)
        bpy.context.scene.frame_set(whole, subframe=frame - whole)
        assert animated.shows(at_frame(animated, frame), tolerance=animated.exactness), frame


def test_scrubbing_and_edits_in_turn(animated: HandleRig):
    """The frame changes, the user moves something else, drags the control without a key, scrubs on.

    F12 shows the keys. In the background Blender then sets the frame again, and so takes the drag back; a
    window goes on showing it (``tests/gui``).
    """

    def keyed(frame: int) -> np.ndarray:
        """Where the target has gone from a control that does not ride along."""
        rides = animated.control.parent
        return at_frame(animated, frame, None if rides else animated.obj.matrix_world.inverted())

    exactness = animated.exactness
    for frame in (5, 12):
        bpy.context.scene.frame_set(frame)
        animated.obj.location.x += 0.5
        scenes.update()
        assert animated.shows(keyed(frame), tolerance=exactness)
        animated.lift(0.3)
        assert animated.shows(animated.now(), tolerance=exactness)
        assert not animated.shows(keyed(frame), tolerance=0.1)
    assert animated.renders(keyed(12), exactness)
    assert animated.shows(animated.now(), tolerance=exactness)
    bpy.context.scene.frame_set(8)
    assert animated.shows(keyed(8), tolerance=exactness)


def test_motion_blur_sees_the_shapes_between_frames(animated: HandleRig):
    """As Cycles asks for them: before, at, and after the frame."""
    scene = bpy.context.scene
    scene.frame_set(10)
    viewport = animated.points()
    subframes = (0.75, 0.25, 0.0, 0.5)
    for subframe, seen in zip(subframes, render(subframes=subframes), strict=True):
        assert scenes.close(seen[animated.name], at_frame(animated, 10.0 + subframe), animated.exactness)
    assert np.array_equal(animated.points(), viewport)
    assert (scene.frame_current, scene.frame_subframe) == (10, 0.0)


@pytest.mark.parametrize("persistent", [False, True])
def test_an_animation_leaves_the_viewport_at_its_frame(animated: HandleRig, persistent: bool):
    """``persistent``: Blender keeps the render's own scene between frames."""
    scene = bpy.context.scene
    scene.render.use_persistent_data = persistent
    scene.frame_set(4)
    viewport = animated.points()
    scene.frame_start, scene.frame_end, scene.frame_step = 9, 13, 2
    for _ in range(2):
        seen = render(animation=True)
        assert Probe.frames == [9, 11, 13]
        for frame, shapes in zip(Probe.frames, seen, strict=True):
            assert scenes.close(shapes[animated.name], at_frame(animated, frame), animated.exactness)
        assert scene.frame_current == 4
        assert np.array_equal(animated.points(), viewport)


# --- edits and keys of its own settings


@EVENTS.on(ALL)
def rendered_right_after_edits(rig: HandleRig) -> None:
    """That nothing else evaluated."""
    rig.control.location.z += 0.25
    rig.height += 0.25
    assert rig.renders(rig.at(0.75))
    rig.deformer.factor = 0.5
    half = 0.5 * rig.rest() + 0.5 * rig.at(0.75)
    assert rig.renders(half)
    assert rig.shows(half)
    rig.deformer.factor = 1.0


@EVENTS.on(ALL, then=is_over)
def edited_between_renders_with_persistent_data(rig: HandleRig) -> None:
    bpy.context.scene.render.use_persistent_data = True
    for _ in range(3):
        rig.lift(0.25)
        assert rig.renders(rig.at(rig.height))
        assert rig.is_right()
    rig.press("unbind")
    assert rig.renders(rig.rest())


@EVENTS.on(ALL)
def its_factor_keyed(rig: HandleRig) -> None:
    scenes.key(rig.deformer, {1: {"factor": 0.0}, 11: {"factor": 1.0}})
    for frame, share in ((1, 0.0), (6, 0.5), (11, 1.0)):
        bpy.context.scene.frame_set(frame)
        assert rig.shows((1.0 - share) * rig.rest() + share * rig.at(0.5), tolerance=1e-5)
        assert rig.deformer.proxy_render is not None


@EVENTS.on(REGIONS)
def a_parameter_keyed(rig: HandleRig) -> None:
    scenes.key(rig.deformer.parameters, {1: {"stretching": 0.0}, 11: {"stretching": 1.0}})
    bpy.context.scene.frame_set(1)
    smooth = rig.points()
    bpy.context.scene.frame_set(11)
    assert np.abs(rig.points() - smooth).max() > 1e-3
    bpy.context.scene.frame_set(1)


@every(EVENTS)
def test_a_rig_lives_through(posed: HandleRig, event: Event):
    event.run(posed)


# --- pictures


def render_image(size: int, engine: str = "CYCLES") -> np.ndarray:
    """The current frame along y, six units wide; brightness (rows from below, columns)."""
    scene = bpy.context.scene
    if scene.camera is None:
        scene.camera = scenes.linked(bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera")))
        scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 6.0
        turn = Matrix.Rotation(math.pi / 2.0, 4, "X")
        scene.camera.matrix_world = Matrix.Translation((0.0, -10.0, 0.0)) @ turn
    render, scene.view_settings.view_transform = scene.render, "Standard"
    render.engine, render.filepath, render.dither_intensity = engine, f"{bpy.app.tempdir}sinew.png", 0.0
    render.resolution_x, render.resolution_y, render.resolution_percentage = size, size, 100
    render.image_settings.file_format, render.image_settings.color_mode = "PNG", "RGB"
    if engine == "CYCLES":
        scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.device = 4, False, "CPU"
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(render.filepath, check_existing=False)
    pixels = np.array(image.pixels[:]).reshape(size, size, 4)[:, :, 0]
    bpy.data.images.remove(image)
    return pixels - pixels[0, 0]


@pytest.fixture
def glowing(plate: scenes.Rig) -> scenes.Rig:
    """White, whatever the light, and free to follow its control as a whole."""
    plate.bind(fixed=False)
    material = bpy.data.materials.new("Glow")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    emission, output = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("Emission", "OutputMaterial"))
    tree.links.new(emission.outputs[0], output.inputs[0])
    plate.obj.data.materials.append(material)
    bpy.context.scene.world.use_nodes = False
    bpy.context.scene.world.color = (0.0, 0.0, 0.0)
    return plate


@pytest.mark.parametrize("engine", ["CYCLES", "BLENDER_WORKBENCH"])
def test_the_picture_shows_the_pose(glowing: scenes.Rig, engine: str):
    """One unit of height is a sixth of the image: the brightest rows rise as far as the handle does."""
    if engine == "BLENDER_WORKBENCH" and is_wine():
        pytest.skip("without a screen Wine has no OpenGL, and any Blender ends where it renders by it")
    glowing.obj.rotation_euler.x = 0.2  # seen a little from above, else it has no height
    scenes.update()
    heights = []
    for height in (0.0, 1.5):
        glowing.control.matrix_basis = Matrix.Identity(4)
        glowing.lift(height)
        bright = np.clip(render_image(96, engine), 0.0, None)
        assert bright.sum() > 0.0
        heights.append((bright.sum(axis=1) * np.arange(96)).sum() / bright.sum())
    assert heights[1] - heights[0] == pytest.approx(1.5 * 96 / 6.0, abs=1.0)  # about a pixel


def test_motion_blur_in_a_picture(glowing: scenes.Rig):
    """Half a frame of shutter on each side smears the plate over the way it goes in one frame."""
    scenes.key_heights(glowing.control, {1: -1.0, 2: 1.0}, linear=True)
    glowing.obj.rotation_euler.x = 0.1
    scene = bpy.context.scene
    rows = []
    for blurred in (False, True):
        scene.render.use_motion_blur = blurred
        if hasattr(scene.render, "motion_blur_shutter"):
            scene.render.motion_blur_shutter = 1.0
        scene.frame_set(1, subframe=0.5)
        lit = np.flatnonzero(render_image(48).max(axis=1) > 0.02)
        rows.append(lit.max() - lit.min() + 1)
    travelled = 2.0 * 48 / 6.0  # two units a frame, the picture is six units high
    assert rows[1] - rows[0] == pytest.approx(travelled, abs=4.0)  # four samples a pixel


# --- by another Blender


@pytest.fixture
def shot(animated: HandleRig, tmp_path: Path) -> str:
    """A saved file whose animation is to be rendered; the viewport stands at another frame."""
    scene = bpy.context.scene
    render()  # gives it a camera
    scene.frame_start, scene.frame_end, scene.frame_step = 5, 14, 3
    scene.render.filepath = str(tmp_path / "picture")
    scene.frame_set(2)
    return scenes.save(tmp_path / "shot.blend")


ITERATIVE = next(method for method in WITH_HANDLES if BY_ID[method].iterative)
FARM = [("handles", ITERATIVE), ("cage", WITH_CAGE[0])]


@pytest.mark.parametrize("animated", FARM[:1], indirect=True, ids=" ".join)
def test_blender_b_a(animated: HandleRig, shot: str, tmp_path: Path, addon_name: str):
    """The farm's way: one frame, and the whole animation with that frame, bit for bit."""
    if not is_executable():
        pytest.skip("Blender as a module has no command line")
    frames, shapes = by_command_line(shot, tmp_path, addon_name, animated.name)
    assert frames == [11, 5, 8, 11, 14]
    for frame, shape in zip(frames, shapes, strict=True):
        assert scenes.close(shape, at_frame(animated, frame), animated.exactness)
    assert np.array_equal(shapes[0], shapes[3])


@pytest.mark.parametrize("animated", FARM, indirect=True, ids=" ".join)
def test_another_process_renders_the_same_bits(
    animated: HandleRig, shot: str, tmp_path: Path, addon_name: str
):
    """What a farm's machine renders, one frame first, then all in turn, equals what playing reaches here."""
    here = {}
    for frame in range(5, 15):
        bpy.context.scene.frame_set(frame)
        here[frame] = animated.points()
    script = f"""
        import probe
        bpy.ops.wm.open_mainfile(filepath={shot!r})
        bpy.context.scene.frame_set(11)
        shapes, frames = probe.render(), [11]
        shapes, frames = shapes + probe.render(animation=True), frames + list(probe.Probe.frames)
        seen["frames"], seen["shapes"] = frames, [shape[{animated.name!r}].tolist() for shape in shapes]
        """
    found = another_blender(script, tmp_path, addon_name)
    assert found["frames"] == [11, 5, 8, 11, 14]
    for frame, shape in zip(found["frames"], found["shapes"], strict=True):
        assert np.array_equal(np.array(shape), here[frame])
