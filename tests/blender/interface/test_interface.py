# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist sees and reads: panels, lists, menus, tooltips."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import bpy
import pytest
from inside import inner
from pages import ROOT
from rigs.point_objects import bind, lattice
from rigs.rig import Rig, linked, make_active, on_all, refused, update
from rigs.sheet import NARROW, WIDE, DrawContext, Sheet, draw, draw_panel
from situations import our_structs

TIME = r"(less than )?[\d.]+ m?s"


def operator_types() -> dict[str, bpy.types.Struct]:
    ids = inner.ids.Operators
    names = [name for key, name in vars(ids).items() if key.isupper()]
    return {name: getattr(bpy.ops.sinew, name.partition(".")[2]).get_rna_type() for name in names}


def reachable(place: str, addon_name: str) -> tuple[set[str], set[str]]:
    """Operators and menus a search finds from one of Blender's menus, by our entries in it."""
    context, operators, seen = DrawContext(), set(), set()
    sheet = Sheet()
    for function in getattr(bpy.types, place)._dyn_ui_initialize():
        if function.__module__.startswith(addon_name):
            function(SimpleNamespace(layout=sheet), context)
    waiting = [sheet]
    while waiting:
        sheet = waiting.pop()
        operators.update(sheet.operator_names())
        for name in sheet.menus():
            if name not in seen:
                seen.add(name)
                waiting.append(draw(getattr(bpy.types, name), context))
    return operators, seen


@pytest.mark.parametrize(
    ("mode", "place"),
    [
        ("OBJECT", "VIEW3D_MT_object"),
        ("EDIT", "VIEW3D_MT_editor_menus"),
        ("EDIT", "VIEW3D_MT_edit_mesh_context_menu"),
        ("WEIGHT_PAINT", "VIEW3D_MT_paint_weight"),
    ],
)
def test_search_finds_every_operator_by_the_menus_of_each_mode(bound_plate: Rig, addon_name, mode, place):
    bpy.ops.object.mode_set(mode=mode)
    found, _menus = reachable(place, addon_name)
    shown = {name for name in operator_types() if not is_internal(name)}
    assert shown == found


def labels_of_buttons() -> list[str]:
    """Those of the main panel."""
    return [
        words.get("text", "") for name, _args, words, _settings in draw_panel().calls if name == "operator"
    ]


def is_internal(name: str) -> bool:
    """Only the add-on itself calls it."""
    room_name, verb = name.split(".")
    operator = getattr(bpy.types, f"{room_name.upper()}_OT_{verb}")
    return "INTERNAL" in getattr(operator, "bl_options", ())


def test_object_mode_offers_each_vertex_group_as_a_region(plate: Rig):
    for role, name in inner.ids.Menus.FOR_GROUPS.items():
        offered = [
            (settings.kind, settings.vertex_group)
            for operator, settings in draw(getattr(bpy.types, name)).operators()
            if operator == "sinew.handle_add"
        ]
        assert offered == [(role, "Top"), (role, "Base")]


def test_add_buttons_take_the_selection_in_edit_mode(bound_plate: Rig):
    bpy.ops.object.mode_set(mode="EDIT")
    kinds = [settings.kind for name, settings in draw_panel().operators() if name == "sinew.handle_add"]
    assert kinds == ["HANDLE", "FIXED", "SUPPORT"]


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_the_pie_has_eight_pieces_in_each_mode(bound_plate: Rig, mode):
    bpy.ops.object.mode_set(mode=mode)
    sheet = draw(bpy.types.SINEW_MT_pie)
    names = sheet.operator_names()
    assert len(names) + len(sheet.menus()) == 8
    assert ({"sinew.grab_region", "sinew.bind"} <= set(names)) == (mode == "EDIT")
    assert ({"sinew.reset_pose", "sinew.key_pose", "sinew.all_tasks"} <= set(names)) == (mode == "OBJECT")


def test_without_a_mesh_the_sidebar_alone_says_what_to_select():
    assert bpy.types.SINEW_PT_sinew.poll(bpy.context)
    assert not bpy.types.SINEW_PT_sinew_properties.poll(bpy.context)
    sheet = draw_panel()
    assert "Select a mesh, text, curve, hair or armature" in sheet.texts()
    assert not sheet.operator_names()


