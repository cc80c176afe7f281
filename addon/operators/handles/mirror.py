# SPDX-License-Identifier: GPL-3.0-or-later
"""Copy handles and their weights to the other side of the mesh."""

from bpy.props import BoolProperty, EnumProperty
from bpy.types import Context, Operator

from ...core.sides import Side
from ...ids import Operators
from ...properties import field
from ...session.actions import rigging
from ...session.actions.handles import mirror
from ...session.actions.handles.mirror import Mirrored, MirrorOptions
from ..arguments import distance
from ..offered import OnDeformer
from ..reporting import reports_errors
from ..target import handle_index, object_mode, target_of
from ..waiting import BindingOperator


class SINEW_OT_handle_mirror(OnDeformer, BindingOperator, Operator):
    """Mirror handles across the local X axis of the mesh: Hand.L to Hand.R, with weights, control and pose.

    The other side is found by its name, or made. A handle without a side in its name is named by the side
    that it lies on; on the centre line it stays one handle and becomes symmetric
    """

    bl_idname = Operators.HANDLE_MIRROR
    bl_label = "Mirror Handle"
    MESHES_ONLY = True

    side: field(
        EnumProperty,
        items=(
            ("ACTIVE", "Active Handle", "Mirror the active handle to the other side", 0),
            (
                "LEFT_TO_RIGHT",
                "Left to Right",
                "Mirror every handle of the left side (+X), and make those in the middle symmetric",
                1,
            ),
            (
                "RIGHT_TO_LEFT",
                "Right to Left",
                "Mirror every handle of the right side (-X), and make those in the middle symmetric",
                2,
            ),
        ),
    ).named("Side", "Choose which handles are mirrored, and to where")
    weights_only: field(BoolProperty).named(
        "Weights Only", "Keep the controls and settings of the other side as they are"
    )
    painted_groups: field(BoolProperty).named(
        "Painted Groups", "Make the mask and the vertex groups of painted parameters symmetric, too"
    )
    tolerance: distance(
        "Tolerance",
        "Set how far a vertex may lie from the mirror image of another",
        default=0.001,
        soft_max=0.1,
        precision=5,
    )

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or (
            "" if target_of(context).sinew.active.handles else "Add a handle first"
        )

    @reports_errors
    def run(self, context: Context, wait: bool) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        active = deformer.handles[handle_index(deformer, -1)]
        if self.side == "ACTIVE":
            keys, source = [active.uid], None
        else:
            source = Side.LEFT if self.side == "LEFT_TO_RIGHT" else Side.RIGHT
            keys = mirror.handles_of_side(deformer, source)
        options = MirrorOptions(source, self.tolerance, self.weights_only, self.painted_groups)
        with object_mode(context, obj):
            done = mirror.mirror(obj, deformer, keys, options)
            context.view_layer.update()  # new empties enter the view layer
            refusal = rigging.try_bind(obj, deformer, wait)
            if refusal is not None:
                self.tell({"WARNING"}, str(refusal))
        self._report_result(done)
        return {"FINISHED"}

    def _report_result(self, done: Mirrored) -> None:
        for old, new in done.named:
            self.tell({"INFO"}, f"{old} is now {new}, after the side that it lies on")
        pairs = [f"{source} to {target}" for source, target in done.pairs]
        if pairs:
            self.tell({"INFO"}, f"Mirrored {', '.join(pairs)}")
        for name in done.evened:
            self.tell({"INFO"}, f"{name} lies on the centre line: it stays one handle, made symmetric")
        if done.centre:
            vertices = "1 vertex" if done.centre == 1 else f"{done.centre:,} vertices"
            self.tell({"INFO"}, f"{vertices} on the centre line belong to the side that was mirrored")
        if done.unmatched:
            vertices = "1 vertex has" if done.unmatched == 1 else f"{done.unmatched:,} vertices have"
            self.tell(
                {"WARNING"},
                f"{vertices} no mirror image across X - raise Tolerance if the two halves differ a little",
            )
