# SPDX-License-Identifier: GPL-3.0-or-later
"""Save, load, recover, new, append, link, override, make local; the add-on off, on, upgraded, missing."""

import importlib
import shutil
import sys

import bpy
import numpy as np
import pytest
from events import ALL, REGIONS, Event, Table, every, is_over, lives_on
from inside import handlers_of_ours, inner, settle, without_the_add_on
from libraries import add_collection, overridden, override, put_into_a_library, read
from probe import render_points
from rigs import rig as scenes
from rigs.kinds import HandleRig

EVENTS = Table()  # to a rig in the file rig.blend
ASSETS = Table()  # to a file that is empty, beside library.blend with a rig in the collection Asset


def goes_on(rig: HandleRig, obj: bpy.types.Object, height: float, tolerance: float = 0.0) -> None:
    """An object with such a rig shows its control at a height, and follows the next move."""
    assert rig.shows(rig.at(height), obj, tolerance)
    rig.lift_of(obj, 0.25)
    assert rig.shows(rig.at(height + 0.25), obj, tolerance)
    assert obj.sinew.deformers[0].status_level == "INFO", obj.sinew.deformers[0].status


# --- save, load, revert, recover, new


@EVENTS.on(ALL)
def saved_again(rig: HandleRig) -> None:
    for options in ({}, {"copy": True}, {"compress": True}):
        scenes.save(rig.folder / "again.blend", **options)
        assert rig.is_right()
    bpy.ops.wm.save_mainfile(filepath=str(rig.folder / "rig.blend"))


@EVENTS.on(ALL)
def loaded(rig: HandleRig) -> None:
    scenes.load(rig.folder / "rig.blend")


@EVENTS.on(ALL)
def reverted(rig: HandleRig) -> None:
    before = rig.points()
    rig.lift(0.4)
    rig.deformer.method = rig.methods[-1]
    assert not scenes.close(rig.points(), before)
    bpy.ops.wm.revert_mainfile()
    assert rig.deformer.method == rig.methods[0]
    rig.height = 0.5


@EVENTS.on(ALL)
def recovered_from_an_autosave(rig: HandleRig) -> None:
    """Blender writes an autosave by a timer, which needs a window: a copy saved here stands for it."""
    autosave = scenes.save(rig.folder / "1234_autosave.blend", copy=True)
    rig.lift(1.0)
    bpy.ops.wm.recover_auto_save(filepath=autosave)
    rig.height = 0.5


@EVENTS.on(ALL)
def its_copy_saved_before_a_pause(rig: HandleRig) -> None:
    """Our save handler tells them apart."""
    scenes.make_active(rig.obj)
    bpy.ops.object.duplicate()
    scenes.save(rig.folder / "copy.blend")
    assert bpy.context.object.sinew.deformers[0].proxy != rig.deformer.proxy


@EVENTS.on(ALL)
def recovered_from_the_last_session(rig: HandleRig) -> None:
    """``quit.blend`` lies in the folder for temporary files, and opens with its own path forgotten."""
    before = bpy.context.preferences.filepaths.temporary_directory
    bpy.context.preferences.filepaths.temporary_directory = str(rig.folder)
    scenes.save(rig.folder / "quit.blend", copy=True)
    rig.lift(1.0)
    bpy.ops.wm.recover_last_session()
    bpy.context.preferences.filepaths.temporary_directory = before
    rig.height = 0.5


@EVENTS.on(ALL)
def loaded_after_another_file(rig: HandleRig) -> None:
    """Both files know the deformer by the same key, and hold different poses of different shapes."""
    rig.change_topology()
    rig.press("bind")
    fine = rig.points()
    other = scenes.save(rig.folder / "other.blend")
    for _ in range(2):
        scenes.load(rig.folder / "rig.blend")
        assert rig.is_right()
        scenes.load(other)
        assert rig.shows(fine)
    scenes.load(rig.folder / "rig.blend")


