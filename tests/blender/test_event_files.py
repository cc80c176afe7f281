# SPDX-License-Identifier: GPL-3.0-or-later
"""Save, load, recover, new, append, link, override, make local; the add-on off, on, upgraded, missing."""

import importlib
import sys
from pathlib import Path

import addon_utils
import bpy
import numpy as np
import pytest
from expected import Expected
from mathutils import Matrix
from rig import MATRIX, Rig, close, evaluated_points, grid_object, make_active, move_world, update
from second_blender import another_blender


def rig_called(name: str) -> Rig:
    """A rig that is there already."""
    rig = Rig.__new__(Rig)
    rig.name = name
    return rig


def save(path: Path, **options: bool) -> str:
    bpy.ops.wm.save_as_mainfile(filepath=str(path), **options)
    return str(path)


@pytest.fixture
def saved(plate: Rig, tmp_path: Path) -> tuple[str, Expected]:
    """The path of a file with a plate lifted by a half, which is open; and what to expect of it."""
    plate.bind()
    expected = Expected.of(plate)
    plate.lift(0.5)
    return save(tmp_path / "rig.blend"), expected


# --- save, load, revert, recover, new


def test_saving_changes_nothing(plate: Rig, saved: tuple[str, Expected], tmp_path: Path):
    path, expected = saved
    for options in ({}, {"copy": True}, {"compress": True}):
        save(tmp_path / "again.blend", **options)
        assert close(plate.points(), expected.lifted(0.5))
    bpy.ops.wm.save_mainfile(filepath=path)
    plate.lift(0.25)
    assert close(plate.points(), expected.lifted(0.75))


def test_revert_takes_back_what_was_not_saved(plate: Rig, saved: tuple[str, Expected]):
    _path, expected = saved
    plate.lift(0.4)
    plate.deformer.method = "arap"
    assert not close(plate.points(), expected.lifted(0.5))
    bpy.ops.wm.revert_mainfile()
    assert plate.deformer.method == "thin_shell"
    assert close(plate.points(), expected.lifted(0.5))
    plate.lift(0.25)
    assert close(plate.points(), expected.lifted(0.75))


def test_recovering_an_autosave(plate: Rig, saved: tuple[str, Expected], tmp_path: Path):
    """Blender writes an autosave by a timer, which needs a window: a copy saved here stands for it."""
    _path, expected = saved
    plate.lift(0.25)
    autosave = save(tmp_path / "1234_autosave.blend", copy=True)
    plate.lift(1.0)
    bpy.ops.wm.recover_auto_save(filepath=autosave)
    assert close(plate.points(), expected.lifted(0.75))
    plate.lift(0.25)
    assert close(plate.points(), expected.lifted(1.0))


def test_recovering_an_autosave_without_our_save_handler(plate: Rig, tmp_path: Path, room):
    """An autosave runs no handler, so copies in it still share their shapes."""
    plate.bind()
    expected = Expected.of(plate)
    plate.lift(0.5)
    make_active(plate.obj)
    bpy.ops.object.duplicate()
    copy_name = bpy.context.object.name
    handlers = list(bpy.app.handlers.save_pre)
    bpy.app.handlers.save_pre.clear()
    try:
        autosave = save(tmp_path / "1234_autosave.blend", copy=True)
    finally:
        bpy.app.handlers.save_pre.extend(handlers)
    bpy.ops.wm.recover_auto_save(filepath=autosave)
    room("handlers.deferred").catch_up()
    plate.lift(0.25)
    for name in (plate.name, copy_name):
        assert close(evaluated_points(bpy.data.objects[name]), expected.lifted(0.75))


def test_recovering_the_last_session(plate: Rig, saved: tuple[str, Expected], tmp_path: Path):
    """``quit.blend`` lies in the folder for temporary files, and opens with its own path forgotten."""
    _path, expected = saved
    plate.lift(0.25)
    paths = bpy.context.preferences.filepaths
    before, paths.temporary_directory = paths.temporary_directory, str(tmp_path)
    try:
        save(tmp_path / "quit.blend", copy=True)
        plate.lift(1.0)
        bpy.ops.wm.recover_last_session()
    finally:
        bpy.context.preferences.filepaths.temporary_directory = before
    assert close(plate.points(), expected.lifted(0.75))
    plate.lift(0.25)
    assert close(plate.points(), expected.lifted(1.0))


