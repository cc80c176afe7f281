# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes, view layers, exclusions, instances; controls hidden in every way, in viewport and render."""

from collections.abc import Callable

import bpy
import pytest
from events import ALL, REGIONS, Event, Table, every, is_over
from expected import Expected
from inside import catch_up
from mathutils import Matrix
from probe import render
from rigs import rig as scenes
from rigs.cages import ball, box, surround
from rigs.kinds import HandleRig

INSTANCES = Table()


def own_collection(*objects: bpy.types.Object) -> bpy.types.Collection:
    collection = bpy.data.collections.new("Hidden")
    bpy.context.scene.collection.children.link(collection)
    for obj in objects:
        unlink(obj)
        collection.objects.link(obj)
    scenes.update()
    return collection


def layer_collection(layer: bpy.types.ViewLayer | None = None) -> bpy.types.LayerCollection:
    return (layer or bpy.context.view_layer).layer_collection.children["Hidden"]


def own_layer_collection(obj: bpy.types.Object) -> bpy.types.LayerCollection:
    own_collection(obj)
    return layer_collection()


def unlink(obj: bpy.types.Object) -> None:
    for collection in obj.users_collection:
        collection.objects.unlink(obj)


WAYS: dict[str, Callable[[bpy.types.Object], None]] = {  # of hiding an object, as a user does
    "hide_viewport": lambda obj: setattr(obj, "hide_viewport", True),
    "eye": lambda obj: obj.hide_set(True),
    "excluded": lambda obj: setattr(own_layer_collection(obj), "exclude", True),
    "collection hide_viewport": lambda obj: setattr(own_collection(obj), "hide_viewport", True),
    "hide_render": lambda obj: setattr(obj, "hide_render", True),
    "collection eye": lambda obj: setattr(own_layer_collection(obj), "hide_viewport", True),
    "collection hide_render": lambda obj: setattr(own_collection(obj), "hide_render", True),
    "unlinked": unlink,
}


@pytest.fixture
def animated(rig: HandleRig) -> HandleRig:
    """Bound; its control is at height 0 at frame 1, which is now, and at 1 at frame 11."""
    rig.start()
    scenes.key_heights(rig.control, {1: 0.0, 11: 1.0})
    bpy.context.scene.frame_set(1)
    return rig


@pytest.mark.parametrize("way", WAYS)
def test_a_hidden_control_still_moves_the_shape(rig: HandleRig, way: str):
    """Animated, in the viewport and in renders; and by hand."""
    rig.start()
    moves_though_hidden(rig, rig.control, rig.control, way)


