# SPDX-License-Identifier: GPL-3.0-or-later
"""The installed add-on, a fresh scene for each test, and the ways to look at a result."""

import importlib
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import bpy
import inside
import installed
import pytest
from baking import animate
from registry import without_method
from rigs.kinds import RIGS, HandleRig
from rigs.rig import Rig, new_file, save

# isort: split
import addon_utils  # comes with bpy, not before it


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--all-methods-in", default="test_", metavar="WORD", help="files that begin with it")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """What a method computes does not depend on Blender, where its kind of control may.

    So other files than those that WORD begins take of each of their tables one method of each kind.
    """
    seen, kept, left = set(), [], []
    for item in items:
        params = item.callspec.params if hasattr(item, "callspec") else {}
        alike = tuple((name, repr(without_method(value))) for name, value in sorted(params.items()))
        case = (item.path, item.function.__name__, alike)
        whole = item.path.name.startswith(config.getoption("--all-methods-in"))
        (kept if whole or case not in seen else left).append(item)
        seen.add(case)
    items[:] = kept
    config.hook.pytest_deselected(items=left)


@pytest.fixture(scope="session")
def addon_name() -> str:
    return installed.name()


@pytest.fixture(scope="session")
def addon(addon_name: str) -> ModuleType:
    return importlib.import_module(addon_name)


@pytest.fixture(scope="session")
def room(addon_name: str) -> Callable[[str], ModuleType]:
    """A room of the add-on by name, as ``room("core.status")``."""
    return inside.room


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo):
    """Fixtures learn whether the test itself passed."""
    report = (yield).get_result()
    if call.when == "call":
        item.stash[_PASSED] = report.passed


@pytest.fixture(autouse=True)
def comes_to_rest(scene: bpy.types.Scene, request: pytest.FixtureRequest) -> Iterator[None]:
    """After every test nothing is stuck, runs away, or stays behind; see ``inside.assert_at_rest``."""
    yield
    if request.node.stash.get(_PASSED, False):
        inside.assert_at_rest()
        assert all(keys.user for keys in bpy.data.shape_keys), "shape keys of removed datablocks are left"


@pytest.fixture(autouse=True)
def scene(addon_name: str, capfd: pytest.CaptureFixture):
    """An empty scene before, no traceback and no dependency cycle after."""
    new_file()
    if addon_name not in bpy.context.preferences.addons:
        addon_utils.enable(addon_name, default_set=True)
    if bpy.context.scene.world is None:
        bpy.context.scene.world = bpy.data.worlds.new("World")
    capfd.readouterr()
    yield bpy.context.scene
    said = "".join(capfd.readouterr())
    for word in ("Traceback", "Dependency cycle", "Error in bpy.app.handlers"):
        assert word not in said, said


@pytest.fixture
def preferences(addon_name: str) -> Iterator[bpy.types.AddonPreferences]:
    """The add-on's, without a memory limit before and after."""
    found = bpy.context.preferences.addons[addon_name].preferences
    found.memory_limit = 0.0
    yield found
    bpy.context.preferences.addons[addon_name].preferences.memory_limit = 0.0


@pytest.fixture(params=RIGS)
def rig(request: pytest.FixtureRequest) -> HandleRig:
    """One of each kind of control and target. Not bound."""
    return RIGS[request.param].new()


@pytest.fixture
def posed(rig: HandleRig, tmp_path: Path) -> HandleRig:
    """Bound and lifted by a half, with a folder of its own."""
    return lifted(rig, tmp_path)


def lifted(rig: HandleRig, folder: Path) -> HandleRig:
    rig.folder = folder
    rig.start().lift(0.5)
    assert rig.is_right()
    return rig


@pytest.fixture
def plate() -> Rig:
    """A grid 2 x 2 in the plane z = 0, its far edge a handle, its near edge fixed. Not bound."""
    return Rig.plate()


@pytest.fixture
def posed_plate(tmp_path: Path) -> HandleRig:
    """The plate, as ``posed``."""
    return lifted(HandleRig.new(), tmp_path)


@pytest.fixture
def bound_plate(plate: Rig) -> Rig:
    return plate.bind("thin_shell")


@pytest.fixture
def moving(plate: Rig) -> Rig:
    """A thin shell that bends over the frames 1 to 8."""
    plate.bind("thin_shell")
    animate(plate.control)
    return plate


@pytest.fixture
def saved(moving: Rig, tmp_path: Path) -> Rig:
    """The same, in a file in a folder of its own."""
    (tmp_path / "shot").mkdir()
    save(tmp_path / "shot" / "scene.blend")
    return moving


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    session.config.stash[_STATUS] = int(exitstatus)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config: pytest.Config) -> None:
    """Blender as a module may hang or crash on its way out."""
    os._exit(config.stash.get(_STATUS, 1))


_STATUS = pytest.StashKey[int]()
_PASSED = pytest.StashKey[bool]()


@pytest.fixture
def overlay(room, scene):
    """``ui.overlay``, with its updates followed as with a window, and a known opacity."""
    module = room("ui.overlays.overlay")
    module.cache.clear()
    preferences = room("preferences").preferences(bpy.context)
    preferences.overlay_opacity = 1.0
    bpy.context.scene.sinew.opacity = inside.OPACITY
    bpy.app.handlers.depsgraph_update_post.append(module.on_update)
    yield module
    bpy.app.handlers.depsgraph_update_post.remove(module.on_update)
    preferences.property_unset("overlay_opacity")


@pytest.fixture
def paint(overlay, room):
    """The picture of an object for some settings."""

    def picture(obj: bpy.types.Object, **wanted):
        for name, value in wanted.items():
            setattr(bpy.context.scene.sinew, name, value)
        look = room("ui.overlays.overlay_mesh").overlay_settings(bpy.context)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        return overlay.cache.overlay_mesh(obj, obj.sinew.active, look, depsgraph)

    return picture


@pytest.fixture
def viewport(scene):
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    region = next(region for region in area.regions if region.type == "WINDOW")
    with bpy.context.temp_override(window=window, screen=window.screen, area=area, region=region):
        yield bpy.context
