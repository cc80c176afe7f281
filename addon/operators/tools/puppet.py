# SPDX-License-Identifier: GPL-3.0-or-later
"""Sinew Drag: Bones: drag a bone of an armature, and the figure follows. Pins, and the handles of bones."""

import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty
from bpy.types import Context, Event, Object, Operator

from ... import compat
from ...core.errors import SinewError
from ...core.methods import DEFAULT_PUPPET_METHOD
from ...ids import Operators
from ...properties import BALANCE, field
from ...session.actions.puppet import bones, rigging
from ...session.actions.puppet.posing import Part, PuppetDrag, PuppetOptions
from ..arguments import REGION_METHODS, given, method_choice, once
from ..modal.motion_properties import MotionValues
from ..modal.view import axes_of, length_text, view_of
from ..offered import Offered
from ..reporting import reports_errors
from ..target import object_mode, object_named, show_control, target_of
from ..waiting import BindingOperator
from .dragging import Drags
from .puppeteering import Puppeteering

_PARTS = (
    ("AUTO", "Automatic", "The tail, or the whole bone if it has no parent", "NONE", 0),
    ("TAIL", "Tail", "The tail of the bone", "NONE", 1),
    ("HEAD", "Head", "The head of the bone", "NONE", 2),
    ("WHOLE", "Whole Bone", "Head, tail and roll, so that the bone turns only if you turn it", "NONE", 3),
)
_BEHIND = 1e-2  # a gap of this share of the motion is worth a word


class SINEW_OT_puppet_pose(Offered, MotionValues, Drags, Operator):
    """Drag the active bone, and let the figure follow: joints keep their limits, pinned bones stay"""

    bl_idname = Operators.PUPPET_POSE
    bl_label = "Sinew Drag: Bones"
    bl_options = {"REGISTER", "UNDO", "GRAB_CURSOR", "BLOCKING", "INTERNAL"}  # buttons start the tool

    armature: given(StringProperty).named(
        "Armature", "Give the name of the armature; if empty, the active one"
    )
    bone: once(StringProperty).named("Bone", "Give the name of the bone to drag; if empty, the active one")
    part: once(EnumProperty, items=_PARTS, default="AUTO").named("Part", "Choose the point that is dragged")
    balance: BoolProperty(**BALANCE)
    from_rest: once(BoolProperty).named(
        "From Rest", "Let joints stay close to their rest, instead of how they are now"
    )
    click_pins: given(BoolProperty).named(
        "Click Pins", "Pin the bone, or release it, if the mouse does not move"
    )
    key: once(BoolProperty).named("Insert Keyframes", "Key the bones that follow, as Auto Keying does")

    @classmethod
    def refusal(cls, context: Context) -> str:
        if context.object is not None and context.object.type == "ARMATURE":
            return ""
        return "Select an armature, and the bone to drag in Pose Mode"

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        armature, drag = self._begin(context)
        try:
            drag.move(armature, self.motion.matrix(axes_of(drag.frame), drag.place))
        except SinewError:
            drag.restore(armature)
            raise
        self._finish(context, armature, drag)
        return {"FINISHED"}

    def start(self, context: Context, event: Event) -> set[str]:
        armature, drag = self._begin(context)
        view = view_of(context, drag.place)
        axes = axes_of(drag.frame)
        tool = Puppeteering(drag, self.typed_motion(context, event, view, axes), drag.place, axes)
        return self.begin(context, tool, armature, _draw_nothing)

    def store_result(self, context: Context) -> None:
        self.store_motion(self.tool.typed.motion)
        armature = self.worked_on(context)
        if self.click_pins and np.allclose(self.tool.matrix, np.eye(4), atol=0.0):
            bone = armature.pose.bones[self.bone]
            bone.sinew.pin = not bone.sinew.pin
            self.tell({"INFO"}, f"{self.bone} {'pinned' if bone.sinew.pin else 'released'}")
            return
        self._finish(context, armature, self.tool.drag)

    def draw(self, _context: Context) -> None:
        self.draw_motion()
        for name in ("bone", "part", "balance", "from_rest", "key"):
            self.layout.prop(self, name)

    def _begin(self, context: Context) -> tuple[Object, PuppetDrag]:
        armature = context.object
        if self.armature:
            armature = object_named(context, self.armature)
        bones.require_bones(armature)
        if not self.bone:
            active = armature.data.bones.active
            if active is None:
                raise SinewError("Select the bone to drag in Pose Mode")
            self.bone = active.name
        options = PuppetOptions(Part(self.part), self.balance, self.from_rest)
        drag = PuppetDrag(armature, self.bone, context.evaluated_depsgraph_get(), options)
        if drag.ignored:
            self.tell({"WARNING"}, f"Constraints of {drag.ignored[0]} move it further - mute them to drag it")
        return armature, drag

    def _finish(self, context: Context, armature: Object, drag: PuppetDrag) -> None:
        context.view_layer.update()
        if self.key or context.scene.tool_settings.use_keyframe_insert_auto:
            drag.key(armature)
        length = np.linalg.norm(self.value)
        if drag.overhang > 0.0:
            self.tell({"WARNING"}, "The centre of mass cannot reach what is pinned")
        elif drag.gap > _BEHIND * max(length, 1e-9):
            text = length_text(context.scene.unit_settings, drag.gap)
            self.tell({"INFO"}, f"{drag.name} is {text} behind: its joints, pinned bones or posture hold it")


