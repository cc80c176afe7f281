# SPDX-License-Identifier: GPL-3.0-or-later
"""The Sinew panel, and the sub-panels with what is seldom changed."""

from bpy.types import Context, Panel
from bpy.utils import register_classes_factory

from ..core.methods import Control
from ..core.tasks import task_of
from ..ids import Operators
from ..operators import page_of, target_of
from ..session.actions import sharing
from ..session.datablocks import movers
from ..session.targets import refined_group, targets
from .control import drawing_of
from .layouts import Button, draw_field, draw_move_entries, fields, invoking, unless_baked
from .lists import draw_deformer as draw_deformer_row
from .parameters import draw_others
from .places import ActiveDeformerPanel, SidebarPanel, active_deformer
from .presets import SINEW_PT_presets
from .situations import puppet, situation_of
from .situations.posing import draw_deformer
from .try_it import draw_steps

_ENDS = (
    Button(Operators.UNBIND, "Unbind", "X"),
    Button(Operators.APPLY, "Apply", "CHECKMARK"),
    Button(Operators.APPLY, "As Shape Key", "SHAPEKEY_DATA", (("as_shape_key", True),)),
    Button(Operators.DEFORMER_REMOVE, "Remove Deformer", "REMOVE"),
)
_REFINES = {
    False: Button(Operators.FAST_SUBDIVISION, "Fast Subdivision", "MOD_SUBSURF"),
    True: Button(Operators.FAST_SUBDIVISION, "Stop Fast Subdivision", "X", (("stop", True),)),
}


class SINEW_PT_sinew(SidebarPanel, Panel):
    """What can be done with what is selected"""

    bl_label = "Sinew"

    @classmethod
    def poll(cls, context: Context) -> bool:
        """The tab in the sidebar is always shown and says what to do. Elsewhere there must be an object."""
        return cls.bl_space_type == "VIEW_3D" or target_of(context) is not None

    def help_page(self, context: Context) -> str:
        return situation_of(context).page(context)

    def draw(self, context: Context) -> None:
        draw_steps(context, self.layout)
        situation_of(context).draw(context, self.layout)


class SINEW_PT_skin(ActiveDeformerPanel, Panel):
    """What the bones move, while they are posed"""

    bl_label = ""
    bl_order = 1

    @classmethod
    def poll(cls, context: Context) -> bool:
        return active_deformer(context) is not None and puppet.is_there(context)

    def draw_header(self, context: Context) -> None:
        self.layout.label(text=target_of(context).name)

    def draw(self, context: Context) -> None:
        obj = target_of(context)
        draw_deformer(context, self.layout, obj, obj.sinew.active)


class SINEW_PT_region(ActiveDeformerPanel, Panel):
    """Settings of the active row, whose name is the title"""

    bl_label = ""
    bl_order = 10

    def help_page(self, context: Context) -> str:
        method = active_deformer(context).definition
        return "handles" if method.control is Control.HANDLES else task_of(method).page

    @classmethod
    def poll(cls, context: Context) -> bool:
        deformer = active_deformer(context)
        return deformer is not None and bool(drawing_of(deformer.definition).row_name(deformer))

    def draw_header(self, context: Context) -> None:
        deformer = active_deformer(context)
        self.layout.label(text=drawing_of(deformer.definition).row_name(deformer))

    def draw(self, context: Context) -> None:
        deformer = active_deformer(context)
        layout = fields(context, unless_baked(self.layout, deformer))
        drawing_of(deformer.definition).draw_row(context, layout, target_of(context), deformer)


class SINEW_PT_advanced(ActiveDeformerPanel, Panel):
    """Settings that are seldom changed"""

    bl_label = "Settings"
    bl_order = 15

    def help_page(self, context: Context) -> str:
        return page_of(active_deformer(context).definition)

    def draw_header_preset(self, context: Context) -> None:
        SINEW_PT_presets.draw_panel_header(self.layout.row())
        SidebarPanel.draw_header_preset(self, context)

    def draw(self, context: Context) -> None:
        deformer = active_deformer(context)
        layout = fields(context, unless_baked(self.layout, deformer))
        draw_others(context, layout, deformer)
        drawing_of(deformer.definition).draw_settings(context, layout, target_of(context), deformer)
        if deformer.is_iterative:
            draw_field(context, layout, deformer, "playback", expand=True)
        if movers.armatures_of(target_of(context)):
            invoking(layout.column()).operator(Operators.DRIVE, icon="DRIVER")
        layout.prop(deformer, "auto_rebind")
        layout.prop(context.scene.render, "use_lock_interface")


class SINEW_PT_order(ActiveDeformerPanel, Panel):
    """Where the deformer shows, in which order, and how it ends"""

    bl_label = "Mask and Order"
    bl_order = 18

    def draw(self, context: Context) -> None:
        obj = target_of(context)
        deformer = obj.sinew.active
        layout = self.layout
        settings = fields(context, unless_baked(layout, deformer))
        if targets.has_groups_and_keys(obj):
            draw_field(context, settings, deformer, "mask_group", among=(obj, "vertex_groups"))
        draw_deformer_row(context, layout.box().row(align=True), obj.sinew, deformer)
        column = invoking(layout.column(align=True))
        if len(obj.sinew.deformers) > 1:
            draw_move_entries(column, Operators.DEFORMER_MOVE, "Deformer")
        for button in drawing_of(deformer.definition).REST:
            button.draw(column)
        if sharing.sharing(deformer):
            column.operator(Operators.SETTINGS_SHARE, icon="DUPLICATE")
        if targets.is_mesh(obj):
            _REFINES[refined_group.of(obj) is not None].draw(column)
        text = "Rebind" if deformer.is_bound else "Bind"
        column.operator(Operators.BIND, text=text, icon="FILE_REFRESH")
        for button in _ENDS:
            button.draw(column)


PANELS = (SINEW_PT_sinew, SINEW_PT_skin, SINEW_PT_region, SINEW_PT_advanced, SINEW_PT_order)

register, unregister = register_classes_factory(PANELS)
