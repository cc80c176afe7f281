# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the current shape permanent."""

from bpy.types import Context, Operator

from .. import session
from ..core.errors import SinewError
from ..ids import Operators
from .target import deformer_index, has_deformer, object_mode, target_of


class SINEW_OT_apply(Operator):
    """Make the shape of now the shape of the mesh, and remove the deformer"""

    bl_idname = Operators.APPLY
    bl_label = "Apply"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return has_deformer(cls, context)

    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        try:
            with object_mode(context, obj):
                session.apply(obj, deformer_index(obj, -1))
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}
