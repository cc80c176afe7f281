# SPDX-License-Identifier: GPL-3.0-or-later
"""Fit a lattice to the selected objects, and set its rest shape."""

from bpy.props import EnumProperty, FloatProperty, IntVectorProperty, StringProperty
from bpy.types import Context, Object, Operator

from ...core.errors import SinewError
from ...ids import Operators
from ...properties import field
from ...session.actions import rigging
from ...session.actions.controls import lattices as edit_lattices
from ...session.actions.controls.lattices import LATTICE_METHODS, LatticeShape
from ..arguments import once
from ..deformer.sharing import BindsAll
from ..offered import OnDeformer, OnTarget
from ..reporting import reports_errors
from ..target import object_mode, object_named, selected_targets, target_of
from ..waiting import BindingOperator
from .cage import show_only

_LATTICES = ("LATTICE", "MESH")
_SOURCES = (
    ("FIT", "Fitted", "A new lattice around all selected objects", 0),
    ("OBJECT", "Selected Object", "The other selected lattice, or mesh of hexahedra", 1),
)
_SHAPES = (
    ("BOX", "Box", "A lattice object of rows, columns and layers", 0),
    ("CYLINDER", "Cylinder", "A mesh of hexahedra about the third axis", 1),
    ("FITTED", "Fitted Boxes", "A mesh of boxes where the objects are: welded hexahedra", 2),
)
_ORIENTATIONS = (
    ("OBJECT", "Object", "Along the axes of the active object", 0),
    ("PRINCIPAL", "Principal Axes", "Along the directions in which the shape is longest", 1),
    ("WORLD", "World", "Along the axes of the world", 2),
)


class SINEW_OT_lattice_add(OnTarget, BindingOperator, Operator):
    """Let a lattice around the selected objects move them. Edit, pose or animate it like any lattice"""

    bl_idname = Operators.LATTICE_ADD
    bl_label = "Add Lattice"

    source: field(EnumProperty, items=_SOURCES, default="FIT").named(
        "Source", "Choose where the lattice comes from"
    )
    shape: field(EnumProperty, items=_SHAPES, default="BOX").named(
        "Shape", "Choose what the new lattice looks like"
    )
    resolution: field(IntVectorProperty, size=3, default=(4, 4, 4), min=1, max=64, soft_max=16).named(
        "Resolution",
        "Set the points along each axis, or of a mesh the cells; of a cylinder across the "
        "core, from there outwards, and along the axis",
    )
    orientation: field(EnumProperty, items=_ORIENTATIONS, default="OBJECT").named(
        "Orientation", "Set how the new lattice is turned"
    )
    margin: field(FloatProperty, default=0.02, min=0.0, max=1.0, soft_max=0.25, precision=3, step=1).named(
        "Margin", "Set how far the new lattice stands out, as a share of its longest side"
    )
    lattice: once(StringProperty).named(
        "Lattice",
        "Give the name of a lattice object, or of a mesh of hexahedra; if empty, the other selected one is "
        "used",
    )

    @reports_errors
    def run(self, context: Context, wait: bool) -> set[str]:
        active = target_of(context)
        with object_mode(context, active):
            if self.source == "OBJECT":
                lattice, targets = self._chosen(context, active), [active]
            else:
                targets = selected_targets(context, active)
                counts = tuple(self.resolution)
                shape = LatticeShape(self.shape, counts, self.orientation, self.margin)
                lattice = edit_lattices.add_lattice_object(targets, shape)
            method, owned = LATTICE_METHODS[0].id, self.source == "FIT"
            bound = rigging.rig_controls(targets, lattice, method, owned=owned, wait=wait)
            show_only(context, active, lattice)
        self.report_shared(bound, lattice.name)
        return {"FINISHED"}

    def _chosen(self, context: Context, active: Object) -> Object:
        if self.lattice:
            return object_named(context, self.lattice)
        others = [other for other in context.selected_objects if other != active and other.type in _LATTICES]
        lattices = [other for other in others if other.type == "LATTICE"]
        if len(lattices) != 1 and len(others) != 1:
            raise SinewError("Select the lattice and then the object that it moves, which becomes active")
        return (lattices or others)[0]


class SINEW_OT_lattice_set_rest(OnDeformer, BindsAll, Operator):
    """Take the current shape and resolution of the lattice as its rest, for all objects that it moves.

    They go back to rest; later edits of the lattice pose them
    """

    bl_idname = Operators.LATTICE_REST
    bl_label = "New Rest"

    @classmethod
    def refusal(cls, context: Context) -> str:
        reason = super().refusal(context)
        if reason:
            return reason
        controls = target_of(context).sinew.active.controls
        has_lattice = any(row.kind == "lattice" and row.object is not None for row in controls)
        return "" if has_lattice else "Add a lattice first"
