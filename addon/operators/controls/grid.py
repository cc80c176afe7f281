# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the control grid of a deformer an object, so that its points can be dragged."""

from bpy.types import Context, Operator

from ...ids import Operators
from ...session.actions.controls import grids
from ..offered import OnDeformer
from ..reporting import reports_errors
from ..target import object_mode, show_control, target_of


class SINEW_OT_grid_new(OnDeformer, Operator):
    """Make a mesh of the control grid whose points you can drag in Edit Mode, or key and hook as any others.

    If there is one already, it starts anew, and moves nothing at first
    """

    bl_idname = Operators.GRID_NEW
    bl_label = "New Grid"
    MESHES_ONLY = True

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or (
            ""
            if grids.has_grid(target_of(context).sinew.active)
            else f"Choose {grids.with_grids()}: other methods have no control grid"
        )

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        with object_mode(context, obj):
            grid = grids.new_grid(obj, obj.sinew.active)
            for other in context.selected_objects:
                other.select_set(False)
            if grid.name in context.view_layer.objects:
                grid.select_set(True)
                show_control(context, obj, grid)
        return {"FINISHED"}