def test_a_new_file_starts_from_nothing(plate: Rig, room):
    plate.bind().lift(0.5)
    plate.points()
    uid = plate.deformer.uid
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert room("session").find(uid) is None
    assert room("session").owners() == []
    fresh = Rig.plate(cells=7).bind()  # an object of the same name, of another size
    expected = Expected.of(fresh)
    fresh.lift(0.3)
    assert close(fresh.points(), expected.lifted(0.3))


def test_loading_one_file_after_another(plate: Rig, saved: tuple[str, Expected], tmp_path: Path):
    """Both files know the deformer by the same key, and hold different poses of different meshes."""
    path, expected = saved
    make_active(plate.obj)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.sinew.bind()
    fine = plate.points()
    other = save(tmp_path / "other.blend")
    for _ in range(2):
        bpy.ops.wm.open_mainfile(filepath=path)
        assert close(plate.points(), expected.lifted(0.5))
        bpy.ops.wm.open_mainfile(filepath=other)
        assert close(plate.points(), fine)


# --- append, link, override, make local


def read(path: str, link: bool, kind: str, name: str) -> bpy.types.ID:
    with bpy.data.libraries.load(path, link=link) as (_there, here):
        setattr(here, kind, [name])
    return getattr(here, kind)[0]


@pytest.fixture
def asset(plate: Rig, tmp_path: Path) -> tuple[str, Expected]:
    """A library with a lifted plate in the collection ``Asset``; the open file is empty again."""
    collection = bpy.data.collections.new("Asset")
    bpy.context.scene.collection.children.link(collection)
    plate.bind()
    expected = Expected.of(plate)
    plate.lift(0.5)
    for obj in (plate.obj, plate.control):
        collection.objects.link(obj)
    plate.points()
    path = save(tmp_path / "library.blend")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    return path, expected


def settle(room) -> None:
    """What a timer does in a window."""
    update()
    room("handlers.deferred").catch_up()
    update()


def test_append(asset: tuple[str, Expected], room):
    path, expected = asset
    collection = read(path, False, "collections", "Asset")
    bpy.context.scene.collection.children.link(collection)
    settle(room)
    rig = rig_called("Plate")
    assert close(rig.points(), expected.lifted(0.5))
    rig.lift(0.25)
    assert close(rig.points(), expected.lifted(0.75))


def test_append_twice_makes_two_rigs(asset: tuple[str, Expected], room):
    path, expected = asset
    for _ in range(2):
        collection = read(path, False, "collections", "Asset")
        bpy.context.scene.collection.children.link(collection)
    settle(room)
    first, second = (obj for obj in bpy.data.objects if obj.sinew.deformers)
    for obj, height in ((first, 0.25), (second, -0.25)):
        move_world(obj.sinew.deformers[0].handles[0].control, Matrix.Translation((0.0, 0.0, height)))
    assert close(evaluated_points(first), expected.lifted(0.75))
    assert close(evaluated_points(second), expected.lifted(0.25))
    assert first.sinew.deformers[0].proxy != second.sinew.deformers[0].proxy


def test_append_into_a_file_that_has_the_rig_itself(asset: tuple[str, Expected], room, tmp_path: Path):
    """The same keys come in once more."""
    path, expected = asset
    bpy.ops.wm.open_mainfile(filepath=path)
    save(tmp_path / "other.blend")  # no file appends from itself
    rig = rig_called("Plate")
    copy = read(path, False, "objects", "Plate")
    bpy.context.scene.collection.objects.link(copy)
    settle(room)
    assert copy.name != "Plate"
    rig.lift(0.25)
    assert close(rig.points(), expected.lifted(0.75))
    assert close(evaluated_points(copy), expected.now(copy, copy.sinew.deformers[0].handles[0].control))


def test_append_by_the_file_browsers_operator(asset: tuple[str, Expected], room):
    path, expected = asset
    bpy.ops.wm.append(directory=f"{path}/Object/", filename="Plate")
    settle(room)
    rig = rig_called("Plate")
    rig.lift(0.25)
    assert close(rig.points(), expected.lifted(0.75))


