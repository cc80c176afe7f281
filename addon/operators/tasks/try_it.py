# SPDX-License-Identifier: GPL-3.0-or-later
"""Try It: open a small rig as a scene of its own, and go back. What the artist works on stays as it is."""

from collections.abc import Iterable
from math import radians

import bpy
from bpy.props import EnumProperty
from bpy.types import Area, Context, Object, Operator, Region, Scene, SpaceView3D, Window
from mathutils import Euler, Vector

from ...backend import availability
from ...core.memory import remember
from ...core.rigs import RIG_BY_ID, RIGS, Rig
from ...ids import Operators
from ...session.actions import picking, try_it
from ..arguments import once
from ..offered import Offered
from ..reporting import reporting_for, reports_errors

# What is set in a viewport when a rig opens, and put back in the opposite order when it closes: what colours
# there are depends on the type of the shading.
_VIEW = (
    "region_3d.view_perspective",
    "region_3d.view_rotation",
    "region_3d.view_location",
    "region_3d.view_distance",
    "shading.type",
    "shading.color_type",
    "overlay.show_overlays",
)
_views: dict[str, list] = remember({})  # what viewports and the tool were before, by the name of the scene


class SINEW_OT_try_it(Offered, Operator):
    """Open a small rig to try Sinew on, as a scene of its own: yours stays as it is"""

    bl_idname = Operators.TRY_IT
    bl_label = "Try It"
    bl_options = {"UNDO", "INTERNAL"}

    rig: once(
        EnumProperty,
        items=tuple((rig.id, rig.label, rig.purpose, rig.icon, number) for number, rig in enumerate(RIGS)),
        default=RIGS[0].id,
    ).named("Rig", "Choose what to try")

    @classmethod
    def description(cls, _context: Context, properties: "SINEW_OT_try_it") -> str:
        """The tooltip: what the rig is."""
        return RIG_BY_ID[properties.rig].purpose

    @classmethod
    def refusal(cls, _context: Context) -> str:
        found = availability()
        return found.remedy if found.module is None else ""

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        rig, before, window = RIG_BY_ID[self.rig], context.scene, context.window
        _leave_mode(context)
        scene, objects = try_it.bring(rig)
        was_rig = try_it.rig_of(before) is not None
        scene.sinew.came_from = before.sinew.came_from if was_rig else before
        _views[scene.name] = _views.pop(before.name, []) if was_rig else _remembered(context, window)
        window.scene = scene
        if was_rig:
            _close(before, scene)
        with reporting_for(self):
            _set_up(context, rig, objects)
        if not bpy.app.background:
            _frame(window, rig, objects.values())
            if rig.drags:
                bpy.ops.sinew.drag_start(mode="AUTO")
        self.tell({"INFO"}, f"{rig.label}: the steps are in the Sinew tab of the sidebar")
        return {"FINISHED"}


class SINEW_OT_try_back(Offered, Operator):
    """Go back to the scene that you came from, and remove this rig with all that belongs to it"""

    bl_idname = Operators.TRY_BACK
    bl_label = "Back to My Scene"
    bl_options = {"UNDO", "INTERNAL"}

    @classmethod
    def refusal(cls, context: Context) -> str:
        return "" if try_it.rig_of(context.scene) else "This scene is none that Try It has opened"

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        scene = context.scene
        _put_back(context, _views.pop(scene.name, []))
        others = [other for other in bpy.data.scenes if other != scene]
        former = scene.sinew.came_from or (others[0] if others else bpy.data.scenes.new("Scene"))
        context.window.scene = former
        _close(scene, former)
        return {"FINISHED"}


def _leave_mode(context: Context) -> None:
    if context.object is not None and context.object.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")


def _close(scene: Scene, instead: Scene) -> None:
    """Remove the scene of a rig. Windows that show it go to another one."""
    for window in bpy.context.window_manager.windows:
        if window.scene == scene:
            window.scene = instead
    try_it.remove(scene)


