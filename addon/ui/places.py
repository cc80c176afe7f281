# SPDX-License-Identifier: GPL-3.0-or-later
"""Where our panels stand: in the sidebar of the 3D Viewport, and in the Properties editor's Modifiers tab.

A panel is written once, for the sidebar. ``in_properties`` makes the other one of it, the way Blender itself
puts its node panels into two editors.
"""

from bpy.types import Context, Panel

from ..ids import Operators
from ..operators import target_of
from ..properties import SinewDeformer

ROOT = "SINEW_PT_sinew"  # the panel that all others are children of
_SUFFIX = "_properties"

# The manual page behind the question mark of each panel that has one.
PAGES = {
    ROOT: "surface",
    "SINEW_PT_bake": "baking",
    "SINEW_PT_overlay": "overlays",
    "SINEW_PT_overlays": "overlays",
}


class SidebarPanel:
    """Mixed into a panel: the Sinew tab of the sidebar, a question mark where the manual has a page."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Sinew"

    def draw_header_preset(self, _context: Context) -> None:
        page = PAGES.get(type(self).__name__.removesuffix(_SUFFIX))
        if page is not None:
            self.layout.operator(Operators.HELP, text="", icon="QUESTION", emboss=False).page = page


class ActiveDeformerPanel(SidebarPanel):
    """Below the panel of deformers, where there is one that can be edited."""

    bl_parent_id = ROOT
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return active_deformer(context) is not None


def active_deformer(context: Context) -> SinewDeformer | None:
    """The deformer that the panels are about."""
    obj = target_of(context)
    return obj.sinew.active if obj is not None and obj.library is None else None


def in_properties(panel: type[Panel]) -> type[Panel]:
    """The same panel for the Modifiers tab of the Properties editor."""
    attributes = {key: value for key, value in vars(panel).items() if key != "bl_rna"}
    twin = type(panel.__name__ + _SUFFIX, panel.__bases__, attributes)
    twin.bl_space_type, twin.bl_region_type, twin.bl_context = "PROPERTIES", "WINDOW", "modifier"
    twin.bl_category = ""
    twin.bl_options = {*getattr(panel, "bl_options", ()), "DEFAULT_CLOSED"}
    if hasattr(panel, "bl_parent_id"):
        twin.bl_parent_id = panel.bl_parent_id + _SUFFIX
    return twin
