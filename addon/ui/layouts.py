# SPDX-License-Identifier: GPL-3.0-or-later
"""Layouts that several panels and menus have in common."""

from collections.abc import Sequence
from dataclasses import dataclass

from bpy.types import Context, UILayout, bpy_struct

from ..properties import SinewDeformer
from .text import fit_beside, is_wide


@dataclass(frozen=True)
class Button:
    """A button: the operator that it calls, its text, its icon, and the arguments of the operator."""

    operator: str
    text: str
    icon: str = "NONE"
    properties: tuple[tuple[str, str | bool], ...] = ()

    @property
    def looks(self) -> tuple[str, str]:
        """Its text and its icon."""
        return self.text, self.icon

    def draw(self, layout: UILayout) -> None:
        """Draw it."""
        settings = layout.operator(self.operator, text=self.text, icon=self.icon)
        for name, value in self.properties:
            setattr(settings, name, value)


def fields(context: Context, layout: UILayout) -> UILayout:
    """For properties: labels to the left in a wide region, as in Blender's own panels, else in the field.

    Without animation dots, as in Blender's sidebar.
    """
    layout.use_property_split = is_wide(context)
    layout.use_property_decorate = False
    return layout


_INSIDE = ("BOOLEAN", "FLOAT", "INT")  # the types whose label has room in the field


def draw_field(
    context: Context,
    layout: UILayout,
    data: bpy_struct,
    name: str,
    text: str = "",
    among: tuple[bpy_struct, str] | None = None,
    **looks: object,
) -> UILayout:
    """Draw a property whose label is never cut. Returns the row with it, for buttons beside it.

    In a narrow region, choices and pickers have their label above. ``among`` is the collection that the
    property names something of.
    """
    known = data.bl_rna.properties[name]
    label = text or known.name
    if not is_wide(context) and (known.type not in _INSIDE or known.is_array):
        layout = layout.column(align=True)
        layout.label(text=label)
        label = ""
    row = layout.row(align=True)
    if among is None:
        # An empty text would take the names of a choice that is drawn as buttons.
        texts = {"text": label} if label or "expand" not in looks else {}
        row.prop(data, name, **texts, **looks)
    else:
        row.prop_search(data, name, *among, text=label, **looks)
    return row


def beside(context: Context, layout: UILayout, *buttons: tuple[str, str], boxed: bool = False) -> UILayout:
    """For buttons with these texts and icons: beside each other where they fit, else below each other."""
    return layout.row(align=True) if fit_beside(context, *buttons, boxed=boxed) else layout.column(align=True)


def draw_pair(context: Context, layout: UILayout, buttons: Sequence[Button]) -> None:
    """Draw buttons beside each other where they fit, else below each other."""
    group = beside(context, layout, *(button.looks for button in buttons))
    for button in buttons:
        button.draw(group)


def unless_baked(layout: UILayout, deformer: SinewDeformer) -> UILayout:
    """For settings and rows, which are greyed out while a bake plays in place of the deformer."""
    column = layout.column()
    column.enabled = not deformer.bake.is_baked
    return column


def invoking(layout: UILayout) -> UILayout:
    """Let the entries of a menu run as if the mouse were over the viewport, in whichever editor it opens."""
    layout.operator_context = "INVOKE_REGION_WIN"
    return layout


class ControlMenu:
    """The menu of a kind of control: what adds one, and below what else can be done with it."""

    ADDING: tuple[Button, ...]
    DOING: tuple[Button, ...]

    def draw(self, _context: Context) -> None:
        layout = invoking(self.layout)
        for button in self.ADDING:
            button.draw(layout)
        layout.separator()
        for button in self.DOING:
            button.draw(layout)


class RowList:
    """A list whose rows ``draw_row`` draws, from less than Blender tells."""

    def draw_item(
        self,
        context: Context,
        layout: UILayout,
        owner: bpy_struct,
        item: bpy_struct,
        icon: int,
        _active_owner: bpy_struct,
        _active_property: str,
        index: int,
    ) -> None:
        self.draw_row(context, layout, owner, item, icon, index)


def draw_move_entries(layout: UILayout, operator: str, row: str) -> None:
    """Draw the entries of a menu that move the active row of a list, which is called a ``row``."""
    layout.operator(operator, text=f"Move {row} Up", icon="TRIA_UP").direction = "UP"
    layout.operator(operator, text=f"Move {row} Down", icon="TRIA_DOWN").direction = "DOWN"