@EVENTS.on(REGIONS, then=is_over)
def loaded_on_a_posed_frame(rig: HandleRig) -> None:
    """Rest is what entered at bind, not what enters when the file is opened: the same bits at each frame,
    however it is reached, and in renders.
    """
    rig.press("deformer_remove")
    bone = scenes.add_armature(rig.obj).pose.bones["high"]
    rig.bind("arap")
    scenes.key(bone, {1: {"rotation_euler": (0.0, 0.0, 0.0)}, 20: {"rotation_euler": (0.9, 0.0, 0.0)}})
    scenes.key_heights(rig.control, {1: 0.0, 20: 0.9})
    shapes: dict[int, np.ndarray] = {}
    for frames in ((1, 12, 20), (20, 1, 12), (12, 20, 1)):
        for frame in frames:
            bpy.context.scene.frame_set(frame)
            shape = shapes.setdefault(frame, rig.points())
            assert np.array_equal(rig.points(), shape)
            assert np.array_equal(render_points(rig.obj), shape)
        scenes.reopen(rig.folder / "posed.blend")


@EVENTS.on(ALL, then=is_over)
def replaced_by_a_new_file(rig: HandleRig) -> None:
    """Nothing is left: an object of the same name is another one."""
    uid = rig.deformer.uid
    scenes.new_file()
    assert inner.sessions.find(uid) is None
    assert inner.owners.owners() == []
    lives_on(type(rig).new().start())


# --- the add-on off, on, upgraded


@EVENTS.on(ALL)
def loaded_without_the_add_on_and_enabled(rig: HandleRig) -> None:
    """It shows the last solution, whatever moves, and saves; here all goes on with its settings."""
    control = rig.control.name
    with without_the_add_on():
        scenes.load(rig.folder / "rig.blend")
        assert rig.is_right()
        bpy.data.objects[control].location.z += 0.25
        bpy.context.scene.frame_set(bpy.context.scene.frame_current + 1)
        assert rig.is_right()
        bpy.ops.wm.save_mainfile()
    rig.height += 0.25
    rig.lift(0.25)
    lives_on(rig)
    scenes.load(rig.folder / "rig.blend")
    rig.height = 0.75


@EVENTS.on(ALL)
def loaded_without_its_native_module(rig: HandleRig) -> None:
    """The last solution, and words about it; Bind is refused, and nothing is lost."""

    def is_missing(name: str) -> None:
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)

    loader = inner.loader
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(loader.importlib, "import_module", is_missing)
        missing = loader.load()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(inner.binding, "availability", lambda: missing)
        scenes.load(rig.folder / "rig.blend")
        assert rig.is_right()
        rig.control.location.z += 0.25
        bpy.context.scene.frame_set(bpy.context.scene.frame_current + 1)
        assert rig.is_right()
        assert rig.deformer.status_level == "ERROR"
        assert "is missing" in rig.deformer.status
        assert f"cp{sys.version_info.major}{sys.version_info.minor}" in rig.deformer.status
        scenes.refused("is missing", "bind", rig.obj)
        assert rig.deformer.is_bound
        assert rig.is_right()
        bpy.ops.wm.save_mainfile()
    scenes.load(rig.folder / "rig.blend")
    rig.height = 0.75


@EVENTS.on(ALL)
def disabled_and_enabled(rig: HandleRig) -> None:
    """The last shape meanwhile, whatever moves."""
    control = rig.control
    with without_the_add_on():
        control.location.z += 0.25
        bpy.context.scene.frame_set(3)
        assert rig.is_right()
        bpy.data.objects.remove(scenes.grid_object("Other"))
    rig.height += 0.25
    rig.obj.update_tag()


@EVENTS.on(ALL)
def upgraded(rig: HandleRig) -> None:
    """The old code is unloaded and read again; the native module stays until Blender ends."""
    name, count = inner.ids.__package__, handlers_of_ours()
    ours = [key for key in sys.modules if f"{key}.".startswith(f"{name}.") and "_native" not in key]
    sys.modules[name].unregister()
    old = {key: sys.modules.pop(key) for key in ours}
    new = importlib.import_module(name)
    try:
        new.register()
        assert handlers_of_ours() == count
        lives_on(rig)
        rig.press("bind")
        lives_on(rig)
    finally:
        new.unregister()
        sys.modules.update(old)
        sys.modules[name].register()


# --- append, link, override, make local


def library(rig: HandleRig) -> str:
    return str(rig.folder / "library.blend")


def owners() -> list[bpy.types.Object]:
    return [obj for obj in bpy.context.scene.objects if obj.sinew.deformers]


def follows_its_control(rig: HandleRig, obj: bpy.types.Object) -> None:
    """Wherever the library left the control of an override."""
    for _ in range(2):
        assert rig.shows(rig.now(obj), obj, scenes.MATRIX)
        rig.lift_of(obj, 0.25)