class SINEW_OT_puppet_pin(Offered, Operator):
    """Pin the selected bones, or release them: pinned ones stay while another bone is dragged"""

    bl_idname = Operators.PUPPET_PIN
    bl_label = "Pin"

    action: once(
        EnumProperty,
        items=(
            ("TOGGLE", "Toggle", "Pin the bones, or release them if all are pinned", "NONE", 0),
            ("PIN", "Pin", "Pin the bones", "NONE", 1),
            ("RELEASE", "Release", "Release the bones", "NONE", 2),
        ),
        default="TOGGLE",
    ).named("Action", "Choose what to do with the selected bones")

    @classmethod
    def refusal(cls, context: Context) -> str:
        return "" if context.mode == "POSE" else "Select bones in Pose Mode"

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        armature = bones.require_bones(context.object)
        chosen = [bone for bone in armature.pose.bones if compat.is_bone_selected(armature, bone.name)]
        if not chosen:
            raise SinewError("Select the bones to pin")
        pin = self.action == "PIN" or (self.action == "TOGGLE" and not all(bone.sinew.pin for bone in chosen))
        for bone in chosen:
            bone.sinew.pin = pin
        armature.update_tag()  # a step of Try It waits for it
        self.tell({"INFO"}, f"{len(chosen)} bone{'s' * (len(chosen) > 1)} {'pinned' if pin else 'released'}")
        return {"FINISHED"}


class SINEW_OT_puppet_rig(Offered, BindingOperator, Operator):
    """Let the bones of an armature move the mesh: each holds the vertex group of its name, or its limb"""

    bl_idname = Operators.PUPPET_RIG
    bl_label = "Skin by Bones"

    armature: once(StringProperty).named(
        "Armature", "Give the name of the armature; if empty, the other selected object"
    )
    method: method_choice(
        REGION_METHODS,
        "Choose how the mesh follows",
        default=DEFAULT_PUPPET_METHOD,
        options={"SKIP_SAVE"},
    )
    automatic: once(BoolProperty).named(
        "Automatic Regions",
        "Make new vertex groups by distance, even if there are groups with the names of bones",
    )
    margin: field(FloatProperty, default=0.25, min=0.0, max=0.45, subtype="FACTOR").named(
        "Margin", "Set how much of a bone's length is left free at each joint, by automatic regions"
    )

    @classmethod
    def refusal(cls, context: Context) -> str:
        objects = (context.object, *context.selected_objects)
        has_mesh = any(obj.type == "MESH" for obj in objects if obj)
        return "" if has_mesh else "Select a mesh and its armature"

    @reports_errors
    def run(self, context: Context, wait: bool) -> set[str]:
        obj = _mesh_to_rig(context)
        others = [other for other in context.selected_objects if other.type == "ARMATURE"]
        if self.armature:
            others = [other for other in context.scene.objects if other.name == self.armature]
            if not others:
                raise SinewError(f"There is no object '{self.armature}' in the scene")
        if len(others) != 1 or obj is None:
            raise SinewError("Select the mesh and one armature")
        with object_mode(context, obj):
            deformer, left_out, refusal = rigging.rig_puppet(
                obj, others[0], self.method, self.margin, self.automatic, wait
            )
        if obj != context.object:
            show_control(context, obj, others[0])  # it stays active, and the panel shows this mesh
        context.view_layer.update()
        count = len(deformer.handles)
        subject = "1 bone" if count == 1 else f"{count} bones"
        if left_out:
            subject += f", without {left_out} whose vertex group{' is' if left_out == 1 else 's are'} empty"
        self.report_bind(refusal, deformer.uid, subject)
        return {"FINISHED"}


def _mesh_to_rig(context: Context) -> Object | None:
    """The mesh that is selected together with an armature, whichever of them is active."""
    if context.object is not None and context.object.type == "MESH":
        return context.object
    meshes = [other for other in context.selected_objects if other.type == "MESH"]
    return meshes[0] if len(meshes) == 1 else target_of(context)


def _draw_nothing() -> None:
    """The bones themselves show what moves."""