def test_an_instance_of_a_linked_collection_shows_the_last_solution(asset: tuple[str, Expected], room):
    path, expected = asset
    collection = read(path, True, "collections", "Asset")
    instance = bpy.data.objects.new("Instance", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", collection
    bpy.context.scene.collection.objects.link(instance)
    settle(room)
    for frame in (1, 7):
        bpy.context.scene.frame_set(frame)
        shown = instanced_points("Plate")
        assert len(shown) == 1
        assert close(shown[0], expected.lifted(0.5))


def instanced_points(name: str) -> list[np.ndarray]:
    """What each instance of the object shows, object space."""
    update()
    found = []
    for instance in bpy.context.evaluated_depsgraph_get().object_instances:
        if instance.is_instance and instance.object.name == name:
            flat = np.empty(len(instance.object.data.vertices) * 3, dtype=np.float32)
            instance.object.data.vertices.foreach_get("co", flat)
            found.append(flat.reshape(-1, 3).astype(float))
    return found


def override(path: str) -> bpy.types.Object:
    """A hierarchy override of the asset, as the outliner makes it; its mesh object."""
    collection = read(path, True, "collections", "Asset")
    bpy.context.scene.collection.children.link(collection)
    update()
    collection.override_hierarchy_create(bpy.context.scene, bpy.context.view_layer)
    update()
    return overridden()


def overridden() -> bpy.types.Object:
    return next(obj for obj in bpy.data.objects if obj.override_library and obj.sinew.deformers)


def test_an_override_whose_hidden_shapes_are_overridden_too(asset: tuple[str, Expected], room, tmp_path):
    """Blender 3.4 does that by itself; an override of a shape object still shows the library's mesh."""
    path, expected = asset
    obj = override(path)
    for name in ("proxy", "proxy_render"):
        shape = getattr(obj.sinew.deformers[0], name)
        if shape is not None and shape.library is not None:
            shape.override_create(remap_local_usages=True)
    settle(room)
    control = obj.sinew.deformers[0].handles[0].control
    move_world(control, Matrix.Translation((0.0, 0.0, 0.25)))
    assert close(evaluated_points(obj), expected.lifted(0.75), MATRIX)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shot.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "shot.blend"))
    settle(room)
    assert close(evaluated_points(overridden()), expected.lifted(0.75), MATRIX)


def test_an_override_lives_through_a_change_of_its_library(asset: tuple[str, Expected], room, tmp_path):
    path, expected = asset
    obj = override(path)
    settle(room)
    move_world(obj.sinew.deformers[0].handles[0].control, Matrix.Translation((0.0, 0.0, 0.25)))
    shot = save(tmp_path / "shot.blend")
    bpy.ops.wm.open_mainfile(filepath=path)
    source = rig_called("Plate")
    source.lift(0.1)
    source.points()
    bpy.ops.wm.save_mainfile()
    bpy.ops.wm.open_mainfile(filepath=shot)
    settle(room)
    obj = overridden()
    control = obj.sinew.deformers[0].handles[0].control
    assert close(evaluated_points(obj), expected.now(obj, control), MATRIX)
    move_world(control, Matrix.Translation((0.0, 0.0, 0.25)))
    assert close(evaluated_points(obj), expected.now(obj, control), MATRIX)


@pytest.mark.parametrize("overriding", [False, True])
def test_a_library_reloaded_after_it_changed(asset: tuple[str, Expected], room, tmp_path, overriding: bool):
    """As Reload in the outliner: a linked rig shows the new solution, an override its own pose."""
    path, expected = asset
    if overriding:
        obj = override(path)
        settle(room)
        move_world(obj.sinew.deformers[0].handles[0].control, Matrix.Translation((0.0, 0.0, 0.25)))
    else:
        bpy.context.scene.collection.objects.link(read(path, True, "objects", "Plate"))
    update()
    found = another_blender(
        f"""
        bpy.ops.wm.open_mainfile(filepath={path!r})
        rig = Rig.__new__(Rig)
        rig.name = "Plate"
        rig.lift(0.1)
        rig.points()
        bpy.ops.wm.save_mainfile()
        """,
        tmp_path,
        room("ids").__package__,
    )
    assert not found["error"]
    bpy.data.libraries[0].reload()
    settle(room)
    if overriding:
        obj = overridden()
        control = obj.sinew.deformers[0].handles[0].control
        assert close(evaluated_points(obj), expected.now(obj, control), MATRIX)
        move_world(control, Matrix.Translation((0.0, 0.0, 0.25)))
        assert close(evaluated_points(obj), expected.now(obj, control), MATRIX)
    else:
        assert close(evaluated_points(bpy.context.scene.objects["Plate"]), expected.lifted(0.6), MATRIX)


