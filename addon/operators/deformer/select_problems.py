# SPDX-License-Identifier: GPL-3.0-or-later
"""Select the elements that a status line names."""

import bpy
from bpy.props import IntProperty
from bpy.types import Context, Operator

from ...core import status
from ...ids import Operators
from ...properties import field
from ...session.actions import selection
from ...session.controls import kinds
from ...session.targets import targets
from ..offered import OnDeformer
from ..reporting import reports_errors
from ..target import target_of


class SINEW_OT_select_problems(OnDeformer, Operator):
    """Show, in Edit Mode, the vertices or faces of the mesh or of its cage that the status names"""

    bl_idname = Operators.SELECT_PROBLEMS
    bl_label = "Show"

    line: field(IntProperty, default=-1, min=-1).named(
        "Line", "Choose the status line by its index; -1 is the first warning"
    )

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        uid = obj.sinew.active.uid
        lines = [line for line in (status.current(uid), *status.notes(uid)) if line.elements]
        if self.line >= 0:
            lines = lines[self.line : self.line + 1]
        else:
            lines.sort(key=lambda line: line.level is status.Level.INFO)
        if not lines:
            self.tell({"INFO"}, "The status names no vertices or faces")
            return {"CANCELLED"}
        shown = kinds.object_with(obj.sinew.active, lines[0].elements)
        if shown.name not in context.view_layer.objects:
            self.tell(
                {"ERROR"},
                f"{shown.name} is not in this view layer - add its collection to the view layer first",
            )
            return {"CANCELLED"}
        if not targets.is_mesh(shown) and shown.type != "LATTICE":
            self.tell({"ERROR"}, f"{shown.name} is not a mesh, so its points cannot be selected here")
            return {"CANCELLED"}
        if shown.mode != "EDIT":
            if context.object is not None and context.object.mode != "OBJECT":
                bpy.ops.object.mode_set(mode="OBJECT")
            shown.hide_set(False)
            context.view_layer.objects.active = shown
            bpy.ops.object.mode_set(mode="EDIT")
        count = selection.select_elements(shown, lines[0].elements)
        self.tell({"INFO"}, f"{lines[0].text}: {count} selected")
        return {"FINISHED"}
