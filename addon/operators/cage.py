# SPDX-License-Identifier: GPL-3.0-or-later
"""Add a cage, set its rest shape, and turn its faces."""

from collections.abc import Callable

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy.types import Context, Event, Object, Operator

from .. import session
from ..core.errors import SinewError
from ..core.methods import DEFAULT_CAGE_METHOD
from ..ids import Operators
from ..properties import SinewDeformer, deformers_of
from .reporting import reports_errors
from .target import has_deformer, has_target, object_mode, show_control, target_of
from .waiting import BindingOperator

_FACES = {
    "name": "Faces",
    "default": 300,
    "min": 12,
    "max": 100_000,
    "soft_max": 1000,
    "description": "How many triangles the automatic cage has; fewer are easier to pose, more follow closer",
}


class _MakesCage(BindingOperator):
    """Base of operators that make an automatic cage. In a window, a thread makes it if that takes long.

    ``run`` gets the shape that the thread has made, else it makes one.
    """

    CANCELLED = ""  # what is said after Esc

    _work: session.Work | None = None
    _target = ("", "")  # what the thread works for; another object or deformer may be active by now

    @classmethod
    def poll(cls, context: Context) -> bool:
        if not has_target(cls, context):
            return False
        if session.cage_work(target_of(context).name) is not None:
            cls.poll_message_set(session.BEING_MADE)
            return False
        return True

    def carry_out(self, context: Context, margin: float) -> set[str]:
        """Make the cage, with this margin, while Blender stays responsive."""
        if not session.may_wait(session.cage_seconds(margin)):
            return self.watched(context, self.run(context, wait=False))
        return self._begin(context)

    @reports_errors
    def _begin(self, context: Context) -> set[str]:
        obj = target_of(context)
        active = obj.sinew.active
        self._target = obj.name, "" if active is None else active.uid
        self._work = session.begin_cage(obj, self.maker(obj, active))
        return self.stay(context)

    def look(self, context: Context, is_cancelled: bool) -> set[str]:
        work = self._work
        if work is None:
            return super().look(context, is_cancelled)
        if is_cancelled or session.cage_work(self._target[0]) is not work:
            self.report({"WARNING"}, self.CANCELLED)
            return {"CANCELLED"}
        if not work.done:
            context.workspace.status_text_set(
                f"Sinew is making a cage: {work.fraction:.0%} {work.stage}   (Esc cancels)"
            )
            return {"PASS_THROUGH"}
        self._forget_work()
        if work.error is not None:
            self.report({"ERROR"}, str(work.error))
            return {"CANCELLED"}
        return self.watched(context, self.run(context, wait=False, shape=work.result))

    def leave(self, context: Context) -> None:
        self._forget_work()
        super().leave(context)

    def _forget_work(self) -> None:
        """Stop the thread, if it still works, and let another cage be made."""
        if self._work is not None and session.cage_work(self._target[0]) is self._work:
            session.drop_cage(self._target[0])
        self._work = None

    def subject(self, context: Context) -> tuple[Object, SinewDeformer | None]:
        """The object that gets the cage, and its deformer that was active when this began."""
        (name, uid), self._target = self._target, ("", "")
        if not name:
            obj = target_of(context)
            return obj, obj.sinew.active
        obj = context.scene.objects.get(name)
        rows = [] if obj is None else [row for row in deformers_of(obj) if row.uid == uid]
        if obj is None or (uid and not rows):
            raise SinewError(f"{name} or its deformer is gone - {self.CANCELLED.lower()}")
        return obj, rows[0] if rows else None


class SINEW_OT_cage_add(_MakesCage, Operator):
    """Let a closed mesh around this one move it. Edit, pose or animate the cage like any other mesh"""

    bl_idname = Operators.CAGE_ADD
    bl_label = "Add Cage"
    bl_options = {"REGISTER", "UNDO"}

    CANCELLED = "No cage was made"

    source: EnumProperty(
        name="Source",
        items=(
            (
                "AUTO",
                "Automatic",
                "A new coarse mesh around this one, with the number of faces given below",
                0,
            ),
            ("OBJECT", "Selected Object", "The other selected mesh becomes the cage", 1),
        ),
        default="AUTO",
        description="Where the cage comes from",
    )
    method: EnumProperty(
        name="Coordinates",
        items=tuple((row.id, row.label, row.summary, "NONE", row.number) for row in session.CAGE_METHODS),
        default=DEFAULT_CAGE_METHOD,
        description="How points follow the cage. It can be changed later, and the cage stays",
    )
    faces: IntProperty(**_FACES)
    margin: FloatProperty(
        name="Margin",
        default=1.0 / 60.0,
        min=0.004,
        max=0.25,
        soft_max=0.1,
        precision=3,
        step=1,
        description="How far from the mesh the automatic cage starts, as a share of the mesh's size",
    )
    quads: BoolProperty(
        name="Quads", description="Join the triangles of the automatic cage in pairs, where that is safe"
    )
    symmetric: BoolProperty(
        name="Symmetric",
        default=True,
        description="Give a symmetric mesh a symmetric cage",
    )
    cage: StringProperty(
        name="Cage",
        description="The name of a mesh object; if empty, the other selected mesh is used",
        options={"SKIP_SAVE"},
    )

    def invoke(self, context: Context, event: Event) -> set[str]:
        return (
            self.carry_out(context, self.margin) if self.source == "AUTO" else super().invoke(context, event)
        )

    @reports_errors
    def run(self, context: Context, wait: bool, shape: tuple | None = None) -> set[str]:
        obj, active = self.subject(context)
        more = ""
        with object_mode(context, obj):
            if self.source == "OBJECT":
                cage = self._chosen(context, obj)
            else:
                shape = shape or self.maker(obj, active)(None)
                cage = session.add_cage_object(obj, shape)
                more = shape[-1] and f", {shape[-1]}"
            deformer, refusal = session.rig_control(
                obj, cage, self.method, owned=self.source == "AUTO", wait=wait
            )
            if obj == target_of(context):
                show_only(context, obj, cage)
        self.report_bind(refusal, deformer.uid, cage.name, more)
        return {"FINISHED"}

    def maker(self, obj: Object, _active: SinewDeformer | None) -> Callable:
        symmetry = "automatic" if self.symmetric else "none"
        return session.cage_maker(
            obj,
            session.waiting_for_control(obj, self.method),
            faces=self.faces,
            margin=self.margin,
            quads=self.quads,
            symmetry=symmetry,
            flat=session.takes_flat_cage(self.method),
        )

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


