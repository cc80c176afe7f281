# SPDX-License-Identifier: GPL-3.0-or-later
"""Save, load, recover, new, append, link, override, make local; the add-on off, on, upgraded, missing.

On a rig of each kind; what needs another Blender takes all of them there at once.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from pathlib import Path

import addon_utils
import bpy
import numpy as np
import pytest
from expected import Poses
from inside import room, settle
from rig import MATRIX, close, grid_object, make_active, update
from rigs import RIGS, HandleRig
from second_blender import another_blender

Posed = tuple[HandleRig, Poses]


def save(path: Path, **options: bool) -> str:
    bpy.ops.wm.save_as_mainfile(filepath=str(path), **options)
    return str(path)


def load(path: str) -> None:
    bpy.ops.wm.open_mainfile(filepath=path)


def lives_on(rig: HandleRig, expected: Poses, height: float, obj=None, tolerance: float = 0.0) -> None:
    """The control stands at a height; it shows, and so does the next move."""
    obj = obj or rig.obj
    assert rig.shows(expected.lifted(height), obj, tolerance)
    rig.lift_of(obj, 0.25)
    assert rig.shows(expected.lifted(height + 0.25), obj, tolerance)
    assert obj.sinew.deformers[0].status_level == "INFO", obj.sinew.deformers[0].status


# --- save, load, revert, recover, new: what happens to a saved rig, and at which height its control is then


def saved_again(rig: HandleRig, folder: Path) -> float:
    for options in ({}, {"copy": True}, {"compress": True}):
        save(folder / "again.blend", **options)
        update()
    bpy.ops.wm.save_mainfile(filepath=str(folder / "rig.blend"))
    return 0.5


def loaded(rig: HandleRig, folder: Path) -> float:
    load(str(folder / "rig.blend"))
    return 0.5


def reverted(rig: HandleRig, folder: Path) -> float:
    """What was not saved is taken back."""
    before = rig.points()
    rig.lift(0.4)
    rig.deformer.method = next(method for method in rig.methods if method != rig.deformer.method)
    assert not close(rig.points(), before)
    bpy.ops.wm.revert_mainfile()
    assert rig.deformer.method == rig.methods[0]
    return 0.5


def autosave_recovered(rig: HandleRig, folder: Path) -> float:
    """Blender writes an autosave by a timer, which needs a window: a copy saved here stands for it."""
    rig.lift(0.25)
    autosave = save(folder / "1234_autosave.blend", copy=True)
    rig.lift(1.0)
    bpy.ops.wm.recover_auto_save(filepath=autosave)
    return 0.75


def last_session_recovered(rig: HandleRig, folder: Path) -> float:
    """``quit.blend`` lies in the folder for temporary files, and opens with its own path forgotten."""
    rig.lift(0.25)
    paths = bpy.context.preferences.filepaths
    before, paths.temporary_directory = paths.temporary_directory, str(folder)
    try:
        save(folder / "quit.blend", copy=True)
        rig.lift(1.0)
        bpy.ops.wm.recover_last_session()
    finally:
        bpy.context.preferences.filepaths.temporary_directory = before
    return 0.75


def loaded_after_another_file(rig: HandleRig, folder: Path) -> float:
    """Both files know the deformer by the same key, and hold different poses of different shapes."""
    rig.change_topology()
    make_active(rig.obj)
    bpy.ops.sinew.bind()
    fine = rig.points()
    other = save(folder / "other.blend")
    for _ in range(2):
        load(str(folder / "rig.blend"))
        assert len(rig.points()) < len(fine)
        load(other)
        assert rig.shows(fine)
    load(str(folder / "rig.blend"))
    return 0.5


def enabled_in_a_scene_that_was_loaded_without(rig: HandleRig, folder: Path) -> float:
    control, name = rig.control.name, room("ids").__package__
    addon_utils.disable(name)
    try:
        load(str(folder / "rig.blend"))
        bpy.data.objects[control].location.z += 0.25
        update()
    finally:
        addon_utils.enable(name)
    rig.lift(0.25)
    return 1.0


def disabled_and_enabled(rig: HandleRig, folder: Path) -> float:
    before, control, count = rig.points(), rig.control.name, handlers_of_ours()
    name = room("ids").__package__
    addon_utils.disable(name)
    try:
        assert handlers_of_ours() == 0
        bpy.data.objects[control].location.z += 0.25
        bpy.context.scene.frame_set(3)
        assert rig.shows(before)
        grid_object("Other")
        bpy.data.objects.remove(bpy.data.objects["Other"])
    finally:
        addon_utils.enable(name)
    assert handlers_of_ours() == count
    rig.obj.update_tag()
    return 0.75


def handlers_of_ours() -> int:
    return sum(
        "sinew" in getattr(handler, "__module__", "")
        for kind in dir(bpy.app.handlers)
        if isinstance(getattr(bpy.app.handlers, kind), list)
        for handler in getattr(bpy.app.handlers, kind)
    )


EVENTS = (
    saved_again,
    loaded,
    reverted,
    autosave_recovered,
    last_session_recovered,
    loaded_after_another_file,
    enabled_in_a_scene_that_was_loaded_without,
    disabled_and_enabled,
)


@pytest.mark.parametrize("event", EVENTS, ids=lambda event: event.__name__)
def test_a_rig_is(posed: Posed, tmp_path: Path, event: Callable[[HandleRig, Path], float]):
    rig, expected = posed
    save(tmp_path / "rig.blend")
    lives_on(rig, expected, event(rig, tmp_path))


def test_recovering_an_autosave_without_our_save_handler(posed: Posed, tmp_path: Path):
    """An autosave runs no handler, so copies in it still share their shapes, and their control."""
    rig, expected = posed
    make_active(rig.obj)
    bpy.ops.object.duplicate()
    copy = bpy.context.object.name
    handlers = list(bpy.app.handlers.save_pre)
    bpy.app.handlers.save_pre.clear()
    try:
        autosave = save(tmp_path / "1234_autosave.blend", copy=True)
    finally:
        bpy.app.handlers.save_pre.extend(handlers)
    bpy.ops.wm.recover_auto_save(filepath=autosave)
    settle()
    rig.lift(0.25)
    for name in (rig.name, copy):
        assert rig.shows(expected.lifted(0.75), bpy.data.objects[name])


def test_a_new_file_starts_from_nothing(posed: Posed):
    """An object of the same name is another one."""
    rig, _expected = posed
    uid = rig.deformer.uid
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert room("session").find(uid) is None
    assert room("session").owners() == []
    fresh = type(rig).new()
    expected = fresh.start()
    lives_on(fresh, expected, 0.0)


def test_upgraded_while_a_rig_is_open(posed: Posed):
    """The old code is unloaded and read again; the native module stays until Blender ends."""
    rig, expected = posed
    name = room("ids").__package__
    old = {
        key: module
        for key, module in sys.modules.items()
        if (key == name or key.startswith(name + ".")) and "_native" not in key
    }
    count = handlers_of_ours()
    sys.modules[name].unregister()
    for key in old:
        del sys.modules[key]
    new = importlib.import_module(name)
    try:
        new.register()
        assert handlers_of_ours() == count
        rig.lift(0.25)
        lives_on(rig, expected, 0.75)
        make_active(rig.obj)
        bpy.ops.sinew.bind()
        lives_on(rig, expected, 1.0)
    finally:
        new.unregister()
        sys.modules.update(old)
        sys.modules[name].register()


# --- append, link, override, make local


def read(path: str, link: bool, kind: str, name: str) -> bpy.types.ID:
    with bpy.data.libraries.load(path, link=link) as (_there, here):
        setattr(here, kind, [name])
    return getattr(here, kind)[0]


@pytest.fixture
def asset(posed: Posed, tmp_path: Path) -> tuple[HandleRig, str, Poses]:
    """A library with a lifted rig in the collection ``Asset``; the open file is empty again."""
    rig, expected = posed
    collection = bpy.data.collections.new("Asset")
    bpy.context.scene.collection.children.link(collection)
    for obj in (rig.obj, rig.control):
        collection.objects.link(obj)
    rig.points()
    path = save(tmp_path / "library.blend")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    return rig, path, expected


def owners_here() -> list[bpy.types.Object]:
    return [obj for obj in bpy.context.scene.objects if obj.sinew.deformers]


def append_collection(path: str, link: bool = False) -> bpy.types.Collection:
    collection = read(path, link, "collections", "Asset")
    bpy.context.scene.collection.children.link(collection)
    update()
    return collection


def test_append(asset):
    rig, path, expected = asset
    append_collection(path)
    settle()
    lives_on(rig, expected, 0.5)


def test_append_twice_makes_two_rigs(asset):
    rig, path, expected = asset
    for _ in range(2):
        append_collection(path)
    settle()
    first, second = owners_here()
    lives_on(rig, expected, 0.5, first)
    rig.lift_of(second, -0.5)
    lives_on(rig, expected, 0.0, second)
    assert rig.shows(expected.lifted(0.75), first)
    assert first.sinew.deformers[0].proxy != second.sinew.deformers[0].proxy


def test_append_into_a_file_that_has_the_rig_itself(asset, tmp_path: Path):
    """The same keys come in once more."""
    rig, path, expected = asset
    load(path)
    save(tmp_path / "other.blend")  # no file appends from itself
    copy = read(path, False, "objects", rig.name)
    bpy.context.scene.collection.objects.link(copy)
    settle()
    assert copy.name != rig.name
    lives_on(rig, expected, 0.5)
    assert rig.shows(expected.now(copy, rig.control_of(copy)), copy)


def test_append_by_the_file_browsers_operator(asset):
    rig, path, expected = asset
    bpy.ops.wm.append(directory=f"{path}/Object/", filename=rig.name)
    settle()
    lives_on(rig, expected, 0.5)


def test_an_instance_of_a_linked_collection_shows_the_last_solution(asset):
    rig, path, expected = asset
    instance = bpy.data.objects.new("Instance", None)
    instance.instance_type = "COLLECTION"
    instance.instance_collection = read(path, True, "collections", "Asset")
    bpy.context.scene.collection.objects.link(instance)
    settle()
    for frame in (1, 7):
        bpy.context.scene.frame_set(frame)
        (shape,) = instanced_points(rig.name)
        assert close(shape, expected.lifted(0.5), rig.tolerance)


def instanced_points(name: str) -> list[np.ndarray]:
    """What each instance of the object shows, object space."""
    update()
    found = []
    for instance in bpy.context.evaluated_depsgraph_get().object_instances:
        if instance.is_instance and instance.object.name == name:
            mesh = instance.object.to_mesh()
            found.append(np.array([vertex.co[:] for vertex in mesh.vertices]))
            instance.object.to_mesh_clear()
    return found


def override(path: str) -> bpy.types.Object:
    """A hierarchy override of the asset, as the outliner makes it; its target."""
    append_collection(path, link=True).override_hierarchy_create(bpy.context.scene, bpy.context.view_layer)
    update()
    return overridden()


def overridden() -> bpy.types.Object:
    return next(obj for obj in bpy.data.objects if obj.override_library and obj.sinew.deformers)


def follows_its_control(rig: HandleRig, expected: Poses, obj: bpy.types.Object) -> None:
    """Wherever the library left the control of an override."""
    for _ in range(2):
        assert rig.shows(expected.now(obj, rig.control_of(obj)), obj, MATRIX)
        rig.lift_of(obj, 0.25)


def test_an_override_whose_hidden_shapes_are_overridden_too(asset, tmp_path: Path):
    """Blender 3.4 does that by itself; an override of a shape object still shows the library's mesh."""
    rig, path, expected = asset
    obj = override(path)
    for name in ("proxy", "proxy_render"):
        shape = getattr(obj.sinew.deformers[0], name)
        if shape is not None and shape.library is not None:
            shape.override_create(remap_local_usages=True)
    settle()
    rig.lift_of(obj, 0.25)
    assert rig.shows(expected.lifted(0.75), obj, MATRIX)
    load(save(tmp_path / "shot.blend"))
    settle()
    lives_on(rig, expected, 0.75, overridden(), MATRIX)


