# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake and unbake. With a window a bake goes on between redraws: progress in the status bar, Esc cancels."""

import time

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty
from bpy.types import Context, Event, Object, Operator

from .. import bake
from ..core.errors import SinewError
from ..ids import Operators
from ..properties import BAKE_TARGETS, MAX_FRAME, SinewDeformer
from .refusing import refusing
from .target import has_deformer, target_of

CANCELLED = "The bake was cancelled - everything is as it was"
_SLICE = 0.1  # seconds of frames between two redraws
_BREATH = 0.01  # seconds to wait for a thread, without a timer
_SKIP = {"SKIP_SAVE"}

_ALL = {
    "name": "All Deformers",
    "description": "All deformers of the mesh, and of the other selected meshes",
    "options": _SKIP,
}


def _chosen(context: Context, everything: bool) -> list[tuple[Object, SinewDeformer]]:
    """The deformers to work on: the active one, or all of the mesh and of the other selected ones."""
    target = target_of(context)
    if not everything:
        return [(target, target.sinew.active)]
    others = [obj for obj in context.selected_objects if obj != target and obj.library is None]
    return [(obj, deformer) for obj in (target, *others) for deformer in obj.sinew.deformers]


class SINEW_OT_bake(Operator):
    """Store the deformed mesh frame by frame, so that it plays without the add-on, on a farm or elsewhere.

    The deformer rests until Unbake
    """

    bl_idname = Operators.BAKE
    bl_label = "Bake"
    bl_options = {"REGISTER", "UNDO"}

    target: EnumProperty(
        name="Target",
        items=BAKE_TARGETS,
        default="PC2",
        description="What the shapes are written to. Caches suit long shots, shape keys single poses",
    )
    frame_start: IntProperty(
        name="Start",
        min=-MAX_FRAME,
        max=MAX_FRAME,
        description="First frame; the scene's where it is not given",
        options=_SKIP,
    )
    frame_end: IntProperty(
        name="End",
        min=-MAX_FRAME,
        max=MAX_FRAME,
        description="Last frame; the scene's where it is not given",
        options=_SKIP,
    )
    step: IntProperty(
        name="Step",
        default=1,
        min=1,
        description="Bake every so many frames; those between are blended",
        options=_SKIP,
    )
    filepath: StringProperty(
        name="Path",
        subtype="FILE_PATH",
        description="The file to write; none means the folder sinew_cache beside the .blend",
        options=_SKIP,
    )
    all_deformers: BoolProperty(**_ALL)
    exact_keys: BoolProperty(
        name="Exact Shape Keys",
        default=True,
        description="One more shape key takes the basis out, so that each frame is right to the last bit",
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

    @refusing
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
            return {"RUNNING_MODAL"}  # edits in the middle of a bake would come into it
        try:
            going_on = self._slice(context)
            if going_on:
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
        """Blender ends us: another file is opened, or the window closed."""
        if hasattr(self, "_baking"):
            self._baking.cancel()
            self._end_modal(context)

    @refusing
    def execute(self, context: Context) -> set[str]:
        if self.choose_path and not bpy.app.background:  # the file browser comes back here
            return self._bake_to_choice()
        baking = None
        try:
            if self.target == "ALEMBIC":
                return self._export(context)
            baking = bake.Baking(self._request(context), context.scene)
            done = -1
            while baking.step():
                if baking.done == done:
                    time.sleep(_BREATH)
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
        if self.all_deformers:  # what shows the rest shape has nothing to bake
            chosen = [pair for pair in chosen if pair[1].is_bound] or chosen
        return bake.Request(
            tuple((obj.name, deformer.uid) for obj, deformer in chosen),
            self.target,
            self._frames(context),
            self.filepath,
            self.exact_keys,
        )

    def _frames(self, context: Context) -> range:
        """The frames asked for; the scene's where they are not given."""
        for name in ("frame_start", "frame_end"):
            if not self.properties.is_property_set(name):
                setattr(self, name, getattr(context.scene, name))
        return range(self.frame_start, self.frame_end + 1, self.step)

    def _slice(self, context: Context) -> bool:
        """Some frames, and a word about them; True while there are more."""
        begin, baking = time.perf_counter(), self._baking
        done, going_on = -1, True
        while going_on and done != baking.done and time.perf_counter() - begin < _SLICE:
            done = baking.done
            going_on = baking.step()
        context.window_manager.progress_update(baking.done)
        context.workspace.status_text_set(
            f"Sinew bakes: {baking.done} of {baking.total} frames   (Esc cancels)"
        )
        return going_on

    def _end_modal(self, context: Context) -> None:
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)

    def _finish(self, baking: bake.Baking) -> None:
        said = baking.finish()
        for line in said:
            self.report({"WARNING"}, line)
        if not said:
            plural = "" if baking.total == 1 else "s"
            self.report({"INFO"}, f"Baked {baking.total} frame{plural}")

    def _export(self, context: Context) -> set[str]:
        objects = list(dict.fromkeys(obj for obj, _deformer in _chosen(context, self.all_deformers)))
        path = bake.export_alembic(context, objects, self._frames(context), self.filepath)
        self.report({"INFO"}, f"Wrote {path}")
        return {"FINISHED"}

    def _browse(self, context: Context) -> set[str]:
        """Let the user choose the path; the last or the default one is offered."""
        obj = target_of(context)
        self._frames(context)
        self.filepath = self.filepath or bake.offered_path(obj, obj.sinew.active, self.target)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def _bake_to_choice(self) -> set[str]:
        """Bake with progress, as without the file browser."""
        bpy.ops.sinew.bake(
            "INVOKE_DEFAULT",
            target=self.target,
            frame_start=self.frame_start,
            frame_end=self.frame_end,
            step=self.step,
            filepath=self.filepath,
            all_deformers=self.all_deformers,
        )
        return {"CANCELLED"}  # the other one is what undo knows


class SINEW_OT_unbake(Operator):
    """Follow the controls again, and remove what Bake added to the mesh"""

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

    @refusing
    def execute(self, context: Context) -> set[str]:
        chosen = _chosen(context, self.all_deformers)
        if self.all_deformers:
            chosen = [pair for pair in chosen if pair[1].bake.is_baked]
        said = [line for obj, deformer in chosen for line in bake.unbake(obj, deformer, self.delete_file)]
        for line in said:
            self.report({"WARNING"}, line)
        return {"FINISHED"}
