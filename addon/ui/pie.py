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

    @classmethod
    def poll(cls, context: Context) -> bool:
        return target_of(context) is not None

    def draw(self, context: Context) -> None:
        pie = self.layout.menu_pie()
        if context.mode == "EDIT_MESH":
            _draw_edit_mode(pie)
        else:
            _draw_other_modes(pie)


def _draw_edit_mode(pie: UILayout) -> None:
    """Blender places the entries left, right, below and above, then in the corners from the upper left."""
    add_entry(pie, "HANDLE", "Make Handle", "ADD")
    add_entry(pie, "FIXED", "Hold Still", "PINNED")
    pie.operator(Operators.BIND, icon="FILE_REFRESH")
    pie.operator(Operators.GRAB_REGION, icon="VIEW_PAN")
    add_entry(pie, "SUPPORT", "Free Around It", "MOD_MESHDEFORM")
    add_entry(pie, "HANDLE", "Make Handle on Selected Object or Bone", "HOOK", control="SELECTED")
    pie.operator(Operators.SELECT_PROBLEMS, text="Show Problems", icon="ERROR")
    pie.operator(Operators.SELECT_HANDLE, icon="RESTRICT_SELECT_OFF")


def _draw_other_modes(pie: UILayout) -> None:
    pie.operator(Operators.SELECT_HANDLE, icon="RESTRICT_SELECT_OFF")
    pie.operator(Operators.HANDLE_MIRROR, icon="MOD_MIRROR")
    pie.operator(Operators.BIND, icon="FILE_REFRESH")
    pie.operator(Operators.BAKE, icon="RENDER_ANIMATION")
    pie.menu(Menus.ADD, icon="ADD")
    pie.operator(Operators.REPAIR, icon="TOOL_SETTINGS")
    pie.operator(Operators.SELECT_PROBLEMS, text="Show Problems", icon="ERROR")
    pie.operator(Operators.APPLY, icon="CHECKMARK")


register, unregister = register_classes_factory((SINEW_MT_pie,))
