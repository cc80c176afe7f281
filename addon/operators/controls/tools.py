# SPDX-License-Identifier: GPL-3.0-or-later
"""Add Tool, and the stops on the path of a tool."""

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatVectorProperty, StringProperty
from bpy.types import Context, Object, Operator
from mathutils import Vector

from ...core.methods import BY_ID, DEFAULT_TOOL_METHOD
from ...ids import Operators
from ...properties import field
from ...session.actions.controls import control_list as rows
from ...session.datablocks.parts import ShownParts
from ..arguments import distance, once
from ..handles.rows import OnRows
from ..offered import OnTarget
from ..reporting import reports_errors
from ..target import object_mode, object_named, target_of
from ..waiting import BindingOperator
from .cage import show_only

(_TOOL,) = (row for row in BY_ID[DEFAULT_TOOL_METHOD].control_parameters if row.id == "tools")


class SINEW_OT_tool_add(OnTarget, BindingOperator, Operator):
    """Add an empty that drags, twists or bends what is around it, and keeps volumes"""

    bl_idname = Operators.TOOL_ADD
    bl_label = "Add Tool"

    tool: field(EnumProperty, items=_TOOL.items, default="drag").named("Tool", _TOOL.description)
    control: once(StringProperty).named(
        "Control", "Give the name of an object to use as the tool; if empty, a new empty is made"
    )
    location: once(FloatVectorProperty, subtype="XYZ").named(
        "Location",
        "Place the new tool in the world; else a drag is at the 3D cursor, and the others in the middle of "
        "the object",
    )
    outer: distance(
        "Outer",
        "Set how far the tool reaches; 0 for a third of the size of the object, or for a Drag of the part "
        "beside it",
        options={"SKIP_SAVE"},
    )

    @reports_errors
    def run(self, context: Context, wait: bool) -> set[str]:
        obj = target_of(context)
        with object_mode(context, obj):
            control, place = self._chosen(context), self._place(context, obj)
            outer = self.outer or rows.tool_reach(self._size(obj, place))
            if control is None:
                label = next(item[1] for item in _TOOL.items if item[0] == self.tool)
                control = rows.new_tool(obj, place, np.array((0.0, 0.0, 1.0)), outer, label)
            widths = sorted(obj.dimensions)
            values = {
                "tools": self.tool,
                "outer": outer,
                "inner": outer / 4.0 if self.tool == "drag" else -outer,
                "width": 0.75 * widths[1] or outer,
            }
            deformer, refusal = rows.add_to(
                obj, {control: values}, DEFAULT_TOOL_METHOD, owned=not self.control, wait=wait
            )
            if obj == target_of(context):
                show_only(context, obj, control)
        self.report_bind(refusal, deformer.uid, control.name)
        return {"FINISHED"}

    def _chosen(self, context: Context) -> Object | None:
        """The object that is to be the tool; None if a new one is to be made."""
        if not self.control:
            return None
        return object_named(context, self.control)

    def _place(self, context: Context, obj: Object) -> np.ndarray:
        """Where the tool is, (3,) in the world."""
        control = self._chosen(context)
        if control is not None:
            return np.array(control.matrix_world.translation)
        if self.properties.is_property_set("location"):
            return np.array(self.location)
        if self.tool == "drag":
            return np.array(context.scene.cursor.location)
        box = np.array([obj.matrix_world @ Vector(corner) for corner in obj.bound_box])
        return 0.5 * (box.min(axis=0) + box.max(axis=0))

    def _size(self, obj: Object, place: np.ndarray) -> float:
        """Of what the tool moves: a Drag takes the part beside it, the others the whole object."""
        if self.tool != "drag":
            return max(obj.dimensions) or 1.0
        return ShownParts(obj, bpy.context.evaluated_depsgraph_get()).size_at(place)


class SINEW_OT_tool_stop(OnRows, BindingOperator, Operator):
    """Add a way point to the path of the active tool at its current place, or remove all of them"""

    bl_idname = Operators.TOOL_STOP
    bl_label = "Add Stop"

    clear: once(BoolProperty).named(
        "Straight", "Remove all stops, so that the tool goes straight from rest to where it is"
    )

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or (
            "" if target_of(context).sinew.active.method == DEFAULT_TOOL_METHOD else "Only tools have a path"
        )

    @reports_errors
    def run(self, context: Context, wait: bool) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        row = rows.active_row(deformer)
        if self.clear:
            rows.forget_stops(obj, row)
        else:
            rows.stop_here(obj, deformer, row)
        context.view_layer.update()
        self.tell({"INFO"}, f"{row.name} has {rows.stop_count(row)} stops on its path")
        return {"FINISHED"}