@pytest.mark.parametrize("way", WAYS)
def test_a_hidden_armature_still_moves_its_region(plate: scenes.Rig, way: str):
    rig = HandleRig.called(plate.name)
    armature = scenes.new_armature(high=((0.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    rig.bind(control_object="Rig", bone="high")
    rig.poses = Expected(rig.obj, rig.obj)
    moves_though_hidden(rig, armature, armature.pose.bones["high"], way)


def moves_though_hidden(rig: HandleRig, control: bpy.types.Object, mover, way: str) -> None:
    scenes.key_heights(mover, {1: 0.0, 11: 1.0})
    WAYS[way](control)
    if way == "unlinked" and not rig.counts_in_no_scene:
        assert rig.shows(rig.at(0.0))
        assert rig.control_is_missing(rig.obj)
        return
    for frame, height in ((11, 1.0), (1, 0.0), (11, 1.0)):
        bpy.context.scene.frame_set(frame)
        assert rig.shows(rig.at(height), tolerance=scenes.MATRIX)
        assert rig.renders(rig.at(height), scenes.MATRIX)
        assert rig.shows(rig.at(height), tolerance=scenes.MATRIX)
    control.animation_data_clear()
    mover.location = (0.0, 0.0, 0.25)
    assert rig.shows(rig.at(0.25), tolerance=scenes.MATRIX)
    assert rig.renders(rig.at(0.25), scenes.MATRIX)


def test_a_target_hidden_from_renders_is_right_in_the_viewport(animated: HandleRig):
    animated.obj.hide_render = True
    bpy.context.scene.frame_set(11)
    assert animated.name not in render()[-1]
    assert animated.shows(animated.at(1.0))


@pytest.mark.parametrize("way", [way for way in WAYS if "render" not in way])
def test_a_target_hidden_in_the_viewport_is_right_in_renders_and_when_shown_again(
    animated: HandleRig, way: str
):
    """But an excluded or unlinked one is in no render either, as any object."""
    obj = animated.obj
    WAYS[way](obj)
    bpy.context.scene.frame_set(11)
    seen = render()[-1]
    if way in ("excluded", "unlinked"):
        assert animated.name not in seen
    else:
        assert scenes.close(seen[animated.name], animated.at(1.0), animated.tolerance)
    obj.hide_viewport = False
    if way == "eye":
        obj.hide_set(False)
    elif way == "unlinked":
        bpy.context.scene.collection.objects.link(obj)
    elif way != "hide_viewport":
        layer_collection().exclude = layer_collection().hide_viewport = False
        bpy.data.collections["Hidden"].hide_viewport = False
    assert animated.shows(animated.at(1.0))
    animated.control.animation_data_clear()
    animated.lift(-0.5)
    assert animated.shows(animated.at(0.5))


def test_view_layers_with_exclusions(animated: HandleRig):
    """The control is excluded from one layer, the target from the other; both are rendered."""
    scene, obj = bpy.context.scene, animated.obj
    own_collection(animated.control)
    targets = bpy.data.collections.new("Targets")
    scene.collection.children.link(targets)
    unlink(obj)
    targets.objects.link(obj)
    first, second = bpy.context.view_layer, scene.view_layers.new("Second")
    layer_collection(first).exclude = True
    second.layer_collection.children["Targets"].exclude = True
    third = scene.view_layers.new("Third")
    scene.frame_set(11)
    seen = render(layer="")
    assert [obj.name in layer for layer in seen] == [True, False, True]
    for layer, shapes in ((first, seen[0]), (third, seen[2])):
        assert scenes.close(shapes[obj.name], animated.at(1.0), animated.tolerance)
        layer.update()
        assert animated.shows_in(layer, animated.at(1.0))


def test_a_control_moved_in_a_layer_without_the_target(rig: HandleRig):
    rig.start()
    own_collection(rig.obj)
    first, second = bpy.context.view_layer, bpy.context.scene.view_layers.new("Second")
    layer_collection(second).exclude = True
    rig.control.matrix_basis = Matrix.Translation((0.0, 0.0, 0.5))
    second.update()
    first.update()
    assert rig.shows(rig.at(0.5))


@pytest.mark.parametrize(
    ("before", "after"), [((0.0, 0.0, 0.0), (-0.75, 0.75, -0.5)), ((0.0, 0.0, -1.0), (0.0, 0.0, -2.0))]
)
def test_a_move_counts_where_blender_has_one_hash_for_both_places(before: tuple, after: tuple):
    target, cage = ball(), box()
    surround(target, cage)
    rest = scenes.evaluated_points(target)
    for place in (before, after):
        cage.location = place
        assert scenes.close(scenes.evaluated_points(target), rest + place, scenes.MATRIX)


# --- several scenes


def second_scene(*objects: bpy.types.Object) -> bpy.types.Scene:
    """With these objects of the first."""
    second = bpy.data.scenes.new("Second")
    second.world = bpy.context.scene.world
    for obj in objects:
        second.collection.objects.link(obj)
    return second


@pytest.mark.parametrize("has_control", [True, False])
def test_scenes_at_different_frames_share_a_target_and_render_apart(animated: HandleRig, has_control: bool):
    """Blender has one animated state of an object: what counts is the scene that is looked at, when it is.

    In a scene without the control it follows by the driver.
    """
    first = bpy.context.scene
    second = second_scene(animated.obj, *[animated.control] * has_control)
    for frame, height in ((1, 0.0), (11, 1.0)):
        second.frame_set(11)
        assert animated.shows_in(second, animated.at(1.0), tolerance=scenes.MATRIX)
        first.frame_set(frame)
        assert animated.shows(animated.at(height))
    second.frame_start = second.frame_end = 11
    first.frame_set(1)
    seen = render(second, animation=True)[-1]
    assert scenes.close(seen[animated.name], animated.at(1.0), max(scenes.MATRIX, animated.tolerance))
    assert animated.shows(animated.at(0.0))
    assert scenes.close(render(first)[-1][animated.name], animated.at(0.0), animated.tolerance)


@pytest.mark.parametrize(("kind", "pause"), [("LINK_COPY", True), ("FULL_COPY", True), ("FULL_COPY", False)])
def test_a_copied_scene(posed: HandleRig, kind: str, pause: bool):
    """A linked copy shows the same rig, a full copy has one of its own, at once and after a pause."""
    first = bpy.context.scene
    bpy.ops.scene.new(type=kind)
    second = next(scene for scene in bpy.data.scenes if scene != first)
    copy = next(obj for obj in second.objects if obj.sinew.deformers)
    assert (copy == posed.obj) == (kind == "LINK_COPY")
    if pause:
        for scene in (first, second):
            scene.view_layers[0].update()
        catch_up()
    posed.control_of(copy).location.z += 0.25
    for scene in (second, first):
        scene.view_layers[0].update()
    assert posed.shows_in(second, posed.at(0.75), copy)
    assert posed.shows_in(first, posed.at(0.75 if kind == "LINK_COPY" else 0.5))


def test_the_scene_deleted_that_the_rig_was_made_in(rig: HandleRig):
    rig.start()
    first, second = bpy.context.scene, second_scene(rig.obj, rig.control)
    bpy.data.scenes.remove(first)
    scenes.update()
    rig.control.location.z += 0.5
    second.view_layers[0].update()
    assert rig.shows_in(second, rig.at(0.5))
    if bpy.context.scene == second:
        assert rig.shows(rig.at(0.5))


# --- instances


def collection_of(*objects: bpy.types.Object) -> bpy.types.Collection:
    """In no scene."""
    collection = bpy.data.collections.new("Asset")
    for obj in objects:
        collection.objects.link(obj)
    return collection


def add_instance(collection: bpy.types.Collection, x: float = 0.0) -> None:
    instance = scenes.new_empty("Instance")
    instance.instance_type, instance.instance_collection = "COLLECTION", collection
    instance.location.x = x


@INSTANCES.on(ALL)
def put_into_a_collection_with_instances(rig: HandleRig) -> None:
    collection = collection_of(rig.obj)
    for x in (3.0, 6.0):
        add_instance(collection, x)
    rig.lift(0.25)
    found = scenes.instances_of(rig.name)
    assert sorted(matrix[0, 3] for matrix, _points in found) == [3.0, 6.0]
    assert all(scenes.close(points, rig.at(0.75), rig.tolerance) for _matrix, points in found)


@INSTANCES.on(ALL, then=is_over)
def instanced_on_vertices(rig: HandleRig) -> None:
    rig.obj.parent = scenes.grid_object("Field", cells=1)
    rig.obj.parent.instance_type = "VERTS"
    rig.lift(0.25)
    found = scenes.instances_of(rig.name)
    assert len(found) == 4
    assert all(scenes.close(points, rig.at(0.75), rig.tolerance) for _matrix, points in found)


@INSTANCES.on(REGIONS, then=is_over)
def shown_by_an_instance_alone(rig: HandleRig) -> None:
    """Target and control are in no scene but the one that the instance gives them."""
    control = rig.control
    collection = collection_of(rig.obj, control)
    for obj in collection.objects:
        bpy.context.scene.collection.objects.unlink(obj)
    add_instance(collection)
    scenes.update()
    control.matrix_basis = Matrix.Translation((0.0, 0.0, 0.75))
    ((_matrix, points),) = scenes.instances_of(rig.name)
    assert scenes.close(points, rig.at(0.75))


@every(INSTANCES)
def test_instances_show_the_pose(posed: HandleRig, event: Event):
    event.run(posed)
