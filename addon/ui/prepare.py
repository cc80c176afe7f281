# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel Prepare: what is unusual about a mesh, and how it bends."""

from bpy.types import Context, Panel
from bpy.utils import register_classes_factory

from ..ids import Operators
from ..operators import target_of
from ..session.actions import repair, surveying
from ..session.targets import targets
from .places import ROOT, SidebarPanel
from .text import draw_text

# What Repair can mend.
_MENDED = {"not_finite", "coincident", "degenerate", "duplicate", "non_manifold", "loose", "slit"}


class SINEW_PT_prepare(SidebarPanel, Panel):
    """What is unusual about the mesh, what mends it, and how the mesh bends"""

    bl_label = "Prepare"
    bl_parent_id = ROOT
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 40

    @classmethod
    def poll(cls, context: Context) -> bool:
        obj = target_of(context)
        return obj is not None and targets.is_mesh(obj)

    def draw(self, context: Context) -> None:
        layout, counts = self.layout, surveying.last_counts(target_of(context))
        layout.operator(Operators.DIAGNOSE, icon="VIEWZOOM")
        if counts is not None:
            self._draw_counts(context, counts)
        layout.separator()
        column = layout.column(align=True)
        column.operator(Operators.REMESH, icon="MOD_REMESH")
        column.operator(Operators.DECIMATE, icon="MOD_DECIM")
        column.operator(Operators.SEMI_REGULAR, icon="MOD_MULTIRES")
        column.operator(Operators.REMOVE_NEEDLES, icon="MOD_TRIANGULATE")
        layout.separator()
        layout.operator(Operators.CURVATURE, icon="MOD_SMOOTH")

    def _draw_counts(self, context: Context, counts: surveying.Counts) -> None:
        column = self.layout.column(align=True)
        parts = "1 part" if counts.parts == 1 else f"{counts.parts:,} parts"
        one_sided = f", {counts.one_sided:,} with one side only" if counts.one_sided else ""
        draw_text(context, column, f"{parts}{one_sided}", "OUTLINER_OB_MESH")
        for what, count in counts.found.items():
            row = column.row()
            draw_text(context, row.column(), surveying.counted(what, count), "DOT", beside=60)
            if what in repair.REMEDIES:
                row.operator(Operators.CURE, text="", icon="TOOL_SETTINGS").what = what
            row.operator(Operators.SELECT_UNUSUAL, text="", icon="RESTRICT_SELECT_OFF").what = what
        if not counts.found:
            draw_text(context, column, "Nothing unusual", "CHECKMARK")
        elif not _MENDED.isdisjoint(counts.found):
            self.layout.operator(Operators.REPAIR, icon="TOOL_SETTINGS")


PANELS = (SINEW_PT_prepare,)

register, unregister = register_classes_factory(PANELS)
