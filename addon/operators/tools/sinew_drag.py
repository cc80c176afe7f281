# SPDX-License-Identifier: GPL-3.0-or-later
"""The tool Sinew Drag: it finds what lies under the mouse, and starts the operator that drags it.

``_DRAGS`` says what each mode of the tool starts, and ``_HELD_BY`` what *Automatic* takes hold of on an
object that is moved already.
"""

import math
from collections.abc import Callable

import bpy
from bpy.props import EnumProperty
from bpy.types import Context, Event, Object, Operator

from ... import compat
from ...core.errors import SinewError
from ...core.methods import Control
from ...ids import Operators
from ...properties import DRAG_MODES, SinewDrag
from ...session.actions.control_drag import Grip
from ...session.datablocks.surface import Hit
from ...session.targets import targets
from ..arguments import once
from ..offered import Offered
from ..target import target_of
from .drag import NOTHING, handle_radius
from .under_mouse import Bone, anything_under, bone_under, grip_under, surface_under

_NEAR = 40.0  # pixels
# How near, in pixels, the mouse has to be to a control that the active deformer follows. A cage or a lattice
# moves all that is pressed, so its nearest point is meant; wires and tools move what is beside them.
_HELD_BY = {Control.CAGE: math.inf, Control.LATTICE: math.inf, Control.CURVES: _NEAR, Control.TOOLS: _NEAR}
# What is dragged where no control is that near; a new handle where nothing is said here.
_ELSE = {Control.TOOLS: "CLAY"}


def makes_handles(drag: SinewDrag, obj: Object) -> bool:
    """Whether a press on the object may make something: a cage is dragged wherever one presses."""
    deformer = obj.sinew.active
    control = None if deformer is None else deformer.definition.control
    return drag.mode != "AUTO" or not math.isinf(_HELD_BY.get(control, _NEAR))


class _Press:
    """A press on a place of the viewport, and what is found there."""

    def __init__(self, context: Context, event: Event) -> None:
        self.context, self.settings = context, context.scene.sinew.drag
        self.x, self.y = event.mouse_x, event.mouse_y

    def bone(self) -> Bone | None:
        return bone_under(self.context, self.x, self.y)

    def anything(self) -> Hit | None:
        return anything_under(self.context, self.x, self.y, self.settings.pixels)

    def found(self) -> tuple[str, object]:
        """What *Automatic* drags: the name of a drag, and what that takes hold of."""
        bone = self.bone() if self.context.mode == "POSE" else None
        if bone is not None:
            return "BONES", bone
        hit = surface_under(self.context, self.x, self.y)
        obj = target_of(self.context) if hit is None else hit.obj
        deformer = None if obj is None else obj.sinew.active
        control = None if deformer is None else deformer.definition.control
        if control in _HELD_BY:
            grip = grip_under(self.context, obj, self.x, self.y, _NEAR if hit is None else _HELD_BY[control])
            if grip is not None:
                return "CONTROL", grip
        if hit is None or not targets.is_mesh(hit.obj):
            return "POINTS", hit or self.anything()
        return _ELSE.get(control, "SURFACE"), hit


def _drag_surface(_press: _Press, settings: SinewDrag, _hit: Hit) -> set[str]:
    return bpy.ops.sinew.drag(
        "INVOKE_DEFAULT", pixels=settings.pixels, reach=settings.reach, unlimited=settings.unlimited
    )


def _drag_points(_press: _Press, settings: SinewDrag, _hit: Hit) -> set[str]:
    return bpy.ops.sinew.drag("INVOKE_DEFAULT", pixels=settings.pixels, places=True)


def _drag_clay(press: _Press, settings: SinewDrag, hit: Hit) -> set[str]:
    """The rigid core is as large as a handle would be, and the drag reaches as far."""
    if target_of(press.context) != hit.obj:
        for other in press.context.selected_objects:
            other.select_set(False)
        hit.obj.select_set(True)
        press.context.view_layer.objects.active = hit.obj
    core = handle_radius(press.context, hit, settings.pixels)
    reach = max(settings.reach, 1.05)
    return bpy.ops.sinew.tool_drag("INVOKE_DEFAULT", radius=core * reach, inner=1.0 / reach)


