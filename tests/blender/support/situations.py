# SPDX-License-Identifier: GPL-3.0-or-later
"""What artists see of Sinew in each situation: the entries of menus and panels, and where a path leads."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Iterable, Iterator
from types import SimpleNamespace
from typing import NamedTuple

import bpy
import installed
from inside import inner
from rigs.cages import ball, box, surround
from rigs.point_objects import bezier, hair, lattice, text
from rigs.puppets import figure
from rigs.rig import Rig, make_active, press
from rigs.sheet import WIDE, DrawContext, Sheet

# isort: split
import addon_utils  # comes with bpy, not before it

CONTEXT = DrawContext(WIDE)


def _nothing() -> Iterator[Step]:
    return iter(())


class Step(NamedTuple):
    """An entry that is shown, "(v)" for a menu behind an arrow, what it opens, and its operator."""

    label: str
    opens: Callable[[], Iterator[Step]] = _nothing
    operator: str = ""
    settings: SimpleNamespace = SimpleNamespace()


def _plain(label: str) -> str:
    return label.rstrip(".:… ")


def drawn(cls: type) -> Iterator[Step]:
    """The entries of a menu or a panel, with those that add-ons appended."""
    sheet = Sheet()
    stand_in = _StandIn(cls, sheet)
    for function in cls._dyn_ui_initialize():
        function(stand_in, CONTEXT)
    return steps_of(sheet)


class _StandIn:
    """A menu or panel without a window."""

    def __init__(self, cls: type, layout: Sheet) -> None:
        self._cls, self.layout = cls, layout
        self.role = getattr(cls, "role", "")

    def __getattr__(self, name: str):
        return getattr(self._cls, name)


def steps_of(sheet: Sheet) -> Iterator[Step]:
    for call, given, words, settings in sheet.calls:
        args = [*given, *(words[name] for name in _ARGUMENTS.get(call, ()) if name in words)]
        if "heading" in words:
            yield Step(words["heading"])
        if call == "label":
            yield Step(_plain(words.get("text", "")))
        elif call == "operator_enum":
            yield from _opening(operator_rna(args[0]).properties[args[1]])()
        elif call in ("operator", "operator_menu_enum"):
            rna = operator_rna(args[0])
            choices = rna.properties[args[1]] if call == "operator_menu_enum" else None
            yield Step(_plain(words.get("text") or rna.name), _opening(choices, args[0]), args[0], settings)
        elif call == "menu":
            found = getattr(bpy.types, args[0], None)
            if found is not None:
                label = words.get("text", getattr(found, "bl_label", ""))
                yield Step(_plain(label) or "(v)", functools.partial(drawn, found))
        elif call in ("prop", "prop_search"):
            known = args[0].bl_rna.properties[args[1]]
            yield Step(_plain(words.get("text") or known.name), _opening(known))
        elif call == "prop_enum":
            yield Step(args[0].bl_rna.properties[args[1]].enum_items[args[2]].name)


# How Blender calls the arguments that it also takes by place.
_ARGUMENTS = {
    "operator": ("operator",),
    "menu": ("menu",),
    "prop_enum": ("data", "property", "value"),
    **dict.fromkeys(("operator_menu_enum", "operator_enum"), ("operator", "property")),
    **dict.fromkeys(("prop", "prop_search"), ("data", "property")),
}


def operator_rna(name: str) -> bpy.types.Struct:
    group, _dot, verb = name.partition(".")
    return getattr(getattr(bpy.ops, group), verb).get_rna_type()


def our_structs() -> list[bpy.types.Struct]:
    found = [operator_rna(f"sinew.{name}") for name in dir(bpy.ops.sinew)]
    found.append(inner.preferences.SinewPreferences.bl_rna)
    owners = (bpy.types.Object, bpy.types.Scene, bpy.types.PoseBone)
    waiting = [owner.bl_rna.properties["sinew"] for owner in owners]
    while waiting:
        struct = getattr(waiting.pop(), "fixed_type", None)
        if struct is not None and struct.identifier.lower().startswith("sinew") and struct not in found:
            found.append(struct)
            waiting += struct.properties
    return found


def _opening(known: bpy.types.Property | None, operator: str = "") -> Callable[[], Iterator[Step]]:
    """What is behind a button: the choices of a property, or a window of Blender."""
    if operator == "screen.userpref_show":
        return _preferences
    choices = choices_of(known) if known is not None and known.type == "ENUM" else []
    return lambda: map(Step, choices)


def choices_of(known: bpy.types.EnumProperty) -> list[str]:
    """The labels of an enumeration, also where they depend on the context."""
    return [item.name for item in getattr(known, "enum_items_static", ()) or known.enum_items]


def _preferences() -> Iterator[Step]:
    """The sections of Blender's preferences; that of add-ons also lists ours."""
    for section in bpy.types.Preferences.bl_rna.properties["active_section"].enum_items:
        yield Step(section.name, _addons if section.identifier == "ADDONS" else _nothing)


def _addons() -> Iterator[Step]:
    yield from drawn(bpy.types.USERPREF_PT_addons)
    yield Step(addon_utils.module_bl_info(sys.modules[installed.name()])["name"])


def panels() -> list[type]:
    """Our panels in the sidebar that are shown now."""
    found = [getattr(bpy.types, name) for name in dir(bpy.types) if name.startswith("SINEW_PT_")]
    found = [cls for cls in found if cls.bl_space_type == "VIEW_3D" and cls.bl_region_type != "HEADER"]
    return [cls for cls in found if not hasattr(cls, "poll") or cls.poll(bpy.context)]


