# SPDX-License-Identifier: GPL-3.0-or-later
"""Playback, renders and previews: equal inputs give equal bits, whatever came before."""

import math

import bpy
import numpy as np
import pytest
from inside import DRAG, catch_up, use_threads
from mathutils import Matrix
from probe import render_points
from registry import WITH_HANDLES
from rig import Rig, add_armature, evaluated_points, make_active, move_world, update


def animate(plate: Rig) -> None:
    """A bend that grows to 90 degrees at frame 20."""
    control = plate.control
    control.rotation_mode = "XYZ"
    for frame, angle in ((1, 0.0), (20, 90.0)):
        control.rotation_euler = (math.radians(angle), 0.0, 0.0)
        control.location = (0.0, -0.01 * angle, 0.01 * angle)
        control.keyframe_insert("rotation_euler", frame=frame)
        control.keyframe_insert("location", frame=frame)


def add_camera(size: float = 6.0) -> None:
    """Looks along y at the plane of x and z; the image is ``size`` wide."""
    data = bpy.data.cameras.new("Camera")
    data.type, data.ortho_scale = "ORTHO", size
    camera = bpy.data.objects.new("Camera", data)
    camera.matrix_world = Matrix.Translation((0.0, -10.0, 0.0)) @ Matrix.Rotation(math.pi / 2.0, 4, "X")
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera


def render_image(size: int = 64, engine: str = "CYCLES", path: str = "") -> np.ndarray:
    """Render the current frame; brightness (rows from below, columns)."""
    scene = bpy.context.scene
    if scene.camera is None:
        add_camera()
    scene.render.engine = engine
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGB"
    scene.render.dither_intensity = 0.0
    scene.render.filepath = path or bpy.app.tempdir + "sinew.png"
    scene.view_settings.view_transform = "Standard"
    if engine == "CYCLES":
        scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.device = 4, False, "CPU"
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath, check_existing=False)
    pixels = np.array(image.pixels[:]).reshape(size, size, 4)[:, :, 0]
    bpy.data.images.remove(image)
    return pixels


def glow(obj: bpy.types.Object) -> None:
    """White, whatever the light."""
    material = bpy.data.materials.new("Glow")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    emission = tree.nodes.new("ShaderNodeEmission")
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(emission.outputs[0], output.inputs[0])
    obj.data.materials.append(material)
    bpy.context.scene.world.use_nodes = False
    bpy.context.scene.world.color = (0.0, 0.0, 0.0)


def test_render_of_another_frame_leaves_the_viewport_alone(plate: Rig):
    plate.bind()
    animate(plate)
    scene = bpy.context.scene
    scene.frame_set(6)
    viewport = plate.points()
    scene.frame_start, scene.frame_end = 18, 20
    scene.render.filepath = bpy.app.tempdir + "frame"
    add_camera()
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = 1, False
    scene.render.resolution_x = scene.render.resolution_y = 8
    bpy.ops.render.render(animation=True)
    update()
    assert scene.frame_current == 6
    assert np.array_equal(plate.points(), viewport)


@pytest.mark.parametrize("engine", ["CYCLES", "BLENDER_WORKBENCH"])
def test_the_picture_shows_the_pose(plate: Rig, engine: str):
    """One unit of height is a sixth of the image: the brightest rows rise as far as the handle does."""
    plate.bind(fixed=False)
    glow(plate.obj)
    plate.obj.rotation_euler.x = 0.2  # seen a little from above, else it has no height
    update()
    rows = np.arange(96)
    heights = []
    for height in (0.0, 1.5):
        plate.control.matrix_basis = Matrix.Identity(4)
        plate.lift(height)
        pixels = render_image(96, engine)
        bright = np.clip(pixels - pixels[0, 0], 0.0, None)
        assert bright.sum() > 0.0
        heights.append((bright.sum(axis=1) * rows).sum() / bright.sum())
    assert heights[1] - heights[0] == pytest.approx(1.5 * 96 / 6.0, abs=1.0)  # about a pixel


