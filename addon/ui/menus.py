# SPDX-License-Identifier: GPL-3.0-or-later
"""The menus: in the header of Edit Mode, in Object > Sinew, in context menus, and beside the lists.

Blender's search finds operators through menus, so each operator is in a menu that is shown where it works.
"""

import bpy
from bpy.types import Context, Menu, UILayout

from ..core.labels import known_as, label_of
from ..core.methods import METHODS
from ..ids import Menus, Operators
from ..operators import PAGES, page_of, target_of
from ..properties import DRAG_MODES, deformers_of
from . import control
from .browser.menus import draw_tasks
from .layouts import draw_move_entries, invoking


class SINEW_MT_edit_mesh(Menu):
    """Make the selected vertices a region, and work on the deformer"""

    bl_idname = Menus.EDIT_MESH
    bl_label = "Sinew"

    def draw(self, context: Context) -> None:
        layout = invoking(self.layout)
        add_entry(layout, "HANDLE", "Make Handle", "ADD")
        add_entry(layout, "HANDLE", "Make Handle on Selected Object or Bone", "HOOK", control="SELECTED")
        add_entry(layout, "FIXED", "Hold Still", "PINNED")
        add_entry(layout, "SUPPORT", "Free Around It", "MOD_MESHDEFORM")
        layout.separator()
        draw_tasks(context, layout)
        layout.separator()
        _draw_common(layout)


class SINEW_MT_object(Menu):
    """Start a task, or work on the deformers of the mesh and their regions"""

    bl_idname = Menus.OBJECT
    bl_label = "Sinew"

    def draw(self, context: Context) -> None:
        layout = invoking(self.layout)
        draw_tasks(context, layout)
        layout.separator()
        layout.menu(Menus.ADD_REGION, icon="ADD")
        _draw_common(layout)


class SINEW_MT_add_region(Menu):
    """Add a region to the deformer"""

    bl_idname = Menus.ADD_REGION
    bl_label = "Add Region"

    def draw(self, context: Context) -> None:
        layout = invoking(self.layout)
        obj = target_of(context)
        if obj is not None and obj.mode == "EDIT":
            add_entry(layout, "HANDLE", "Handle", "ADD")
            add_entry(layout, "HANDLE", "Handle to Selected Object or Bone", "HOOK", control="SELECTED")
            add_entry(layout, "FIXED", "Hold Still", "PINNED")
            add_entry(layout, "SUPPORT", "Free Around It", "MOD_MESHDEFORM")
            layout.separator()
        for role, name in Menus.FOR_GROUPS.items():
            layout.menu(name, icon=_ADDING[role][1])
        layout.operator_menu_enum(Operators.POINT_ADD, "source", icon="EMPTY_AXIS")


class SINEW_MT_deformer(Menu):
    """What can be done with the active deformer"""

    bl_idname = Menus.DEFORMER
    bl_label = "Deformer"

    def draw(self, _context: Context) -> None:
        layout = invoking(self.layout)
        layout.operator(Operators.CHOOSE_METHOD, icon="PRESET")
        draw_move_entries(layout, Operators.DEFORMER_MOVE, "Deformer")
        layout.separator()
        layout.operator(Operators.KEY_ADD, icon="KEY_HLT")
        layout.operator(Operators.KEY_MOVE, icon="KEYFRAME")
        layout.operator(Operators.KEY_REMOVE, icon="KEY_DEHLT")
        layout.separator()
        layout.operator(Operators.APPLY, icon="CHECKMARK")
        layout.operator(Operators.APPLY, text="Apply as Shape Key", icon="SHAPEKEY_DATA").as_shape_key = True
        layout.operator(Operators.BAKE, icon="RENDER_ANIMATION")
        layout.operator(Operators.UNBAKE, icon="LOOP_BACK")
        layout.operator(Operators.BAKE_FIND, icon="FILEBROWSER")
        layout.operator(Operators.SETTINGS_SHARE, icon="DUPLICATE")
        layout.operator(Operators.TRANSFER, icon="MOD_MESHDEFORM")
        layout.operator(Operators.MORPH, icon="MOD_DATA_TRANSFER")
        layout.operator(Operators.FAST_SUBDIVISION, icon="MOD_SUBSURF")
        layout.operator(Operators.DRIVE, icon="DRIVER")
        layout.operator(Operators.GRID_NEW, icon="MESH_GRID")
        layout.separator()
        layout.operator(Operators.DEFORMER_REMOVE, icon="REMOVE")


