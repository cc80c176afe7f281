# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake and unbake."""

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty
from bpy.types import Context, Event, Object, Operator

from ... import bake
from ...ids import Operators
from ...properties import BAKE_TARGETS, SinewDeformer, field
from ..arguments import file_path, once
from ..frame_by_frame import FrameByFrame
from ..offered import OnDeformer
from ..reporting import reports_errors
from ..target import target_of

_SKIP = {"SKIP_SAVE"}

_ALL = {
    "name": "All Deformers",
    "description": "Bake all deformers of the mesh, and of the other selected meshes",
    "options": _SKIP,
}


def _chosen(context: Context, everything: bool) -> list[tuple[Object, SinewDeformer]]:
    """The active deformer, or all deformers of the mesh and of the other selected meshes."""
    target = target_of(context)
    if not everything:
        return [(target, target.sinew.active)]
    others = [obj for obj in context.selected_objects if obj != target and obj.library is None]
    return [(obj, deformer) for obj in (target, *others) for deformer in obj.sinew.deformers]


class SINEW_OT_bake(OnDeformer, FrameByFrame, Operator):
    """Store the deformed mesh frame by frame, so that it plays without the add-on, on a render farm for
    example.

    The deformer is off until Unbake
    """

    bl_idname = Operators.BAKE
    bl_label = "Bake"
    doing, did = "baking", "Baked"
    cancelled = "The bake was cancelled - everything is as it was"

    target: field(EnumProperty, items=BAKE_TARGETS, default="PC2").named(
        "Target",
        "Choose what the shapes are written to; use caches for long shots and shape keys for single poses",
    )
    filepath: file_path(
        "Path", "Choose the file to write; if empty, a file in the folder sinew_cache beside the .blend file"
    )
    all_deformers: BoolProperty(**_ALL)
    exact_keys: once(BoolProperty, default=True).named(
        "Exact Shape Keys",
        "Add one more shape key that cancels the basis, so that each frame is exact to the last bit",
    )
    again: once(BoolProperty).named(
        "Again", "Bake what is baked once more: the same frames, to the same target and file"
    )
    choose_path: BoolProperty(options={"HIDDEN", "SKIP_SAVE"})
    filter_glob: StringProperty(default="*.pc2;*.mdd;*.abc", options={"HIDDEN", "SKIP_SAVE"})
    check_existing: BoolProperty(default=True, options={"HIDDEN", "SKIP_SAVE"})

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or (
            "" if target_of(context).mode == "OBJECT" else "Go to Object Mode to bake"
        )

    def invoke(self, context: Context, _event: Event) -> set[str]:
        if bpy.app.background:
            return self.execute(context)
        self._take_last(context)
        return self._browse(context) if self.choose_path else self._begin(context)

    def _begin(self, context: Context) -> set[str]:
        return self._export(context) if self.target == "ALEMBIC" else self.begin(context)

    def execute(self, context: Context) -> set[str]:
        if self.choose_path and not bpy.app.background:  # the file browser calls this when the user confirms
            return self._bake_to_choice()
        self._take_last(context)
        return self._export(context) if self.target == "ALEMBIC" else self.run(context)

    def _take_last(self, context: Context) -> None:
        """Where it is to bake again, take the target and the frames of the last bake."""
        bake = target_of(context).sinew.active.bake
        if self.again and bake.is_baked:
            self.target, self.step, self.exact_keys = bake.result, bake.step, bake.exact_keys
            self.frame_start, self.frame_end = bake.first, bake.last
            self.again = False  # what is adjusted afterwards counts

    def draw(self, _context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "target")
        self.draw_frames()
        if self.target == "SHAPE_KEYS":
            layout.prop(self, "exact_keys")

    def job(self, context: Context) -> bake.Baking:
        return bake.Baking(self._request(context), context.scene)

    def _request(self, context: Context) -> bake.Request:
        chosen = _chosen(context, self.all_deformers)
        if self.all_deformers:  # a deformer that is not bound has nothing to bake
            chosen = [pair for pair in chosen if pair[1].is_bound] or chosen
        return bake.Request(
            tuple((obj.name, deformer.uid) for obj, deformer in chosen),
            self.target,
            self.frames(context),
            self.filepath,
            self.exact_keys,
        )

    @reports_errors
    def _export(self, context: Context) -> set[str]:
        objects = list(dict.fromkeys(obj for obj, _deformer in _chosen(context, self.all_deformers)))
        path = bake.export_alembic(context, objects, self.frames(context), self.filepath)
        self.tell({"INFO"}, f"Wrote {path}")
        return {"FINISHED"}

    def _browse(self, context: Context) -> set[str]:
        """Let the user choose the path in a file browser, which starts with the last or the default path."""
        obj = target_of(context)
        self.frames(context)
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


class SINEW_OT_unbake(OnDeformer, Operator):
    """Let the deformer follow its controls again, and remove what Bake added to the mesh"""

    bl_idname = Operators.UNBAKE
    bl_label = "Unbake"

    all_deformers: BoolProperty(**_ALL)
    delete_file: once(BoolProperty).named(
        "Delete File", "Delete the cache file too, which undo cannot bring back"
    )

    @classmethod
    def refusal(cls, context: Context) -> str:
        reason = super().refusal(context)
        if reason:
            return reason
        target = target_of(context)
        if target.mode != "OBJECT":
            return "Go to Object Mode to unbake"
        return (
            "" if any(deformer.bake.is_baked for deformer in target.sinew.deformers) else "Nothing is baked"
        )

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        chosen = _chosen(context, self.all_deformers)
        if self.all_deformers:
            chosen = [pair for pair in chosen if pair[1].bake.is_baked]
        warnings = [line for obj, deformer in chosen for line in bake.unbake(obj, deformer, self.delete_file)]
        for line in warnings:
            self.tell({"WARNING"}, line)
        return {"FINISHED"}


class SINEW_OT_bake_find(OnDeformer, Operator):
    """Choose where the baked file is now, if it was moved or renamed"""

    bl_idname = Operators.BAKE_FIND
    bl_label = "Find File"

    filepath: file_path("Path", "Choose the file to play")
    filter_glob: StringProperty(default="*.pc2;*.mdd", options={"HIDDEN", "SKIP_SAVE"})

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or (
            "" if target_of(context).sinew.active.bake.filepath else "Nothing is baked to a file"
        )

    def invoke(self, context: Context, _event: Event) -> set[str]:
        self.filepath = self.filepath or target_of(context).sinew.active.bake.filepath
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        bake.play_instead(obj, obj.sinew.active, self.filepath)
        return {"FINISHED"}
