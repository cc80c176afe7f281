# SPDX-License-Identifier: GPL-3.0-or-later
"""The pie menu: the operators that are used most often."""

from bpy.types import Context, Menu, UILayout
from bpy.utils import register_classes_factory

from ..ids import Menus, Operators
from ..operators import target_of
from .menus import add_entry


class SINEW_MT_pie(Menu):
    """Work on regions in Edit Mode, and on controls in the other modes"""

    bl_idname = Menus.PIE
    bl_label = "Sinew"

    def draw(self, context: Context) -> None:
        """In Edit Mode of a cage, the entries are those of the object that it moves."""
        pie = self.layout.menu_pie()
        if context.mode == "EDIT_MESH" and target_of(context) in (None, context.edit_object):
            _draw_edit_mode(pie)
        else:
            _draw_other_modes(pie)


def _draw_edit_mode(pie: UILayout) -> None:
    """Blender places the entries left, right, below and above, then in the corners from the upper left."""
    add_entry(pie, "HANDLE", "Make Handle", "ADD")
    add_entry(pie, "FIXED", "Hold Still", "PINNED")
    pie.operator(Operators.SELECT_HANDLE, text="Select Region", icon="RESTRICT_SELECT_OFF")
    pie.operator(Operators.GRAB_REGION, icon="VIEW_PAN")
    pie.operator(Operators.WIRE_ADD, text="Wire along Edges", icon="CURVE_DATA").source = "EDGES"
    add_entry(pie, "SUPPORT", "Free Around It", "MOD_MESHDEFORM")
    pie.operator(Operators.SELECT_PROBLEMS, text="Show Problems", icon="ERROR")
    pie.operator(Operators.BIND, icon="FILE_REFRESH")


def _draw_other_modes(pie: UILayout) -> None:
    pie.operator(Operators.DRAG_START, icon="VIEW_PAN").mode = "AUTO"
    pie.operator(Operators.HANDLE_MIRROR, icon="MOD_MIRROR")
    pie.operator(Operators.POSE_RESET, icon="LOOP_BACK")
    pie.operator(Operators.POSE_KEY, icon="KEY_HLT")
    pie.operator(Operators.SELECT_HANDLE, icon="RESTRICT_SELECT_OFF")
    pie.operator(Operators.ALL_TASKS, icon="IMGDISPLAY")
    pie.operator(Operators.SELECT_PROBLEMS, text="Show Problems", icon="ERROR")
    pie.operator(Operators.BAKE, icon="RENDER_ANIMATION")


register, unregister = register_classes_factory((SINEW_MT_pie,))
