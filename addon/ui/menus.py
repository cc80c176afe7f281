# SPDX-License-Identifier: GPL-3.0-or-later
"""Menu entries of Edit Mode: in the header, and under the right mouse button."""

import bpy
from bpy.types import Context, Menu, UILayout

from ..ids import Operators


class SINEW_MT_edit_mesh(Menu):
    """Make regions of the selected vertices"""

    bl_label = "Sinew"

    def draw(self, _context: Context) -> None:
        layout = self.layout
        _entry(layout, "HANDLE", "Add Handle", "EMPTY_AXIS")
        _entry(layout, "HANDLE", "Add Handle to Selected Object or Bone", "HOOK", control="SELECTED")
        _entry(layout, "FIXED", "Add Fixed", "PINNED")
        _entry(layout, "SUPPORT", "Set Support", "MOD_MESHDEFORM")
        layout.separator()
        layout.operator(Operators.BIND, icon="FILE_REFRESH")
        layout.operator(Operators.SELECT_PROBLEMS, text="Select Problems")


def _entry(layout: UILayout, kind: str, text: str, icon: str, control: str = "NEW") -> None:
    settings = layout.operator(Operators.HANDLE_ADD, text=text, icon=icon)
    settings.kind, settings.control = kind, control


def _in_header(menu: Menu, context: Context) -> None:
    if context.mode == "EDIT_MESH":
        menu.layout.menu(SINEW_MT_edit_mesh.__name__)


def _in_context_menu(menu: Menu, _context: Context) -> None:
    menu.layout.separator()
    menu.layout.menu(SINEW_MT_edit_mesh.__name__)


def register() -> None:
    bpy.utils.register_class(SINEW_MT_edit_mesh)
    bpy.types.VIEW3D_MT_editor_menus.append(_in_header)
    bpy.types.VIEW3D_MT_edit_mesh_context_menu.append(_in_context_menu)


def unregister() -> None:
    bpy.types.VIEW3D_MT_edit_mesh_context_menu.remove(_in_context_menu)
    bpy.types.VIEW3D_MT_editor_menus.remove(_in_header)
    bpy.utils.unregister_class(SINEW_MT_edit_mesh)
