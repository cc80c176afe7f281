# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the handles of a deformer, the sub-panel of the active handle, and its menu."""

from bpy.types import Context, Menu, Object, Panel, UILayout

from ...ids import Menus, Operators
from ...operators import target_of
from ...properties import STANDS_ON, SinewDeformer, SinewHandle
from ...session.actions import rigging
from ...session.actions.handles import standing
from ...session.actions.handles.standing import NOTHING_MOVES
from ...session.controls import kinds
from ...session.controls.handles import points, riding, sides
from ...session.targets import targets
from ..layouts import draw_move_buttons, draw_move_entries, invoking, split, unless_baked
from ..places import ActiveDeformerPanel, active_deformer
from ..text import columns, draw_text

ABOVE_PARAMETERS = False
_WIDE_MENUS = 36  # characters; in a wider region, two menu buttons fit beside each other


class SINEW_PT_region(ActiveDeformerPanel, Panel):
    """Settings of the active region"""

    bl_label = "Region"
    bl_order = 10

    @classmethod
    def poll(cls, context: Context) -> bool:
        deformer = active_deformer(context)
        if deformer is None or not kinds.marks_regions(deformer.definition):
            return False
        return 0 <= deformer.active_handle < len(deformer.handles)

    def draw(self, context: Context) -> None:
        obj = target_of(context)
        deformer = obj.sinew.active
        handle = deformer.handles[deformer.active_handle]
        layout = split(unless_baked(self.layout, deformer))
        layout.prop(handle, "kind")
        layout.prop_search(handle, "vertex_group", obj, "vertex_groups")
        if handle.kind == "HANDLE":
            control = layout.column()
            control.alert = handle.control_missing
            control.prop(handle, "control")
            if handle.control_missing:
                layout.operator(Operators.CONTROL_NEW, icon="EMPTY_AXIS").index = deformer.active_handle
            if handle.control is not None and handle.control.type == "ARMATURE":
                control.prop_search(handle, "bone", handle.control.data, "bones")
            if not handle.vertex_group and rigging.takes_points(deformer):
                _draw_acts_as(context, layout, deformer, handle)
            _draw_stands_on(context, layout, obj, deformer, handle)
        layout.prop(handle, "weight", slider=True)
        for parameter in deformer.definition.handle_parameters:
            layout.prop(handle, parameter.id, slider=True)
        if handle.kind == "HANDLE":
            layout.prop(handle, "colour")


def _draw_stands_on(
    context: Context, layout: UILayout, obj: Object, deformer: SinewDeformer, handle: SinewHandle
) -> None:
    """Draw what the control stands on. *From Rest* is older, and for handles in the world that use it."""
    halves = layout.split(factor=0.4)
    label = halves.row()
    label.alignment = "RIGHT"
    label.label(text="Stands On")
    row = halves.row(align=True)
    why_not = standing.why_not_on_surface(obj, deformer, handle)
    row.enabled = handle.stands_on == "SURFACE" or not why_not
    for on, text, *_rest in STANDS_ON:
        button = row.operator(Operators.HANDLE_STAND, text=text, depress=handle.stands_on == on)
        button.on, button.index = on, deformer.active_handle
    if handle.stands_on == "SURFACE" and riding.carrier_of(handle):
        draw_text(context, layout, riding.standing(handle), "INFO")
    elif why_not == NOTHING_MOVES:
        draw_text(context, layout, why_not, "INFO")
    if handle.from_rest:
        layout.prop(handle, "from_rest")


def _draw_acts_as(context: Context, layout: UILayout, deformer: SinewDeformer, handle: SinewHandle) -> None:
    """Draw the choice of place, points or segments, as far as the method has them."""
    halves = layout.split(factor=0.4)
    label = halves.row()
    label.alignment = "RIGHT"
    label.label(text="Acts As")
    column = halves.column(align=True)
    column.use_property_split = False  # which would give each button a label
    column.prop_enum(handle, "acts_as", "PLACE")
    column.prop_enum(handle, "acts_as", "POINTS")
    if points.takes_segments(deformer):
        column.prop_enum(handle, "acts_as", "SEGMENTS")
    elif handle.acts_as == "SEGMENTS":
        draw_text(context, layout, "This method has no segments: their ends act as points", "INFO")


