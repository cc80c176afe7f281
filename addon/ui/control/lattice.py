# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the lattice of a deformer in the panel, and its menu."""

from bpy.types import Context, Menu, Object, UILayout

from ...ids import Menus, Operators
from ...properties import SinewControl, SinewDeformer
from ..layouts import Button, ControlMenu, draw_field
from ..pose import draw_pose

REST = (Button(Operators.LATTICE_REST, "New Rest of the Lattice", "PIVOT_BOUNDBOX"),)
_ADDING = (
    *(
        Button(Operators.LATTICE_ADD, text, icon, (("source", "FIT"), ("shape", shape)))
        for shape, text, icon in (
            ("BOX", "Put in a Box", "LATTICE_DATA"),
            ("CYLINDER", "Cylindrical Lattice", "MESH_CYLINDER"),
            ("FITTED", "Fitted Boxes", "MESH_GRID"),
        )
    ),
    Button(Operators.LATTICE_ADD, "Lattice from Selected", "LATTICE_DATA", (("source", "OBJECT"),)),
)
POSE = Button(Operators.CONTROL_EDIT, "Pose the Lattice", "EDITMODE_HLT")


class SINEW_MT_lattice(ControlMenu, Menu):
    """What can be done with the lattice of the active deformer"""

    bl_idname = Menus.LATTICE
    bl_label = "Lattice"
    ICON = "LATTICE_DATA"
    ADDING = _ADDING
    DOING = (POSE, *REST)


MENUS = (SINEW_MT_lattice,)


def draw(context: Context, layout: UILayout, _obj: Object, deformer: SinewDeformer) -> None:
    """Draw what poses the lattice and its resolution, or the buttons that add one."""
    row = _row(deformer)
    if row is None or row.missing:
        if row is not None:
            line = layout.column()
            line.alert = deformer.is_bound
            draw_field(context, line, row, "object", text="Lattice")
        column = layout.column(align=True)
        for adding in _ADDING:
            adding.draw(column)
        return
    draw_pose(context, layout, POSE)
    if row.object.type == "LATTICE":
        counts = layout.row(align=True)
        for axis in "uvw":
            counts.prop(row.object.data, f"points_{axis}", text=axis.upper())


def row_name(_deformer: SinewDeformer) -> str:
    """There are no rows."""
    return ""


def draw_row(_context: Context, _layout: UILayout, _obj: Object, _deformer: SinewDeformer) -> None:
    """Nothing, as there are no rows."""


def draw_settings(context: Context, layout: UILayout, _obj: Object, deformer: SinewDeformer) -> None:
    """Draw which object is the lattice, and the interpolation of Blender's lattices."""
    row = _row(deformer)
    if row is None:
        return
    draw_field(context, layout, row, "object", text="Lattice")
    blender = row.object is not None and row.object.type == "LATTICE"
    if blender and deformer.parameters.basis == "blender":
        for axis in "uvw":
            draw_field(context, layout, row.object.data, f"interpolation_type_{axis}", text=axis.upper())


def _row(deformer: SinewDeformer) -> SinewControl | None:
    return next((row for row in deformer.controls if row.kind == "lattice"), None)
