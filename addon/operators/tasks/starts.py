# SPDX-License-Identifier: GPL-3.0-or-later
"""What each task does when it is started: it picks from what is selected, and calls the operator for that."""

from collections.abc import Callable
from dataclasses import dataclass

import bpy
from bpy.types import Context, Object

from ...core.errors import SinewError
from ...core.methods import BY_ID
from ...core.tasks import Task
from ...ids import Operators
from ...session.actions import deformers, picking, rigging, selection
from ...session.actions.handles.handles import NewRegion
from ...session.targets import targets
from ..target import object_mode, selected_targets, target_of
from .refusals import armature_for, curves_for, subject_of, twin_for


@dataclass(frozen=True)
class Start:
    """A task that is started with a method; ``call`` is how operators are called: INVOKE_DEFAULT or
    EXEC_DEFAULT. ``tells`` reports to the artist.
    """

    context: Context
    task: Task
    method: str
    call: str
    tells: Callable[[set[str], str], None]

    def operator(self, name: str, **values: object) -> set[str]:
        """Call one of our operators, which makes the undo step, and whose settings can be adjusted after."""
        verb = name.partition(".")[2]
        refusal = getattr(bpy.types, f"SINEW_OT_{verb}").refusal(self.context)
        if refusal:
            raise SinewError(refusal)
        return getattr(bpy.ops.sinew, verb)(self.call, True, **values)

    def run(self) -> set[str]:
        """Start it."""
        return _STARTS[self.task.id](self)


def _press(start: Start) -> set[str]:
    """The selection of Edit Mode becomes a handle. Otherwise Sinew Drag makes one where it is pressed."""
    obj = target_of(start.context)
    _deformer, is_new = picking.deformer_for(obj, start.task, start.method)
    if obj.mode != "EDIT":
        return _dragging(start)
    return _unless_refused(obj, is_new, start.operator(Operators.HANDLE_ADD, kind="HANDLE"))


def _sheet(start: Start) -> set[str]:
    """The border holds still, unless the sheet has none."""
    obj = target_of(start.context)
    deformer, _is_new = picking.deformer_for(obj, start.task, start.method)
    is_pulled = obj.mode == "EDIT"
    with object_mode(start.context, obj):
        held = set(picking.border(obj).tolist())
        if is_pulled:
            held -= set(picking.selected_vertices(obj).tolist())
        if held and not len(deformer.handles):
            group = selection.group_of(obj, "Border", sorted(held))
            rigging.rig_region(obj, NewRegion("FIXED", group, owns_group=True))
    started = _press(start)
    if not held:
        start.tells({"INFO"}, "A closed body has no border to hold - Bend a Limb keeps it rounder")
    return started


def _unless_refused(obj: Object, is_new: bool, made: set[str]) -> set[str]:
    """Remove the new deformer again that an operator made no handles for."""
    if is_new and made == {"CANCELLED"}:
        deformers.remove_deformer(obj, len(obj.sinew.deformers) - 1)
    return made


def _dragging(start: Start, mode: str = "SURFACE") -> set[str]:
    """Take up Sinew Drag in a mode, which needs Object Mode and a window."""
    obj = target_of(start.context)
    if start.context.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    if not bpy.app.background:
        start.operator(Operators.DRAG_START, mode=mode)
    bpy.ops.ed.undo_push(message=start.task.label)
    start.tells({"INFO"}, f"Press on {obj.name} and drag")
    return {"FINISHED"}


def _box(start: Start) -> set[str]:
    obj = target_of(start.context)
    lattices = [other for other in start.context.selected_objects if other.type == "LATTICE" and other != obj]
    if len(lattices) == 1:
        return start.operator(Operators.LATTICE_ADD, source="OBJECT", lattice=lattices[0].name)
    counts = picking.lattice_counts(selected_targets(start.context, obj))
    return start.operator(Operators.LATTICE_ADD, source="FIT", shape="BOX", resolution=counts)


def _cage(start: Start) -> set[str]:
    obj = target_of(start.context)
    around = [other for other in start.context.selected_objects if other != obj]
    cages = [other for other in around if picking.encloses(other, obj)]
    if len(cages) == 1:
        return start.operator(Operators.CAGE_ADD, method=start.method, source="OBJECT", cage=cages[0].name)
    faces = picking.cage_faces(selected_targets(start.context, obj))
    return start.operator(Operators.CAGE_ADD, method=start.method, source="AUTO", faces=faces)


def _parts(start: Start) -> set[str]:
    """Selected empties and bones move them. Otherwise Sinew Drag makes handles where it is pressed."""
    context, obj = start.context, target_of(start.context)
    _deformer, is_new = picking.deformer_for(obj, start.task, start.method)
    empties = any(other.type == "EMPTY" for other in context.selected_objects)
    if not (empties or context.selected_pose_bones):
        return _dragging(start, "POINTS")
    others = {} if BY_ID[start.method].wraps else {"method": start.method}  # of other selected objects
    return _unless_refused(obj, is_new, start.operator(Operators.POINT_ADD, source="SELECTED", **others))


def _lines(start: Start) -> set[str]:
    """Along selected edges, else selected curves, else a stroke."""
    obj = target_of(start.context)
    if obj.mode == "EDIT" and targets.is_mesh(obj) and obj.data.total_edge_sel:
        return start.operator(Operators.WIRE_ADD, source="EDGES")
    if curves_for(start.context, obj):
        return start.operator(Operators.WIRE_ADD, source="CURVES")
    return start.operator(Operators.WIRE_DRAW)


def _clay(start: Start) -> set[str]:
    """Drag the surface. What has none, and scripts, get a tool in the middle."""
    obj = target_of(start.context)
    if targets.is_mesh(obj) and start.call == "INVOKE_DEFAULT":
        return _dragging(start, "CLAY")
    return start.operator(Operators.TOOL_ADD, tool="drag", location=_middle(obj))


def _figure(start: Start) -> set[str]:
    obj = subject_of(start.context)
    armature = armature_for(start.context, obj)
    names = [bone.name for bone in armature.data.bones if bone.use_deform]
    everywhere = picking.overlap_all_over(obj, names)
    return start.operator(
        Operators.PUPPET_RIG, armature=armature.name, method=start.method, automatic=everywhere
    )


def _morph(start: Start) -> set[str]:
    return start.operator(Operators.MORPH, target=twin_for(start.context, target_of(start.context)).name)


def _once(start: Start) -> set[str]:
    in_edit_mode = target_of(start.context).mode == "EDIT"
    return start.operator(Operators.GRAB_REGION if in_edit_mode else Operators.SILHOUETTE_SKETCH)


def _middle(obj: Object) -> tuple[float, float, float]:
    corners = picking.box_corners(obj)
    return tuple(sum(corner[axis] for corner in corners) / len(corners) for axis in range(3))


_STARTS: dict[str, Callable[[Start], set[str]]] = {  # by the task
    "limb": _press,
    "joint": _press,
    "sheet": _sheet,
    "box": _box,
    "cage": _cage,
    "parts": _parts,
    "lines": _lines,
    "clay": _clay,
    "figure": _figure,
    "animation": _press,
    "morph": _morph,
    "once": _once,
}
