# SPDX-License-Identifier: GPL-3.0-or-later
"""Add, remove and select handles."""

from bpy.props import EnumProperty, IntProperty, StringProperty
from bpy.types import Context, Object, Operator

from .. import session
from ..core.errors import SinewError
from ..ids import Operators
from ..preferences import preferences
from ..properties import HANDLE_KINDS, SinewDeformer, SinewHandle
from .target import handle_index, has_deformer, has_target, object_mode, target_of
from .waiting import WaitsForBind

_LABELS = {identifier: label for identifier, label, *_rest in HANDLE_KINDS}


class SINEW_OT_handle_add(WaitsForBind, Operator):
    """Make a region of the selected vertices, or of a vertex group"""

    bl_idname = Operators.HANDLE_ADD
    bl_label = "Add Handle"
    bl_options = {"REGISTER", "UNDO"}

    kind: EnumProperty(name="Kind", items=HANDLE_KINDS, default="HANDLE")
    vertex_group: StringProperty(
        name="Vertex Group", description="An existing group; empty takes the selection in Edit Mode"
    )
    control: EnumProperty(
        name="Control",
        items=(
            ("NEW", "New Empty", "An empty at the region, aligned with its mean normal", 0),
            (
                "SELECTED",
                "Selected Object or Bone",
                "The other selected object, its active bone if it is an armature",
                1,
            ),
        ),
        options={"SKIP_SAVE"},
    )
    control_object: StringProperty(
        name="Control Object", description="An object by name", options={"SKIP_SAVE"}
    )
    bone: StringProperty(name="Bone", description="A pose bone of the control object", options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context: Context) -> bool:
        return has_target(cls, context)

    def invoke(self, context: Context, _event: object) -> set[str]:
        result = self._run(context, wait=False)
        deformer = target_of(context).sinew.active
        return result if deformer is None else self.wait_for(context, deformer.uid, result)

    def execute(self, context: Context) -> set[str]:
        return self._run(context, wait=True)

    def _run(self, context: Context, wait: bool) -> set[str]:
        obj = target_of(context)
        was_editing = obj.mode == "EDIT"
        try:
            control, bone = self._chosen_control(context, obj)
            group = self.vertex_group
            if not group:
                if not was_editing:
                    raise SinewError("Name a vertex group, or select vertices in Edit Mode")
                group = session.group_from_selection(obj, _LABELS[self.kind])
            with object_mode(context, obj):
                deformer = obj.sinew.active or session.add_deformer(obj, preferences(context).method)
                handle = session.add_handle(
                    obj, deformer, self.kind, group, control, bone, owns_group=not self.vertex_group
                )
                bound = self._bind(obj, deformer, wait)
                if handle.kind == "HANDLE":
                    context.view_layer.update()  # the new empty enters the view layer
                    _select_only(context, obj, handle)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if bound:
            self.report({"INFO"}, f"{handle.name}: {deformer.status}")
        return {"FINISHED"}

    def _bind(self, obj: Object, deformer: SinewDeformer, wait: bool) -> bool:
        """The region is kept when the bind is refused; the panel then says what to do."""
        try:
            session.bind(obj, deformer, wait)
        except SinewError as error:
            self.report({"WARNING"}, str(error))
            return False
        return True

    def _chosen_control(self, context: Context, obj: Object) -> tuple[Object | None, str]:
        if self.kind != "HANDLE":
            return None, ""
        if self.control_object:
            control = context.scene.objects.get(self.control_object)
            if control is None:
                raise SinewError(f"There is no object '{self.control_object}' in the scene")
            return control, self.bone
        if self.control == "NEW":
            return None, ""
        others = [other for other in context.selected_objects if other != obj]
        if len(others) != 1:
            raise SinewError("Select the mesh and one other object, which becomes the control")
        control = others[0]
        active = control.data.bones.active if control.type == "ARMATURE" else None
        return control, active.name if active else ""


class SINEW_OT_handle_remove(Operator):
    """Remove the region, with the control and the vertex group that were made for it"""

    bl_idname = Operators.HANDLE_REMOVE
    bl_label = "Remove Handle"
    bl_options = {"REGISTER", "UNDO"}

    index: IntProperty(name="Index", default=-1, min=-1, description="Which handle; -1 is the active one")

    @classmethod
    def poll(cls, context: Context) -> bool:
        return has_deformer(cls, context)

    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        try:
            index = handle_index(deformer, self.index)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        try:
            with object_mode(context, obj):
                session.remove_handle(obj, deformer, index)
                if deformer.handles:
                    session.bind(obj, deformer)
        except SinewError as error:  # the region is gone; the panel says what the rest needs
            self.report({"WARNING"}, str(error))
        return {"FINISHED"}


class SINEW_OT_select_handle(Operator):
    """Select the control in Object Mode, or the vertices of the region in Edit Mode"""

    bl_idname = Operators.SELECT_HANDLE
    bl_label = "Select Handle"
    bl_options = {"REGISTER", "UNDO"}

    index: IntProperty(name="Index", default=-1, min=-1, description="Which handle; -1 is the active one")

    @classmethod
    def poll(cls, context: Context) -> bool:
        return has_deformer(cls, context)

    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        try:
            handle = deformer.handles[handle_index(deformer, self.index)]
            if obj.mode == "EDIT":
                session.select_group(obj, handle.vertex_group)
            else:
                _select_only(context, obj, handle)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


def _select_only(context: Context, obj: Object, handle: SinewHandle) -> None:
    """The control alone is selected, so G, R and S move it; the mesh stays active, and so does its panel."""
    control = handle.control
    if control is None or control.name not in context.view_layer.objects:
        raise SinewError(f"{handle.name} has no control to select here")
    for other in context.selected_objects:
        other.select_set(False)
    control.select_set(True)
    if handle.bone:
        control.data.bones.active = control.data.bones[handle.bone]
    context.view_layer.objects.active = control if control.type == "ARMATURE" else obj