@pytest.mark.parametrize("kind", ["SURFACE", "META"])
def test_an_object_that_is_no_mesh_yet_says_how_it_becomes_one(kind, scene):
    if kind == "META":
        data = bpy.data.metaballs.new("Thing")
        data.elements.new()
    else:
        data = bpy.data.curves.new("Thing", kind)
    make_active(linked(bpy.data.objects.new("Thing", data)))
    sheet = draw_panel(WIDE)
    assert "Thing is a" in sheet.texts()
    assert "which Sinew cannot move" in sheet.texts()
    assert "object.convert" in sheet.operator_names()
    refused("Thing is a", "cage_add")
    bpy.ops.object.convert(target="MESH")
    assert "Wrap in a Cage" in labels_of_buttons()


def test_the_panel_says_that_the_mesh_follows_and_how_fast(bound_plate: Rig):
    """What a bind took in, scripts and the report read."""
    bound_plate.lift()
    said = draw_panel(WIDE).texts()
    assert re.search(rf"Follows, {TIME}", said), said
    assert re.search(rf"121 vertices, 1 handle, 1 still, bound in {TIME}", bound_plate.deformer.status)
    bpy.ops.sinew.unbind()
    assert "At rest" in draw_panel(WIDE).texts()


@pytest.mark.parametrize("width", [NARROW, WIDE])
def test_a_sentence_is_wrapped_whole_into_lines_that_fit(width):
    said = "This object is linked from another file - make a library override to pose it here"
    sheet, context = Sheet(), DrawContext(width)
    inner.text.draw_text(context, sheet, said, "INFO")
    lines = [keywords["text"] for name, _args, keywords, _settings in sheet.calls if name == "label"]
    assert " ".join(lines) == said
    assert max(len(line) for line in lines) * 4 < width  # no letter of the font is narrower on average
    assert len(lines) in ((3, 4) if width == NARROW else (1, 2))


def test_a_changed_topology_offers_rebind_above_everything_else(bound_plate: Rig):
    on_all(bound_plate.obj, bpy.ops.mesh.subdivide)
    bound_plate.deformer.auto_rebind = False
    update()
    sheet = draw_panel()
    drawn = [args[0] for name, args, *_rest in sheet.calls if name in ("operator", "template_list")]
    assert drawn[0] == "sinew.bind"
    assert drawn.index("SINEW_UL_handles") > 0


def of_target(element: str, *indices: int):
    elements = inner.elements
    return elements.Elements(elements.Owner.TARGET, element, indices)


def test_each_line_with_elements_selects_its_own_and_one_button_mends_all(bound_plate: Rig):
    """Also where the panel is longer than the window, a refusal is seen: it stands before the settings."""
    core, uid = inner.status, bound_plate.deformer.uid
    core.put(uid, core.Status(core.Level.ERROR, "Two regions share 4 vertices", of_target("vertex", 1, 2)))
    sheet = draw_panel(WIDE)
    assert sheet.texts().index("share") < sheet.texts().index("Shape a Sheet")
    select = [settings.line for name, settings in sheet.operators() if name == "sinew.select_problems"]
    assert select == [0]
    core.clear(uid)
    texts = ("4 coincident vertices", "3 faces without area", "2 loose vertices")
    mended = [
        core.Status(core.Level.WARNING, text, of_target("face", 1), core.Remedy.REPAIR) for text in texts
    ]
    plain = core.Status(core.Level.WARNING, "nothing to select")
    rebind = core.Status(core.Level.WARNING, "topology changed", remedy=core.Remedy.BIND)
    core.put_notes(uid, (mended[0], plain, *mended[1:], rebind))
    sheet = draw_panel()
    assert [s.line for name, s in sheet.operators() if name == "sinew.select_problems"] == [0, 1, 2]
    buttons = sheet.operator_names()
    assert buttons.count("sinew.repair") == 1
    assert buttons.index("sinew.repair") < buttons.index("sinew.bind")
    assert inner.situations.situation_of(bpy.context).page(bpy.context) == "troubles"


