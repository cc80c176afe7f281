# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake and unbake. With a window, a bake runs between redraws, with its progress in the status bar."""

import time

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty
from bpy.types import Context, Event, Object, Operator

from .. import bake
from ..core.errors import SinewError
from ..ids import Operators
from ..properties import BAKE_TARGETS, MAX_FRAME, SinewDeformer
from .reporting import reports_errors
from .target import has_deformer, target_of

CANCELLED = "The bake was cancelled - everything is as it was"
_SLICE = 0.1  # seconds for which frames are baked between two redraws
_PAUSE = 0.01  # seconds to wait for a thread, if there is no timer
_SKIP = {"SKIP_SAVE"}

_ALL = {
    "name": "All Deformers",
    "description": "All deformers of the mesh, and of the other selected meshes",
    "options": _SKIP,
}


def _chosen(context: Context, everything: bool) -> list[tuple[Object, SinewDeformer]]:
    """The active deformer, or all deformers of the mesh and of the other selected meshes."""
    target = target_of(context)
    if not everything:
        return [(target, target.sinew.active)]
    others = [obj for obj in context.selected_objects if obj != target and obj.library is None]
    return [(obj, deformer) for obj in (target, *others) for deformer in obj.sinew.deformers]


class SINEW_OT_bake(Operator):
    """Store the deformed mesh frame by frame, so that it plays without the add-on, on a render farm for
    example.

    The deformer is off until Unbake
    """

    bl_idname = Operators.BAKE
    bl_label = "Bake"
    bl_options = {"REGISTER", "UNDO"}

    target: EnumProperty(
        name="Target",
        items=BAKE_TARGETS,
        default="PC2",
        description="What the shapes are written to. Use caches for long shots and shape keys for single "
        "poses",
    )
    frame_start: IntProperty(
        name="Start",
        min=-MAX_FRAME,
        max=MAX_FRAME,
        description="First frame; if it is not given, the first frame of the scene",
        options=_SKIP,
    )
    frame_end: IntProperty(
        name="End",
        min=-MAX_FRAME,
        max=MAX_FRAME,
        description="Last frame; if it is not given, the last frame of the scene",
        options=_SKIP,
    )
    step: IntProperty(
        name="Step",
        default=1,
        min=1,
        description="Bake every n-th frame; the frames between are blended",
        options=_SKIP,
    )
    filepath: StringProperty(
        name="Path",
        subtype="FILE_PATH",
        description="The file to write; if empty, a file in the folder sinew_cache beside the .blend file",
        options=_SKIP,
    )
    all_deformers: BoolProperty(**_ALL)
    exact_keys: BoolProperty(
        name="Exact Shape Keys",
        default=True,
        description="Add one more shape key that cancels the basis, so that each frame is exact to the "
        "last bit",
        options=_SKIP,
    )
    choose_path: BoolProperty(options={"HIDDEN", "SKIP_SAVE"})
    filter_glob: StringProperty(default="*.pc2;*.mdd;*.abc", options={"HIDDEN", "SKIP_SAVE"})
    check_existing: BoolProperty(default=True, options={"HIDDEN", "SKIP_SAVE"})

    @classmethod
    def poll(cls, context: Context) -> bool:
        if not has_deformer(cls, context):
            return False
        if target_of(context).mode != "OBJECT":
            cls.poll_message_set("Go to Object Mode to bake")
            return False
        return True

    def invoke(self, context: Context, _event: Event) -> set[str]:
        if bpy.app.background:
            return self.execute(context)
        return self._browse(context) if self.choose_path else self._begin(context)

    @reports_errors
    def _begin(self, context: Context) -> set[str]:
        if self.target == "ALEMBIC":
            return self._export(context)
        self._baking = bake.Baking(self._request(context), context.scene)
        manager = context.window_manager
        manager.progress_begin(0, self._baking.total)
        self._timer = manager.event_timer_add(0.01, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: Event) -> set[str]:
        if event.type == "ESC" and event.value == "PRESS":
            self._baking.cancel()
            self._end_modal(context)
            self.report({"WARNING"}, CANCELLED)
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}  # edits during a bake would change what it bakes
        try:
            has_more = self._bake_frames(context)
            if has_more:
                return {"RUNNING_MODAL"}
            self._finish(self._baking)
        except SinewError as error:
            self._baking.cancel()
            self._end_modal(context)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._end_modal(context)
        return {"FINISHED"}

    def cancel(self, context: Context) -> None:
        """Blender ends the operator, because another file is opened or the window is closed."""
        if hasattr(self, "_baking"):
            self._baking.cancel()
            self._end_modal(context)

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        if self.choose_path and not bpy.app.background:  # the file browser calls this when the user confirms
            return self._bake_to_choice()
        baking = None
        try:
            if self.target == "ALEMBIC":
                return self._export(context)
            baking = bake.Baking(self._request(context), context.scene)
            done = -1
            while baking.step():
                if baking.done == done:
                    time.sleep(_PAUSE)
                done = baking.done
            self._finish(baking)
        finally:
            if baking is not None:
                baking.cancel()
        return {"FINISHED"}

    def draw(self, _context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "target")
        frames = layout.column(align=True)
        for name in ("frame_start", "frame_end", "step"):
            frames.prop(self, name)
        if self.target == "SHAPE_KEYS":
            layout.prop(self, "exact_keys")

    def _request(self, context: Context) -> bake.Request:
        chosen = _chosen(context, self.all_deformers)
        if self.all_deformers:  # a deformer that is not bound has nothing to bake
            chosen = [pair for pair in chosen if pair[1].is_bound] or chosen
        return bake.Request(
            tuple((obj.name, deformer.uid) for obj, deformer in chosen),
            self.target,
            self._frames(context),
            self.filepath,
            self.exact_keys,
        )

    def _frames(self, context: Context) -> range:
        """The frames to bake. Those of the scene are used if none are given."""
        for name in ("frame_start", "frame_end"):
            if not self.properties.is_property_set(name):
                setattr(self, name, getattr(context.scene, name))
        return range(self.frame_start, self.frame_end + 1, self.step)

    def _bake_frames(self, context: Context) -> bool:
        """Bake some frames and show the progress; True while there are more."""
        begin, baking = time.perf_counter(), self._baking
        done, has_more = -1, True
        while has_more and done != baking.done and time.perf_counter() - begin < _SLICE:
            done = baking.done
            has_more = baking.step()
        context.window_manager.progress_update(baking.done)
        context.workspace.status_text_set(
            f"Sinew is baking: {baking.done} of {baking.total} frames   (Esc cancels)"
        )
        return has_more

    def _end_modal(self, context: Context) -> None:
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)

    def _finish(self, baking: bake.Baking) -> None:
        warnings = baking.finish()
        for line in warnings:
            self.report({"WARNING"}, line)
        if not warnings:
            plural = "" if baking.total == 1 else "s"
            self.report({"INFO"}, f"Baked {baking.total} frame{plural}")

    def _export(self, context: Context) -> set[str]:
        objects = list(dict.fromkeys(obj for obj, _deformer in _chosen(context, self.all_deformers)))
        path = bake.export_alembic(context, objects, self._frames(context), self.filepath)
        self.report({"INFO"}, f"Wrote {path}")
        return {"FINISHED"}

    def _browse(self, context: Context) -> set[str]:
        """Let the user choose the path in a file browser, which starts with the last or the default path."""
        obj = target_of(context)
        self._frames(context)
        self.filepath = self.filepath or bake.offered_path(obj, obj.sinew.active, self.target)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def _bake_to_choice(self) -> set[str]:
        """Start a bake that shows its progress, with the path from the file browser."""
        bpy.ops.sinew.bake(
            "INVOKE_DEFAULT",
            target=self.target,
            frame_start=self.frame_start,
            frame_end=self.frame_end,
            step=self.step,
            filepath=self.filepath,
            all_deformers=self.all_deformers,
        )
        return {"CANCELLED"}  # undo records the bake that was just started, not this call


class SINEW_OT_unbake(Operator):
    """Let the deformer follow its controls again, and remove what Bake added to the mesh"""

    bl_idname = Operators.UNBAKE
    bl_label = "Unbake"
    bl_options = {"REGISTER", "UNDO"}

    all_deformers: BoolProperty(**_ALL)
    delete_file: BoolProperty(
        name="Delete File",
        description="Delete the cache file too, which undo cannot bring back",
        options=_SKIP,
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        if not has_deformer(cls, context):
            return False
        target = target_of(context)
        if target.mode != "OBJECT":
            cls.poll_message_set("Go to Object Mode to unbake")
            return False
        if not any(deformer.bake.is_baked for deformer in target.sinew.deformers):
            cls.poll_message_set("Nothing is baked")
            return False
        return True

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        chosen = _chosen(context, self.all_deformers)
        if self.all_deformers:
            chosen = [pair for pair in chosen if pair[1].bake.is_baked]
        warnings = [line for obj, deformer in chosen for line in bake.unbake(obj, deformer, self.delete_file)]
        for line in warnings:
            self.report({"WARNING"}, line)
        return {"FINISHED"}