def show_only(context: Context, obj: Object, cage: Object) -> None:
    """Select a control alone, so that Tab edits it and G moves it. The panel still shows the mesh."""
    if cage.name not in context.view_layer.objects:
        return
    for other in context.selected_objects:
        other.select_set(False)
    cage.select_set(True)
    show_control(context, obj, cage)


def _has_cage(operator: type, context: Context) -> bool:
    """For ``poll``: whether the active deformer has a cage."""
    if not has_deformer(operator, context):
        return False
    if target_of(context).sinew.active.cage is None:
        operator.poll_message_set("Add a cage first")
        return False
    return True


class _CageOperator(BindingOperator):
    """Base of operators that change the cage of the active deformer and bind again."""

    @classmethod
    def poll(cls, context: Context) -> bool:
        return _has_cage(cls, context)

    @reports_errors
    def run(self, context: Context, wait: bool) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        self.change(obj, deformer)
        session.bind(obj, deformer, wait)
        self.report_state(deformer.uid)
        return {"FINISHED"}


class SINEW_OT_cage_set_rest(_CageOperator, Operator):
    """Take the current shape of the cage as its rest shape.

    The mesh goes back to rest; later edits pose it
    """

    bl_idname = Operators.CAGE_REST
    bl_label = "Set Rest Cage"
    bl_options = {"REGISTER", "UNDO"}

    def change(self, obj: Object, deformer: SinewDeformer) -> None:
        session.set_rest_cage(obj, deformer)


class SINEW_OT_cage_flip(_CageOperator, Operator):
    """Flip the faces of a cage that is inside out, and bind to its current shape"""

    bl_idname = Operators.CAGE_FLIP
    bl_label = "Flip Cage"
    bl_options = {"REGISTER", "UNDO"}

    def change(self, _obj: Object, deformer: SinewDeformer) -> None:
        session.flip_cage(deformer)


class SINEW_OT_cage_faces(_MakesCage, Operator):
    """Make the automatic cage anew, with more faces or fewer, as long as it is neither posed nor edited"""

    bl_idname = Operators.CAGE_FACES
    bl_label = "Change Faces"
    bl_options = {"REGISTER", "UNDO"}

    CANCELLED = "The cage stays as it was"

    faces: IntProperty(**_FACES)

    _is_confirmed = False  # whether the dialog was shown, which calls ``execute``

    @classmethod
    def poll(cls, context: Context) -> bool:
        return super().poll(context) and _has_cage(cls, context)

    def invoke(self, context: Context, _event: Event) -> set[str]:
        return self._ask(context)

    @reports_errors
    def _ask(self, context: Context) -> set[str]:
        obj = target_of(context)
        session.check_cage(obj, obj.sinew.active)
        if not self.properties.is_property_set("faces"):
            self.faces = session.face_count(obj.sinew.active.cage)
        self._is_confirmed = True
        return context.window_manager.invoke_props_dialog(self)

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        if not self._is_confirmed:
            return super().execute(context)
        self._is_confirmed = False
        obj = target_of(context)
        return self.carry_out(context, session.check_cage(obj, obj.sinew.active)["margin"])

    @reports_errors
    def run(self, context: Context, wait: bool, shape: tuple | None = None) -> set[str]:
        obj, deformer = self.subject(context)
        session.check_cage(obj, deformer)  # it may have been posed or edited meanwhile
        shape = shape or self.maker(obj, deformer)(None)
        session.change_cage(obj, deformer, shape)
        refusal = session.try_bind(obj, deformer, wait)
        more = f", {shape[-1]}" if shape[-1] else ""
        self.report_bind(refusal, deformer.uid, deformer.cage.name, more)
        return {"FINISHED"}

    def maker(self, obj: Object, deformer: SinewDeformer) -> Callable:
        options = session.check_cage(obj, deformer) | {"faces": self.faces}
        return session.cage_maker(obj, deformer, **options)