def test_every_remedy_has_a_button_that_exists(addon_name):
    remedies = inner.status_box.remedies()
    wanted = inner.status.Remedy
    assert set(remedies) == set(wanted) - {wanted.NONE}
    for button in remedies.values():
        group, _dot, name = button.operator.partition(".")
        properties = getattr(getattr(bpy.ops, group), name).get_rna_type().properties
        assert all(key in properties for key, _value in button.properties)
    assert dict(remedies[wanted.PREFERENCES].properties)["module"] == addon_name


@pytest.mark.parametrize("bound", [False, True])
def test_without_the_native_module_the_panel_leads_to_the_preferences(plate: Rig, room, monkeypatch, bound):
    if bound:
        plate.bind()
    missing = inner.backend.Availability(None, "Install a wheel")
    monkeypatch.setattr(room("ui.status_box"), "availability", lambda: missing)
    sheet = draw_panel()
    assert "preferences.addon_show" in sheet.operator_names()
    assert "native module" in sheet.texts()


def test_the_panel_shows_what_the_method_uses(plate: Rig):
    plate.bind("laplacian_editing")
    shown = {}
    for name in ("explicit", "estimated"):
        plate.deformer.parameters.transforms = name
        sheets = draw_panel(), draw(bpy.types.SINEW_PT_advanced)
        shown[name] = {name for sheet in sheets for name in sheet.properties()}
    assert shown["explicit"] - shown["estimated"] == {"field"}
    assert shown["estimated"] - shown["explicit"] == {"refits", "mean_frame", "substeps"}


def test_a_bind_under_way_shows_progress_and_a_way_out(bound_plate: Rig, monkeypatch):
    work = SimpleNamespace(fraction=0.42, stage="factorising")
    monkeypatch.setattr(inner.binding, "job", lambda _uid: work)
    sheet = draw_panel()
    words = [str(keywords) for _name, _args, keywords, _settings in sheet.calls]
    assert any("42%" in word and "factorising" in word for word in words)
    assert "sinew.cancel" in sheet.operator_names()


@pytest.mark.parametrize("caged", [None, "cage", "handles"])
def test_a_cage_being_made_shows_progress_in_place_of_its_button(plate: Rig, monkeypatch, caged):
    """For a first deformer, for one that has a cage, and beside one with handles. No second one begins."""
    assert not bpy.ops.sinew.cancel.poll()
    button = "Pose the Cage" if caged == "cage" else "Wrap in a Cage"
    if caged == "cage":
        bpy.ops.sinew.cage_add(faces=40)
        make_active(plate.obj)
    elif caged == "handles":
        plate.bind()
    assert (button in labels_of_buttons()) == (caged != "handles")
    work = SimpleNamespace(fraction=0.42, stage="flooding")
    monkeypatch.setattr(inner.making, "cage_work", lambda _name: work)
    sheet = draw_panel()
    assert button not in labels_of_buttons()
    assert sheet.operator_names().count("sinew.cancel") == 1
    assert any("42% flooding" in str(keywords) for _name, _args, keywords, _settings in sheet.calls)
    for operator in (bpy.ops.sinew.cage_add, bpy.ops.sinew.cage_faces):
        assert not operator.poll()
    assert bpy.ops.sinew.cancel.poll()


def draw_row(cls: type, owner, item, width: int) -> Sheet:
    sheet = Sheet()
    cls.draw_row(SimpleNamespace(), DrawContext(width), sheet, owner, item, 0, 0)
    return sheet


def test_a_handle_row_shows_its_colour_its_name_and_an_eye(bound_plate: Rig):
    deformer = bound_plate.deformer
    sheet = draw_row(bpy.types.SINEW_UL_handles, deformer, deformer.handles[0], NARROW)
    assert sheet.properties() == ["colour", "name", "enabled"]
    assert not sheet.operator_names()


@pytest.mark.parametrize("width", [NARROW, WIDE])
def test_a_lost_control_has_its_picker_in_the_row(bound_plate: Rig, width):
    bpy.data.objects.remove(bound_plate.control)
    deformer = bound_plate.deformer
    sheet = draw_row(bpy.types.SINEW_UL_handles, deformer, deformer.handles[0], width)
    assert "control" in sheet.properties()
    assert "lost its control" in draw_panel().texts()


