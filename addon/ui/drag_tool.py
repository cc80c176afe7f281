# SPDX-License-Identifier: GPL-3.0-or-later
"""The tool Sinew Drag in the toolbar of Object and Pose Mode: settings, keys, and the rings at the mouse."""

import bpy
from bpy.types import Context, Pose, UILayout, WorkSpaceTool

from ..core.errors import SinewError
from ..ids import Operators
from ..operators import (
    AROUND,
    HANDLE,
    ViewportTool,
    bone_under,
    draw_line,
    handle_sizes,
    makes_handles,
    ring,
    surface_under,
)
from ..properties import SinewDeformer
from ..session.controls import kinds
from .places import active_deformer

_SETTINGS = "scene.sinew.drag"
# What the header shows beside the mode: how new handles are made, or how bones follow.
_SHOWN = {
    "AUTO": ("pixels", "reach", "unlimited", "balance"),
    "SURFACE": ("pixels", "reach", "unlimited"),
    "CLAY": ("pixels", "reach"),
    "POINTS": ("pixels",),
    "BONES": ("balance",),
}


_HANDS = (Operators.DRAG, "builtin.move")  # the tools that move controls


def is_hand_tool(context: Context) -> bool:
    """Whether the tool of the viewport is Sinew Drag or Move: only then gizmos of controls are shown."""
    tool = context.workspace.tools.from_space_view3d_mode(context.mode, create=False)
    return tool is not None and tool.idname in _HANDS


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
        is_posing = context.mode == "POSE" or drag.mode == "BONES"
        for name in _SHOWN[drag.mode]:
            if name == "balance" and not is_posing:
                continue
            row = layout.row()
            row.active = name != "reach" or not drag.unlimited
            row.prop(drag, name)
        mirrored = _mirrored(context)
        if mirrored is not None:
            layout.prop(mirrored, "use_mirror_x", text="", icon="MOD_MIRROR")

    @staticmethod
    def draw_cursor(context: Context, _tool: WorkSpaceTool, place: tuple[float, float]) -> None:
        """Draw the bone under the mouse, or how large a new handle there is, and how far it reaches."""
        if ViewportTool.running or context.region_data is None or context.screen.is_animation_playing:
            return
        drag, region, view = context.scene.sinew.drag, context.region, context.region_data
        takes_bones = drag.mode == "BONES" or (drag.mode == "AUTO" and context.mode == "POSE")
        bone = bone_under(context, *place) if takes_bones else None
        if bone is not None:
            draw_line(region, view, bone.ends, HANDLE, (region.x, region.y))
        if bone is not None or drag.mode == "BONES":
            return
        try:
            hit = surface_under(context, *place)
        except SinewError:
            return  # pressing there tells why
        if hit is None or not makes_handles(drag, hit.obj):
            return
        radius, reach = handle_sizes(context, hit, drag.pixels, drag.reach)
        rings = [(radius, HANDLE)]
        if "reach" in _SHOWN[drag.mode] and not drag.unlimited:
            rings.append((radius * reach, AROUND))
        for size, colour in rings:
            draw_line(region, view, ring(hit.place, hit.normal, size), colour, (region.x, region.y))


def _mirrored(context: Context) -> SinewDeformer | Pose | None:
    """What has the switch for mirrored posing: the armature that is posed, or the deformer with handles."""
    if context.object is not None and context.object.mode == "POSE":
        return context.object.pose
    deformer = active_deformer(context)
    return deformer if deformer is not None and kinds.marks_regions(deformer.definition) else None


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
