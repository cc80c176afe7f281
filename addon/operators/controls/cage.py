# SPDX-License-Identifier: GPL-3.0-or-later
"""Add a cage, set its rest shape, and turn its faces."""

from collections.abc import Callable

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy.types import Context, Event, Object, Operator

from ... import compat
from ...core.errors import SinewError
from ...core.methods import DEFAULT_CAGE_METHOD
from ...ids import Operators
from ...properties import SinewDeformer, deformers_of, field
from ...session.actions import bind, rigging, sharing
from ...session.actions.controls import automatic as edit_automatic, cages, making
from ...session.actions.controls.around import Target
from ...session.actions.controls.cages import CAGE_METHODS
from ...session.actions.controls.making import BEING_MADE
from ...session.evaluation import binding
from ...session.state.background import Work
from ..arguments import method_choice, once
from ..deformer.sharing import BindsAll
from ..offered import OnDeformer, OnTarget
from ..reporting import reports_errors
from ..target import object_mode, object_named, selected_targets, show_control, target_of
from ..waiting import BindingOperator

_FACES = {
    "name": "Faces",
    "default": 300,
    "min": 12,
    "max": 100_000,
    "soft_max": 1000,
    "description": "Set how many triangles the automatic cage has; fewer are easier to pose, more follow "
    "closer",
}


class _MakesCage(OnTarget, BindingOperator):
    """Base of operators that make an automatic cage. In a window, a thread makes it if that takes long.

    ``run`` gets the shape that the thread has made, else it makes one.
    """

    CANCELLED = ""  # what is said after Esc

    _work: Work | None = None
    _targets: tuple[tuple[str, str], ...] = ()  # what the thread works for; others may be active by now

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or (
            "" if making.cage_work(target_of(context).name) is None else BEING_MADE
        )

    def carry_out(self, context: Context, margin: float) -> set[str]:
        """Make the cage, with this margin, while Blender stays responsive."""
        if not binding.may_wait(cages.cage_seconds(margin)):
            return self.watched(context, self.run(context, wait=False))
        return self._begin(context)

    @reports_errors
    def _begin(self, context: Context) -> set[str]:
        targets = self.targets(context)
        self._targets = tuple((obj.name, "" if row is None else row.uid) for obj, row in targets)
        self._work = making.begin_cage([obj for obj, _row in targets], self.maker(targets))
        return self.stay(context)

    def look(self, context: Context, is_cancelled: bool) -> set[str]:
        work = self._work
        if work is None:
            return super().look(context, is_cancelled)
        if is_cancelled or making.cage_work(self._targets[0][0]) is not work:
            self.tell({"WARNING"}, self.CANCELLED)
            return {"CANCELLED"}
        if not work.done:
            context.workspace.status_text_set(
                compat.told(f"Sinew is making a cage: {work.fraction:.0%} {work.stage}   (Esc cancels)")
            )
            return {"PASS_THROUGH"}
        self._forget_work()
        if work.error is not None:
            self.tell({"ERROR"}, str(work.error))
            return {"CANCELLED"}
        return self.watched(context, self.run(context, wait=False, shape=work.result))

    def leave(self, context: Context) -> None:
        self._forget_work()
        super().leave(context)

    def _forget_work(self) -> None:
        """Stop the thread, if it still works, and let another cage be made."""
        if self._work is not None and making.cage_work(self._targets[0][0]) is self._work:
            making.drop_cage(self._targets[0][0])
        self._work = None

    def subjects(self, context: Context) -> list[Target]:
        """The objects that get the cage, the active one first, with the deformers when this began."""
        chosen, self._targets = self._targets, ()
        if not chosen:
            return self.targets(context)
        found: list[Target] = []
        for name, uid in chosen:
            obj = context.scene.objects.get(name)
            rows = [] if obj is None else [row for row in deformers_of(obj) if row.uid == uid]
            if obj is None or (uid and not rows):
                raise SinewError(f"{name} or its deformer is gone - {self.CANCELLED.lower()}")
            found.append((obj, rows[0] if rows else None))
        return found


