# SPDX-License-Identifier: GPL-3.0-or-later
"""A correction that is there as far as a bone is bent."""

import math

import bpy
from bpy.props import FloatProperty, StringProperty
from bpy.types import Context, Event, Object, Operator

from ...core.errors import SinewError
from ...ids import Operators
from ...session.actions import driving
from ...session.datablocks.movers import armatures_of
from ...session.targets import targets
from ..arguments import once
from ..offered import OnDeformer
from ..reporting import reports_errors
from ..target import target_of


class SINEW_OT_drive_by_bone(OnDeformer, Operator):
    """Let Factor follow how far a bone is bent: 0 while it is at rest, 1 where it is bent as now"""

    bl_idname = Operators.DRIVE
    bl_label = "Drive by Bone..."

    armature: once(StringProperty).named(
        "Armature", "Choose the armature; if empty, the bent bone nearest to the handle counts"
    )
    bone: once(StringProperty).named("Bone", "Choose the bone that bends, such as the lower arm")
    angle: once(FloatProperty, subtype="ANGLE", min=0.0, max=math.pi).named(
        "Full At", "Set the bend at which Factor is 1; 0 takes the present one"
    )

    @classmethod
    def refusal(cls, context: Context) -> str:
        reason, obj = super().refusal(context), target_of(context)
        if reason:
            return reason
        if obj.override_library is not None:
            return "Blender does not save new drivers of a library override - key Factor instead"
        if not armatures_of(obj):
            return f"No armature moves {obj.name} - give it an Armature modifier first"
        return ""

    def invoke(self, context: Context, _event: Event) -> set[str]:
        return self._ask(context)

    @reports_errors
    def _ask(self, context: Context) -> set[str]:
        armature, self.bone = self._chosen(context)
        self.armature = armature.name
        self.angle = driving.bend_of(armature, self.bone)
        return context.window_manager.invoke_props_dialog(self)

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.prop_search(self, "armature", bpy.data, "objects")
        armature = self._named(context)
        if armature is not None:
            layout.prop_search(self, "bone", armature.data, "bones")
        layout.prop(self, "angle")

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        armature, self.bone = self._chosen(context)
        self.armature = armature.name
        deformer = target_of(context).sinew.active
        self.angle = driving.drive(deformer, armature, self.bone, self.angle)
        self.tell(
            {"INFO"},
            f"Factor is 1 where {self.bone} is bent by {math.degrees(self.angle):.0f} degrees or more",
        )
        return {"FINISHED"}

    def _chosen(self, context: Context) -> tuple[Object, str]:
        """The armature and the bone that are given, or those found."""
        if not self.armature:
            obj = target_of(context)
            found = driving.bent_bone(obj, obj.sinew.active)
            if found is None:
                raise SinewError(f"No bone of {armatures_of(obj)[0].name} is bent now - go to another frame")
            return found
        armature = self._named(context)
        if armature is None:
            raise SinewError(f"There is no armature {self.armature} - choose another one")
        return armature, self.bone

    def _named(self, context: Context) -> Object | None:
        """The armature of this name, first of those that move the object: linked and own may share it."""
        objects = (*armatures_of(target_of(context)), *bpy.data.objects)
        return next((obj for obj in objects if obj.name == self.armature and targets.has_bones(obj)), None)