@ASSETS.on(ALL)
def appended(rig: HandleRig) -> None:
    add_collection(library(rig))


@ASSETS.on(ALL)
def appended_twice(rig: HandleRig) -> None:
    for _ in range(2):
        add_collection(library(rig))
    settle()
    first, second = owners()
    goes_on(rig, first, 0.5)
    rig.height = 0.75
    rig.lift_of(second, -0.5)
    goes_on(rig, second, 0.0)
    assert first.sinew.deformers[0].proxy != second.sinew.deformers[0].proxy


@ASSETS.on(ALL)
def appended_into_a_file_that_has_the_rig_itself(rig: HandleRig) -> None:
    scenes.load(library(rig))
    scenes.save(rig.folder / "other.blend")  # no file appends from itself
    copy = read(library(rig), False, "objects", rig.name)
    bpy.context.scene.collection.objects.link(copy)
    settle()
    assert copy.name != rig.name
    rig.lift(0.25)
    assert rig.shows(rig.now(copy), copy)


@ASSETS.on(ALL)
def appended_by_the_file_browsers_operator(rig: HandleRig) -> None:
    bpy.ops.wm.append(directory=f"{library(rig)}/Object/", filename=rig.name)


@ASSETS.on(ALL, then=is_over)
def linked(rig: HandleRig) -> None:
    """The last solution, by itself and through an instance; the status says how to pose it."""
    collection, instance = read(library(rig), True), scenes.new_empty("Instance")
    instance.instance_type, instance.instance_collection = "COLLECTION", collection
    obj = collection.objects[rig.name]
    bpy.context.scene.collection.objects.link(obj)
    settle()
    for frame in (1, 7):
        bpy.context.scene.frame_set(frame)
        ((_matrix, points),) = scenes.instances_of(rig.name)
        assert scenes.close(points, rig.at(0.5), rig.tolerance)
        assert rig.shows(rig.at(0.5), obj)
    assert "library override" in obj.sinew.deformers[0].status


def lives_as_an_override(rig: HandleRig, obj: bpy.types.Object) -> None:
    settle()
    goes_on(rig, obj, 0.5, scenes.MATRIX)
    scenes.reopen(rig.folder / "shot.blend")
    settle()
    goes_on(rig, overridden(), 0.75, scenes.MATRIX)


@ASSETS.on(ALL, then=is_over)
def overridden_posed_and_saved(rig: HandleRig) -> None:
    """With a shape of its own, which the library does not have."""
    obj = override(library(rig))
    assert obj.sinew.deformers[0].proxy.library is None
    assert rig.control_of(obj).library is None
    lives_as_an_override(rig, obj)


@ASSETS.on(ALL, then=is_over)
def overridden_with_its_hidden_shapes(rig: HandleRig) -> None:
    """Blender 3.4 does that by itself; an override of a shape object still shows the library's mesh."""
    obj = override(library(rig))
    for name in ("proxy", "proxy_render"):
        shape = getattr(obj.sinew.deformers[0], name)
        if shape is not None and shape.library is not None:
            shape.override_create(remap_local_usages=True)
    lives_as_an_override(rig, obj)


@ASSETS.on(ALL, then=is_over)
def overridden_and_the_library_changed(rig: HandleRig) -> None:
    rig.lift_of(override(library(rig)), 0.25)
    shot = scenes.save(rig.folder / "shot.blend")
    scenes.load(library(rig))
    rig.lift(0.1)
    rig.points()
    bpy.ops.wm.save_mainfile()
    scenes.load(shot)
    settle()
    follows_its_control(rig, overridden())


@ASSETS.on(ALL, then=is_over)
def overridden_and_reset_to_its_library(rig: HandleRig) -> None:
    """All of its own values go, the shapes of its own included; it can be posed again at once."""
    obj = override(library(rig))
    goes_on(rig, obj, 0.5, scenes.MATRIX)
    control = rig.control_of(obj)
    obj.override_library.reset()
    control.override_library.reset()
    settle()
    follows_its_control(rig, overridden())


def hidden_ones() -> list[str]:
    """Our hidden objects that show as rows in the outliner."""
    return [obj.name for scene in bpy.data.scenes for obj in scene.objects if obj.name.startswith(".Sinew")]