def test_a_deformer_row_mutes_its_modifier_in_viewport_and_render(bound_plate: Rig):
    obj = bound_plate.obj
    obj.modifiers.new("Other", "SUBSURF")
    bpy.ops.object.modifier_move_to_index(modifier="Other", index=0)
    sheet = draw_row(bpy.types.SINEW_UL_deformers, obj.sinew, obj.sinew.deformers[0], WIDE)
    toggles = [(args[0].name, args[1]) for name, args, *_rest in sheet.calls if name == "prop"][-2:]
    assert toggles == [("Sinew", "show_viewport"), ("Sinew", "show_render")]


def test_the_row_of_a_lattice_mutes_its_key():
    obj, _cage = bind(lattice())
    sheet = draw_row(bpy.types.SINEW_UL_deformers, obj.sinew, obj.sinew.deformers[0], WIDE)
    toggled, name = [(args[0], args[1]) for name, args, *_rest in sheet.calls if name == "prop"][-1]
    assert (toggled, name) == (obj.data.shape_keys.key_blocks["Sinew"], "mute")


def panels(space: str) -> dict[str, type]:
    """Without popovers."""
    found = {name: getattr(bpy.types, name) for name in dir(bpy.types) if name.startswith("SINEW_PT")}
    return {
        name: cls
        for name, cls in found.items()
        if cls.bl_space_type == space and cls.bl_region_type != "HEADER"
    }


def test_the_modifiers_tab_has_every_panel_of_the_sidebar(bound_plate: Rig):
    sidebar, tab = panels("VIEW_3D"), panels("PROPERTIES")
    assert {name + "_properties" for name in sidebar} == set(tab)
    assert len(sidebar) > 2
    for name, cls in sidebar.items():
        twin = tab[name + "_properties"]
        assert twin.bl_context == "modifier"
        parents = [getattr(each, "bl_parent_id", "") for each in (cls, twin)]
        assert parents[1] == (parents[0] and parents[0] + "_properties")
        calls, others = (
            [(method, repr(args[1:]), keywords) for method, args, keywords, _s in draw(each).calls]
            for each in (cls, twin)
        )
        assert calls == others


def shown_properties() -> list[tuple[str, bpy.types.Property]]:
    """Every property of ours that an artist may meet, and where it is."""
    groups = (bpy.types.AddonPreferences, bpy.types.PropertyGroup)
    inherited = {prop.identifier for group in groups for prop in group.bl_rna.properties} - {"name"}
    found = [(struct, prop) for struct in our_structs() for prop in struct.properties]
    return [
        (f"{struct.identifier}.{prop.identifier}", prop)
        for struct, prop in found
        if prop.identifier not in inherited
        if not prop.is_hidden and prop.type not in {"POINTER", "COLLECTION"}
    ]


def flaws(where: str, label: str, text: str) -> list[str]:
    if not text.strip():
        return [f"{where}: no description"]
    found = []
    if len(text) <= len(label):
        found.append(f"{where}: '{text}' says no more than '{label}'")
    if text.rstrip().endswith("."):
        found.append(f"{where}: Blender adds the full stop to '{text}'")
    if re.search(r"[.!?]\s+[A-Z]", text):
        found.append(f"{where}: more than one sentence: '{text}'")
    if UNFIT.search(text):
        found.append(f"{where}: for those who read papers: '{text}'")
    if label and text != OF_BLENDER and not VERBS.match(text):
        found.append(f"{where}: begins with no verb: '{text}'")
    if AMERICAN.search(f"{label} {text}"):
        found.append(f"{where}: not in British spelling: '{text}'")
    return found


UNFIT = re.compile(r"\b(the papers?|section|et al|k_[sb]|tutorial)\b")
OF_BLENDER = bpy.types.PropertyGroup.bl_rna.properties["name"].description
VERBS = re.compile(
    r"("
    "Add|Apply|Avoid|Bake|Bend|Bind|Bring|Calm|Cancel|Choose|Collapse|Colour|Compute|Cover|Deform|"
    "Delete|Discard|Double|Drag|Draw|Edit|Flip|Follow|Give|Go|Improve|Join|Keep|Key|Leave|Let|Limit|"
    "Make|Mend|Merge|Mirror|Morph|Move|Name|Open|Paint|Pin|Place|Play|Pose|Redraw|Refuse|Remove|Report|"
    "Rewrite|Round|Save|Say|Scale|Search|Select|Set|Show|Smooth|Speed|Start|Stiffen|Stop|Store|Take|"
    "Tighten|Turn|Use"
    r")\b"
)

