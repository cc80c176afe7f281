# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the cage of a deformer in the panel, and its menu."""

from bpy.types import Context, Menu, Object, UILayout

from ...ids import Menus, Operators
from ...properties import SinewDeformer
from ...session.actions.controls import making
from ..layouts import Button, ControlMenu, draw_field
from ..pose import draw_pose
from ..status_box import draw_progress

REST = (
    Button(Operators.CAGE_REST, "New Rest of the Cage", "PIVOT_BOUNDBOX"),
    Button(Operators.CAGE_FACES, "Cage Faces", "MOD_DECIM"),
)
_ADDING = (
    Button(Operators.CAGE_ADD, "Wrap in a Cage", "MESH_CUBE", (("source", "AUTO"),)),
    Button(Operators.CAGE_ADD, "Cage from Selected", "MESH_ICOSPHERE", (("source", "OBJECT"),)),
)
POSE = Button(Operators.CONTROL_EDIT, "Pose the Cage", "EDITMODE_HLT")


class SINEW_MT_cage(ControlMenu, Menu):
    """What can be done with the cage of the active deformer"""

    bl_idname = Menus.CAGE
    bl_label = "Cage"
    ICON = "MESH_CUBE"
    ADDING = _ADDING
    DOING = (
        POSE,
        *REST,
        Button(Operators.CAGE_FLIP, "Flip Cage", "NORMALS_FACE"),
        Button(Operators.CAGE_OUTSIDE, "Let Outside Follow", "MOD_MESHDEFORM"),
    )


MENUS = (SINEW_MT_cage,)


def draw(context: Context, layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
    """Draw what poses the cage, or the buttons that add one; while one is made, how far that is."""
    work = making.cage_work(obj.name)
    if work is not None:
        draw_progress(layout.column(), work, "making a cage")
    elif deformer.cage is None or deformer.cage_missing:
        column = layout.column(align=True)
        column.alert = deformer.is_bound and deformer.cage_missing
        draw_field(context, column, deformer, "cage")
        column = layout.column(align=True)
        for adding in _ADDING:
            adding.draw(column)
    else:
        draw_pose(context, layout, POSE)


def row_name(_deformer: SinewDeformer) -> str:
    """There are no rows."""
    return ""


def draw_row(_context: Context, _layout: UILayout, _obj: Object, _deformer: SinewDeformer) -> None:
    """Nothing, as there are no rows."""


def draw_settings(context: Context, layout: UILayout, _obj: Object, deformer: SinewDeformer) -> None:
    """Draw which object is the cage."""
    draw_field(context, layout, deformer, "cage")
