# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys that nobody else has, the page in Preferences, and the manual behind the question marks."""

import importlib.util
from pathlib import Path
from types import SimpleNamespace

import bpy
import pytest
from inside import inner
from rigs.rig import Rig, refused
from rigs.sheet import Sheet


def default_keymaps() -> list[tuple[str, dict, dict]]:
    """Blender's own keymaps, as its preset makes them."""
    (path,) = Path(bpy.utils.system_resource("SCRIPTS")).glob(
        "presets/keyconfig/keymap_data/blender_default.py"
    )
    spec = importlib.util.spec_from_file_location("blender_default_keymap", path)
    preset = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(preset)
    return preset.generate_keymaps(preset.Params())


MODIFIERS = ("shift", "ctrl", "alt", "oskey")


def test_our_keys_are_free_in_every_keymap_of_the_3d_viewport():
    wanted = {
        (shortcut.key, *(bool(getattr(shortcut, name, False)) for name in MODIFIERS)): shortcut.operator
        for shortcut in inner.preferences.SHORTCUTS
    }
    taken, keys = [], 0
    for name, place, content in default_keymaps():
        if place["space_type"] not in {"EMPTY", "VIEW_3D"} or place.get("modal"):
            continue
        for item in content["items"]:
            event = item[1]
            keys += 1
            exact = (event["type"], *(event.get(modifier, False) is True for modifier in MODIFIERS))
            loose = [key for key in wanted if key[0] == event["type"] and event.get("any")]
            if exact in wanted or loose:
                taken.append(f"{name}: {item[0]} has the key of {wanted.get(exact, loose)}")
    assert keys > 500
    assert not taken, taken


class KeyItems(list):
    def new(self, idname, key, value, **modifiers):
        self.append(SimpleNamespace(idname=idname, type=key, properties=SimpleNamespace(), **modifiers))
        return self[-1]


class KeyMaps(dict):
    def new(self, name, space_type):
        return self.setdefault(name, SimpleNamespace(name=name, keymap_items=KeyItems()))


def with_keys(monkeypatch, made) -> None:
    manager = SimpleNamespace(keyconfigs=SimpleNamespace(addon=made))
    fake = SimpleNamespace(context=SimpleNamespace(window_manager=manager))
    monkeypatch.setattr(inner.keymap, "bpy", fake)


def test_keys_come_and_go_with_the_add_on(monkeypatch):
    """In a keyconfig as a window has it, with a key of someone else."""
    keyconfig = SimpleNamespace(keymaps=KeyMaps())
    items = keyconfig.keymaps.new("3D View", "VIEW_3D").keymap_items
    items.new("wm.call_menu_pie", "Q", "PRESS").properties.name = "X"
    with_keys(monkeypatch, keyconfig)
    inner.keymap.register()
    assert [item.idname for item in items[1:]] == [s.operator for s in inner.preferences.SHORTCUTS]
    assert [item.type for item in items[1:]] == [s.key for s in inner.preferences.SHORTCUTS]
    items[1].type = "F5"  # the user's choice
    inner.keymap.unregister()
    assert [item.type for item in items] == ["Q"]


def test_without_a_keyconfig_there_are_no_keys_and_no_error(monkeypatch):
    with_keys(monkeypatch, None)
    inner.keymap.register()
    inner.keymap.unregister()


def test_every_key_calls_something_that_exists():
    for shortcut in inner.preferences.SHORTCUTS:
        group, _dot, name = shortcut.operator.partition(".")
        properties = getattr(getattr(bpy.ops, group), name).get_rna_type().properties
        for key, value in shortcut.properties:
            assert key in properties
            assert hasattr(bpy.types, value)


@pytest.fixture
def values(addon_name):
    """Our preferences, as they were before the test."""
    found = bpy.context.preferences.addons[addon_name].preferences
    names = [p.identifier for p in found.bl_rna.properties if p.identifier not in {"rna_type", "bl_idname"}]
    yield found
    for name in names:
        found.property_unset(name)


@pytest.mark.parametrize("section", ["GENERAL", "OVERLAYS", "KEYMAP"])
def test_the_preferences_page_shows_module_and_section(values, room, section):
    values.section = section
    sheet = Sheet()
    stand_in = SimpleNamespace(layout=sheet, section=section)
    for name in ("_draw_general", "_draw_overlays", "_draw_keymap"):
        setattr(stand_in, name, getattr(type(values), name).__get__(stand_in))
    type(values).draw(stand_in, bpy.context)
    assert f"Native module {room('ids').VERSION}" in sheet.texts()
    assert "section" in sheet.properties()
    wanted = {"GENERAL": "method", "OVERLAYS": "overlay_stretched", "KEYMAP": "section"}
    assert wanted[section] in sheet.properties()


def test_defaults_stand_in_where_blender_has_no_entry(values):
    defaults = inner.preferences.DEFAULTS
    nowhere = SimpleNamespace(preferences=SimpleNamespace(addons={}))
    assert inner.preferences.preferences(nowhere) is defaults
    assert inner.preferences.preferences(bpy.context).drag_budget == 40.0
    for name, value in vars(defaults).items():
        shown = getattr(values, name)
        assert (tuple(shown) if isinstance(value, tuple) else shown) == pytest.approx(value), name
    known = {prop.identifier for prop in values.bl_rna.properties}
    assert set(vars(defaults)) == known - {"bl_idname", "rna_type", "section"}


def test_limits_reach_the_native_module_on_change_and_on_load(values, monkeypatch):
    module = inner.backend.availability().module
    told = {"limit_threads": [], "limit_memory": []}
    for name, calls in told.items():
        monkeypatch.setattr(module, name, calls.append)
    values.threads = 3
    values.memory_limit = 1.5
    assert told["limit_threads"][-1] == 3
    assert told["limit_memory"][-1] == 3 * 2**29
    for calls in told.values():
        calls.clear()
    inner.native.availability.cache_clear()  # as in a new process
    inner.backend.availability()
    assert [calls[-1] for calls in told.values()] == [3, 3 * 2**29]


def test_new_deformers_start_with_the_preferred_method(values, plate: Rig):
    values.method = "thin_shell"
    bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group="Top")
    assert plate.deformer.method == "thin_shell"


def test_a_packaged_page_comes_first_then_the_one_of_a_checkout(monkeypatch, tmp_path):
    help_room = inner.help
    monkeypatch.setattr(help_room, "_ADDON", tmp_path / "addon")
    for path in ("addon/manual/show.html", "docs/manual/show.md", "docs/manual/bake.md"):
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text("page", encoding="utf-8")
    assert help_room.manual_page("show") == tmp_path / "addon/manual/show.html"
    assert help_room.manual_page("bake") == tmp_path / "docs/manual/bake.md"
    refused("install the Sinew zip again", "help", page="handles")


def test_help_tells_the_path_where_there_is_no_window(monkeypatch, tmp_path, capfd):
    (tmp_path / "manual").mkdir()
    page = tmp_path / "manual/troubles.html"
    page.write_text("page", encoding="utf-8")
    monkeypatch.setattr(inner.help, "_ADDON", tmp_path)
    assert bpy.ops.sinew.help(page="troubles") == {"FINISHED"}
    assert str(page) in "".join(capfd.readouterr())