AMERICAN = re.compile(
    r"\b(colou?rize|color|center|behavior|neighbor|gray|favorite|meter|canceled|\w+yze)\b", re.I
)


def test_every_property_and_operator_says_what_it_does():
    found = []
    for name, struct in operator_types().items():
        found += flaws(name, struct.name, struct.description)
    for where, prop in shown_properties():
        found += flaws(where, prop.name, prop.description)
        if prop.type == "ENUM":
            for item in prop.enum_items_static if hasattr(prop, "enum_items_static") else prop.enum_items:
                found += flaws(f"{where} {item.identifier}", "", item.description)
    assert not found, "\n".join(found)


def test_labels_are_in_title_case():
    small = {"a", "and", "as", "at", "by", "for", "from", "in", "of", "on", "or", "the", "to", "with"}
    labels = [struct.name for struct in operator_types().values()]
    labels += [prop.name for _where, prop in shown_properties()]
    words = [(word, label) for label in labels for word in re.findall(r"[A-Za-z]+", label)]
    assert not [label for word, label in words if word[0].islower() and word not in small]


def test_each_question_mark_leads_to_a_page(bound_plate: Rig):
    """Those of sub-panels are dim."""
    pages = bpy.ops.sinew.help.get_rna_type().properties["page"].enum_items
    for cls in (*panels("VIEW_3D").values(), *panels("PROPERTIES").values()):
        sheet = Sheet()
        names = {"layout": sheet, "help_page": cls.help_page}
        if hasattr(cls, "bl_parent_id"):
            names["bl_parent_id"] = cls.bl_parent_id
        cls.draw_header_preset(type(cls.__name__, (), names)(), DrawContext())
        ((name, settings),) = sheet.operators()
        assert name == "sinew.help"
        assert settings.page in pages
        assert inner.help.manual_page(settings.page).is_file()


DRAWN = """
active alert alignment emboss enabled operator_context scale_y ui_units_x
use_property_split use_property_decorate kind mode vertex_group control source index line page direction
as_shape_key target on task bl_space_type bl_region_type bl_context bl_category bl_options bl_parent_id
"""


def test_drawing_never_writes():
    """Panels, lists and menus assign to layouts and to what an operator button carries, to nothing else."""
    folder = Path(inner.ui.__file__).parent
    files = [folder / f"{name}.py" for name in ("panel", "lists", "menus", "pie", "status_box", "places")]
    for path in (*files, *folder.glob("control/*.py"), *folder.glob("situations/*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            for target in getattr(node, "targets", ()):
                for part in getattr(target, "elts", (target,)):
                    assert not isinstance(part, ast.Attribute) or part.attr in DRAWN.split(), (
                        f"{path}: {part.attr}"
                    )


def stored(group: bpy.types.Struct, path: str) -> Iterator[str]:
    """The properties below one, by path."""
    for prop in group.properties:
        if prop.identifier not in ("rna_type", "name"):
            yield f"{path}.{prop.identifier}"
            kind = prop.fixed_type if prop.type in ("POINTER", "COLLECTION") else None
            if kind and kind.base and kind.base.identifier == "PropertyGroup":
                yield from stored(kind, f"{path}.{prop.identifier}")


def operators() -> Iterator[str]:
    for name in dir(bpy.ops.sinew):
        kind = getattr(bpy.ops.sinew, name).get_rna_type()
        arguments = sorted(prop.identifier for prop in kind.properties if prop.identifier != "rna_type")
        yield f"sinew.{name}({', '.join(arguments)})"


def test_operators_and_properties_keep_their_names():
    owners = (bpy.types.Object, bpy.types.Scene, bpy.types.PoseBone)
    groups = {owner.__name__: owner.bl_rna.properties["sinew"].fixed_type for owner in owners}
    now = [line for name, group in groups.items() for line in stored(group, f"{name}.sinew")]
    kept = (ROOT / "tests" / "names" / "blender.txt").read_text(encoding="utf-8").splitlines()
    assert sorted([*operators(), *now]) == kept