def _set_up(context: Context, rig: Rig, objects: dict[str, Object]) -> None:
    """Let operators set the rig up, as an artist would, and select what the first step is about."""
    body, scene = objects[rig.objects[0]], context.scene
    for verb, values in rig.setup:
        _choose(context, body)
        named = {name: objects[value].name if value in objects else value for name, value in values.items()}
        getattr(bpy.ops.sinew, verb)(**named)
    for deformer in body.sinew.deformers:
        deformer.active_handle = 0
    scene.sinew.show_overlay = rig.coloured
    _choose(context, objects[rig.posing] if rig.posing else body)
    if rig.posing:
        bpy.ops.object.mode_set(mode="POSE")


def _choose(context: Context, obj: Object) -> None:
    for other in context.selected_objects:
        other.select_set(False)
    obj.select_set(True)
    context.view_layer.objects.active = obj


def _viewports(window: Window) -> list[Area]:
    return [area for area in window.screen.areas if area.type == "VIEW_3D"]


def _main_region(area: Area) -> Region:
    return next(region for region in area.regions if region.type == "WINDOW")


def _frame(window: Window, rig: Rig, objects: Iterable[Object]) -> None:
    """Let all viewports show the rig, in solid shading with its own colours."""
    shown = bpy.context.evaluated_depsgraph_get()
    meshes = [obj.evaluated_get(shown) for obj in objects if obj.type == "MESH"]
    corners = [corner for obj in meshes for corner in picking.box_corners(obj)]
    low, high = (Vector(map(end, zip(*corners))) for end in (min, max))
    size, (above, around) = max(high - low), rig.view
    for area in _viewports(window):
        region = _main_region(area)
        seen = size * rig.room * max(1.0, region.width / region.height)
        space = area.spaces.active
        view = space.region_3d
        view.view_perspective = "PERSP"
        view.view_rotation = Euler((radians(90.0 - above), 0.0, radians(around))).to_quaternion()
        view.view_location = (low + high) / 2.0
        view.view_distance = seen * space.lens / 72.0
        space.shading.type, space.shading.color_type = "SOLID", "VERTEX"
        space.overlay.show_overlays = True


def _remembered(context: Context, window: Window) -> list:
    """What is to be put back: of each viewport, and the tools."""
    if bpy.app.background:
        return []
    kept: list = []
    for area in _viewports(window):
        space = area.spaces.active
        if space.local_view:  # nothing of another scene would be in it
            with context.temp_override(window=window, area=area, region=_main_region(area)):
                bpy.ops.view3d.localview(frame_selected=False)
        shading = space.shading.type
        space.shading.type = "SOLID"
        kept.append(
            (space.as_pointer(), {path: _read(space, path) for path in _VIEW} | {"shading.type": shading})
        )
    tools = context.workspace.tools
    for mode in ("OBJECT", "POSE"):
        tool = tools.from_space_view3d_mode(mode, create=False)
        kept += [(mode, tool.idname)] if tool is not None else []
    return kept


def _put_back(context: Context, kept: list) -> None:
    """Put back what a rig has changed in the viewports, and leave its mode."""
    held = dict(kept)
    for mode in ("POSE", "OBJECT"):
        if context.mode == mode and mode in held:
            bpy.ops.wm.tool_set_by_id(name=held[mode], space_type="VIEW_3D")
        _leave_mode(context)
    for window in context.window_manager.windows if held else ():
        for space in (area.spaces.active for area in _viewports(window)):
            for path, value in reversed(held.get(space.as_pointer(), {}).items()):
                owner, _dot, name = path.partition(".")
                setattr(getattr(space, owner), name, value)


def _read(space: SpaceView3D, path: str) -> object:
    owner, _dot, name = path.partition(".")
    value = getattr(getattr(space, owner), name)
    return value.copy() if hasattr(value, "copy") else value
