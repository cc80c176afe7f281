# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the current shape permanent."""

from bpy.props import BoolProperty
from bpy.types import Context, Operator

from ...ids import Operators
from ...session.actions import apply
from ..arguments import once
from ..offered import OnDeformer
from ..reporting import reports_errors
from ..target import deformer_index, object_mode, target_of


class SINEW_OT_apply(OnDeformer, Operator):
    """Make the current shape the shape of the mesh, or a shape key of it, and remove the deformer"""

    bl_idname = Operators.APPLY
    bl_label = "Apply"

    as_shape_key: once(BoolProperty).named(
        "As Shape Key", "Add the shape as a new shape key instead of changing the mesh"
    )
    keep_deformer: once(BoolProperty).named(
        "Keep Deformer", "Leave the deformer on the mesh, to make more shape keys with it"
    )

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        keep = self.keep_deformer and self.as_shape_key
        with object_mode(context, obj):
            before = apply.apply(obj, deformer_index(obj, -1), self.as_shape_key, keep)
        if before:
            names = ", ".join(before)
            self.tell(
                {"INFO"},
                f"Applied modifier was not first ({names} came before), result may not be as expected",
            )
        return {"FINISHED"}

    def draw(self, _context: Context) -> None:
        self.layout.prop(self, "as_shape_key")
        row = self.layout.row()
        row.enabled = self.as_shape_key
        row.prop(self, "keep_deformer")
