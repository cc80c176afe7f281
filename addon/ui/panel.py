# SPDX-License-Identifier: GPL-3.0-or-later
"""The Sinew panel: deformers, method, handles, influence, status; and its sub-panels."""

from collections.abc import Iterator

from bpy.types import Context, Object, Panel, PropertyGroup, UILayout
from bpy.utils import register_classes_factory

from ..backend import availability
from ..core.methods import METHODS, Moved, Parameter
from ..core.status import Level, Remedy, Status
from ..ids import Menus, Operators
from ..operators import explain_no_target, target_of
from ..properties import BASE, SinewDeformer
from ..session.actions import sharing
from ..session.controls import kinds
from ..session.targets import modified, targets
from . import control, keys
from .control import draw_start, drawing_of
from .layouts import draw_move_buttons, split, unless_baked
from .parameters import draw_parameter
from .places import ActiveDeformerPanel, SidebarPanel, active_deformer
from .presets import SINEW_PT_presets
from .status_box import NATIVE_MISSING, draw_error, draw_message, draw_remedy, draw_status
from .text import draw_text

LINKED = "This object is linked from another file - make a library override to pose it here"
COPIED = (
    "The modifier {} was copied from another object and shows the shape of that one - remove it, then add "
    "handles or a cage here"
)


class SINEW_PT_sinew(SidebarPanel, Panel):
    """Deformers of the active mesh"""

    bl_label = "Sinew"

    @classmethod
    def poll(cls, context: Context) -> bool:
        """The tab in the sidebar is always shown and says what to do. Elsewhere there must be an object."""
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
        for name in modified.stray_modifiers(obj):
            draw_message(context, layout, Status(Level.WARNING, COPIED.format(name)))
        deformer = obj.sinew.active
        if deformer is None:
            _draw_first_step(context, layout, obj)
            return
        _draw_deformers(layout, obj)
        draw_error(context, layout, deformer)
        settings = unless_baked(layout, deformer)
        _draw_method(context, settings, obj, deformer)
        drawing = drawing_of(deformer.definition)
        if not drawing.ABOVE_PARAMETERS:
            drawing.draw(context, settings, obj, deformer)
        _draw_influence(settings, obj, deformer)
        draw_status(context, layout, deformer)


class SINEW_PT_advanced(ActiveDeformerPanel, Panel):
    """Settings that are seldom changed"""

    bl_label = "Settings"
    bl_order = 40

    def draw(self, context: Context) -> None:
        deformer = active_deformer(context)
        layout = split(unless_baked(self.layout, deformer))
        if kinds.marks_regions(deformer.definition) and not deformer.definition.is_space:
            layout.row().prop(deformer, "loose_parts", expand=True)
        layout.column(heading="Rebind").prop(deformer, "auto_rebind", text="Automatic")
        if deformer.is_iterative:
            layout.row().prop(deformer, "playback", expand=True)
        for values, parameter in _parameters(deformer, advanced=True):
            draw_parameter(layout, values, parameter)
        layout.column(heading="Render").prop(context.scene.render, "use_lock_interface")


def _parameters(deformer: SinewDeformer, advanced: bool) -> Iterator[tuple[PropertyGroup, Parameter]]:
    """What the methods use with their present choices, either the ``advanced`` ones or the others."""
    for method, values in deformer.methods:
        for parameter in method.parameters:
            if parameter.advanced == advanced and parameter.is_used(values):
                yield values, parameter


def _draw_no_mesh(context: Context, layout: UILayout) -> None:
    text, convertible = explain_no_target(context)
    draw_text(context, layout, text, "INFO")
    if convertible:
        draw_remedy(layout, Remedy.CONVERT)


def _draw_first_step(context: Context, layout: UILayout, obj: Object) -> None:
    """Draw the first step for an object without a deformer."""
    if availability().module is None:
        draw_message(context, layout, NATIVE_MISSING)
    draw_start(context, layout, obj)
    if targets.is_mesh(obj):
        layout.operator_menu_enum(
            Operators.DEFORMER_ADD, "method", text="Add Deformer", icon="MOD_MESHDEFORM"
        )


def _draw_deformers(layout: UILayout, obj: Object) -> None:
    several = len(obj.sinew.deformers) > 1
    row = layout.row()
    rows = 5 if several else 3
    row.template_list(
        "SINEW_UL_deformers", "", obj.sinew, "deformers", obj.sinew, "active_deformer", rows=rows
    )
    side = row.column(align=True)
    adding = Operators.DEFORMER_ADD if targets.is_mesh(obj) else Operators.CAGE_ADD
    side.operator_menu_enum(adding, "method", text="", icon="ADD")
    side.operator(Operators.DEFORMER_REMOVE, text="", icon="REMOVE")
    side.separator()
    side.menu(Menus.DEFORMER, text="", icon="DOWNARROW_HLT")
    if several:
        draw_move_buttons(side, Operators.DEFORMER_MOVE)


def _draw_method(context: Context, layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
    row = layout.row(align=True)
    if targets.is_mesh(obj):
        row.prop(deformer, "method", text="")
    else:
        choices = row.column(align=True)
        for method in METHODS:
            if Moved.POINTS in method.moves:
                choices.prop_enum(deformer, "method", method.id)
    SINEW_PT_presets.draw_panel_header(row.row())
    drawing = drawing_of(deformer.definition)
    if drawing.ABOVE_PARAMETERS:
        drawing.draw(context, layout, obj, deformer)
    settings = split(layout.column())
    if deformer.definition.wraps:
        settings.prop(deformer.parameters, BASE)
    for values, parameter in _parameters(deformer, advanced=False):
        draw_parameter(settings, values, parameter)


def _draw_influence(layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
    column = split(layout.column())
    column.prop(deformer, "factor", slider=True)
    if targets.has_groups_and_keys(obj):
        column.prop_search(deformer, "mask_group", obj, "vertex_groups")
    if sharing.sharing(deformer):
        layout.operator(Operators.SETTINGS_SHARE, icon="DUPLICATE")


PANELS = (SINEW_PT_sinew, *keys.PANELS, *control.PANELS, SINEW_PT_advanced)

register, unregister = register_classes_factory(PANELS)