class SINEW_MT_problems(Menu):
    """What is wrong with a mesh and its regions, and what mends it"""

    bl_idname = Menus.PROBLEMS
    bl_label = "Problems"

    def draw(self, _context: Context) -> None:
        layout = invoking(self.layout)
        layout.operator(Operators.SELECT_PROBLEMS, text="Show Problems", icon="ERROR")
        layout.operator(Operators.SELECT_DISTORTED, icon="MOD_CLOTH")
        layout.separator()
        layout.operator(Operators.REPAIR, icon="TOOL_SETTINGS")
        layout.operator(Operators.PART_REGIONS, icon="SELECT_DIFFERENCE")
        layout.operator(Operators.REFINE, icon="MESH_GRID")
        layout.operator(Operators.ARMATURE_OFF, icon="MOD_ARMATURE")
        layout.operator(Operators.KEEP_INSIDE, icon="PINNED")
        layout.operator(Operators.USE_FACTOR, icon="MEMORY")


class SINEW_MT_prepare(Menu):
    """Look at a mesh before it is posed: what is unusual about it, and how it bends"""

    bl_idname = Menus.PREPARE
    bl_label = "Prepare"

    def draw(self, _context: Context) -> None:
        layout = invoking(self.layout)
        layout.operator(Operators.DIAGNOSE, icon="VIEWZOOM")
        layout.operator_menu_enum(Operators.SELECT_UNUSUAL, "what", icon="RESTRICT_SELECT_OFF")
        layout.operator_menu_enum(Operators.CURE, "what", icon="TOOL_SETTINGS")
        layout.separator()
        layout.operator(Operators.REMESH, icon="MOD_REMESH")
        layout.operator(Operators.DECIMATE, icon="MOD_DECIM")
        layout.operator(Operators.SEMI_REGULAR, icon="MOD_MULTIRES")
        layout.operator(Operators.REMOVE_NEEDLES, icon="MOD_TRIANGULATE")
        layout.separator()
        layout.operator(Operators.CURVATURE, icon="MOD_SMOOTH")


class SINEW_MT_manual(Menu):
    """Open a page of the manual that was installed with the add-on"""

    bl_idname = Menus.MANUAL
    bl_label = "Sinew Manual"

    def draw(self, _context: Context) -> None:
        for page, label, _description in PAGES:
            self.layout.operator(Operators.HELP, text=label).page = page
        self.layout.menu(Menus.MANUAL_METHODS)


class SINEW_MT_manual_methods(Menu):
    """Open the page about a method"""

    bl_idname = Menus.MANUAL_METHODS
    bl_label = "Methods"

    def draw(self, _context: Context) -> None:
        for method in METHODS:
            text = f"About {label_of(method)} ({known_as(method)})"
            self.layout.operator(Operators.HELP, text=text).page = page_of(method)


_ADDING = {
    "HANDLE": ("Handle from Vertex Group", "ADD"),
    "FIXED": ("Still from Vertex Group", "PINNED"),
    "SUPPORT": ("Free Area from Vertex Group", "MOD_MESHDEFORM"),
}


class _GroupsMenu:
    """Lists the vertex groups of the mesh. The chosen one becomes a region with a ``role``."""

    role = ""

    def draw(self, context: Context) -> None:
        layout = invoking(self.layout)
        obj = target_of(context)
        groups = [] if obj is None else [group.name for group in obj.vertex_groups]
        if not groups:
            layout.label(text="No vertex groups - select vertices in Edit Mode", icon="INFO")
        for name in groups:
            settings = layout.operator(Operators.HANDLE_ADD, text=name, icon="GROUP_VERTEX")
            settings.kind, settings.vertex_group = self.role, name