def test_motion_between_frames(plate: Rig):
    plate.bind()
    for frame, height in ((1, 0.0), (2, 1.0)):
        plate.control.location.z = height
        plate.control.keyframe_insert("location", frame=frame)
    for curve in curves_of(plate.control):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    bpy.context.scene.frame_set(1, subframe=0.25)
    assert plate.points()[plate.top, 2] == pytest.approx(0.25, abs=1e-4)


def curves_of(obj: bpy.types.Object) -> list:
    action = obj.animation_data.action
    if hasattr(action, "fcurves"):
        return list(action.fcurves)
    return [
        curve
        for layer in action.layers
        for strip in layer.strips
        for bag in strip.channelbags
        for curve in bag.fcurves
    ]


def test_factor_can_be_keyframed(plate: Rig):
    plate.bind().lift(1.0)
    for frame, factor in ((1, 0.0), (11, 1.0)):
        plate.deformer.factor = factor
        plate.obj.keyframe_insert("sinew.deformers[0].factor", frame=frame)
    for frame, expected in ((1, 0.0), (6, 0.5), (11, 1.0)):
        bpy.context.scene.frame_set(frame)
        assert plate.points()[plate.top, 2] == pytest.approx(expected, abs=1e-5)
        assert plate.deformer.proxy_render is not None
    assert render_points(plate.obj)[plate.top, 2] == pytest.approx(1.0, abs=1e-5)


def test_a_parameter_can_be_keyframed(plate: Rig):
    plate.bind()
    move_world(plate.control, Matrix.Translation((0.0, 0.0, 0.5)))
    for frame, value in ((1, 0.0), (11, 1.0)):
        plate.deformer.parameters.stretching = value
        plate.obj.keyframe_insert("sinew.deformers[0].thin_shell.stretching", frame=frame)
    bpy.context.scene.frame_set(1)
    smooth = plate.points()
    bpy.context.scene.frame_set(11)
    assert np.abs(plate.points() - smooth).max() > 1e-3


@pytest.fixture
def dragged(plate: Rig, room):
    """A plate in the middle of a drag: what a window's handler shows before the pause."""
    plate.bind("arap")
    handlers, handler = (
        bpy.app.handlers.depsgraph_update_post,
        room("handlers.evaluation").on_depsgraph_update,
    )
    handlers.remove(handler)
    motion = Matrix.Translation((0.0, -0.6, 0.9)) @ Matrix.Rotation(math.radians(110.0), 4, "X")
    move_world(plate.control, motion)
    room("session").update(bpy.context.evaluated_depsgraph_get(), preview=True)
    update()
    handlers.append(handler)
    return plate


def final_points(plate: Rig) -> np.ndarray:
    """The answer for the same pose, reached without any preview."""
    basis = plate.control.matrix_basis.copy()
    plate.control.matrix_basis = Matrix.Identity(4)
    update()
    plate.control.matrix_basis = basis
    return plate.points()


def test_a_drag_shows_a_preview_and_settles_to_the_final_answer(dragged: Rig, room):
    plate = dragged
    session = room("session")
    assert session.unsettled() == [plate.deformer.uid]
    preview = evaluated_points(plate.obj)
    assert np.abs(preview[plate.top] - plate.rest()[plate.top]).max() > 0.5  # handles follow at once
    assert session.settle()
    settled = plate.points()
    assert not session.unsettled()
    assert np.array_equal(settled, final_points(plate))


def test_a_heavy_mesh_settles_in_a_thread(dragged: Rig, room, monkeypatch: pytest.MonkeyPatch):
    plate = dragged
    use_threads(monkeypatch)
    session = room("session")
    session.settle()
    update()
    work = session.find(plate.deformer.uid).work
    assert work is not None
    work.thread.join(timeout=20.0)
    catch_up()
    settled = plate.points()
    assert not session.busy()
    assert not session.unsettled()
    monkeypatch.undo()
    assert np.array_equal(settled, final_points(plate))