def test_an_override_lives_through_a_change_of_its_library(asset, tmp_path: Path):
    rig, path, expected = asset
    obj = override(path)
    settle()
    rig.lift_of(obj, 0.25)
    shot = save(tmp_path / "shot.blend")
    load(path)
    rig.lift(0.1)
    rig.points()
    bpy.ops.wm.save_mainfile()
    load(shot)
    settle()
    follows_its_control(rig, expected, overridden())


def test_an_override_reset_to_its_library(asset):
    """All of its own values go, the shapes of its own included; it can be posed again at once."""
    rig, path, expected = asset
    obj = override(path)
    settle()
    rig.lift_of(obj, 0.25)
    assert rig.shows(expected.lifted(0.75), obj, MATRIX)
    control = rig.control_of(obj)
    obj.override_library.reset()
    control.override_library.reset()
    settle()
    follows_its_control(rig, expected, overridden())


@pytest.mark.parametrize("overriding", [False, True])
def test_make_local(asset, overriding: bool):
    rig, path, expected = asset
    if overriding:
        override(path)
        settle()
    else:
        append_collection(path, link=True)
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.make_local(type="ALL")
    settle()
    obj = owners_here()[0]
    assert obj.library is None
    lives_on(rig, expected, 0.5, obj, MATRIX)
    make_active(obj)
    bpy.ops.sinew.bind()
    lives_on(rig, expected, 0.75, obj, MATRIX)


