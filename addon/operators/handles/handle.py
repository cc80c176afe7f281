# SPDX-License-Identifier: GPL-3.0-or-later
"""Add, remove and select handles."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty
from bpy.types import Context, Object, Operator

from ... import compat
from ...core.errors import SinewError
from ...ids import Operators
from ...preferences import preferences
from ...properties import HANDLE_ROLES, SinewDeformer, SinewHandle, field
from ...session.actions import bind, rigging, selection
from ...session.actions.handles import handles
from ...session.actions.handles.handles import NewRegion
from ...session.controls.handles import riding
from ..arguments import once, row_index
from ..offered import OnDeformer, OnTarget
from ..reporting import reports_errors
from ..target import handle_index, object_mode, object_named, show_control, target_of
from ..waiting import BindingOperator


class SINEW_OT_handle_add(OnTarget, BindingOperator, Operator):
    """Make the selected vertices a region; outside Edit Mode, those of the active vertex group.

    In Pose and Weight Paint Mode the active bone becomes its control, in other modes a new empty
    """

    bl_idname = Operators.HANDLE_ADD
    bl_label = "Make Handle"
    MESHES_ONLY = True

    kind: field(EnumProperty, items=HANDLE_ROLES, default="HANDLE").named(
        "Role", "Say whether the region follows a control, holds still, or is all that may move"
    )
    vertex_group: field(StringProperty).named(
        "Vertex Group",
        "Choose a vertex group; if empty, the selected vertices in Edit Mode, else the active group",
    )
    handle_name: once(StringProperty).named(
        "Name", "Give the name of the region; if empty, the name of its vertex group"
    )
    weight: once(FloatProperty, default=1.0, min=0.0, max=1.0, subtype="FACTOR").named(
        "Weight", "Let the region give way by a weight below 1"
    )
    control: once(
        EnumProperty,
        items=(
            ("AUTO", "Automatic", "The active bone in Pose and Weight Paint Mode, else a new empty", 2),
            ("NEW", "New Empty", "An empty at the region, aligned with its mean normal", 0),
            (
                "SELECTED",
                "Selected Object or Bone",
                "The other selected object; if it is an armature, its active bone",
                1,
            ),
        ),
        default="AUTO",
    ).named("Control", "Choose what will move the region, for a handle")
    control_object: once(StringProperty).named(
        "Control Object", "Give the name of the object that will move the region"
    )
    bone: once(StringProperty).named("Bone", "Give the name of a pose bone, if the control is an armature")

    @reports_errors
    def run(self, context: Context, wait: bool) -> set[str]:
        obj = target_of(context)
        mode = context.mode
        control, bone = self._chosen_control(context, obj)
        group = self.vertex_group or _default_group(obj, bone)
        owns_group = not group
        if not group:
            if obj.mode != "EDIT":
                raise SinewError("Choose a vertex group, or select vertices in Edit Mode")
            group = selection.group_from_selection(obj, self.kind, self.handle_name)
        with object_mode(context, obj):
            handle, refusal = rigging.rig_region(
                obj,
                NewRegion(self.kind, group, control, bone, owns_group, self.handle_name, self.weight),
                preferences(context).method,
                from_rest=False if self.control_object else None,
                wait=wait,
            )
            context.view_layer.update()  # the new empty enters the view layer, and the shape is solved
            if handle.kind == "HANDLE" and mode not in ("POSE", "PAINT_WEIGHT"):
                self._show_control(context, obj, handle)
        more = f" - {riding.standing(handle)}" if handle.stands_on == "SURFACE" else ""
        self.report_bind(refusal, obj.sinew.active.uid, handle.name, more)
        return {"FINISHED"}

    def _show_control(self, context: Context, obj: Object, handle: SinewHandle) -> None:
        """Select the control. The region is kept even if its control cannot be selected."""
        try:
            select_control(context, obj, handle)
        except SinewError as error:
            self.tell({"WARNING"}, str(error))

    def _chosen_control(self, context: Context, obj: Object) -> tuple[Object | None, str]:
        if self.kind != "HANDLE":
            return None, ""
        if self.control_object:
            return object_named(context, self.control_object), self.bone
        if self.control == "AUTO":
            return _active_bone(obj, context.object)
        if self.control == "NEW":
            return None, ""
        others = [other for other in context.selected_objects if other != obj]
        if len(others) != 1:
            raise SinewError("Select the mesh and one other object, which becomes the control")
        control = others[0]
        active = control.data.bones.active if control.type == "ARMATURE" else None
        return control, active.name if active else ""


class SINEW_OT_keep_inside(OnDeformer, BindingOperator, Operator):
    """Make the loose parts that lie inside, such as eyes and teeth, a region, so that they leave the surface.

    In Pose Mode the active bone becomes its control. Otherwise it is fixed: it stays at rest, or where an
    Armature modifier puts it
    """

    bl_idname = Operators.KEEP_INSIDE
    bl_label = "Keep Inside Parts"
    MESHES_ONLY = True

    @reports_errors
    def run(self, context: Context, wait: bool) -> set[str]:
        obj = target_of(context)
        vertices = selection.parts_inside(obj.sinew.active)
        if not len(vertices):
            self.tell({"INFO"}, "No loose part that follows the surface lies inside")
            return {"CANCELLED"}
        control, bone = _active_bone(obj, context.object)
        with object_mode(context, obj):
            group = selection.group_of(obj, "Inside", vertices)
            region = NewRegion("HANDLE" if bone else "FIXED", group, control, bone, owns_group=True)
            handle, refusal = rigging.rig_region(obj, region, wait=wait)
            context.view_layer.update()
        self.report_bind(refusal, obj.sinew.active.uid, handle.name)
        return {"FINISHED"}


class SINEW_OT_handle_remove(OnDeformer, Operator):
    """Remove the region, and the control and the vertex group that were made for it"""

    bl_idname = Operators.HANDLE_REMOVE
    bl_label = "Remove Handle"

    index: row_index("Choose which handle; -1 is the active one")

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        index = handle_index(deformer, self.index)
        try:
            with object_mode(context, obj):
                handles.remove_handle(obj, deformer, index)
                if deformer.handles:
                    bind.bind(obj, deformer)
        except SinewError as error:  # the region is removed all the same
            self.tell({"WARNING"}, str(error))
        return {"FINISHED"}


class SINEW_OT_select_handle(OnDeformer, Operator):
    """Select the control of the region; in Edit Mode its vertices, in Weight Paint Mode its vertex group.

    A control that is a bone is selected in Pose Mode
    """

    bl_idname = Operators.SELECT_HANDLE
    bl_label = "Select Handle"

    index: row_index("Choose which handle; -1 is the active one")
    extend: once(BoolProperty).named("Extend", "Add to the selection")

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        deformer.active_handle = handle_index(deformer, self.index)
        choose_handle(context, obj, deformer, self.extend)
        return {"FINISHED"}


def choose_handle(context: Context, obj: Object, deformer: SinewDeformer, extend: bool = False) -> None:
    """Select what belongs to the active handle in this mode: its control, its vertices, or its group."""
    handle = deformer.handles[handle_index(deformer, -1)]
    if obj.mode not in {"EDIT", "WEIGHT_PAINT"}:
        select_control(context, obj, handle, extend)
        if handle.bone and handle.control.mode == "OBJECT" and bpy.ops.object.mode_set.poll():
            bpy.ops.object.mode_set(mode="POSE")
    if obj.vertex_groups.get(handle.vertex_group):
        obj.vertex_groups.active = obj.vertex_groups[handle.vertex_group]
    if obj.mode == "EDIT":
        _select_vertices(obj, handle, extend)


def _default_group(obj: Object, bone: str) -> str:
    """The vertex group to use outside Edit Mode: the one named like the bone, else the active one.

    A vertex group can be used once per deformer.
    """
    if obj.mode == "EDIT":
        return ""
    active = obj.vertex_groups.active
    group = bone if bone in obj.vertex_groups else active.name if active else ""
    deformer = obj.sinew.active
    used = {handle.vertex_group for handle in deformer.handles} if deformer else set()
    if group in used:
        raise SinewError(f"'{group}' is a region of this deformer already - choose another vertex group")
    return group


def _active_bone(obj: Object, active: Object) -> tuple[Object | None, str]:
    """The armature in Pose Mode and its active bone, if it is selected. While painting, that of the mesh."""
    if active.type == "ARMATURE":
        armatures = [active]
    elif obj.mode == "WEIGHT_PAINT":
        armatures = [modifier.object for modifier in obj.modifiers if modifier.type == "ARMATURE"]
    else:
        armatures = []
    for armature in armatures:
        bone = armature.data.bones.active if armature and armature.mode == "POSE" else None
        if bone is not None and compat.is_bone_selected(armature, bone.name):
            return armature, bone.name
    return None, ""


def _select_vertices(obj: Object, handle: SinewHandle, extend: bool) -> None:
    if extend and handle.vertex_group in obj.vertex_groups:
        bpy.ops.object.vertex_group_select()
    else:
        selection.select_group(obj, handle.vertex_group)


def select_control(context: Context, obj: Object, handle: SinewHandle, extend: bool = False) -> None:
    """Select the control and make it active, so that G, R, S and typed numbers move it.

    The panel still shows the mesh that it moves.
    """
    control = handle.control
    if control is None or control.name not in context.view_layer.objects:
        raise SinewError(
            f"{handle.name} has no control in this view layer - choose one in its panel, below the list"
        )
    if handle.control_missing:
        raise SinewError(
            f"{control.name} has no bone '{handle.bone}' - choose the control of {handle.name} again"
        )
    for other in () if extend else context.selected_objects:
        other.select_set(False)
    control.select_set(True)
    if handle.bone:
        for other in () if extend else control.pose.bones:
            compat.select_bone(control, other.name, False)
        compat.select_bone(control, handle.bone)
        control.data.bones.active = control.data.bones[handle.bone]
    show_control(context, obj, control)