def test_a_newer_pose_drops_the_final_answer_under_way(dragged: Rig, room, monkeypatch: pytest.MonkeyPatch):
    plate = dragged
    use_threads(monkeypatch)
    session = room("session")
    session.settle()
    update()
    plate.lift(0.1)
    assert session.find(plate.deformer.uid).work is None
    assert not session.unsettled()  # without a window the newer pose is solved to the end
    monkeypatch.undo()
    assert np.array_equal(plate.points(), final_points(plate))


def test_deformers_of_the_other_side_of_an_armature_stay_exact_in_playback(plate: Rig):
    armature = add_armature(plate.obj)
    plate.bind("arap")
    bone = armature.pose.bones["high"]
    for frame, height in ((1, 0.0), (11, 0.5)):
        bone.location = (0.0, 0.0, height)
        bone.keyframe_insert("location", frame=frame)
    make_active(plate.obj)
    bpy.context.scene.frame_set(1)
    bpy.context.scene.frame_set(11)
    once = evaluated_points(plate.obj)
    bpy.context.scene.frame_set(7)
    bpy.context.scene.frame_set(11)
    assert np.array_equal(evaluated_points(plate.obj), once)
    assert np.array_equal(render_points(plate.obj), once)


@pytest.fixture
def heavy_drag(plate: Rig, room, monkeypatch: pytest.MonkeyPatch):
    """A drag of a mesh whose every step costs more than the drag budget; the handler is a window's."""

    def begin(method: str) -> Rig:
        plate.bind(method)
        use_threads(monkeypatch)
        session = room("session").find(plate.deformer.uid)
        session.step_milliseconds = 1e9
        handlers = bpy.app.handlers.depsgraph_update_post
        handlers.remove(room("handlers.evaluation").on_depsgraph_update)
        handlers.append(lambda _scene, depsgraph: room("session").update(depsgraph, preview=True, edit=True))
        return plate

    yield begin
    handler = room("handlers.evaluation").on_depsgraph_update
    bpy.app.handlers.depsgraph_update_post[:] = [handler]


@pytest.mark.parametrize("method", WITH_HANDLES)
def test_a_drag_over_the_budget_never_waits_and_the_shape_follows(heavy_drag, room, method: str):
    plate = heavy_drag(method)
    session = room("session").find(plate.deformer.uid)
    rest = plate.points()
    plate.lift(0.5)
    first = session.work
    assert first is not None  # asked in a thread
    assert np.array_equal(evaluated_points(plate.obj), rest)  # and nobody waited
    first.thread.join(timeout=20.0)
    session.step_milliseconds = 1e9
    plate.lift(0.5)  # the control moves on, the answer for the first place comes in
    assert evaluated_points(plate.obj)[plate.top, 2] == pytest.approx(0.5, abs=1e-6)
    second = session.work
    assert second not in (None, first)
    second.thread.join(timeout=20.0)
    session.step_milliseconds = 1e9
    room("session").collect()
    assert plate.points()[plate.top, 2] == pytest.approx(1.0, abs=1e-6)
    while catch_up() or room("session").unsettled():
        update()
        if session.work is not None:
            session.work.thread.join(timeout=20.0)
    settled = plate.points()
    bpy.app.handlers.depsgraph_update_post[:] = [room("handlers.evaluation").on_depsgraph_update]
    assert np.array_equal(settled, final_points(plate))


def test_the_drag_budget_sets_how_many_steps_a_preview_takes(heavy_drag, room, monkeypatch):
    plate = heavy_drag("arap")
    session = room("session").find(plate.deformer.uid)
    taken = []
    solve = session.bound.factor.solve

    def count(poses, **options):
        positions, report = solve(poses, **options)
        taken.append(options["max_iterations"])
        return positions, report

    session.bound.factor.solve = count
    session.step_milliseconds = 0.0
    for budget, steps in ((1.0e4, 10), (1.0e-4, 1)):
        monkeypatch.setattr(room(DRAG), "budget", lambda budget=budget: budget)
        for _ in range(3):
            plate.lift(0.1)
            session.step_milliseconds = 0.0  # so that nothing goes to a thread
        assert taken[-1] == steps
