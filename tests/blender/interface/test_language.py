# SPDX-License-Identifier: GPL-3.0-or-later
"""What things are called: methods, new regions, and all of it in other languages."""

from pathlib import Path

import bpy
import pytest
from editing import select
from inside import inner
from rigs.rig import Rig, add_armature, in_mode, make_active, refused, reopen
from rigs.sheet import WIDE, draw_panel


def shown_names(deformer) -> tuple[str, ...]:
    """What the menus of methods show: of a deformer, of a base, of the preferences."""
    name = bpy.types.UILayout.enum_item_name
    around = deformer.multiresolution
    preferences = inner.preferences.preferences(bpy.context)
    return (
        name(deformer, "method", "arap"),
        name(around, "base", "arap"),
        name(preferences, "method", "arap"),
        bpy.types.UILayout.enum_item_description(deformer, "method", "arap").splitlines()[-1],
    )


@pytest.mark.parametrize("names", ["TASKS", "LITERATURE"])
def test_artists_read_names_by_tasks_or_at_once_those_of_the_literature(plate: Rig, names, tmp_path: Path):
    preferences = inner.preferences.preferences(bpy.context)
    preferences.names = names
    try:
        plate.bind("arap")
        label, other = "Natural Bend", "As-Rigid-As-Possible"
        keyed = "Keyed Bend" if names == "TASKS" else "Mesh Sequence"
        label, other = (label, other) if names == "TASKS" else (other, label)
        assert shown_names(plate.deformer) == (label, label, label, f"Known as {other}")
        refused(f"Choose a method that has keys: {keyed}", "key_add", plate.obj)
        assert (plate.deformer.method, plate.deformer.name) == ("arap", "Limb"), "what files store stays"
        reopen(tmp_path / "names.blend")
        assert plate.deformer.method == "arap"
    finally:
        inner.preferences.preferences(bpy.context).names = "TASKS"


def pressed_at(plate: Rig, wanted, role: str = "HANDLE") -> str:
    """The name of a region made of the vertices of a plate, from -1 to 1, that are ``wanted``."""
    with in_mode(plate.obj):
        select(plate.obj, wanted)
        bpy.ops.sinew.handle_add(kind=role)
    make_active(plate.obj)
    return plate.obj.sinew.active.handles[-1].name


def test_a_region_is_called_after_its_role_its_side_and_its_number(plate: Rig):
    assert pressed_at(plate, lambda co: abs(co.x) < 0.3 and co.y > 0.7) == "Handle"
    assert pressed_at(plate, lambda co: abs(co.x) < 0.3 and co.y < -0.7) == "Handle 2"
    assert pressed_at(plate, lambda co: co.x > 0.7 and co.y > 0.7) == "Handle L"
    assert pressed_at(plate, lambda co: co.x > 0.7 and co.y < -0.7) == "Handle 2 L"
    assert pressed_at(plate, lambda co: co.x < -0.7) == "Handle R"
    assert pressed_at(plate, lambda co: co.length < 0.2, "FIXED") == "Still"


def test_a_handle_is_called_after_the_nearest_bone(plate: Rig):
    armature = add_armature(plate.obj)  # low and high, along y
    assert pressed_at(plate, lambda co: co.y > 0.7 and abs(co.x) < 0.3) == "High"
    assert pressed_at(plate, lambda co: co.y < -0.7 and abs(co.x) < 0.3) == "Low"
    armature.data.bones["low"].use_deform = False
    assert pressed_at(plate, lambda co: co.y < -0.7 and co.x > 0.6) == "High 2"


@pytest.mark.parametrize(
    ("bone", "said"),
    [("upper_arm.L", "Upper Arm L"), ("hand.R.001", "Hand R"), ("DEF-spine", "DEF Spine"), ("Head", "Head")],
)
def test_bones_are_spoken_as_people_write_them(bone: str, said: str):
    assert inner.names.spoken(bone) == said
    assert inner.names.numbered(said, ()) == said


def test_a_number_stands_before_the_side():
    assert inner.names.numbered("Hand L", {"Hand L", "Hand 2 L"}) == "Hand 3 L"
    assert inner.names.numbered("Cage", {"Cage"}) == "Cage 2"


@pytest.fixture
def german(monkeypatch: pytest.MonkeyPatch):
    """A table as someone may add it, in use."""
    translation = inner.translation
    words = {
        "Nothing is selected - select the vertices of the region first": "Nichts ist ausgewählt",
        "Choose a method that has keys: ...": "Nimm eine Methode mit Keys: {0}",
        "... vertices": "{0} Punkte",
        "1 handle": "1 Griff",
        "Follows": "Folgt",
    }
    monkeypatch.setitem(translation.LANGUAGES, "de_DE", words)
    monkeypatch.setattr(translation, "_locale", lambda: "de_DE")
    translation.register()
    yield translation
    translation.unregister()


def test_a_language_is_added_with_one_table(plate: Rig, german, capfd: pytest.CaptureFixture):
    """Whole sentences, sentences around names and numbers, clauses of a list; all else stays."""
    plate.bind("thin_shell")
    refused("Nimm eine Methode mit Keys: Keyed Bend", "key_add", plate.obj)
    assert german.told("1,234 vertices, 1 handle, bound in 3 ms") == "1,234 Punkte, 1 Griff, bound in 3 ms"
    assert german.told("Nobody has this sentence") == "Nobody has this sentence"
    with in_mode(plate.obj):
        bpy.ops.mesh.select_all(action="DESELECT")
        with pytest.raises(RuntimeError, match="Nichts ist ausgewählt"):
            bpy.ops.sinew.handle_add()
    make_active(plate.obj)
    assert "Folgt, " in draw_panel(WIDE).texts()


def test_without_a_table_nothing_changes(plate: Rig):
    assert not inner.translation.LANGUAGES
    assert inner.translation.told("1 handle, 1 still") == "1 handle, 1 still"