def _drag_bone(press: _Press, settings: SinewDrag, bone: Bone) -> set[str]:
    armature, name, _ends = bone
    press.context.view_layer.objects.active = armature
    if not compat.is_bone_selected(armature, name):
        for other in armature.pose.bones:
            compat.select_bone(armature, other.name, other.name == name)
    armature.data.bones.active = armature.data.bones[name]
    return bpy.ops.sinew.puppet_pose(
        "INVOKE_DEFAULT", armature=armature.name, bone=name, balance=settings.balance, click_pins=True
    )


def _drag_control(press: _Press, _settings: SinewDrag, grip: Grip) -> set[str]:
    """The row of the control becomes the active one, so that its reach is shown."""
    obj = target_of(press.context)
    for deformer in () if obj is None else obj.sinew.deformers:
        for number, row in enumerate(deformer.controls):
            if row.object == grip.control:
                deformer.active_control = number
    return bpy.ops.sinew.control_drag("INVOKE_DEFAULT", control=grip.control.name, point=grip.point)


_Find, _Start = Callable[[_Press], object], Callable[[_Press, SinewDrag, object], set[str]]
_NO_BONE = "There is no bone at this place - press on a bone of an armature"
# By the name of a drag: what finds what it takes hold of, what starts it, and what to say if nothing is
# there.
_DRAGS: dict[str, tuple[_Find, _Start, str]] = {
    "SURFACE": (_Press.anything, _drag_surface, NOTHING),
    "CLAY": (_Press.anything, _drag_clay, NOTHING),
    "POINTS": (_Press.anything, _drag_points, NOTHING),
    "BONES": (_Press.bone, _drag_bone, _NO_BONE),
    "CONTROL": (lambda _press: None, _drag_control, NOTHING),
}


class SINEW_OT_drag_press(Offered, Operator):
    """Drag what lies under the mouse, by the mode of the tool Sinew Drag"""

    bl_idname = Operators.DRAG_PRESS
    bl_label = "Sinew Drag"
    bl_options = {"INTERNAL"}  # what it starts has the step of undo

    @classmethod
    def refusal(cls, context: Context) -> str:
        if context.area is None or context.area.type != "VIEW_3D":
            return "Press in a 3D Viewport"
        return "" if context.mode in ("OBJECT", "POSE") else "Go to Object Mode or Pose Mode to drag"

    def invoke(self, context: Context, event: Event) -> set[str]:
        press = _Press(context, event)
        try:
            name, what = press.settings.mode, None
            if name == "AUTO":
                name, what = press.found()
            find, start, missing = _DRAGS[name]
            what = what or find(press)
            if what is None:
                self.tell({"INFO"}, missing)
                return {"CANCELLED"}
            result = start(press, press.settings, what)
        except SinewError as error:
            self.tell({"ERROR"}, str(error))
            return {"CANCELLED"}
        except RuntimeError as error:  # of the operator that was started, with its reason
            self.report({"ERROR"}, str(error).removeprefix("Error: ").strip())
            return {"CANCELLED"}
        return {"CANCELLED"} if result == {"CANCELLED"} else {"FINISHED"}


class SINEW_OT_drag_start(Offered, Operator):
    """Take the tool Sinew Drag in a mode, to press and drag in the viewport"""

    bl_idname = Operators.DRAG_START
    bl_label = "Sinew Drag"
    bl_options = {"REGISTER"}  # the choice of a tool is no step of undo

    mode: once(EnumProperty, items=DRAG_MODES).named("Drag", "Choose what pressing and dragging does")

    @classmethod
    def refusal(cls, context: Context) -> str:
        return "" if context.mode in ("OBJECT", "POSE") else "Go to Object Mode or Pose Mode to drag"

    def execute(self, context: Context) -> set[str]:
        context.scene.sinew.drag.mode = self.mode
        armature = _armature_of(target_of(context)) if self.mode == "BONES" else None
        if armature is not None and context.mode == "OBJECT":
            context.view_layer.objects.active = armature
            bpy.ops.object.mode_set("EXEC_DEFAULT", True, mode="POSE")
        return bpy.ops.wm.tool_set_by_id(name=Operators.DRAG, space_type="VIEW_3D")


def _armature_of(obj: Object | None) -> Object | None:
    """The armature whose bones move the handles of the active deformer, if it can be posed."""
    deformer = None if obj is None else obj.sinew.active
    rows = () if deformer is None else deformer.handles
    found = next((row.control for row in rows if row.bone and row.control is not None), None)
    return found if found is not None and found.library is None and found.visible_get() else None