class SINEW_OT_cage_add(_MakesCage, Operator):
    """Let a closed mesh around this one move it. Edit, pose or animate the cage like any other mesh"""

    bl_idname = Operators.CAGE_ADD
    bl_label = "Wrap in a Cage"
    bl_options = {"REGISTER", "UNDO"}

    CANCELLED = "No cage was made"

    source: field(
        EnumProperty,
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
    ).named("Source", "Choose where the cage comes from")
    method: method_choice(
        CAGE_METHODS,
        "Set how points follow the cage; it can be changed later, and the cage stays",
        name="Coordinates",
        default=DEFAULT_CAGE_METHOD,
    )
    faces: IntProperty(**_FACES)
    margin: field(
        FloatProperty, default=1.0 / 60.0, min=0.004, max=0.25, soft_max=0.1, precision=3, step=1
    ).named("Margin", "Set how far from the mesh the automatic cage starts, as a share of the mesh's size")
    quads: field(BoolProperty).named(
        "Quads", "Join the triangles of the automatic cage in pairs, where that is safe"
    )
    symmetric: field(BoolProperty, default=True).named("Symmetric", "Give a symmetric mesh a symmetric cage")
    cage: once(StringProperty).named(
        "Cage", "Give the name of a mesh object; if empty, the other selected mesh is used"
    )

    def invoke(self, context: Context, event: Event) -> set[str]:
        return (
            self.carry_out(context, self.margin) if self.source == "AUTO" else super().invoke(context, event)
        )

    @reports_errors
    def run(self, context: Context, wait: bool, shape: tuple | None = None) -> set[str]:
        automatic, more = self.source == "AUTO", ""
        targets = self.subjects(context)
        obj = targets[0][0]
        with object_mode(context, obj):
            if automatic:
                shape = shape or self.maker(targets)(None)
                cage = cages.add_cage_object([obj for obj, _row in targets], shape)
                more = shape[-1] and f", {shape[-1]}"
            else:
                cage = self._chosen(context, obj)
            bound = rigging.rig_controls(
                [obj for obj, _row in targets], cage, self.method, owned=automatic, wait=wait
            )
            if obj == target_of(context):
                show_only(context, obj, cage)
        self.report_shared(bound, cage.name, more)
        return {"FINISHED"}

    def targets(self, context: Context) -> list[Target]:
        active = target_of(context)
        objects = selected_targets(context, active) if self.source == "AUTO" else [active]
        return [(obj, obj.sinew.active) for obj in objects]

    def maker(self, targets: list[Target]) -> Callable:
        symmetry = "automatic" if self.symmetric else "none"
        return cages.cage_maker(
            [(obj, rigging.waiting_for_control(obj, self.method)) for obj, _row in targets],
            faces=self.faces,
            margin=self.margin,
            quads=self.quads,
            symmetry=symmetry,
            flat=cages.takes_flat_cage(self.method),
        )

    def _chosen(self, context: Context, obj: Object) -> Object:
        if self.cage:
            return object_named(context, self.cage)
        others = [other for other in context.selected_objects if other != obj and other.type == "MESH"]
        if len(others) != 1:
            raise SinewError("Select the cage and then the mesh, which becomes the active object")
        return others[0]


def show_only(context: Context, obj: Object, control: Object) -> None:
    """Select a control alone, so that Tab edits it and G moves it. The panel still shows the object."""
    if control.name not in context.view_layer.objects:
        return
    for other in context.selected_objects:
        other.select_set(False)
    control.select_set(True)
    show_control(context, obj, control)


class OnCage(OnDeformer):
    """Mixin for an operator on the cage of the active deformer."""

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or (
            "Add a cage first" if target_of(context).sinew.active.cage is None else ""
        )


class SINEW_OT_cage_set_rest(OnCage, BindsAll, Operator):
    """Take the current shape of the cage as its rest shape, for all objects that it moves.

    They go back to rest; later edits pose them
    """

    bl_idname = Operators.CAGE_REST
    bl_label = "New Rest"


class SINEW_OT_cage_flip(OnCage, BindsAll, Operator):
    """Flip the faces of a cage that is inside out, and bind to its current shape"""

    bl_idname = Operators.CAGE_FLIP
    bl_label = "Flip Cage"

    def change(self, _obj: Object, deformer: SinewDeformer) -> list[Target]:
        return cages.flip_cage(deformer)


class SINEW_OT_cage_outside_follow(OnCage, BindingOperator, Operator):
    """Let what lies outside the cage follow it, too, by the setting Outside"""

    bl_idname = Operators.CAGE_OUTSIDE
    bl_label = "Let Outside Follow"

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or (
            ""
            if sharing.refuses_outside(target_of(context).sinew.active)
            else "What lies outside this cage follows already"
        )

    @reports_errors
    def run(self, context: Context, wait: bool) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        sharing.let_outside_follow(deformer)
        bind.bind(obj, deformer, wait)
        self.report_state(deformer.uid)
        return {"FINISHED"}


class SINEW_OT_cage_faces(OnCage, _MakesCage, Operator):
    """Make the automatic cage anew, with more faces or fewer, as long as it is neither posed nor edited"""

    bl_idname = Operators.CAGE_FACES
    bl_label = "Cage Faces"
    bl_options = {"REGISTER", "UNDO"}

    CANCELLED = "The cage stays as it was"

    faces: IntProperty(**_FACES)

    _is_confirmed = False  # whether the dialog was shown, which calls ``execute``

    def invoke(self, context: Context, _event: Event) -> set[str]:
        return self._ask(context)

    @reports_errors
    def _ask(self, context: Context) -> set[str]:
        obj = target_of(context)
        edit_automatic.check_cage(obj.sinew.active)
        if not self.properties.is_property_set("faces"):
            self.faces = edit_automatic.face_count(obj.sinew.active.cage)
        self._is_confirmed = True
        return context.window_manager.invoke_props_dialog(self)

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        if not self._is_confirmed:
            return super().execute(context)
        self._is_confirmed = False
        return self.carry_out(context, edit_automatic.check_cage(target_of(context).sinew.active)["margin"])

    @reports_errors
    def run(self, context: Context, wait: bool, shape: tuple | None = None) -> set[str]:
        targets = self.subjects(context)
        obj, deformer = targets[0]
        edit_automatic.check_cage(deformer)  # it may have been posed or edited meanwhile
        shape = shape or self.maker(targets)(None)
        edit_automatic.change_cage(obj, deformer, shape)
        bound = [(row, rigging.try_bind(target, row, wait)) for target, row in targets]
        self.report_shared(bound, deformer.cage.name, shape[-1] and f", {shape[-1]}")
        return {"FINISHED"}

    def targets(self, context: Context) -> list[Target]:
        obj = target_of(context)
        deformer = obj.sinew.active
        others = [pair for pair in edit_automatic.moved_by(deformer.cage) if pair[1].uid != deformer.uid]
        return [(obj, deformer), *others]

    def maker(self, targets: list[Target]) -> Callable:
        options = edit_automatic.check_cage(targets[0][1]) | {"faces": self.faces}
        return cages.cage_maker(targets, **options)