def test_an_override_reset_to_its_library(asset: tuple[str, Expected], room):
    """All of its own values go, the shapes of its own included; it can be posed again at once."""
    path, expected = asset
    obj = override(path)
    settle(room)
    control = obj.sinew.deformers[0].handles[0].control
    move_world(control, Matrix.Translation((0.0, 0.0, 0.25)))
    assert close(evaluated_points(obj), expected.lifted(0.75), MATRIX)
    obj.override_library.reset()
    control.override_library.reset()
    settle(room)
    obj = overridden()
    control = obj.sinew.deformers[0].handles[0].control
    assert close(evaluated_points(obj), expected.now(obj, control), MATRIX)
    move_world(control, Matrix.Translation((0.0, 0.0, 0.25)))
    assert close(evaluated_points(obj), expected.now(obj, control), MATRIX)


@pytest.mark.parametrize("overriding", [False, True])
def test_make_local(asset: tuple[str, Expected], room, overriding: bool):
    path, expected = asset
    if overriding:
        obj = override(path)
        settle(room)
    else:
        collection = read(path, True, "collections", "Asset")
        bpy.context.scene.collection.children.link(collection)
    update()
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.make_local(type="ALL")
    settle(room)
    obj = next(obj for obj in bpy.context.scene.objects if obj.sinew.deformers)
    assert obj.library is None
    control = obj.sinew.deformers[0].handles[0].control
    assert close(evaluated_points(obj), expected.lifted(0.5), MATRIX)
    move_world(control, Matrix.Translation((0.0, 0.0, 0.25)))
    assert close(evaluated_points(obj), expected.lifted(0.75), MATRIX)
    make_active(obj)
    bpy.ops.sinew.bind()
    assert close(evaluated_points(obj), expected.lifted(0.75), MATRIX)


def test_make_local_of_the_mesh_object_alone(asset: tuple[str, Expected], room):
    """Its control stays in the library, where nobody moves it."""
    path, expected = asset
    obj = read(path, True, "objects", "Plate")
    bpy.context.scene.collection.objects.link(obj)
    update()
    local = obj.make_local()
    settle(room)
    assert close(evaluated_points(local), expected.lifted(0.5), MATRIX)
    new = bpy.data.objects.new("New", None)
    bpy.context.scene.collection.objects.link(new)
    local.sinew.deformers[0].handles[0].control = new
    settle(room)
    move_world(new, Matrix.Translation((0.0, 0.0, 0.25)))
    assert close(evaluated_points(local), expected.lifted(0.75), MATRIX)


# --- the add-on off, on, upgraded, missing


def handlers_of_ours() -> int:
    return sum(
        "sinew" in getattr(handler, "__module__", "")
        for kind in dir(bpy.app.handlers)
        if isinstance(getattr(bpy.app.handlers, kind), list)
        for handler in getattr(bpy.app.handlers, kind)
    )


def test_disabled_and_enabled(plate: Rig, addon_name: str):
    plate.bind()
    expected = Expected.of(plate)
    plate.lift(0.5)
    control, count = plate.control.name, handlers_of_ours()
    addon_utils.disable(addon_name)
    try:
        assert handlers_of_ours() == 0
        move_world(bpy.data.objects[control], Matrix.Translation((0.0, 0.0, 0.25)))
        bpy.context.scene.frame_set(3)
        assert close(plate.points(), expected.lifted(0.5))
        grid_object("Other")
        bpy.data.objects.remove(bpy.data.objects["Other"])
    finally:
        addon_utils.enable(addon_name)
    assert handlers_of_ours() == count
    plate.obj.update_tag()
    assert close(plate.points(), expected.lifted(0.75))
    plate.lift(0.25)
    assert close(plate.points(), expected.lifted(1.0))


def test_enabled_in_a_scene_that_was_loaded_without(saved: tuple[str, Expected], addon_name: str):
    path, expected = saved
    addon_utils.disable(addon_name)
    try:
        bpy.ops.wm.open_mainfile(filepath=path)
        control = next(obj.name for obj in bpy.data.objects if obj.type == "EMPTY")
        move_world(bpy.data.objects[control], Matrix.Translation((0.0, 0.0, 0.25)))
    finally:
        addon_utils.enable(addon_name)
    rig = rig_called("Plate")
    rig.lift(0.25)
    assert close(rig.points(), expected.lifted(1.0))


