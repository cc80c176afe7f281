# SPDX-License-Identifier: GPL-3.0-or-later
"""The remedies: mend the mesh, part regions that share vertices."""

from bpy.props import BoolProperty, FloatProperty
from bpy.types import Context, Object, Operator

from .. import session
from ..core.errors import SinewError
from ..ids import Operators
from .refusing import refusing
from .target import has_deformer, has_target, object_mode, target_of


class SINEW_OT_repair(Operator):
    """Mend what is broken in the mesh, as far as it is safe, and bind again.

    Vertex groups, shape keys and UVs stay; what has no safe cure is counted and left as it is
    """

    bl_idname = Operators.REPAIR
    bl_label = "Repair"
    bl_options = {"REGISTER", "UNDO"}

    not_finite: BoolProperty(
        name="Lost Positions",
        default=True,
        description="Put vertices whose position is not a number between their neighbours; "
        "remove them where they have none",
    )
    coincident: BoolProperty(
        name="Seams",
        default=True,
        description="Merge vertices of open borders that lie on each other; "
        "closed parts that touch stay apart",
    )
    distance: FloatProperty(
        name="Merge Distance",
        default=0.0,
        min=0.0,
        soft_max=0.1,
        precision=5,
        subtype="DISTANCE",
        description="How far vertices of a seam may lie apart; 0 merges only exact ones",
    )
    degenerate: BoolProperty(
        name="Zero-Area Faces", default=True, description="Collapse faces and edges without size"
    )
    duplicate: BoolProperty(
        name="Duplicate Faces", default=True, description="Keep one of several faces with the same vertices"
    )
    non_manifold: BoolProperty(
        name="Fins and Inner Walls",
        default=True,
        description="Remove faces that stick out of an edge, or divide the inside, "
        "where an ordinary surface remains",
    )
    loose: BoolProperty(
        name="Loose Vertices", default=True, description="Remove vertices that are in no face"
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        if not has_target(cls, context, mesh=True):
            return False
        if target_of(context).mode not in ("OBJECT", "EDIT"):
            cls.poll_message_set("Repair works in Object and Edit Mode")
            return False
        return True

    @refusing
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        cures = session.Cures(
            not_finite=self.not_finite,
            coincident=self.coincident,
            degenerate=self.degenerate,
            duplicate=self.duplicate,
            non_manifold=self.non_manifold,
            loose=self.loose,
            distance=self.distance,
        )
        mended, left = session.repair(obj, cures)
        self.report({"INFO"}, session.repair_summary(mended, left))
        _bind_again(self, context, obj, any(mended.values()))
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


class SINEW_OT_part_regions(Operator):
    """Let vertices that two regions share go from the second one, and bind again.

    A region that lies wholly inside another one keeps them instead
    """

    bl_idname = Operators.PART_REGIONS
    bl_label = "Part Regions"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return has_deformer(cls, context, mesh=True)

    @refusing
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        with object_mode(context, obj):
            parted = session.part_regions(obj, obj.sinew.active)
        if not parted:
            self.report({"INFO"}, "No vertex is in two regions")
            return {"CANCELLED"}
        for keeps, gives, count in parted:
            vertices = "1 vertex" if count == 1 else f"{count:,} vertices"
            self.report({"INFO"}, f"{vertices} went from {gives} to {keeps} alone")
        _bind_again(self, context, obj, True)
        return {"FINISHED"}


def _bind_again(operator: Operator, context: Context, obj: Object, changed: bool) -> None:
    """Bind the active deformer, and the bound ones where the mesh changed. A refusal is a warning."""
    active = obj.sinew.active
    for deformer in obj.sinew.deformers:
        is_active = deformer.uid == active.uid
        if (
            not deformer.handles
            or (deformer.is_bound and not changed)
            or not (deformer.is_bound or is_active)
        ):
            continue
        try:
            with object_mode(context, obj):
                session.bind(obj, deformer)
        except SinewError as error:
            operator.report({"WARNING"}, f"{deformer.name}: {error}")
