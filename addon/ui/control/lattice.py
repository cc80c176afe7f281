# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the lattice of a deformer in the panel, and its menu."""

from bpy.types import Context, Menu, Object, UILayout

from ...ids import Menus, Operators
from ...properties import SinewDeformer
from ..layouts import invoking, split

ABOVE_PARAMETERS = True
PANELS = ()
_SHAPES = (
    ("BOX", "Add Lattice", "LATTICE_DATA"),
    ("CYLINDER", "Add Cylindrical Lattice", "MESH_CYLINDER"),
    ("FITTED", "Add Fitted Boxes", "MESH_GRID"),
)


class SINEW_MT_lattice(Menu):
    """What can be done with the lattice of the active deformer"""

    bl_idname = Menus.LATTICE
    bl_label = "Lattice"
    ICON = "LATTICE_DATA"

    def draw(self, _context: Context) -> None:
        layout = invoking(self.layout)
        for shape, text, icon in _SHAPES:
            adding = layout.operator(Operators.LATTICE_ADD, text=text, icon=icon)
            adding.source, adding.shape = "FIT", shape
        layout.operator(
            Operators.LATTICE_ADD, text="Lattice from Selected", icon="LATTICE_DATA"
        ).source = "OBJECT"
        layout.separator()
        layout.operator(Operators.LATTICE_REST, text="New Rest of the Lattice", icon="PIVOT_BOUNDBOX")


MENUS = (SINEW_MT_lattice,)


def draw_start(_context: Context, layout: UILayout, _obj: Object) -> None:
    """Draw the button that fits a lattice."""
    _draw_add(layout)


def draw(_context: Context, layout: UILayout, _obj: Object, deformer: SinewDeformer) -> None:
    """Draw the lattice, or the buttons that add one."""
    column = split(layout.column())
    row = next((row for row in deformer.controls if row.kind == "lattice"), None)
    if row is not None:
        line = column.row()
        line.alert = deformer.is_bound and row.missing
        line.prop(row, "object", text="Lattice")
    if row is None or row.object is None:
        _draw_add(layout)
        return
    if row.object.type == "LATTICE":
        data = row.object.data
        counts = column.column(align=True)
        for axis in "uvw":
            counts.prop(data, f"points_{axis}", text="Resolution U" if axis == "u" else axis.upper())
        if deformer.parameters.basis == "blender":
            types = column.column(align=True)
            for axis in "uvw":
                types.prop(data, f"interpolation_type_{axis}", text=axis.upper())
    layout.operator(Operators.LATTICE_REST, icon="PIVOT_BOUNDBOX")


def _draw_add(layout: UILayout) -> None:
    column = layout.column(align=True)
    for shape, text, icon in _SHAPES:
        adding = column.operator(Operators.LATTICE_ADD, text=text, icon=icon)
        adding.source, adding.shape = "FIT", shape
    column.operator(
        Operators.LATTICE_ADD, text="Lattice from Selected", icon="LATTICE_DATA"
    ).source = "OBJECT"
