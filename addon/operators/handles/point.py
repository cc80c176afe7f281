# SPDX-License-Identifier: GPL-3.0-or-later
"""Adds handle points: handles without a region, which move space where their controls are."""

from bpy.props import BoolProperty, EnumProperty
from bpy.types import Context, Object, Operator

from ...core.errors import SinewError
from ...core.labels import items_of
from ...core.methods import BY_ID, DEFAULT_POINT_METHOD, METHODS, Control
from ...ids import Operators
from ...properties import field
from ...session.actions import rigging
from ...session.actions.handles import points as edit_handles_points
from ...session.controls import twice
from ...session.targets.targets import can_be_moved
from ..offered import OnTarget
from ..reporting import reports_errors
from ..target import object_mode, target_of
from ..waiting import BindingOperator

_METHODS = tuple(
    method for method in METHODS if method.is_space and method.control is Control.HANDLES and not method.wraps
)
_SOURCES = (
    ("CURSOR", "At the Cursor", "A new empty at the 3D cursor", "CURSOR", 0),
    (
        "SELECTED",
        "Selected Empties and Bones",
        "The selected empties, and the selected bones of armatures in Pose Mode",
        "EMPTY_AXIS",
        1,
    ),
    (
        "OBJECT",
        "Empties at the Points of an Object",
        "New empties that follow the points of the other selected mesh, curve or lattice object",
        "EMPTY_DATA",
        2,
    ),
    (
        "POINTS",
        "Points of Objects",
        "All points of the other selected objects, such as meshes, curves and point clouds, as their edits, "
        "shape keys and modifiers move them; without empties",
        "POINTCLOUD_DATA",
        3,
    ),
)


class SINEW_OT_point_add(OnTarget, BindingOperator, Operator):
    """Add handles that move the space around them: no vertex groups are needed, and curves follow, too.

    All selected objects follow the same empties and bones
    """

    bl_idname = Operators.POINT_ADD
    bl_label = "Add Points"

    source: field(EnumProperty, items=_SOURCES, default="CURSOR").named(
        "Where", "Choose what the handles follow"
    )
    method: field(EnumProperty, items=items_of(_METHODS), default=BY_ID[DEFAULT_POINT_METHOD].number).named(
        "Method", "Set how space follows the handles, for an object that has no deformer yet"
    )

    segments: field(BoolProperty, default=False).named(
        "Segments", "Use bones and edges as line handles, if the method supports them"
    )

    @reports_errors
    def run(self, context: Context, wait: bool) -> set[str]:
        active = target_of(context)
        with object_mode(context, active):
            owned, controls = self._controls(context, active)
            points = "SEGMENTS" if self.segments else "POINTS" if self.source == "POINTS" else "PLACE"
            targets = [active, *(other for other in _others(context, active, controls))]
            rigged = rigging.rig_points(
                targets, controls, self.method, owned=owned, acts_as=points, wait=wait
            )
            context.view_layer.update()
            for deformer, count, refusal in rigged:
                noun = "handle" if points != "PLACE" else "handle point"
                self.report_bind(refusal, deformer.uid, f"1 {noun}" if count == 1 else f"{count} {noun}s")
                for text in twice.explain(deformer.id_data, deformer):
                    self.tell({"WARNING"}, text)
        return {"FINISHED"}

    def _controls(self, context: Context, active: Object) -> tuple[bool, list[tuple[Object, str]]]:
        """Whether they are new, and objects with the names of their bones."""
        if self.source == "CURSOR":
            empty = edit_handles_points.empty_at(active, context.scene.cursor.location)
            context.view_layer.update()
            return True, [(empty, "")]
        if self.source == "SELECTED":
            found = [(obj, "") for obj in context.selected_objects if obj.type == "EMPTY"]
            bones = context.selected_pose_bones or ()
            found += [(bone.id_data, bone.name) for bone in bones]
            if not found:
                raise SinewError("Select empties, or bones in Pose Mode, together with the object to move")
            return False, found
        others = [
            obj for obj in context.selected_objects if obj not in (active, None) and obj.type != "EMPTY"
        ]
        if self.source == "POINTS":
            found = [(obj, "") for obj in edit_handles_points.with_points(others)]
            if not found:
                raise SinewError(
                    "Select the object to move last, and before it those whose points are handles: meshes, "
                    "curves, hair or point clouds; for a lattice, use Empties at the Points of an Object"
                )
            return False, found
        if len(others) != 1:
            raise SinewError("Select the object to move last, and one other object, whose points are handles")
        return True, [(empty, "") for empty in edit_handles_points.empties_on(active, others[0])]


def _others(context: Context, active: Object, controls: list[tuple[Object, str]]) -> list[Object]:
    """The further selected objects that can follow the same controls, if these are empties and bones."""
    taken = {active, *(control for control, _bone in controls)}
    parents = {control.parent for control, _bone in controls if control.parent_type == "VERTEX"}
    return [
        obj
        for obj in context.selected_objects
        if obj not in taken and obj not in parents and can_be_moved(obj) and obj.library is None
    ]
