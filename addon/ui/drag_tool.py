# SPDX-License-Identifier: GPL-3.0-or-later
"""The tool Sinew Drag in the toolbar of Object and Pose Mode: settings, keys, and the rings at the mouse."""

import bpy
from bpy.types import Context, UILayout, WorkSpaceTool

from ..core.errors import SinewError
from ..ids import Operators
from ..operators import HANDLE, REACH, ViewportTool, draw_line, handle_radius, ring, surface_under, target_of

_SETTINGS = "scene.sinew.drag"
# What the header shows beside the mode: how new handles are made, or how bones follow.
_SHOWN = {
    "AUTO": ("pixels", "reach", "unlimited", "balance"),
    "SURFACE": ("pixels", "reach", "unlimited"),
    "CLAY": ("pixels", "reach"),
    "POINTS": ("pixels",),
    "BONES": ("balance",),
}


def _radial(key: str, name: str, **modifiers: bool) -> tuple:
    return (
        "wm.radial_control",
        {"type": key, "value": "PRESS", **modifiers},
        {"properties": [("data_path_primary", f"{_SETTINGS}.{name}")]},
    )


def _wheel(key: str, factor: float) -> tuple:
    return (
        "wm.context_scale_int",
        {"type": key, "value": "PRESS", "ctrl": True},
        {"properties": [("data_path", f"{_SETTINGS}.pixels"), ("value", factor)]},
    )


class _DragTool:
    """Hand for surfaces, bones and controls: press, and drag."""

    bl_space_type = "VIEW_3D"
    bl_idname = Operators.DRAG
    bl_label = "Sinew Drag"
    bl_description = (
        "Drag the surface of a mesh, text or hair, a bone, or a control of a deformer.\n"
        "A handle is made where you press, or taken if there is one; a click holds the place still"
    )
    bl_icon = "ops.pose.push"
    bl_cursor = "CROSSHAIR"
    bl_keymap = (
        (Operators.DRAG_PRESS, {"type": "LEFTMOUSE", "value": "PRESS"}, None),
        _radial("F", "pixels"),
        _radial("F", "reach_in_pixels", shift=True),
        _wheel("WHEELUPMOUSE", 1.1),
        _wheel("WHEELDOWNMOUSE", 1.0 / 1.1),
    )

    @staticmethod
    def draw_settings(context: Context, layout: UILayout, _tool: WorkSpaceTool) -> None:
        """Draw the settings in the header and in the sidebar."""
        drag = context.scene.sinew.drag
        layout.prop(drag, "mode", text="")
        for name in _SHOWN[drag.mode]:
            row = layout.row()
            row.active = name != "reach" or not drag.unlimited
            row.prop(drag, name)
        obj = target_of(context)
        mirrored = None if obj is None else obj.sinew.active
        if drag.mode == "BONES" and context.object is not None:
            mirrored = context.object.pose
        if mirrored is not None:
            layout.prop(mirrored, "use_mirror_x", text="", icon="MOD_MIRROR")

    @staticmethod
    def draw_cursor(context: Context, _tool: WorkSpaceTool, place: tuple[float, float]) -> None:
        """Draw on the surface under the mouse how large a new handle would be, and how far it would reach."""
        drag = context.scene.sinew.drag
        if "pixels" not in _SHOWN[drag.mode] or ViewportTool.running:
            return
        if context.region_data is None or context.screen.is_animation_playing:
            return
        try:
            hit = surface_under(context, *place)
        except SinewError:
            return  # pressing there tells why
        if hit is None:
            return
        radius = handle_radius(context, hit, drag.pixels)
        region, view = context.region, context.region_data
        rings = [(radius, HANDLE)]
        if "reach" in _SHOWN[drag.mode] and not drag.unlimited:
            rings.append((radius * drag.reach, REACH))
        for size, colour in rings:
            draw_line(region, view, ring(hit.place, hit.normal, size), colour, (region.x, region.y))


class SINEW_WT_drag(_DragTool, WorkSpaceTool):
    """The tool in Object Mode"""

    bl_context_mode = "OBJECT"


class SINEW_WT_drag_pose(_DragTool, WorkSpaceTool):
    """The same tool in Pose Mode"""

    bl_context_mode = "POSE"


_TOOLS = (SINEW_WT_drag, SINEW_WT_drag_pose)


def register() -> None:
    if bpy.context.window_manager.keyconfigs.addon is not None:  # without a window there may be no toolbar
        for tool in _TOOLS:
            bpy.utils.register_tool(tool, after={"builtin.scale_cage"}, separator=True, group=True)


def unregister() -> None:
    for tool in _TOOLS:
        if hasattr(tool, "_bl_tool"):
            bpy.utils.unregister_tool(tool)
