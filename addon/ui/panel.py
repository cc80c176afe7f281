# SPDX-License-Identifier: GPL-3.0-or-later
"""The Sinew tab of the sidebar."""

from bpy.types import Context, Object, Panel, UILayout
from bpy.utils import register_classes_factory

from .. import session
from ..backend import availability
from ..core import status
from ..core.methods import group_property
from ..core.status import Level, Status
from ..ids import Operators
from ..operators import target_of
from ..properties import SinewDeformer
from .text import draw_text

_ICONS = {Level.NONE: "BLANK1", Level.INFO: "INFO", Level.WARNING: "ERROR", Level.ERROR: "CANCEL"}


class _Sidebar(Panel):
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Sinew"


class SINEW_PT_sinew(_Sidebar):
    """Deformers of the active mesh"""

    bl_label = "Sinew"

    def draw(self, context: Context) -> None:
        layout = self.layout
        obj = target_of(context)
        if obj is None:
            layout.label(text="Select a mesh object", icon="INFO")
            return
        if obj.library is not None:
            draw_text(context, layout, "This object is linked - make a library override to pose it", "INFO")
            return
        _draw_deformers(layout, obj)
        deformer = obj.sinew.active
        if deformer is None:
            if availability().module is None:
                draw_text(context, layout, availability().remedy, "ERROR")
            draw_text(context, layout, "Select vertices in Edit Mode, then", "INFO")
            _draw_add_buttons(layout)
            return
        _draw_method(context, layout, obj, deformer)
        _draw_handles(layout, deformer)
        _draw_add_buttons(layout)
        _draw_influence(layout, obj, deformer)
        draw_status(context, layout, deformer)


class SINEW_PT_handle(_Sidebar):
    """Settings of the active region"""

    bl_label = "Region"
    bl_parent_id = "SINEW_PT_sinew"

    @classmethod
    def poll(cls, context: Context) -> bool:
        obj = target_of(context)
        deformer = obj.sinew.active if obj is not None else None
        return deformer is not None and 0 <= deformer.active_handle < len(deformer.handles)

    def draw(self, context: Context) -> None:
        obj = target_of(context)
        deformer = obj.sinew.active
        handle = deformer.handles[deformer.active_handle]
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(handle, "kind")
        layout.prop_search(handle, "vertex_group", obj, "vertex_groups")
        if handle.kind == "HANDLE":
            control = layout.column()
            control.alert = handle.control_missing
            control.prop(handle, "control")
            if handle.control is not None and handle.control.type == "ARMATURE":
                control.prop_search(handle, "bone", handle.control.data, "bones")
            layout.prop(handle, "from_rest")
        layout.prop(handle, "weight", slider=True)
        if deformer.definition.continuity:
            layout.prop(handle, "continuity", slider=True)


def _draw_deformers(layout: UILayout, obj: Object) -> None:
    row = layout.row()
    row.template_list("SINEW_UL_deformers", "", obj.sinew, "deformers", obj.sinew, "active_deformer", rows=2)
    column = row.column(align=True)
    column.operator_menu_enum(Operators.DEFORMER_ADD, "method", text="", icon="ADD")
    column.operator(Operators.DEFORMER_REMOVE, text="", icon="REMOVE")


def _draw_method(context: Context, layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
    column = layout.column()
    column.prop(deformer, "method", text="")
    hint = column.column(align=True)
    hint.active = False
    draw_text(context, hint, deformer.definition.summary)
    settings = layout.column()
    settings.use_property_split = True
    settings.use_property_decorate = False
    for parameter in deformer.definition.parameters:
        row = settings.row(align=True)
        row.prop(deformer.parameters, parameter.id)
        if getattr(parameter, "paintable", False):
            group = group_property(parameter)
            painted = settings.row()
            painted.prop_search(deformer.parameters, group, obj, "vertex_groups", text="Group")


def _draw_handles(layout: UILayout, deformer: SinewDeformer) -> None:
    row = layout.row()
    row.template_list("SINEW_UL_handles", "", deformer, "handles", deformer, "active_handle", rows=3)
    column = row.column(align=True)
    column.operator(Operators.HANDLE_REMOVE, text="", icon="REMOVE")
    column.operator(Operators.SELECT_HANDLE, text="", icon="RESTRICT_SELECT_OFF")


def _draw_add_buttons(layout: UILayout) -> None:
    column = layout.column(align=True)
    column.operator(Operators.HANDLE_ADD, text="Add Handle", icon="ADD").kind = "HANDLE"
    row = column.row(align=True)
    row.operator(Operators.HANDLE_ADD, text="Add Fixed").kind = "FIXED"
    row.operator(Operators.HANDLE_ADD, text="Set Support").kind = "SUPPORT"


def _draw_influence(layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
    column = layout.column()
    column.use_property_split = True
    column.prop(deformer, "factor", slider=True)
    column.use_property_decorate = False
    column.prop_search(deformer, "mask_group", obj, "vertex_groups")


def draw_status(context: Context, layout: UILayout, deformer: SinewDeformer) -> None:
    """What the deformer is doing, what is wrong, and the buttons that help."""
    box = layout.box()
    under_way = session.job(deformer.uid)
    if under_way is not None:
        box.label(text=f"Binding {under_way.fraction:.0%} {under_way.stage}", icon="SORTTIME")
        return
    main = status.of(deformer.uid)
    known = session.find(deformer.uid)
    text = main.text or ("Bound" if deformer.is_bound else "Not bound - press Bind")
    if main.level is Level.INFO and known is not None and known.solve_milliseconds:
        text = f"{text}, solve {session.duration(known.solve_milliseconds)}"
    lines = [Status(main.level, text, main.elements, main.element_kind), *status.notes(deformer.uid)]
    number = 0
    for line in lines:
        row = box.row()
        draw_text(context, row.column(), line.text, _ICONS[line.level], beside=30 if line.elements else 0)
        if line.elements:
            row.operator(Operators.SELECT_PROBLEMS, text="", icon="RESTRICT_SELECT_OFF").line = number
            number += 1
    for handle in deformer.handles:
        if handle.control_missing:
            text = f"{handle.name} has lost its control and stays where it was - pick another"
            draw_text(context, box, text, _ICONS[Level.WARNING])
    render = context.scene.render
    if deformer.is_bound and not render.use_lock_interface:
        draw_text(context, box, "Renders from this window are safe only with", _ICONS[Level.WARNING])
        box.prop(render, "use_lock_interface")
    row = box.row(align=True)
    row.operator(Operators.BIND, text="Rebind" if deformer.is_bound else "Bind")
    row.operator(Operators.UNBIND, text="Unbind")
    row.operator(Operators.APPLY, text="Apply")


register, unregister = register_classes_factory((SINEW_PT_sinew, SINEW_PT_handle))
