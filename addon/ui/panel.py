# SPDX-License-Identifier: GPL-3.0-or-later
"""The Sinew panel: deformers, method, handles, influence, status; and its sub-panels."""

from collections.abc import Iterator

from bpy.types import Context, Object, Panel, PropertyGroup, UILayout
from bpy.utils import register_classes_factory

from .. import session
from ..backend import availability
from ..core.methods import METHODS, Control, Moved, Parameter
from ..core.status import Level, Remedy, Status
from ..ids import Menus, Operators
from ..operators import no_mesh, target_of
from ..properties import BASE, SinewDeformer
from .parameters import draw_parameter
from .places import ROOT, SidebarPanel
from .status_box import NATIVE_MISSING, draw_error, draw_message, draw_remedy, draw_status
from .text import columns, draw_text

LINKED = "This object is linked from another file - make a library override to pose it here"
_WIDE_MENUS = 36  # characters, from which on two menu buttons fit beside each other


class SINEW_PT_sinew(SidebarPanel, Panel):
    """Deformers of the active mesh"""

    bl_label = "Sinew"

    @classmethod
    def poll(cls, context: Context) -> bool:
        """The sidebar's tab is always there and says what to do; elsewhere there must be a mesh."""
        return cls.bl_space_type == "VIEW_3D" or target_of(context) is not None

    def draw(self, context: Context) -> None:
        layout = self.layout
        obj = target_of(context)
        if obj is None:
            _draw_no_mesh(context, layout)
            return
        if obj.library is not None:
            draw_message(context, layout, Status(Level.INFO, LINKED, remedy=Remedy.OVERRIDE))
            return
        deformer = obj.sinew.active
        if deformer is None:
            _draw_start(context, layout, obj)
            return
        _draw_deformers(layout, obj)
        draw_error(context, layout, deformer)
        _draw_method(layout, obj, deformer)
        if deformer.definition.control is Control.HANDLES:
            _draw_handles(context, layout, obj, deformer)
        _draw_influence(layout, obj, deformer)
        draw_status(context, layout, deformer)


class _ActiveDeformerPanel(SidebarPanel):
    bl_parent_id = ROOT
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return _active_deformer(context) is not None


class SINEW_PT_region(_ActiveDeformerPanel, Panel):
    """Settings of the active region"""

    bl_label = "Region"
    bl_order = 10

    @classmethod
    def poll(cls, context: Context) -> bool:
        deformer = _active_deformer(context)
        if deformer is None or deformer.definition.control is not Control.HANDLES:
            return False
        return 0 <= deformer.active_handle < len(deformer.handles)

    def draw(self, context: Context) -> None:
        obj = target_of(context)
        deformer = obj.sinew.active
        handle = deformer.handles[deformer.active_handle]
        layout = _split(self.layout)
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
        for parameter in deformer.definition.handle_parameters:
            layout.prop(handle, parameter.id, slider=True)
        if handle.kind == "HANDLE":
            layout.prop(handle, "colour")


class SINEW_PT_advanced(_ActiveDeformerPanel, Panel):
    """What is seldom changed"""

    bl_label = "Advanced"
    bl_order = 40

    def draw(self, context: Context) -> None:
        deformer = _active_deformer(context)
        layout = _split(self.layout)
        layout.column(heading="Rebind").prop(deformer, "auto_rebind", text="Automatic")
        for values, parameter in _parameters(deformer, advanced=True):
            draw_parameter(layout, values, parameter)
        layout.column(heading="Render").prop(context.scene.render, "use_lock_interface")


def _active_deformer(context: Context) -> SinewDeformer | None:
    obj = target_of(context)
    return obj.sinew.active if obj is not None and obj.library is None else None