def hides_its_shapes(rig: HandleRig) -> None:
    for _ in range(2):
        settle()
        assert hidden_ones() == []
        scenes.reopen(rig.folder / "shot.blend")
    assert hidden_ones() == []
    follows_its_control(rig, overridden())


@ASSETS.on(ALL, then=hides_its_shapes)
def overridden_by_a_script(rig: HandleRig) -> None:
    """It can be posed at once, without a pause, and without a call of ours."""
    added = add_collection(library(rig), link=True)
    added.override_hierarchy_create(bpy.context.scene, bpy.context.view_layer)
    obj = overridden()
    assert obj.name == rig.name
    rig.control_of(obj).location.z += 0.25
    follows_its_control(rig, obj)
    assert not rig.shows(rig.at(0.5), obj, 0.1)
    assert obj.sinew.deformers[0].status_level == "INFO"
    assert hidden_ones() == []


@ASSETS.on(ALL, then=hides_its_shapes)
def overridden_by_the_operator(rig: HandleRig) -> None:
    control = rig.control_of(read(library(rig), True, "objects", rig.name)).name
    for wanted in (rig.name, control):
        obj = read(library(rig), True, "objects", wanted)
        if obj.name not in bpy.context.scene.objects:
            bpy.context.scene.collection.objects.link(obj)
    scenes.make_active(bpy.data.objects[rig.name])
    assert bpy.ops.object.make_override_library() == {"FINISHED"}
    assert rig.shows(rig.at(0.5), overridden(), scenes.MATRIX)


def made_local(rig: HandleRig) -> None:
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.make_local(type="ALL")
    settle()
    obj = owners()[0]
    assert obj.library is None
    goes_on(rig, obj, 0.5, scenes.MATRIX)
    scenes.press(obj, "bind")
    goes_on(rig, obj, 0.75, scenes.MATRIX)


@ASSETS.on(ALL, then=made_local)
def linked_and_made_local(rig: HandleRig) -> None:
    add_collection(library(rig), link=True)


@ASSETS.on(ALL, then=made_local)
def overridden_and_made_local(rig: HandleRig) -> None:
    override(library(rig))


@ASSETS.on(ALL, then=is_over)
def its_target_alone_made_local(rig: HandleRig) -> None:
    """Its control stays in the library, where nobody moves it; another handle goes on, another cage rests."""
    obj = read(library(rig), True, "objects", rig.name)
    bpy.context.scene.collection.objects.link(obj)
    scenes.update()
    local = obj.make_local()
    settle()
    assert rig.shows(rig.at(0.5), local, scenes.MATRIX)
    rig.set_control(local, rig.another_control(local))
    settle()
    if not rig.goes_on:
        scenes.press(local, "bind")
    before = scenes.evaluated_points(local)
    assert scenes.close(before, rig.at(0.5) if rig.goes_on else rig.unmoved(local), scenes.MATRIX)
    rig.lift_of(local, 0.25)
    assert scenes.close(
        scenes.evaluated_points(local)[rig.held], before[rig.held] + (0.0, 0.0, 0.25), scenes.MATRIX
    )


@ASSETS.on(ALL, then=is_over)
def linked_and_overridden_and_the_library_reloaded(rig: HandleRig) -> None:
    """As Reload in the outliner: a linked rig shows the new solution, an override its own pose."""

    def linked_one() -> bpy.types.Object:
        return next(obj for obj in bpy.data.objects if obj.library and obj.sinew.deformers)

    scenes.load(library(rig))
    rig.lift(0.1)
    rig.points()
    changed = scenes.save(rig.folder / "changed.blend")
    scenes.new_file()
    rig.lift_of(override(library(rig)), 0.25)
    bpy.context.scene.collection.objects.link(linked_one())
    assert rig.shows(rig.at(0.5), linked_one())
    shutil.copyfile(changed, library(rig))
    bpy.data.libraries[0].reload()
    settle()
    assert rig.shows(rig.at(0.6), linked_one(), scenes.MATRIX)
    follows_its_control(rig, overridden())


# --- each of them


@every(EVENTS)
def test_a_rig_is(posed: HandleRig, event: Event):
    scenes.save(posed.folder / "rig.blend")
    event.run(posed)


@every(ASSETS)
def test_a_rig_in_a_library_is(posed: HandleRig, event: Event):
    put_into_a_library(posed.folder / "library.blend", posed.obj, posed.control)
    event.run(posed)
