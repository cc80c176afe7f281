# SPDX-License-Identifier: GPL-3.0-or-later
"""The pages for artists name what artists see: menus, buttons, settings, keys and messages.

**Bold** is a name that Sinew shows, *italics* one of Sinew or Blender, or a message. Names around " > " are a
path, each step of which is shown by the one before. "(v)" is a menu behind an arrow.
"""

import functools
import re
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import bpy
import messages
from inside import inner
from pages import MANUAL, PAGES, ROOT, Name, blocks, keys, names
from registry import METHODS
from rigs.rig import new_file, save
from situations import (
    SITUATIONS,
    Step,
    choices_of,
    first_steps,
    leads_somewhere,
    operator_rna,
    our_structs,
    sidebar,
    visible,
)
from test_interface_keys import default_keymaps

# Where the first steps of a page begin: what they name is there before Sinew has done anything.
_OF_A_MESH = ("start", "bend-a-limb", "shape-a-sheet", "put-in-a-box", "wrap-in-a-cage", "brows-and-folds")
_IN_EDIT_MODE = ("../../README", "edit-an-animation", "shape-it-once", "handles")
BEGINNINGS = {
    **dict.fromkeys((*_OF_A_MESH, "push-like-clay", "morph-and-copy"), "a mesh"),
    **dict.fromkeys(_IN_EDIT_MODE, "a mesh in Edit Mode"),
    "correct-an-elbow": "a posed mesh",
    "move-loose-parts": "a text",
    "pose-by-bones": "a puppet",
}
# Names that neither Sinew nor Blender shows: titles, names of an artist's own things, and what a system says.
OTHERS = {
    "Interactive Shape Modeling and Deformation",
    "built, never run",
    "Basis",  # Blender's name for the first shape key
    "Zero",  # the key of an exact bake
    "Handle.L",
    "Handle.R",
    "Damaged, too short, not a valid application",
    "Blocked, quarantine, system policy, virus",
    "Module or library not found",
    "Privacy & Security",
}


class Button(NamedTuple):
    """A button of ours, and where it can be pressed."""

    situation: str
    step: Step

    def __call__(self) -> set[str]:
        return getattr(bpy.ops.sinew, self.step.operator.partition(".")[2])(**vars(self.step.settings))


class Seen(NamedTuple):
    """What a tour through all situations shows."""

    labels: set[str]
    operators: dict[str, str]  # by label, whether they can be pressed or not
    buttons: dict[str, Button]  # by label
    paths: dict[tuple[str, ...], set[str]]  # by path of a page: where it leads somewhere
    tab: dict[str, set[str]]  # the labels in our tab before there is a deformer, by situation


@functools.cache
def tour() -> Seen:
    seen = Seen(set(), {}, {}, {tuple(name.steps): set() for name in paths_of_this_blender()}, {})
    for situation, begin in SITUATIONS.items():
        new_file()
        begin()
        for step in visible():
            seen.labels.add(step.label)
            if step.operator.startswith("sinew.") and step.operator != "sinew.help":
                seen.operators[step.label] = step.operator
                if step.label not in seen.buttons and polls(step.operator):
                    seen.buttons[step.label] = Button(situation, step)
        first = list(first_steps())
        for path, where in seen.paths.items():
            if (not where or situation in BEGINNINGS.values()) and leads_somewhere(path, first):
                where.add(situation)
        if situation in BEGINNINGS.values():
            seen.tab[situation] = {step.label for step in sidebar()}
    new_file()
    return seen


def polls(operator: str) -> bool:
    group, _dot, verb = operator.partition(".")
    return getattr(getattr(bpy.ops, group), verb).poll()


def is_of_this_blender(name: Name) -> bool:
    """Whether the paragraph speaks of this release or of all, as "Blender 3.4 to 4.1" does of some."""
    spans = re.findall(r"Blender (\d)\.(\d+) to (\d)\.(\d+)", name.around)
    numbers = [tuple(map(int, span)) for span in spans]
    return all(span[:2] <= bpy.app.version[:2] <= span[2:] for span in numbers)


def is_headline(name: Name) -> bool:
    """What begins a paragraph as its title, or an item of the list in the README."""
    begins = name.around.removeprefix("- ").startswith(f"**{name.text}**")
    return begins and (name.text.endswith(".") or name.page == "README.md")


def all_names() -> list[Name]:
    return [name for page in PAGES for name in names(page)]


def all_blocks() -> list[str]:
    return [block for page in PAGES for block in blocks(page)]


def paths_of_this_blender() -> list[Name]:
    return [name for name in all_names() if len(name.steps) > 1 and is_of_this_blender(name)]


def single_names(marks: str) -> list[Name]:
    found = [name for name in all_names() if name.marks == marks and len(name.steps) == 1]
    return [name for name in found if not is_headline(name) and name.text not in OTHERS]


def words_of(structs: Iterable[bpy.types.Struct]) -> set[str]:
    """The names of structs, of their properties, and of the choices of these."""
    found = set()
    for struct in structs:
        found.add(struct.name)
        for known in struct.properties:
            found.add(known.name)
            if known.type == "ENUM":
                found.update(choices_of(known))
    return found


