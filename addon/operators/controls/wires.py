# SPDX-License-Identifier: GPL-3.0-or-later
"""Add Wire: let curves, or edges of the mesh, carry what lies near them."""

from bpy.props import EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy.types import Context, Object, Operator

from ...core.errors import SinewError
from ...core.methods import DEFAULT_WIRE_METHOD
from ...ids import Operators
from ...session.actions.controls import control_list as rows, wires as edit_wires
from ...session.targets import targets
from ..arguments import once
from ..offered import OnTarget
from ..reporting import reports_errors
from ..target import object_mode, object_named, target_of
from ..waiting import BindingOperator
from .cage import show_only

RADIUS = {
    "name": "Radius",
    "subtype": "DISTANCE",
    "default": 0.0,
    "min": 0.0,
    "options": {"SKIP_SAVE"},
    "description": "Set how far from the wire points follow it; 0 for about a third of its length, and at "
    "most a seventh of the size of the part beside it",
}
POINTS = {
    "name": "Points",
    "default": 6,
    "min": 0,
    "soft_max": 32,
    "description": "Limit the points of the new curve for each row of edges, or for a stroke; 0 takes all "
    "of them",
}


class SINEW_OT_wire_add(OnTarget, BindingOperator, Operator):
    """Let curves move what lies near them: the selected curves, or a new one along the selected edges"""

    bl_idname = Operators.WIRE_ADD
    bl_label = "Add Wire"

    source: once(
        EnumProperty,
        items=(
            ("AUTO", "Automatic", "The selected edges in Edit Mode, else the selected curves", 0),
            ("CURVES", "Selected Curves", "The other selected curve objects become wires", 1),
            ("EDGES", "Selected Edges", "A new curve along the selected rows and rings of edges", 2),
        ),
        default="AUTO",
    ).named("Source", "Choose where the wires come from")
    curve: once(StringProperty).named(
        "Curve", "Give the name of a curve object; if empty, the other selected curves are used"
    )
    points: IntProperty(**POINTS)
    radius: FloatProperty(**RADIUS)

    @reports_errors
    def run(self, context: Context, wait: bool) -> set[str]:
        obj = target_of(context)
        from_edges = self.source == "EDGES" or (
            self.source == "AUTO" and obj.mode == "EDIT" and obj.type == "MESH" and not self.curve
        )
        if from_edges and not targets.is_mesh(obj):
            raise SinewError(f"{obj.name} has no edges - select a curve and then {obj.name}")
        wires = [edit_wires.wire_from_edges(obj, self.points)] if from_edges else self._chosen(context, obj)
        with object_mode(context, obj):
            add_wires(self, context, obj, wires, self.radius, owned=from_edges, wait=wait)
        return {"FINISHED"}

    def _chosen(self, context: Context, obj: Object) -> list[Object]:
        if self.curve:
            return [object_named(context, self.curve)]
        wires = [other for other in context.selected_objects if other != obj and other.type == "CURVE"]
        if not wires:
            raise SinewError("Select the curves and then the object that they move, which becomes active")
        return wires


def add_wires(
    operator: BindingOperator,
    context: Context,
    obj: Object,
    wires: list[Object],
    radius: float,
    owned: bool,
    wait: bool,
) -> None:
    """Let curves be wires of an object, select the last one, and report."""
    radii = {wire: radius or edit_wires.fitting_radius(obj, wire) for wire in wires}
    values = {wire: {"radius": own} if own > 0.0 else {} for wire, own in radii.items()}
    deformer, refusal = rows.add_to(obj, values, DEFAULT_WIRE_METHOD, owned, wait)
    if obj == target_of(context):
        show_only(context, obj, wires[-1])
    operator.report_bind(refusal, deformer.uid, wires[-1].name)
