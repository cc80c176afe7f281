# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the handles of a deformer, the settings of the active one, and its menu."""

from bpy.types import Context, Menu, Object, UILayout

from ...core.methods import MeshShape, wrapper_of
from ...ids import Menus, Operators
from ...properties import STANDS_ON, SinewDeformer, SinewHandle, row_at
from ...session.actions import rigging
from ...session.actions.handles import standing
from ...session.actions.handles.standing import NOTHING_MOVES
from ...session.controls.handles import points, riding, sides
from .. import keys
from ..layouts import Button, beside, draw_field, draw_move_entries, fields, invoking
from ..pose import RESET, draw_drag, draw_reset
from ..text import draw_text, is_wide

REST: tuple[Button, ...] = ()


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


def draw(context: Context, layout: UILayout, _obj: Object, deformer: SinewDeformer) -> None:
    """Draw the keys of an edit, the list of handles, and what poses all of them."""
    if deformer.definition.keyed:
        keys.draw(context, layout, deformer)
    goals = _goals(deformer)
    for goal in goals:
        draw_text(context, layout, f"To {goal.name}", "OUTLINER_OB_MESH", boxed=False)
        target = (("target", goal.name), ("key", True))
        Button(Operators.MORPH, "Key from 0 to 1", "KEYINGSET", target).draw(layout)
    if goals and not deformer.handles:
        return
    if context.mode == "OBJECT" and any(handle.bone for handle in deformer.handles):
        large = layout.column()
        large.scale_y = 1.3
        draw_drag(large, "BONES")
    row = layout.row()
    rows = 4 if len(deformer.handles) > 1 else 3
    row.template_list("SINEW_UL_handles", "", deformer, "handles", deformer, "chosen_handle", rows=rows)
    side = row.column(align=True)
    side.menu(Menus.ADD_REGION, text="", icon="ADD")
    side.operator(Operators.HANDLE_REMOVE, text="", icon="REMOVE")
    side.separator()
    side.menu(Menus.HANDLE, text="", icon="DOWNARROW_HLT")
    pair = beside(context, layout, ("Mirror", "MOD_MIRROR"), RESET)
    if len(deformer.handles) > 1:
        pair.prop(deformer, "use_mirror_x", toggle=True, icon="MOD_MIRROR")
    draw_reset(pair)
    if deformer.use_mirror_x:
        _draw_mirrored(context, layout, deformer)
    details = layout.row()
    details.enabled = wrapper_of(deformer.methods[-1][0]) is not None
    details.prop(deformer, "keep_details", toggle=True, icon="MOD_DISPLACE")


def row_name(deformer: SinewDeformer) -> str:
    """The name of the active handle."""
    handle = row_at(deformer.handles, deformer.active_handle)
    return "" if handle is None else handle.name


def draw_row(context: Context, layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
    """Draw the settings of the active handle."""
    handle = row_at(deformer.handles, deformer.active_handle)
    draw_field(context, layout, handle, "kind")
    draw_field(context, layout, handle, "vertex_group", among=(obj, "vertex_groups"))
    if handle.kind == "HANDLE":
        control = layout.column()
        control.alert = handle.control_missing
        fields(context, control)
        draw_field(context, control, handle, "control")
        if handle.control_missing:
            layout.operator(Operators.CONTROL_NEW, icon="EMPTY_AXIS").index = deformer.active_handle
        if handle.control is not None and handle.control.type == "ARMATURE":
            draw_field(context, control, handle, "bone", among=(handle.control.data, "bones"))
        if not handle.vertex_group and rigging.takes_points(deformer):
            _draw_acts_as(context, layout, deformer, handle)
        _draw_stands_on(context, layout, obj, deformer, handle)
    draw_field(context, layout, handle, "weight", slider=True)
    for parameter in deformer.definition.handle_parameters:
        draw_field(context, layout, handle, parameter.id, slider=True)
    if handle.kind == "HANDLE":
        draw_field(context, layout, handle, "colour")


def draw_settings(context: Context, layout: UILayout, _obj: Object, deformer: SinewDeformer) -> None:
    """Draw what parts without a region do."""
    if not deformer.definition.is_space:
        draw_field(context, layout, deformer, "loose_parts", expand=True)


def _goals(deformer: SinewDeformer) -> list[Object]:
    """The objects whose shapes the surface goes to, which needs no handles."""
    found = [
        getattr(values, parameter.id)
        for method, values in deformer.methods
        for parameter in method.parameters
        if isinstance(parameter, MeshShape)
    ]
    return [obj for obj in found if obj is not None]


def _draw_stands_on(
    context: Context, layout: UILayout, obj: Object, deformer: SinewDeformer, handle: SinewHandle
) -> None:
    """Draw what the control stands on. *From Rest* is older, and for handles in the world that use it."""
    row = _labelled(context, layout, "Stands On").row(align=True)
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
        draw_field(context, layout, handle, "from_rest")


def _draw_acts_as(context: Context, layout: UILayout, deformer: SinewDeformer, handle: SinewHandle) -> None:
    """Draw the choice of place, points or segments, as far as the method has them."""
    column = _labelled(context, layout, "Acts As").column(align=True)
    column.use_property_split = False  # which would give each button a label
    column.prop_enum(handle, "acts_as", "PLACE")
    column.prop_enum(handle, "acts_as", "POINTS")
    if points.takes_segments(deformer):
        column.prop_enum(handle, "acts_as", "SEGMENTS")
    elif handle.acts_as == "SEGMENTS":
        draw_text(context, layout, "This method has no segments: their ends act as points", "INFO")


def _labelled(context: Context, layout: UILayout, text: str) -> UILayout:
    """A place for buttons, with a label beside it in a wide region, else above it."""
    if not is_wide(context):
        column = layout.column(align=True)
        column.label(text=text)
        return column
    halves = layout.split(factor=0.4)
    label = halves.row()
    label.alignment = "RIGHT"
    label.label(text=text)
    return halves


def _draw_mirrored(context: Context, layout: UILayout, deformer: SinewDeformer) -> None:
    """Draw what mirrored posing lacks. Bones have their own switch, that of their armature."""
    armatures = {handle.control for handle in deformer.handles if handle.bone and handle.control is not None}
    for armature in sorted(armatures, key=lambda armature: armature.name):
        if armature.pose is not None:
            layout.prop(armature.pose, "use_mirror_x", text=f"Bones of {armature.name}", icon="MOD_MIRROR")
    if not armatures and not sides.control_pairs(deformer):
        draw_text(context, layout, "No control has one on the other side yet - Mirror makes it", "INFO")