def test_upgraded_while_a_rig_is_open(plate: Rig, addon_name: str):
    """The old code is unloaded and read again; the native module stays until Blender ends."""
    plate.bind()
    expected = Expected.of(plate)
    plate.lift(0.5)
    plate.points()
    old = {
        name: module
        for name, module in sys.modules.items()
        if (name == addon_name or name.startswith(addon_name + ".")) and "_native" not in name
    }
    count = handlers_of_ours()
    sys.modules[addon_name].unregister()
    for name in old:
        del sys.modules[name]
    new = importlib.import_module(addon_name)
    try:
        new.register()
        assert handlers_of_ours() == count
        plate.lift(0.25)
        assert close(plate.points(), expected.lifted(0.75))
        assert plate.deformer.status_level == "INFO"
        make_active(plate.obj)
        bpy.ops.sinew.bind()
        plate.lift(0.25)
        assert close(plate.points(), expected.lifted(1.0))
    finally:
        new.unregister()
        sys.modules.update(old)
        sys.modules[addon_name].register()


def test_a_blender_without_the_add_on_shows_saves_and_gives_back(saved: tuple[str, Expected], tmp_path: Path):
    """It opens the file, moves the control, plays, saves; back here the file lives on with its settings."""
    path, expected = saved
    passed_on = str(tmp_path / "passed_on.blend")
    found = another_blender(
        f"""
        bpy.ops.wm.open_mainfile(filepath={path!r})
        obj = bpy.data.objects["Plate"]
        seen["points"] = evaluated_points(obj).tolist()
        control = next(other for other in bpy.data.objects if other.type == "EMPTY")
        move_world(control, __import__("mathutils").Matrix.Translation((0.0, 0.0, 0.25)))
        bpy.context.scene.frame_set(5)
        seen["later"] = evaluated_points(obj).tolist()
        seen["has_sinew"] = hasattr(obj, "sinew")
        bpy.ops.wm.save_as_mainfile(filepath={passed_on!r})
        """,
        tmp_path,
    )
    assert not found["has_sinew"]
    assert close(np.array(found["points"]), expected.lifted(0.5))
    assert close(np.array(found["later"]), expected.lifted(0.5))
    bpy.ops.wm.open_mainfile(filepath=passed_on)
    rig = rig_called("Plate")
    assert [handle.vertex_group for handle in rig.deformer.handles] == ["Top", "Base"]
    assert close(rig.points(), expected.lifted(0.75))
    rig.lift(0.25)
    assert close(rig.points(), expected.lifted(1.0))


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
    saved: tuple[str, Expected], tmp_path: Path, addon_name: str, fault: str
):
    """A module built for another Python does not load: here a library that is no Python module at all."""
    path, expected = saved
    prelude = MISSING
    if fault == "wrong python":
        foreign = tmp_path / "sinew_native.cpython-399-x86_64-linux-gnu.so"
        foreign.write_bytes(b"\x7fELF" + bytes(60))
        prelude = WRONG_PYTHON.format(path=str(foreign))
    found = another_blender(
        f"""
        seen["enabled"] = hasattr(bpy.types.Object, "sinew")
        bpy.ops.wm.open_mainfile(filepath={path!r})
        rig = Rig.__new__(Rig)
        rig.name = "Plate"
        seen["points"] = rig.points().tolist()
        rig.lift(0.25)
        bpy.context.scene.frame_set(3)
        seen["later"] = rig.points().tolist()
        seen["status"], seen["level"] = rig.deformer.status, rig.deformer.status_level
        make_active(rig.obj)
        try:
            bpy.ops.sinew.bind()
        except RuntimeError as refusal:
            seen["refusal"] = str(refusal)
        seen["after"] = rig.points().tolist()
        seen["bound"] = rig.deformer.is_bound
        bpy.ops.wm.save_as_mainfile(filepath={path!r})
        """,
        tmp_path,
        addon_name,
        prelude,
    )
    assert found["enabled"]
    for moment in ("points", "later", "after"):
        assert close(np.array(found[moment]), expected.lifted(0.5))
    assert found["level"] == "ERROR"
    version = f"cp{sys.version_info.major}{sys.version_info.minor}"
    for text in (found["status"], found["refusal"]):
        assert ("does not load" if fault == "wrong python" else "is missing") in text
        assert version in text
    assert found["bound"]
    bpy.ops.wm.open_mainfile(filepath=path)  # here the module is there
    assert close(rig_called("Plate").points(), expected.lifted(0.75))