@functools.cache
def shown_by_sinew() -> frozenset[str]:
    tool = inner.drag_tool.SINEW_WT_drag.bl_label
    remedies = {button.text for button in inner.status_box.remedies().values()}
    kinds = {method.control.value for method in METHODS}
    methods = {name for method in METHODS for name in (method.label, method.known_as)}
    own = {bpy.types.SINEW_PT_sinew.bl_label, tool, inner.status_box.REFINING.partition(" - ")[0]}
    preferences = set(messages.sentences(messages.ADDON / "preferences" / "page.py"))
    return frozenset().union(
        tour().labels, words_of(our_structs()), remedies, kinds, methods, own, preferences
    )


@functools.cache
def shown_by_blender() -> frozenset[str]:
    classes = [getattr(bpy.types, name) for name in dir(bpy.types)]
    found = words_of(cls.bl_rna for cls in classes if hasattr(cls, "bl_rna"))
    found |= {getattr(cls, "bl_label", "") for cls in classes}
    for path in Path(bpy.utils.system_resource("SCRIPTS"), "startup", "bl_ui").glob("*.py"):
        found.update(re.findall(r'text="([^"]+)"', path.read_text(encoding="utf-8")))
    for group in dir(bpy.ops):
        found |= words_of(operator_rna(f"{group}.{name}") for name in dir(getattr(bpy.ops, group)))
    return frozenset(found)


def test_each_path_leads_to_what_it_names():
    assert not [str(name) for name in paths_of_this_blender() if not tour().paths[tuple(name.steps)]]


def test_the_first_steps_of_a_page_begin_without_a_deformer():
    """Paths in the first list that counts its items."""
    for name, beginning in BEGINNINGS.items():
        page = ROOT / "docs" / "manual" / f"{name}.md"
        items = [block for block in blocks(page) if re.match(r"\d+\. ", block)]
        end = next((n for n, block in enumerate(items) if n and block.startswith("1. ")), len(items))
        assert end > 1
        for name in names(page):
            if name.around in items[:end] and len(name.steps) > 1:
                assert beginning in tour().paths[tuple(name.steps)], str(name)


def test_what_is_said_to_be_in_our_tab_is_there_from_the_beginning():
    said = set()
    place = r"\*+Sinew\*+ (?:tab|panel)"
    for block in all_blocks():
        said.update(re.findall(rf"\*\*(?:[^*]+ > )?([^*>]+)\*\*[^*.]*in the {place}", block))
        said.update(re.findall(rf"[Ii]n the {place} (?:choose|press)\s+\*\*([^*]+)\*\*", block))
    assert len(said) > 4
    assert said <= set().union(*tour().tab.values())


def test_what_needs_no_deformer_is_not_said_to_be_beside_the_list_of_deformers():
    """Before there is one, there is no list."""
    told = (re.findall(r"\*\*([^*]+)\*\*, in the menu beside the list", block) for block in all_blocks())
    said = {name for names_told in told for name in names_told}
    assert said
    new_file()
    SITUATIONS["a mesh"]()
    early = {operator_rna(f"sinew.{name}").name for name in dir(bpy.ops.sinew) if polls(f"sinew.{name}")}
    assert not said & early


def test_the_manual_calls_methods_as_the_interface_does():
    """Names of the literature are no names of buttons: they stand in columns called "known as"."""
    known = {method.known_as for method in METHODS if method.known_as != method.label}
    told = [name for page in MANUAL for name in names(page) if name.text in known]
    assert not [str(name) for name in told]


def test_each_name_in_bold_is_shown_by_sinew():
    assert not [str(name) for name in single_names("**") if name.text not in shown_by_sinew()]


def test_each_name_in_italics_is_shown_by_sinew_or_blender():
    known = shown_by_sinew() | shown_by_blender()
    unknown = [name for name in single_names("*") if name.text not in known and is_of_this_blender(name)]
    assert not [str(name) for name in unknown if not is_message(name.text)]


@functools.cache
def is_message(entry: str) -> bool:
    """Whether the add-on has such a sentence, or the library a clause of it, perhaps without the capital."""
    if any(messages.says(sentence, entry) for sentence in messages.of_the_addon()):
        return True
    return any(clause in text for clause in messages.of_the_library() for text in (entry, entry.lower()))


def test_each_key_with_a_modifier_does_something():
    """It is ours, or one of Blender's."""
    known = {" ".join(sorted([*_modifiers(vars(key)), key.key])) for key in inner.preferences.SHORTCUTS}
    for _name, place, content in default_keymaps():
        if place["space_type"] in {"EMPTY", "VIEW_3D"}:
            known |= {" ".join(sorted([*_modifiers(item[1]), item[1]["type"]])) for item in content["items"]}
    modal = {f"{key} Shift" for key in "XYZ"} | {f"Shift {key}" for key in "XYZ"}  # while a drag of ours runs
    assert set().union(*map(keys, PAGES)) <= known | modal


