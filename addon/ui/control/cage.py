# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the cage of a deformer in the panel, and its menu."""

from bpy.types import Context, Menu, Object, UILayout

from ...ids import Menus, Operators
from ...properties import SinewDeformer
from ...session.actions.controls import automatic, making
from ...session.targets import targets
from ..layouts import invoking, split
from ..status_box import draw_progress
from ..text import draw_text

ABOVE_PARAMETERS = True
PANELS = ()


class SINEW_MT_cage(Menu):
    """What can be done with the cage of the active deformer"""

    bl_idname = Menus.CAGE
    bl_label = "Cage"
    ICON = "MESH_CUBE"

    def draw(self, _context: Context) -> None:
        layout = invoking(self.layout)
        for source, text in (("AUTO", "Wrap in a Cage"), ("OBJECT", "Cage from Selected")):
            layout.operator(Operators.CAGE_ADD, text=text, icon="MESH_CUBE").source = source
        layout.separator()
        layout.operator(Operators.CAGE_FACES, icon="MOD_DECIM")
        layout.operator(Operators.CAGE_REST, text="New Rest of the Cage", icon="PIVOT_BOUNDBOX")
        layout.operator(Operators.CAGE_FLIP, icon="NORMALS_FACE")
        layout.operator(Operators.CAGE_OUTSIDE, icon="MOD_MESHDEFORM")


MENUS = (SINEW_MT_cage,)


def draw_start(context: Context, layout: UILayout, obj: Object) -> None:
    """Draw the buttons that add a cage. An object that is not a mesh can only be moved by a cage."""
    if not targets.is_mesh(obj):
        draw_text(context, layout, f"A cage moves this {targets.label(obj)} object - add one", "INFO")
    _draw_add(layout, obj)


def draw(_context: Context, layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
    """Draw the cage, or the buttons that add one."""
    column = split(layout.column())
    row = column.row()
    row.alert = deformer.is_bound and deformer.cage_missing
    row.prop(deformer, "cage")
    if deformer.cage is None:
        _draw_add(layout, obj)
        return
    column.prop(deformer, "cage_subdivision")
    if not _draw_making(layout, obj) and automatic.is_automatic(deformer.cage):
        layout.operator(Operators.CAGE_FACES, icon="MOD_DECIM")
    layout.operator(Operators.CAGE_REST, icon="PIVOT_BOUNDBOX")


def _draw_making(layout: UILayout, obj: Object) -> bool:
    """Draw the progress of a cage that is being made, in place of the buttons; whether there is one."""
    work = making.cage_work(obj.name)
    if work is not None:
        draw_progress(layout.column(), work, "making a cage")
    return work is not None


def _draw_add(layout: UILayout, obj: Object) -> None:
    if _draw_making(layout, obj):
        return
    column = layout.column(align=True)
    column.operator(Operators.CAGE_ADD, icon="MESH_CUBE").source = "AUTO"
    column.operator(Operators.CAGE_ADD, text="Cage from Selected", icon="MESH_ICOSPHERE").source = "OBJECT"
