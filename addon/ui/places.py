# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the panels are: in the sidebar of the 3D Viewport, and in the Modifiers tab of the Properties editor.

A panel is written once, for the sidebar. ``in_properties`` derives the other panel from it.
"""

from bpy.types import Context, Panel

from ..ids import Operators
from ..operators import target_of
from ..properties import SinewDeformer

ROOT = "SINEW_PT_sinew"  # the parent of all other panels
_SUFFIX = "_properties"

# The manual page behind the question mark of each sub-panel that always has the same.
_PAGES = {
    "SINEW_PT_skin": "pose-by-bones",
    "SINEW_PT_order": "order-and-masks",
    "SINEW_PT_bake": "bake",
    "SINEW_PT_overlays": "show",
    "SINEW_PT_prepare": "prepare",
}


class SidebarPanel:
    """Mixin for a panel in the Sinew tab of the sidebar, with a question mark that opens the manual."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Sinew"

    def help_page(self, _context: Context) -> str:
        """The page that the question mark opens."""
        return _PAGES[type(self).__name__.removesuffix(_SUFFIX)]

    def draw_header_preset(self, context: Context) -> None:
        row = self.layout.row()
        row.active = not hasattr(type(self), "bl_parent_id")  # those of sub-panels are dim
        row.operator(Operators.HELP, text="", icon="QUESTION", emboss=False).page = self.help_page(context)


class ActiveDeformerPanel(SidebarPanel):
    """Mixin for a sub-panel that is shown if there is a deformer that can be edited."""

    bl_parent_id = ROOT
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return active_deformer(context) is not None


def active_deformer(context: Context) -> SinewDeformer | None:
    """The deformer that the panels show, or None."""
    obj = target_of(context)
    return obj.sinew.active if obj is not None and obj.library is None else None


def in_properties(panel: type[Panel]) -> type[Panel]:
    """Derive the same panel for the Modifiers tab of the Properties editor."""
    attributes = {key: value for key, value in vars(panel).items() if key != "bl_rna"}
    derived = type(panel.__name__ + _SUFFIX, panel.__bases__, attributes)
    derived.bl_space_type, derived.bl_region_type, derived.bl_context = "PROPERTIES", "WINDOW", "modifier"
    derived.bl_category = ""
    derived.bl_options = {*getattr(panel, "bl_options", ()), "DEFAULT_CLOSED"}
    if hasattr(panel, "bl_parent_id"):
        derived.bl_parent_id = panel.bl_parent_id + _SUFFIX
    return derived
