# SPDX-License-Identifier: GPL-3.0-or-later
"""Give new controls to handles that have lost theirs, and edit the points of a cage or a lattice."""

import bpy
from bpy.types import Context, Object, Operator

from ...core.errors import SinewError
from ...ids import Operators
from ...session.actions.handles import handles
from ..arguments import row_index
from ..controls.cage import show_only
from ..offered import OnDeformer, OnLiveDeformer
from ..reporting import reports_errors
from ..target import handle_index, object_mode, target_of
from .handle import select_control


class SINEW_OT_control_new(OnDeformer, Operator):
    """Make a new empty for a handle that has lost its control, where its region is now"""

    bl_idname = Operators.CONTROL_NEW
    bl_label = "New Control"

    index: row_index("Choose the handle; -1 is every one that has lost its control", options={"SKIP_SAVE"})

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or (
            ""
            if any(handle.control_missing for handle in target_of(context).sinew.active.handles)
            else "Every handle has its control"
        )

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        wanted = range(len(deformer.handles)) if self.index < 0 else [handle_index(deformer, self.index)]
        lost = [index for index in wanted if deformer.handles[index].control_missing]
        with object_mode(context, obj):
            for index in lost:
                handles.new_control(obj, deformer, deformer.handles[index])
            context.view_layer.update()  # the new empties enter the view layer
            for index in lost:
                select_control(context, obj, deformer.handles[index], extend=index != lost[0])
        return {"FINISHED"}


class SINEW_OT_control_edit(OnLiveDeformer, Operator):
    """Pose the cage or the lattice by its points, in Edit Mode"""

    bl_idname = Operators.CONTROL_EDIT
    bl_label = "Pose the Control"

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or ("" if _edited(context) else "Add a cage or a lattice first")

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj, control = target_of(context), _edited(context)
        if context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        if control.name not in context.view_layer.objects or control.library is not None:
            raise SinewError(f"{control.name} cannot be edited in this view layer")
        show_only(context, obj, control)
        context.view_layer.objects.active = control
        bpy.ops.object.mode_set(mode="EDIT")
        return {"FINISHED"}


def _edited(context: Context) -> Object | None:
    """The control whose points pose the active deformer; None if there is none."""
    deformer = target_of(context).sinew.active
    rows = [row for row in deformer.all_controls if row.kind == deformer.definition.control.name.lower()]
    return next((row.object for row in rows if row.object is not None and not row.missing), None)