def title(cls: type) -> str:
    """The title of a panel, also where it depends on what is active."""
    if cls.bl_label:
        return cls.bl_label
    sheet = Sheet()
    cls.draw_header(_StandIn(cls, sheet), CONTEXT)
    return sheet.texts()


def sidebar() -> Iterator[Step]:
    """All that the Sinew tab shows."""
    for cls in panels():
        yield Step(title(cls), functools.partial(drawn, cls))
        yield from drawn(cls)


def first_steps() -> Iterator[Step]:
    """Where a path may begin: menus of both headers, our tab, its panels, tabs of the Properties editor."""
    for name in ("TOPBAR_MT_editor_menus", "VIEW3D_MT_editor_menus"):
        yield from drawn(getattr(bpy.types, name))
    yield Step("Sinew", sidebar)
    yield from (step for step in sidebar() if step.label in {title(cls) for cls in panels()})
    yield Step("Bone", _bone_tab)


def _bone_tab() -> Iterator[Step]:
    for name in dir(bpy.types):
        cls = getattr(bpy.types, name)
        if getattr(cls, "bl_space_type", "") == "PROPERTIES" and getattr(cls, "bl_context", "") == "bone":
            yield Step(getattr(cls, "bl_label", ""))


def leads_somewhere(path: tuple[str, ...], among: Iterable[Step]) -> bool:
    """Whether each step of a path is shown by the one before."""
    found = [step for step in among if step.label == path[0]]
    return bool(found) and (len(path) == 1 or any(leads_somewhere(path[1:], step.opens()) for step in found))


def visible() -> Iterator[Step]:
    """All entries of our tab, of our menus, and the choices behind them."""
    menus = [getattr(bpy.types, name) for name in dir(bpy.types) if name.startswith("SINEW_MT_")]
    yield from (Step(cls.bl_label) for cls in menus)
    found = [*sidebar(), *(step for cls in menus for step in drawn(cls))]
    yield from found
    yield from (inner for step in found for inner in step.opens())


# The situations. Each begins in an empty file and leaves something active.


def fresh(mode: str = "OBJECT") -> None:
    make_active(Rig.plate().obj)
    bpy.ops.object.mode_set(mode=mode)
    if mode == "EDIT":
        bpy.ops.mesh.select_all(action="SELECT")


def posed() -> None:
    """By the bones of an armature."""
    plate = Rig.plate()
    plate.obj.modifiers.new("Armature", "ARMATURE").object = figure()
    make_active(plate.obj)


def handles(method: str = "thin_shell", mode: str = "OBJECT") -> Rig:
    plate = Rig.plate().bind(method)
    make_active(plate.obj)
    bpy.ops.object.mode_set(mode=mode)
    return plate


def handle_points() -> None:
    plate = handles("mls")
    bpy.ops.sinew.point_add(source="CURSOR", method="mls")
    make_active(plate.obj)


def lost_control() -> None:
    plate = handles()
    bpy.data.objects.remove(plate.control)
    make_active(plate.obj)


def cage() -> None:
    target = ball()
    bpy.ops.sinew.cage_add(source="AUTO", method="harmonic", faces=60)
    make_active(target)


def cage_inside_out() -> None:
    around = box()
    around.data.flip_normals()
    target = ball()
    surround(target, around)
    make_active(target)


def lattice_around() -> None:
    target = ball()
    bpy.ops.sinew.lattice_add(source="FIT")
    make_active(target)


def wire() -> None:
    obj = Rig.plate().obj
    curve = bezier()
    press(obj, "wire_add", curve=curve.name, radius=1.0)
    make_active(obj)


def tools() -> None:
    target = ball()
    for tool in ("twist", "drag"):
        bpy.ops.sinew.tool_add(tool=tool)
        make_active(target)


def puppet() -> None:
    make_active(figure())
    bpy.ops.object.mode_set(mode="POSE")
    bpy.ops.pose.select_all(action="SELECT")


def skin() -> None:
    """That bones move."""
    plate, armature = Rig.plate(), figure()
    plate.obj.vertex_groups.new(name="hip").add([0, 1], 1.0, "REPLACE")
    make_active(plate.obj)
    bpy.ops.sinew.puppet_rig(armature=armature.name)


def baked() -> None:
    handles()
    bpy.context.scene.frame_end = 2
    bpy.ops.sinew.bake(target="SHAPE_KEYS")


def two_deformers() -> None:
    plate = handles()
    bpy.ops.sinew.deformer_add(method="arap")
    make_active(plate.obj)


SITUATIONS: dict[str, Callable[[], object]] = {
    "a mesh": fresh,
    "a posed mesh": posed,
    "a mesh in Edit Mode": lambda: fresh("EDIT"),
    "handles": handles,
    "a refined mesh": lambda: (handles(), bpy.ops.sinew.fast_subdivision()),
    "handles in Edit Mode": lambda: handles(mode="EDIT"),
    "handles in Weight Paint": lambda: handles(mode="WEIGHT_PAINT"),
    "handle points": handle_points,
    "a lost control": lost_control,
    "a cage": cage,
    "a cage inside out": cage_inside_out,
    "a lattice": lattice_around,
    "a wire": wire,
    "tools": tools,
    "keys": lambda: handles("mesh_sequence"),
    "a puppet": puppet,
    "a skin": skin,
    "baked": baked,
    "two deformers": two_deformers,
    "a curve": lambda: make_active(bezier()),
    "a text": lambda: make_active(text()),
    "hair": lambda: make_active(hair()),
    "a lattice object": lambda: make_active(lattice()),
    "a rig to try": lambda: bpy.ops.sinew.try_it(rig="lines"),
}