def test_make_local_of_the_target_alone(asset):
    """Its control stays in the library, where nobody moves it; another handle goes on, another cage rests."""
    rig, path, expected = asset
    obj = read(path, True, "objects", rig.name)
    bpy.context.scene.collection.objects.link(obj)
    update()
    local = obj.make_local()
    settle()
    assert rig.shows(expected.lifted(0.5), local, MATRIX)
    rig.set_control(local, rig.another_control(local))
    settle()
    if not rig.goes_on:
        make_active(local)
        assert bpy.ops.sinew.bind() == {"FINISHED"}
    before = rig.shown(local)
    assert close(before, expected.lifted(0.5) if rig.goes_on else rig.unmoved(local), MATRIX)
    rig.lift_of(local, 0.25)
    assert close(rig.shown(local)[rig.held], before[rig.held] + (0.0, 0.0, 0.25), MATRIX)


# --- another Blender


@pytest.fixture
def all_rigs() -> dict[str, Posed]:
    """One of each kind in one scene, lifted by a half."""
    found = {}
    for kind, new in RIGS.items():
        rig = new.new()
        expected = rig.start()
        rig.lift(0.5)
        found[kind] = rig, expected
    return found


def names(rigs: dict[str, Posed]) -> dict[str, tuple[str, str]]:
    """Target and control of each, for a program."""
    return {kind: (rig.name, rig.control.name) for kind, (rig, _expected) in rigs.items()}


