# SPDX-License-Identifier: GPL-3.0-or-later
"""Select the vertex where the surface is distorted most."""

import bpy
from bpy.props import EnumProperty
from bpy.types import Context, Operator

from ...core.elements import Elements, Owner
from ...core.geometry.distortion import Measure
from ...ids import Operators
from ...properties import field
from ...properties.scene import MEASURES
from ...session.actions import selection
from ...session.results import result
from ..offered import OnDeformer
from ..target import target_of


class SINEW_OT_select_distorted(OnDeformer, Operator):
    """Select, in Edit Mode, the vertex around which the surface is distorted most.

    To reduce the distortion, add a handle there, or let more of the surface move
    """

    bl_idname = Operators.SELECT_DISTORTED
    bl_label = "Select Most Distorted"
    MESHES_ONLY = True

    measure: field(EnumProperty, items=MEASURES).named("Measure", "Choose the measure of distortion")

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or (
            "" if target_of(context).sinew.active.is_bound else "Bind the deformer first"
        )

    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        result.repainted(deformer)
        found = result.measure(obj, deformer, Measure(self.measure))
        if found is None:
            self.tell({"ERROR"}, "There is no shape to measure - press Rebind")
            return {"CANCELLED"}
        if len(obj.data.vertices) != len(found.values):
            self.tell(
                {"ERROR"},
                "A modifier before Sinew adds or removes vertices, so the mesh itself has no such vertex "
                "to select",
            )
            return {"CANCELLED"}
        if obj.mode != "EDIT":
            context.view_layer.objects.active = obj
            bpy.ops.object.mode_set(mode="EDIT")
        selection.select_elements(obj, Elements(Owner.TARGET, "vertex", (found.worst,)))
        label = next(label for identifier, label, *_rest in MEASURES if identifier == self.measure)
        self.tell({"INFO"}, f"{label} {found.largest:.3g} at vertex {found.worst}")
        return {"FINISHED"}
