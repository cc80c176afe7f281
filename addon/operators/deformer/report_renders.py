# SPDX-License-Identifier: GPL-3.0-or-later
"""Tell in Blender's own place for reports what a render could not show."""

from bpy.props import StringProperty
from bpy.types import Context, Operator

from ...ids import Operators
from ...properties import field
from ..reporting import Reports


class SINEW_OT_report_renders(Reports, Operator):
    """Report which deformers showed the rest shape in the last render, and why"""

    bl_idname = Operators.REPORT_RENDERS
    bl_label = "Report Renders"
    bl_options = {"INTERNAL"}  # Sinew calls it after a render

    text: field(StringProperty).named("Text", "Say what to report")

    def execute(self, _context: Context) -> set[str]:
        self.tell({"WARNING"}, self.text)
        return {"FINISHED"}