@pytest.mark.parametrize("overriding", [False, True])
def test_a_library_reloaded_after_it_changed(all_rigs, tmp_path: Path, addon_name: str, overriding: bool):
    """As Reload in the outliner: a linked rig shows the new solution, an override its own pose."""
    collection = bpy.data.collections.new("Asset")
    bpy.context.scene.collection.children.link(collection)
    here = names(all_rigs)
    for pair in here.values():
        for name in pair:
            collection.objects.link(bpy.data.objects[name])
    path = save(tmp_path / "library.blend")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    if overriding:
        override(path)
        settle()
        for obj in [obj for obj in bpy.data.objects if obj.override_library and obj.sinew.deformers]:
            rig_of(all_rigs, obj).lift_of(obj, 0.25)
    else:
        append_collection(path, link=True)
    another_blender(
        f"""
        bpy.ops.wm.open_mainfile(filepath={path!r})
        from rigs import RIGS
        for kind, (name, _control) in {here!r}.items():
            rig = RIGS[kind].called(name)
            rig.lift(0.1)
            rig.points()
        bpy.ops.wm.save_mainfile()
        """,
        tmp_path,
        addon_name,
    )
    bpy.data.libraries[0].reload()
    settle()
    for kind, (rig, expected) in all_rigs.items():
        if overriding:
            obj = next(o for o in bpy.data.objects if o.override_library and o.name == here[kind][0])
            follows_its_control(rig, expected, obj)
        else:
            assert rig.shows(expected.lifted(0.6), bpy.context.scene.objects[rig.name], MATRIX)


def rig_of(rigs: dict[str, Posed], obj: bpy.types.Object) -> HandleRig:
    return next(rig for rig, _expected in rigs.values() if rig.name == obj.name)


