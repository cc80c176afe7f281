# SPDX-License-Identifier: GPL-3.0-or-later
"""Add a cage, and let it rest as it is."""

from bpy.props import EnumProperty, StringProperty
from bpy.types import Context, Event, Object, Operator

from .. import session
from ..core.errors import SinewError
from ..core.methods import DEFAULT_CAGE_METHOD, METHODS, Control
from ..ids import Operators
from ..properties import SinewDeformer
from .target import has_deformer, has_target, object_mode, target_of
from .waiting import WaitsForBind

_METHODS = tuple(method for method in METHODS if method.control is Control.CAGE)


class SINEW_OT_cage_add(WaitsForBind, Operator):
    """Let a closed mesh around this one move it: edit, pose or animate it like any other mesh"""

    bl_idname = Operators.CAGE_ADD
    bl_label = "Add Cage"
    bl_options = {"REGISTER", "UNDO"}

    source: EnumProperty(
        name="Source",
        items=(("OBJECT", "Selected Object", "The other selected mesh becomes the cage", 1),),
        default="OBJECT",
        description="Where the cage comes from",
    )
    method: EnumProperty(
        name="Coordinates",
        items=tuple((row.id, row.label, row.summary, "NONE", row.number) for row in _METHODS),
        default=DEFAULT_CAGE_METHOD,
        description="How points follow the cage. It can be changed later, and the cage stays",
    )
    cage: StringProperty(
        name="Cage",
        description="A mesh object by name; empty takes the other selected one",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        return has_target(cls, context)

    def invoke(self, context: Context, _event: Event) -> set[str]:
        result = self._run(context, wait=False)
        deformer = target_of(context).sinew.active
        return result if deformer is None else self.wait_for(context, deformer.uid, result)

    def execute(self, context: Context) -> set[str]:
        return self._run(context, wait=True)

    def _run(self, context: Context, wait: bool) -> set[str]:
        obj = target_of(context)
        try:
            cage = self._chosen(context, obj)
            with object_mode(context, obj):
                deformer, is_new = self._deformer(obj)
                try:
                    session.set_cage(obj, deformer, cage)
                except SinewError:
                    if is_new:
                        session.remove_deformer(obj, len(obj.sinew.deformers) - 1)
                    raise
                bound = self._bind(obj, deformer, wait)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if bound:
            self.report({"INFO"}, f"{cage.name}: {deformer.status}")
        return {"FINISHED"}

    def _deformer(self, obj: Object) -> tuple[SinewDeformer, bool]:
        """The active one where it waits for a cage, else a new one; whether it is new."""
        active = obj.sinew.active
        if active is not None and active.definition.control is Control.CAGE and active.cage is None:
            return active, False
        return session.add_deformer(obj, self.method), True

    def _chosen(self, context: Context, obj: Object) -> Object:
        if self.cage:
            cage = context.scene.objects.get(self.cage)
            if cage is None:
                raise SinewError(f"There is no object '{self.cage}' in the scene")
            return cage
        others = [other for other in context.selected_objects if other != obj and other.type == "MESH"]
        if len(others) != 1:
            raise SinewError("Select the cage and then the mesh, which becomes the active object")
        return others[0]

    def _bind(self, obj: Object, deformer: SinewDeformer, wait: bool) -> bool:
        """The cage is kept when the bind is refused; the panel then says what to do."""
        try:
            session.bind(obj, deformer, wait)
        except SinewError as error:
            self.report({"WARNING"}, str(error))
            return False
        return True


class SINEW_OT_cage_set_rest(WaitsForBind, Operator):
    """Take the cage as it is now for its rest shape: the mesh goes back to rest, and later edits are poses"""

    bl_idname = Operators.CAGE_REST
    bl_label = "Set Rest Cage"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        if not has_deformer(cls, context):
            return False
        if target_of(context).sinew.active.cage is None:
            cls.poll_message_set("Add a cage first")
            return False
        return True

    def invoke(self, context: Context, _event: Event) -> set[str]:
        result = self._run(context, wait=False)
        return self.wait_for(context, target_of(context).sinew.active.uid, result)

    def execute(self, context: Context) -> set[str]:
        return self._run(context, wait=True)

    def _run(self, context: Context, wait: bool) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        try:
            session.set_rest_cage(obj, deformer)
            session.bind(obj, deformer, wait)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, deformer.status)
        return {"FINISHED"}
