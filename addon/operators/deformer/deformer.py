# SPDX-License-Identifier: GPL-3.0-or-later
"""Add and remove deformers."""

from typing import ClassVar

from bpy.props import EnumProperty
from bpy.types import Context, Operator

from ... import bake
from ...core.methods import BY_ID, DEFAULT_METHOD
from ...ids import Operators
from ...preferences import preferences
from ...properties import field, method_items
from ...session.actions import deformers
from ..arguments import row_index
from ..offered import OnDeformer, OnTarget
from ..reporting import reports_errors
from ..target import deformer_index, object_mode, target_of


class SINEW_OT_deformer_add(OnTarget, Operator):
    """Add a Sinew deformer to the mesh"""

    bl_idname = Operators.DEFORMER_ADD
    bl_label = "Add Deformer"
    bl_options: ClassVar[set[str]] = {"REGISTER", "UNDO", "INTERNAL"}  # tasks add deformers

    method: field(EnumProperty, items=method_items, default=BY_ID[DEFAULT_METHOD].number).named(
        "Method", "Set how the surface follows its handles; it can be changed later, and the handles stay"
    )

    def invoke(self, context: Context, _event: object) -> set[str]:
        if not self.properties.is_property_set("method"):
            self.method = preferences(context).method
        return self.execute(context)

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        deformers.add_deformer(target_of(context), self.method)
        return {"FINISHED"}


class SINEW_OT_deformer_remove(OnDeformer, Operator):
    """Remove the deformer, its controls and its hidden data. The mesh shows its rest shape again"""

    bl_idname = Operators.DEFORMER_REMOVE
    bl_label = "Remove Deformer"

    index: row_index("Choose which deformer; -1 is the active one")

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        index = deformer_index(obj, self.index)
        deformer = obj.sinew.deformers[index]
        with object_mode(context, obj):
            if deformer.bake.is_baked:
                for line in bake.unbake(obj, deformer):
                    self.tell({"WARNING"}, line)
            deformers.remove_deformer(obj, index)
        return {"FINISHED"}