def test_a_blender_without_the_add_on_shows_saves_and_gives_back(all_rigs, tmp_path: Path):
    """It opens the file, moves the controls, plays, saves; back here all live on with their settings."""
    path, passed_on = save(tmp_path / "rig.blend"), str(tmp_path / "passed_on.blend")
    regions = [handle.vertex_group for handle in all_rigs["handles"][0].deformer.handles]
    found = another_blender(
        f"""
        bpy.ops.wm.open_mainfile(filepath={path!r})
        import point_objects
        rigs = {names(all_rigs)!r}
        def look():
            return {{kind: point_objects.shown(bpy.data.objects[name]).tolist() for kind, (name, _) in
            rigs.items()}}
        seen["points"] = look()
        for _name, control in rigs.values():
            bpy.data.objects[control].location.z += 0.25
        bpy.context.scene.frame_set(5)
        seen["later"] = look()
        seen["has_sinew"] = hasattr(bpy.types.Object, "sinew")
        bpy.ops.wm.save_as_mainfile(filepath={passed_on!r})
        """,
        tmp_path,
    )
    assert not found["has_sinew"]
    load(passed_on)
    assert [handle.vertex_group for handle in all_rigs["handles"][0].deformer.handles] == regions
    for kind, (rig, expected) in all_rigs.items():
        for moment in ("points", "later"):
            assert close(np.array(found[moment][kind]), expected.lifted(0.5), rig.tolerance)
        lives_on(rig, expected, 0.75)


MISSING = """
class Hidden:
    def find_spec(self, name, path=None, target=None):
        if name.rpartition(".")[2] == "sinew_native":
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
sys.meta_path.insert(0, Hidden())
"""

WRONG_PYTHON = """
import importlib.machinery
class Foreign:
    def find_spec(self, name, path=None, target=None):
        if name.rpartition(".")[2] == "sinew_native":
            loader = importlib.machinery.ExtensionFileLoader(name, {path!r})
            return importlib.machinery.ModuleSpec(name, loader, origin={path!r})
sys.meta_path.insert(0, Foreign())
"""


@pytest.mark.parametrize("fault", ["missing", "wrong python"])
def test_without_its_native_module_the_add_on_registers_and_shows_the_last_solution(
    all_rigs, tmp_path: Path, addon_name: str, fault: str
):
    """A module built for another Python does not load: here a library that is no Python module at all."""
    path, prelude = save(tmp_path / "rig.blend"), MISSING
    if fault == "wrong python":
        foreign = tmp_path / "sinew_native.cpython-399-x86_64-linux-gnu.so"
        foreign.write_bytes(b"\x7fELF" + bytes(60))
        prelude = WRONG_PYTHON.format(path=str(foreign))
    found = another_blender(
        f"""
        seen["enabled"] = hasattr(bpy.types.Object, "sinew")
        bpy.ops.wm.open_mainfile(filepath={path!r})
        from rigs import RIGS
        for kind, (name, _control) in {names(all_rigs)!r}.items():
            rig, said = RIGS[kind].called(name), dict()
            said["points"] = rig.points().tolist()
            rig.lift(0.25)
            bpy.context.scene.frame_set(bpy.context.scene.frame_current + 1)
            said["later"] = rig.points().tolist()
            said["status"], said["level"] = rig.deformer.status, rig.deformer.status_level
            make_active(rig.obj)
            try:
                bpy.ops.sinew.bind()
            except RuntimeError as refusal:
                said["refusal"] = str(refusal)
            said["after"] = rig.points().tolist()
            said["bound"] = rig.deformer.is_bound
            seen[kind] = said
        bpy.ops.wm.save_as_mainfile(filepath={path!r})
        """,
        tmp_path,
        addon_name,
        prelude,
    )
    assert found["enabled"]
    load(path)  # here the module is there
    for kind, (rig, expected) in all_rigs.items():
        said = found[kind]
        for moment in ("points", "later", "after"):
            assert close(np.array(said[moment]), expected.lifted(0.5), rig.tolerance)
        assert said["level"] == "ERROR"
        for text in (said["status"], said["refusal"]):
            assert ("does not load" if fault == "wrong python" else "is missing") in text
            assert f"cp{sys.version_info.major}{sys.version_info.minor}" in text
        assert said["bound"]
        lives_on(rig, expected, 0.75)
