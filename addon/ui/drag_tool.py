# SPDX-License-Identifier: GPL-3.0-or-later
"""The tool in the toolbar of Object Mode that drags the surface: its settings, and the rings at the mouse."""

import bpy
from bpy.types import Context, UILayout, WorkSpaceTool

from ..core.errors import SinewError
from ..ids import Operators
from ..operators import SINEW_OT_drag, draw_line, ring, surface_under
from ..operators.tools.drag import HANDLE, REACH, handle_radius


class SINEW_WT_drag(WorkSpaceTool):
    """Hand for surfaces: press where a handle is to be, and drag."""

    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = Operators.DRAG
    bl_label = "Sinew Drag"
    bl_description = (
        "Drag the surface of a mesh. A handle is made where you press, or taken if there is one;\n"
        "what is around it follows by a Sinew method"
    )
    bl_icon = "ops.pose.push"
    bl_cursor = "CROSSHAIR"
    bl_keymap = ((Operators.DRAG, {"type": "LEFTMOUSE", "value": "PRESS"}, None),)

    @staticmethod
    def draw_settings(_context: Context, layout: UILayout, tool: WorkSpaceTool) -> None:
        """Draw the settings in the header and in the sidebar."""
        settings = tool.operator_properties(Operators.DRAG)
        layout.prop(settings, "pixels")
        row = layout.row()
        row.active = not settings.unlimited
        row.prop(settings, "reach")
        layout.prop(settings, "unlimited")

    @staticmethod
    def draw_cursor(context: Context, tool: WorkSpaceTool, place: tuple[float, float]) -> None:
        """Draw on the surface under the mouse how large a new handle would be, and how far it would reach."""
        if SINEW_OT_drag.running or context.region_data is None or context.screen.is_animation_playing:
            return
        try:
            hit = surface_under(context, *place)
        except SinewError:
            return  # pressing there tells why
        if hit is None:
            return
        settings = tool.operator_properties(Operators.DRAG)
        radius = handle_radius(context, hit, settings.pixels)
        region, view = context.region, context.region_data
        rings = [(radius, HANDLE)]
        if not settings.unlimited:
            rings.append((radius * settings.reach, REACH))
        for size, colour in rings:
            draw_line(region, view, ring(hit.place, hit.normal, size), colour, (region.x, region.y))


def register() -> None:
    if bpy.context.window_manager.keyconfigs.addon is not None:  # without a window there may be no toolbar
        bpy.utils.register_tool(SINEW_WT_drag, after={"builtin.scale_cage"}, separator=True, group=True)


def unregister() -> None:
    if hasattr(SINEW_WT_drag, "_bl_tool"):
        bpy.utils.unregister_tool(SINEW_WT_drag)
