# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes, view layers, exclusions; controls hidden in every way, in viewport and render."""

import bpy
import pytest
from expected import Expected, Poses
from inside import catch_up
from mathutils import Matrix
from probe import render, render_points
from rig import MATRIX, Rig, add_armature, close, evaluated_points, make_active, update
from rigs import HandleRig


def keyed(control: bpy.types.Object, heights: dict[int, float]) -> None:
    for frame, height in heights.items():
        control.location.z = height
        control.keyframe_insert("location", frame=frame)


def own_collection(*objects: bpy.types.Object) -> bpy.types.Collection:
    collection = bpy.data.collections.new("Hidden")
    bpy.context.scene.collection.children.link(collection)
    for obj in objects:
        for other in obj.users_collection:
            other.objects.unlink(obj)
        collection.objects.link(obj)
    update()
    return collection


def layer_collection(layer: bpy.types.ViewLayer | None = None) -> bpy.types.LayerCollection:
    return (layer or bpy.context.view_layer).layer_collection.children["Hidden"]


def hide(obj: bpy.types.Object, way: str) -> None:
    """Each way a user has."""
    if way in ("hide_viewport", "hide_render"):
        setattr(obj, way, True)
    elif way == "eye":
        obj.hide_set(True)
    elif way == "excluded":
        own_collection(obj)
        layer_collection().exclude = True
    elif way == "collection eye":
        own_collection(obj)
        layer_collection().hide_viewport = True
    elif way in ("collection hide_viewport", "collection hide_render"):
        setattr(own_collection(obj), way.split()[1], True)
    elif way == "unlinked":
        for collection in obj.users_collection:
            collection.objects.unlink(obj)


WAYS = (
    "hide_viewport",
    "eye",
    "excluded",
    "collection hide_viewport",
    "hide_render",
    "collection eye",
    "collection hide_render",
    "unlinked",
)


@pytest.mark.parametrize("way", WAYS)
def test_a_hidden_control_still_moves_the_shape(rig: HandleRig, way: str):
    """Animated, in the viewport and in renders; and by hand."""
    moves_though_hidden(rig, rig.start(), rig.control, rig.control, way)


@pytest.mark.parametrize("way", WAYS)
def test_a_hidden_armature_still_moves_its_region(plate: Rig, way: str):
    armature = add_armature(plate.obj)
    plate.obj.modifiers.remove(plate.obj.modifiers["Armature"])
    make_active(plate.obj)
    plate.bind(control_object="Rig", bone="high")
    bone = armature.pose.bones["high"]
    bone.rotation_mode = "XYZ"
    moves_though_hidden(HandleRig.called(plate.name), Expected(plate.obj, plate.obj), armature, bone, way)


def moves_though_hidden(rig: HandleRig, expected: Poses, control: bpy.types.Object, mover, way: str) -> None:
    keyed(mover, {1: 0.0, 11: 1.0})
    hide(control, way)
    if way == "unlinked" and not rig.counts_in_no_scene:
        assert rig.shows(expected.lifted(0.0))
        assert rig.control_is_missing(rig.obj)
        return
    for frame, height in ((11, 1.0), (1, 0.0), (11, 1.0)):
        bpy.context.scene.frame_set(frame)
        assert rig.shows(expected.lifted(height), tolerance=MATRIX)
        assert close(render_points(rig.obj), expected.lifted(height), MATRIX)
        assert rig.shows(expected.lifted(height), tolerance=MATRIX)
    control.animation_data_clear()
    mover.location = (0.0, 0.0, 0.25)
    assert rig.shows(expected.lifted(0.25), tolerance=MATRIX)
    assert close(render_points(rig.obj), expected.lifted(0.25), MATRIX)


@pytest.mark.parametrize("way", [way for way in WAYS if "render" not in way])
def test_a_target_hidden_in_the_viewport_is_right_in_renders_and_when_shown_again(rig: HandleRig, way: str):
    """But an excluded or unlinked one is in no render either, as any object."""
    expected = rig.start()
    keyed(rig.control, {1: 0.0, 11: 1.0})
    bpy.context.scene.frame_set(1)
    hide(rig.obj, way)
    bpy.context.scene.frame_set(11)
    seen = render()[-1]
    if way in ("excluded", "unlinked"):
        assert rig.name not in seen
    else:
        assert close(seen[rig.name], expected.lifted(1.0), rig.tolerance)
    rig.obj.hide_viewport = False
    if way == "eye":
        rig.obj.hide_set(False)
    elif way == "unlinked":
        bpy.context.scene.collection.objects.link(rig.obj)
    elif way != "hide_viewport":
        layer_collection().exclude = layer_collection().hide_viewport = False
        bpy.data.collections["Hidden"].hide_viewport = False
    assert rig.shows(expected.lifted(1.0))
    rig.control.animation_data_clear()
    rig.lift(-0.5)
    assert rig.shows(expected.lifted(0.5))


def test_a_target_hidden_from_renders_is_right_in_the_viewport(rig: HandleRig):
    expected = rig.start()
    keyed(rig.control, {1: 0.0, 11: 1.0})
    rig.obj.hide_render = True
    bpy.context.scene.frame_set(11)
    assert rig.name not in render()[-1]
    assert rig.shows(expected.lifted(1.0))