_GROUP_MENUS = tuple(
    type(
        name,
        (_GroupsMenu, Menu),
        {
            "__doc__": "Make a vertex group of the mesh a region",
            "__module__": __name__,
            "bl_idname": name,
            "bl_label": _ADDING[role][0],
            "role": role,
        },
    )
    for role, name in Menus.FOR_GROUPS.items()
)


def add_entry(layout: UILayout, role: str, text: str, icon: str, control: str = "NEW") -> None:
    """Draw an entry that makes the selection a region with a ``role``."""
    settings = layout.operator(Operators.HANDLE_ADD, text=text, icon=icon)
    settings.kind, settings.control = role, control


def _draw_common(layout: UILayout) -> None:
    for mode, label, *_rest in DRAG_MODES:
        text = "Sinew Drag" if mode == "AUTO" else f"Sinew Drag: {label}"
        layout.operator(Operators.DRAG_START, text=text, icon="VIEW_PAN").mode = mode
    layout.separator()
    layout.operator(Operators.POSE_RESET, icon="LOOP_BACK")
    layout.operator(Operators.POSE_KEY, icon="KEY_HLT")
    layout.operator(Operators.PUPPET_PIN, icon="PINNED")
    layout.operator(Operators.PUPPET_RIG, icon="BONE_DATA")
    layout.separator()
    layout.operator_menu_enum(Operators.POINT_ADD, "source", icon="EMPTY_AXIS")
    layout.operator(Operators.GRAB_REGION, icon="VIEW_PAN")
    layout.operator(Operators.SILHOUETTE_SKETCH, icon="GREASEPENCIL")
    layout.separator()
    layout.operator(Operators.BIND, icon="FILE_REFRESH")
    layout.operator(Operators.UNBIND, icon="X")
    layout.operator(Operators.CANCEL, icon="CANCEL")
    layout.separator()
    layout.menu(Menus.PREPARE, icon="VIEWZOOM")
    layout.menu(Menus.PROBLEMS, icon="ERROR")
    for menu in control.MENUS:
        layout.menu(menu.bl_idname, icon=menu.ICON)
    layout.menu(Menus.DEFORMER, icon="MODIFIER")
    layout.menu(Menus.MANUAL, icon="QUESTION")


def _in_header(menu: Menu, context: Context) -> None:
    if context.mode == "EDIT_MESH":
        menu.layout.menu(Menus.EDIT_MESH)


def _at_the_end(menu: Menu, context: Context) -> None:
    menu.layout.separator()
    menu.layout.menu(Menus.EDIT_MESH if context.mode == "EDIT_MESH" else Menus.OBJECT)


def _in_object_context_menu(menu: Menu, context: Context) -> None:
    """Draw the entry only for objects with a deformer and for controls, since this menu is long already."""
    obj = target_of(context)
    if obj is not None and deformers_of(obj):
        _at_the_end(menu, context)


_CLASSES = (
    *_GROUP_MENUS,
    SINEW_MT_manual,
    SINEW_MT_manual_methods,
    SINEW_MT_problems,
    SINEW_MT_prepare,
    SINEW_MT_add_region,
    *control.MENUS,
    SINEW_MT_deformer,
    SINEW_MT_edit_mesh,
    SINEW_MT_object,
)
# The menus of Blender that have an entry of Sinew, and the functions that draw it.
_PLACES = (
    ("VIEW3D_MT_editor_menus", _in_header),
    ("VIEW3D_MT_edit_mesh_context_menu", _at_the_end),
    ("VIEW3D_MT_object", _at_the_end),
    ("VIEW3D_MT_pose", _at_the_end),
    ("VIEW3D_MT_paint_weight", _at_the_end),
    ("VIEW3D_MT_object_context_menu", _in_object_context_menu),
    ("VIEW3D_MT_pose_context_menu", _in_object_context_menu),
)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    for place, draw in _PLACES:
        getattr(bpy.types, place).append(draw)


def unregister() -> None:
    for place, draw in reversed(_PLACES):
        getattr(bpy.types, place).remove(draw)
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
