# SPDX-License-Identifier: GPL-3.0-or-later
"""A layout that records what a panel draws, and how much room each label has, as Blender shares it."""

from types import SimpleNamespace
from typing import NamedTuple

import bpy
from inside import inner
from rigs.sheet import DrawContext

MARGINS = {
    "UI": 61,
    "WINDOW": 52,
}  # of the sidebar with its tabs; of the Properties editor with its scroll bar
BOX = 19  # the margins of a box
UNIT = 20  # the height of a button, and the width of an icon
ICON, PLAIN = 24, 8  # of a button, beside its text
NUMBER = 26  # the margins of a number, and between its label and its value
# Of its label, which a window clips earlier: letters are wider where a screen has 75 dots per inch.
ROUNDED = 0.08
BESIDE = 0.4  # of a choice or a picker, what its label gets
_BUTTONS = ("operator", "menu", "operator_menu_enum")
_INSIDE = ("BOOLEAN", "FLOAT", "INT")  # the types whose label stands in the field
_FIELDS = ("prop", "prop_search", "prop_enum")


class Label(NamedTuple):
    """A text that is drawn, and the room that it has."""

    kind: str
    text: str
    room: float

    @property
    def is_cut(self) -> bool:
        return bool(self.text) and inner.compat.text_width(self.text, 11.0) > self.room


class Ruler:
    """Stands in for a layout. ``labels`` are all texts, once the outermost one is measured."""

    def __init__(self, is_row: bool = False, box: bool = False) -> None:
        self.parts: list[Ruler | SimpleNamespace] = []
        self.is_row, self.is_box = is_row, box
        self.ui_units_x = 0.0
        self.scale_y = 1.0

    def __getattr__(self, name: str):
        if name.startswith("_"):
            raise AttributeError(name)
        if name in ("row", "column", "box", "split", "grid_flow"):
            return lambda **_looks: self._add(Ruler(name in ("row", "split"), name == "box"))
        return lambda *args, **looks: self._draw(name, args, looks)

    def _add(self, part):
        self.parts.append(part)
        return part

    def _draw(self, kind: str, args: tuple, looks: dict) -> SimpleNamespace:
        text = looks.get("text")
        value = 0.0
        if kind in _FIELDS and text is None:
            text = args[0].bl_rna.properties[args[1]].name
        if kind == "prop_enum":
            text = args[0].bl_rna.properties[args[1]].enum_items[args[2]].name
        if kind == "prop":
            known = args[0].bl_rna.properties[args[1]]
            value = 0 if getattr(known, "is_array", False) else _value_width(args[0], known)
            if looks.get("expand"):
                parts = self._add(Ruler(is_row=True))
                for item in known.enum_items:
                    parts._add(_leaf("prop_enum", item.name, "NONE", 0))
                return SimpleNamespace()
        if kind in ("operator", "operator_menu_enum") and text is None:
            group, _dot, verb = args[0].partition(".")
            text = getattr(getattr(bpy.ops, group), verb).get_rna_type().name
        if kind == "menu" and text is None:
            text = getattr(bpy.types, args[0]).bl_label
        leaf = self._add(_leaf(kind, text or "", looks.get("icon", "NONE"), value))
        if kind in ("prop", "prop_search") and args[0].bl_rna.properties[args[1]].type not in _INSIDE:
            leaf.share = BESIDE
        return SimpleNamespace()

    def labels(self, width: float) -> list[Label]:
        """The labels in this layout, if it is so wide."""
        width = width - BOX if self.is_box else width
        free = [part for part in self.parts if not _fixed(part)]
        share = width
        if self.is_row:
            share = (width - sum(filter(None, map(_fixed, self.parts)))) / max(len(free), 1)
        found = []
        for part in self.parts:
            room = (_fixed(part) or share) if self.is_row else width
            if isinstance(part, Ruler):
                found += part.labels(room)
            else:
                found.append(Label(part.kind, part.text, part.share * room - part.beside))
        return found


def _leaf(kind: str, text: str, icon: str, value: float) -> SimpleNamespace:
    beside = value + (ICON if icon != "NONE" else PLAIN)
    if value:
        beside += ROUNDED * inner.compat.text_width(text, 11.0)
    return SimpleNamespace(kind=kind, text=text, beside=beside, share=1.0)


def _value_width(data: object, known: bpy.types.Property) -> float:
    """How much a number takes in its field, beside its label."""
    if known.type not in ("FLOAT", "INT"):
        return 0.0
    digits = known.precision if known.type == "FLOAT" else 0
    unit = " m" if known.unit == "LENGTH" else ""
    value = f"{getattr(data, known.identifier):.{digits}f}{unit}"
    return NUMBER + inner.compat.text_width(value, 11.0)


def _fixed(part: Ruler | SimpleNamespace) -> float:
    """The width of what does not share the room in a row: icons, what has its own width, columns of icons."""
    if not isinstance(part, Ruler):
        return 0.0 if part.text or part.kind in ("template_list", *_FIELDS) else UNIT
    if part.ui_units_x:
        return part.ui_units_x * UNIT
    widths = [_fixed(inside) for inside in part.parts]
    return 0.0 if not all(widths) else sum(widths) if part.is_row else max(widths, default=0.0)


def measured(draw, width: int, region: str = "UI") -> list[Label]:
    """What ``draw(context, layout)`` draws in a region of this width."""
    ruler = Ruler()
    draw(DrawContext(width, region), ruler)
    return ruler.labels(width - MARGINS[region])


def measured_panel(cls: type, width: int, region: str = "UI") -> list[Label]:
    return measured(lambda context, layout: cls.draw(SimpleNamespace(layout=layout), context), width, region)


def buttons(labels: list[Label]) -> list[str]:
    return [label.text for label in labels if label.kind in _BUTTONS]


def cut(labels: list[Label]) -> list[Label]:
    return [label for label in labels if label.is_cut]