def test_view_layers_with_exclusions(rig: HandleRig):
    """The control is excluded from one layer, the target from the other; both are rendered."""
    expected = rig.start()
    scene, control = bpy.context.scene, rig.control
    keyed(control, {1: 0.0, 11: 1.0})
    own_collection(control)
    targets = bpy.data.collections.new("Targets")
    scene.collection.children.link(targets)
    scene.collection.objects.unlink(rig.obj)
    targets.objects.link(rig.obj)
    first = bpy.context.view_layer
    second = scene.view_layers.new("Second")
    layer_collection(first).exclude = True
    second.layer_collection.children["Targets"].exclude = True
    third = scene.view_layers.new("Third")
    scene.frame_set(11)
    seen = render(layer="")
    assert [rig.name in layer for layer in seen] == [True, False, True]
    for layer in (seen[0], seen[2]):
        assert close(layer[rig.name], expected.lifted(1.0), rig.tolerance)
    for layer in (first, third):
        layer.update()
        assert close(rig.points_in(layer), expected.lifted(1.0), rig.tolerance)


def test_a_control_moved_in_a_layer_without_the_target(rig: HandleRig):
    expected = rig.start()
    own_collection(rig.obj)
    first = bpy.context.view_layer
    second = bpy.context.scene.view_layers.new("Second")
    layer_collection(second).exclude = True
    rig.control.matrix_basis = Matrix.Translation((0.0, 0.0, 0.5))
    second.update()
    first.update()
    assert rig.shows(expected.lifted(0.5))


# --- several scenes


@pytest.fixture
def two_scenes(rig: HandleRig) -> tuple[bpy.types.Scene, bpy.types.Scene, Expected]:
    """Both show the plate and its control; keyed from 0 at frame 1 to 1 at frame 11."""
    expected = rig.start()
    keyed(rig.control, {1: 0.0, 11: 1.0})
    first = bpy.context.scene
    second = bpy.data.scenes.new("Second")
    second.world = first.world
    for obj in (rig.obj, rig.control):
        second.collection.objects.link(obj)
    first.frame_set(1)
    return first, second, expected


def test_scenes_at_different_frames_share_a_target(rig: HandleRig, two_scenes):
    """Blender has one animated state of an object: what counts is the scene that is looked at, when it is."""
    first, second, expected = two_scenes
    second.frame_set(11)
    assert close(rig.points_in(second.view_layers[0], rig.obj), expected.lifted(1.0), rig.tolerance)
    first.frame_set(1)
    assert rig.shows(expected.lifted(0.0))
    second.frame_set(11)
    assert close(
        rig.points_in(second.view_layers[0], rig.obj),
        expected.lifted(1.0),
        rig.tolerance,
    )
    first.frame_set(11)
    assert rig.shows(expected.lifted(1.0))


def test_rendering_another_scene_leaves_this_one_alone(rig: HandleRig, two_scenes):
    first, second, expected = two_scenes
    second.frame_start = second.frame_end = 11
    first.frame_set(1)
    seen = render(second, animation=True)[-1]
    assert close(seen[rig.name], expected.lifted(1.0), rig.tolerance)
    update()
    assert rig.shows(expected.lifted(0.0))
    assert close(render(first)[-1][rig.name], expected.lifted(0.0), rig.tolerance)


def test_a_scene_without_the_control(rig: HandleRig):
    """The target is linked into another scene alone, its control follows by the driver."""
    expected = rig.start()
    keyed(rig.control, {1: 0.0, 11: 1.0})
    second = bpy.data.scenes.new("Second")
    second.collection.objects.link(rig.obj)
    second.frame_set(11)
    assert close(rig.points_in(second.view_layers[0], rig.obj), expected.lifted(1.0), MATRIX)
    second.frame_start = second.frame_end = 11
    assert close(render(second, animation=True)[-1][rig.name], expected.lifted(1.0), MATRIX)


@pytest.mark.parametrize("kind", ["LINK_COPY", "FULL_COPY"])
def test_a_copied_scene(rig: HandleRig, kind: str):
    """A linked copy shows the same rig, a full copy has one of its own."""
    expected = rig.start()
    rig.lift(0.5)
    first = bpy.context.scene
    bpy.ops.scene.new(type=kind)
    second = next(scene for scene in bpy.data.scenes if scene != first)
    copy = next(obj for obj in second.objects if obj.sinew.deformers)
    assert (copy == rig.obj) == (kind == "LINK_COPY")
    for scene in (first, second):
        scene.view_layers[0].update()
    catch_up()
    rig.control_of(copy).location.z += 0.25
    for scene in (second, first):
        scene.view_layers[0].update()
    seen = rig.points_in(second.view_layers[0], copy)
    assert close(seen, expected.lifted(0.75), rig.tolerance)
    original = rig.points_in(first.view_layers[0], rig.obj)
    assert close(original, expected.lifted(0.75 if kind == "LINK_COPY" else 0.5), rig.tolerance)


def test_the_scene_deleted_that_the_rig_was_made_in(rig: HandleRig):
    expected = rig.start()
    first = bpy.context.scene
    second = bpy.data.scenes.new("Second")
    for obj in (rig.obj, rig.control):
        second.collection.objects.link(obj)
    bpy.data.scenes.remove(first)
    update()
    obj = bpy.data.objects[rig.name]
    control = rig.control_of(obj)
    control.location.z += 0.5
    second.view_layers[0].update()
    assert close(rig.points_in(second.view_layers[0], obj), expected.lifted(0.5), rig.tolerance)
    if bpy.context.scene == second:
        assert close(evaluated_points(obj), expected.lifted(0.5), rig.tolerance)
