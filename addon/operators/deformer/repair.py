# SPDX-License-Identifier: GPL-3.0-or-later
"""Remedies: mend the mesh, separate regions that share vertices, use more cells or another solver, and move a
mesh once.
"""

from bpy.props import BoolProperty, EnumProperty
from bpy.types import Context, Object, Operator, PropertyGroup

from ...core.errors import SinewError
from ...core.labels import label_of
from ...ids import Operators
from ...properties import SinewDeformer, field
from ...session.actions import bind, refining, repair, surveying
from ...session.actions.handles import overlaps
from ...session.actions.repair import RepairOptions
from ..arguments import distance
from ..offered import OnDeformer, OnTarget
from ..reporting import reports_errors
from ..target import object_mode, target_of


class SINEW_OT_repair(OnTarget, Operator):
    """Mend the defects of the mesh that can be mended safely, and bind again.

    Vertex groups, shape keys and UV maps stay. All other defects are counted and stay as they are
    """

    bl_idname = Operators.REPAIR
    bl_label = "Repair"
    MESHES_ONLY = True

    not_finite: field(BoolProperty, default=True).named(
        "Lost Positions",
        "Move vertices with invalid coordinates (NaN or infinite) between their neighbours; "
        "remove them if they have none",
    )
    coincident: field(BoolProperty, default=True).named(
        "Seams",
        "Merge vertices of open borders that lie at the same place; closed parts that touch stay separate",
    )
    distance: distance(
        "Merge Distance",
        "Set the largest distance between vertices that are merged; 0 merges only vertices at exactly the "
        "same place",
        default=0.0,
        soft_max=0.1,
        precision=5,
    )
    degenerate: field(BoolProperty, default=True).named(
        "Zero-Area Faces", "Collapse faces without area and edges without length"
    )
    duplicate: field(BoolProperty, default=True).named(
        "Duplicate Faces", "Keep one of several faces with the same vertices"
    )
    non_manifold: field(BoolProperty, default=True).named(
        "Fins and Inner Walls",
        "Remove faces that stick out of an edge or divide the inside, if an ordinary surface remains",
    )
    loose: field(BoolProperty, default=True).named("Loose Vertices", "Remove vertices that are in no face")

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or (
            "" if target_of(context).mode in ("OBJECT", "EDIT") else "Repair works in Object and Edit Mode"
        )

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        wanted = RepairOptions(
            not_finite=self.not_finite,
            coincident=self.coincident,
            degenerate=self.degenerate,
            duplicate=self.duplicate,
            non_manifold=self.non_manifold,
            loose=self.loose,
            distance=self.distance,
        )
        mended, left = repair.repair(obj, wanted)
        self.tell({"INFO"}, repair.summary(mended, left))
        bind_again(self, context, obj, any(mended.values()))
        return {"FINISHED"}

    def draw(self, _context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        column = layout.column(heading="Mend")
        for name in ("not_finite", "degenerate", "duplicate", "non_manifold", "loose", "coincident"):
            column.prop(self, name)
        row = layout.row()
        row.active = self.coincident
        row.prop(self, "distance")


class SINEW_OT_cure(OnTarget, Operator):
    """Mend one kind of what is unusual about the mesh, and nothing else, and bind again.

    Vertex groups, shape keys and UV maps stay
    """

    bl_idname = Operators.CURE
    bl_label = "Mend"
    MESHES_ONLY = True

    what: field(
        EnumProperty,
        items=tuple(
            (name, label, f"Mend each {surveying.NAMES[name][0]}", number)
            for number, (name, label) in enumerate(repair.REMEDIES.items())
        ),
    ).named("What", "Choose what to mend")

    @classmethod
    def refusal(cls, context: Context) -> str:
        return SINEW_OT_repair.refusal(context)

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        surveying.survey(obj, crossings=False)
        before = surveying.last_counts(obj).found.get(self.what, 0)
        repair.cure(obj, self.what)
        surveying.survey(obj, crossings=False)
        left = surveying.last_counts(obj).found.get(self.what, 0)
        told = surveying.counted(self.what, max(before - left, 0))
        stays = f"; {left:,} stay as they are" if left else ""
        self.tell({"INFO"}, f"Mended {told}{stays}")
        bind_again(self, context, obj, before != left)
        return {"FINISHED"}


class SINEW_OT_part_regions(OnDeformer, Operator):
    """Remove vertices that two regions share from the second region, and bind again.

    If one region lies completely inside another, it keeps them, and the outer region loses them
    """

    bl_idname = Operators.PART_REGIONS
    bl_label = "Unshare"
    MESHES_ONLY = True

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        with object_mode(context, obj):
            parted = overlaps.part_regions(obj, obj.sinew.active)
        if not parted:
            self.tell({"INFO"}, "No vertex is in two regions")
            return {"CANCELLED"}
        for kept, lost, count in parted:
            vertices = "1 vertex is" if count == 1 else f"{count:,} vertices are"
            self.tell({"INFO"}, f"{vertices} now in {kept} alone, no longer in {lost}")
        bind_again(self, context, obj, True)
        return {"FINISHED"}


class SINEW_OT_refine(OnDeformer, Operator):
    """Double the number of cells until each handle has one of its own, and bind.

    Objects that share the handles get the same number
    """

    bl_idname = Operators.REFINE
    bl_label = "Refine"

    @classmethod
    def refusal(cls, context: Context) -> str:
        reason = super().refusal(context)
        if reason:
            return reason
        method = target_of(context).sinew.active.definition
        return "" if method.finer else f"{label_of(method)} has nothing that could be finer"

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        with object_mode(context, obj):
            label, value = refining.refine(obj.sinew.active)
        self.tell({"INFO"}, f"{label}: {value:,}")
        return {"FINISHED"}


class SINEW_OT_use_factor(OnDeformer, Operator):
    """Use a factor, which takes more memory, where iterations do not come to an end"""

    bl_idname = Operators.USE_FACTOR
    bl_label = "Use Factor"

    @classmethod
    def refusal(cls, context: Context) -> str:
        reason = super().refusal(context)
        if reason:
            return reason
        deformer = target_of(context).sinew.active
        return "" if _solved(deformer) else f"{label_of(deformer.definition)} has no choice of solvers"

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        for parameters in _solved(target_of(context).sinew.active):
            parameters.solver = "factor"
        return {"FINISHED"}


def _solved(deformer: SinewDeformer) -> list[PropertyGroup]:
    """The parameters with a choice of solvers."""
    return [parameters for _method, parameters in deformer.methods if hasattr(parameters, "solver")]


class SINEW_OT_armature_off(OnDeformer, Operator):
    """Turn off the Armature modifiers of this mesh whose armature also moves a control of Sinew.

    The control carries the mesh along, so it moved twice as far
    """

    bl_idname = Operators.ARMATURE_OFF
    bl_label = "Turn Off Armature"
    MESHES_ONLY = True

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        names = refining.turn_off_armatures(obj, obj.sinew.active)
        if not names:
            self.tell({"INFO"}, "Nothing moves this mesh twice")
            return {"CANCELLED"}
        self.tell({"INFO"}, f"Turned off {', '.join(names)}")
        return {"FINISHED"}


def bind_again(operator: Operator, context: Context, obj: Object, changed: bool) -> None:
    """Bind the active deformer and, if the mesh changed, all bound ones of all objects here with this mesh.

    Errors are reported as warnings.
    """
    for user in (each for each in repair.users_of(obj.data) if each.name in context.view_layer.objects):
        for deformer in user.sinew.deformers:
            is_active = user == obj and deformer.uid == obj.sinew.active.uid
            if not (changed if deformer.is_bound else is_active and deformer.handles):
                continue
            try:
                with object_mode(context, user):
                    bind.bind(user, deformer)
            except SinewError as error:
                operator.tell({"WARNING"}, f"{deformer.name}: {error}")