def _modifiers(event: dict) -> list[str]:
    return [name.title() for name in ("shift", "ctrl", "alt") if event.get(name) is True]


def test_our_keys_are_on_the_pages():
    told = {key for page in PAGES for key in keys(page)}
    for shortcut in inner.preferences.SHORTCUTS:
        assert " ".join(sorted([*_modifiers(vars(shortcut)), shortcut.key])) in told, shortcut


def test_each_page_of_the_manual_can_be_opened_from_blender():
    opened = {page for page, *_rest in inner.operators.PAGES}
    assert all(inner.help.manual_page(page).is_file() for page in opened)
    assert opened == {page.stem for page in MANUAL} - {"README"} | {"methods/comparison"}


# Parts of sentences, descriptions, and what only a script or a button that was just pressed says.
NOT_LISTED = {
    text.replace("...", messages.GAP)
    for text in (
        "The ... - add some, or check the modifiers before Sinew",
        "The control of ...",
        "... - choose a space method",
        "... object - choose a space method, or convert it to a mesh",
        "... meshes, and ... is a ......",
        "... ... ... have",
        "... has no parts",
        "... ..., ..., bound in ...",
        "The ... of a ... cannot be selected",
        "The controls of handles have nothing that could be selected",
        "The ray has no direction, or is not finite - give three numbers for each",
        "The shape shown in viewports",
        "The shape shown in renders",
        "Vertex group that limits the deformation",
        "Where the incoming positions are kept",
        "Where the incoming indices are kept",
        "... alone moves no handle - name the vertices that follow it",
        "... is a ... of ... already",
        "... has no keys - choose ...",
        "... does not follow its controls now - the panel says why",
        "... stands on the surface and moves with it",
        "... stays in the world",
        "Override to Pose It",
    )
}


def entries(page: str) -> list[str]:
    """The messages in the first column of the tables of a page, and those in italics."""
    found = []
    for block in blocks(ROOT / page):
        first = block.split("|")[1].strip() if block.startswith("| ") else ""
        found += [entry.strip("* ") for entry in re.split(r"; |\*, \*", first) if entry]
    return found


def test_each_message_in_the_table_of_troubles_exists():
    told = [entry for entry in entries("docs/manual/troubles.md") if entry != "message"]
    assert len(told) > 50
    assert not [entry for entry in told if not is_message(entry)]


def test_each_message_of_the_status_box_is_on_a_page():
    told = [entry for page in MANUAL for entry in entries(page.relative_to(ROOT).as_posix())]
    shown = [text for text in messages.of_the_status_box() if text not in NOT_LISTED]
    assert len(shown) > 50
    untold = [text for text in shown if not any(messages.says(text, entry) for entry in told)]
    assert not [text.replace(messages.GAP, "...") for text in untold]


# Buttons that need a gesture, a selection of two, or a fault: the tests that press them.
PRESSED_BY = {
    "test_browser.py": ("Bone Skin", "Correct a Joint", "Keyed Bend", "Morph", "Wires"),
    "test_cage.py": ("Cage from Selected", "Show"),
    "test_control_grid.py": ("New Grid",),
    "test_drag_tool.py": tuple(f"Sinew Drag: {what}" for what in ("Bones", "Clay", "Points", "Surface")),
    "test_grab_region.py": ("Grab Once",),
    "test_handles.py": ("Make Handle on Selected Object or Bone",),
    "test_lattice.py": ("Lattice from Selected",),
    "test_loose_parts.py": ("Keep Inside Parts",),
    "test_morph.py": ("Morph to a Mesh",),
    "test_moved_twice.py": ("Turn Off Armature",),
    "test_puppet_skin.py": ("Skin by Bones",),
    "test_repair.py": ("Repair", "Unshare"),
    "test_riding.py": ("Surface",),
    "test_silhouette_sketch.py": ("Draw Outline",),
    "test_space_nonlinear.py": ("Refine",),
    "test_transfer.py": ("Copy the Motion",),
    "test_wires.py": ("Draw Wire", "Wire along Edges", "Wires from Selected"),
}
ELSEWHERE = {label: test for test, labels in PRESSED_BY.items() for label in labels}


def test_each_button_that_a_page_names_does_its_work(tmp_path: Path):
    named = {name.steps[-1] for name in all_names() if name.marks == "**"}
    pressed, refused = named & tour().buttons.keys() - ELSEWHERE.keys(), {}
    assert len(pressed) > 25
    for label in sorted(pressed):
        press = tour().buttons[label]
        new_file()
        SITUATIONS[press.situation]()
        bpy.context.scene.frame_end = 2
        save(tmp_path / "pressed.blend")  # bakes are written beside it
        try:
            assert press() == {"FINISHED"}
        except RuntimeError as error:
            refused[label] = str(error)
    assert not refused


def test_the_other_buttons_are_pressed_by_other_tests():
    for label, test in ELSEWHERE.items():
        source = next((ROOT / "tests" / "blender").rglob(test)).read_text(encoding="utf-8")
        operator = tour().operators[label]
        assert f"bpy.ops.{operator}" in source or f'"{operator.removeprefix("sinew.")}"' in source, label