def _split(layout: UILayout) -> UILayout:
    """Labels to the left, as in Blender's own panels; without the dots of animation, as in its sidebar."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    return layout


def _parameters(deformer: SinewDeformer, advanced: bool) -> Iterator[tuple[PropertyGroup, Parameter]]:
    """Those of the methods in use; ``advanced`` is also how far an iterative one goes on its way."""
    for method, values in deformer.methods:
        for parameter in method.parameters:
            if advanced == (parameter.advanced or (method.iterative and not parameter.rebinds)):
                yield values, parameter


def _draw_no_mesh(context: Context, layout: UILayout) -> None:
    text, convertible = no_mesh(context)
    draw_text(context, layout, text, "INFO")
    if convertible:
        draw_remedy(layout, Remedy.CONVERT)


def _draw_start(context: Context, layout: UILayout, obj: Object) -> None:
    """An object without a deformer: the first step."""
    if availability().module is None:
        draw_message(context, layout, NATIVE_MISSING)
    if not session.is_mesh(obj):
        draw_text(context, layout, f"A cage moves this {session.label(obj)} object - add one", "INFO")
        _draw_add_cage(layout)
        return
    if obj.mode == "EDIT":
        hint = "Select the vertices to move, then Add Handle; those to keep, then Add Fixed"
    else:
        hint = "Enter Edit Mode and select vertices, or choose a vertex group here"
    draw_text(context, layout, hint, "INFO")
    _draw_add_buttons(context, layout, obj)
    _draw_add_cage(layout)
    layout.operator_menu_enum(Operators.DEFORMER_ADD, "method", text="Add Deformer", icon="MOD_MESHDEFORM")


def _draw_deformers(layout: UILayout, obj: Object) -> None:
    several = len(obj.sinew.deformers) > 1
    row = layout.row()
    rows = 5 if several else 3
    row.template_list(
        "SINEW_UL_deformers", "", obj.sinew, "deformers", obj.sinew, "active_deformer", rows=rows
    )
    side = row.column(align=True)
    adding = Operators.DEFORMER_ADD if session.is_mesh(obj) else Operators.CAGE_ADD
    side.operator_menu_enum(adding, "method", text="", icon="ADD")
    side.operator(Operators.DEFORMER_REMOVE, text="", icon="REMOVE")
    side.separator()
    side.menu(Menus.DEFORMER, text="", icon="DOWNARROW_HLT")
    if several:
        _draw_move(side, Operators.DEFORMER_MOVE)


def _draw_move(side: UILayout, operator: str) -> None:
    side.separator()
    side.operator(operator, text="", icon="TRIA_UP").direction = "UP"
    side.operator(operator, text="", icon="TRIA_DOWN").direction = "DOWN"


def _draw_method(layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
    if session.is_mesh(obj):
        layout.prop(deformer, "method", text="")
    else:
        choices = layout.column(align=True)
        for method in METHODS:
            if Moved.POINTS in method.moves:
                choices.prop_enum(deformer, "method", method.id)
    if deformer.definition.control is Control.CAGE:
        _draw_cage(layout, deformer)
    settings = _split(layout.column())
    if deformer.definition.wraps:
        settings.prop(deformer.parameters, BASE)
    for values, parameter in _parameters(deformer, advanced=False):
        draw_parameter(settings, values, parameter)


def _draw_handles(context: Context, layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
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
        _draw_move(side, Operators.HANDLE_MOVE)
    _draw_add_buttons(context, layout, obj)


def _draw_cage(layout: UILayout, deformer: SinewDeformer) -> None:
    column = _split(layout.column())
    row = column.row()
    row.alert = deformer.is_bound and deformer.cage_missing
    row.prop(deformer, "cage")
    if deformer.cage is None:
        _draw_add_cage(layout)
    else:
        column.prop(deformer, "cage_subdivision")
        layout.operator(Operators.CAGE_REST, icon="PIVOT_BOUNDBOX")


def _draw_add_cage(layout: UILayout) -> None:
    column = layout.column(align=True)
    column.operator(Operators.CAGE_ADD, icon="MESH_CUBE").source = "AUTO"
    column.operator(Operators.CAGE_ADD, text="Use Selected as Cage", icon="MESH_ICOSPHERE").source = "OBJECT"


def _draw_add_buttons(context: Context, layout: UILayout, obj: Object) -> None:
    """In Edit Mode they take the selection, else a vertex group from a menu."""
    column = layout.column(align=True)
    _draw_add(column, obj, "HANDLE", "Add Handle", "ADD")
    beside = obj.mode == "EDIT" or columns(context) >= _WIDE_MENUS
    others = column.row(align=True) if beside else column
    _draw_add(others, obj, "FIXED", "Add Fixed", "PINNED")
    _draw_add(others, obj, "SUPPORT", "Set Support", "MOD_MESHDEFORM")


def _draw_add(layout: UILayout, obj: Object, kind: str, text: str, icon: str) -> None:
    if obj.mode == "EDIT":
        layout.operator(Operators.HANDLE_ADD, text=text, icon=icon).kind = kind
    else:
        layout.menu(Menus.OF_GROUPS[kind], text=text, icon=icon)


def _draw_influence(layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
    column = _split(layout.column())
    column.prop(deformer, "factor", slider=True)
    if session.is_mesh(obj):
        column.prop_search(deformer, "mask_group", obj, "vertex_groups")


PANELS = (SINEW_PT_sinew, SINEW_PT_region, SINEW_PT_advanced)

register, unregister = register_classes_factory(PANELS)