class SINEW_MT_handle(Menu):
    """What can be done with the active handle"""

    bl_idname = Menus.HANDLE
    bl_label = "Handle"
    ICON = "EMPTY_AXIS"

    def draw(self, _context: Context) -> None:
        layout = invoking(self.layout)
        layout.operator(Operators.SELECT_HANDLE, icon="RESTRICT_SELECT_OFF")
        layout.operator(Operators.HANDLE_MIRROR, icon="MOD_MIRROR")
        layout.operator(Operators.CONTROL_NEW, icon="EMPTY_AXIS")
        for on, label, *_rest in STANDS_ON:
            layout.operator(Operators.HANDLE_STAND, text=f"Stand on {label}").on = on
        draw_move_entries(layout, Operators.HANDLE_MOVE, "Handle")
        layout.separator()
        layout.operator(Operators.HANDLE_REMOVE, icon="REMOVE")


MENUS = (SINEW_MT_handle,)
PANELS = (SINEW_PT_region,)


def draw_start(context: Context, layout: UILayout, obj: Object) -> None:
    """Draw how to make the first region."""
    if not targets.is_mesh(obj):
        draw_text(context, layout, "Empties and bones can move the space around them", "INFO")
        _draw_add_points(layout)
        return
    if obj.mode == "EDIT":
        hint = "Select the vertices to move, then Make Handle; those to keep, then Hold Still"
    else:
        hint = "Enter Edit Mode and select vertices, or choose a vertex group here"
    draw_text(context, layout, hint, "INFO")
    _draw_add_buttons(context, layout, obj)
    if obj.mode != "EDIT":
        _draw_add_points(layout)


def draw(context: Context, layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
    """Draw the list of handles, and the buttons that add handles."""
    layout.label(text="Handles")
    row = layout.row()
    several = len(deformer.handles) > 1
    rows = 5 if several else 3
    row.template_list("SINEW_UL_handles", "", deformer, "handles", deformer, "active_handle", rows=rows)
    side = row.column(align=True)
    side.menu(Menus.ADD_REGION, text="", icon="ADD")
    side.operator(Operators.HANDLE_REMOVE, text="", icon="REMOVE")
    side.separator()
    side.menu(Menus.HANDLE, text="", icon="DOWNARROW_HLT")
    if several:
        draw_move_buttons(side, Operators.HANDLE_MOVE)
    if several:
        _draw_mirror(context, layout, deformer)
    if targets.is_mesh(obj):
        _draw_add_buttons(context, layout, obj)
    if rigging.takes_points(deformer):
        _draw_add_points(layout)


def _draw_add_points(layout: UILayout) -> None:
    layout.operator_menu_enum(Operators.POINT_ADD, "source", icon="EMPTY_AXIS")


def _draw_mirror(context: Context, layout: UILayout, deformer: SinewDeformer) -> None:
    """Draw the switch for mirrored posing. Bones have their own, that of their armature."""
    layout.prop(deformer, "use_mirror_x", icon="MOD_MIRROR")
    if not deformer.use_mirror_x:
        return
    armatures = {handle.control for handle in deformer.handles if handle.bone and handle.control is not None}
    for armature in sorted(armatures, key=lambda armature: armature.name):
        if armature.pose is not None:
            layout.prop(armature.pose, "use_mirror_x", text=f"Bones of {armature.name}", icon="MOD_MIRROR")
    if not armatures and not sides.control_pairs(deformer):
        draw_text(context, layout, "No control has one on the other side yet - Mirror makes it", "INFO")


def _draw_add_buttons(context: Context, layout: UILayout, obj: Object) -> None:
    """Draw the buttons that add regions: from the selection in Edit Mode, else from a vertex group."""
    column = layout.column(align=True)
    _draw_add(column, obj, "HANDLE", "Make Handle", "ADD")
    beside = obj.mode == "EDIT" or columns(context) >= _WIDE_MENUS
    others = column.row(align=True) if beside else column
    _draw_add(others, obj, "FIXED", "Hold Still", "PINNED")
    _draw_add(others, obj, "SUPPORT", "Free Around It", "MOD_MESHDEFORM")


def _draw_add(layout: UILayout, obj: Object, role: str, text: str, icon: str) -> None:
    if obj.mode == "EDIT":
        layout.operator(Operators.HANDLE_ADD, text=text, icon=icon).kind = role
    else:
        layout.menu(Menus.FOR_GROUPS[role], text=text, icon=icon)
