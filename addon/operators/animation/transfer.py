# SPDX-License-Identifier: GPL-3.0-or-later
"""Deformation transfer from one mesh to another."""

import bpy
from bpy.props import StringProperty
from bpy.types import Context, Event, Object, Operator

from ... import bake
from ...core.errors import SinewError
from ...ids import Operators
from ..arguments import file_path, once
from ..frame_by_frame import FrameByFrame
from ..offered import Offered
from ..target import LINKED


class SINEW_OT_transfer_deformation(Offered, FrameByFrame, Operator):
    """Deform the active mesh as the other selected mesh is deformed, frame by frame.

    Both have the same faces, and other proportions. A Mesh Cache modifier plays the result
    """

    bl_idname = Operators.TRANSFER
    bl_label = "Copy the Motion"
    doing, did = "transferring", "Transferred"
    cancelled = "The transfer was cancelled - everything is as it was"

    source: once(StringProperty).named(
        "Source",
        "Give the name of the mesh object that is deformed already; if empty, the other selected one",
    )
    filepath: file_path(
        "Path", "Choose the PC2 file to write; if empty, one in the folder sinew_cache beside the .blend file"
    )

    @classmethod
    def refusal(cls, context: Context) -> str:
        obj = context.object
        if obj is None or obj.type != "MESH":
            return "Select the mesh that is deformed, then the one to deform"
        if obj.library is not None:
            return LINKED
        return "" if obj.mode == "OBJECT" else "Go to Object Mode to transfer"

    def invoke(self, context: Context, _event: Event) -> set[str]:
        return self.execute(context) if bpy.app.background else self.begin(context)

    def execute(self, context: Context) -> set[str]:
        return self.run(context)

    def draw(self, _context: Context) -> None:
        self.layout.use_property_split = True
        self.layout.prop_search(self, "source", bpy.data, "objects")
        self.draw_frames()

    def job(self, context: Context) -> bake.Transferring:
        return bake.Transferring(
            self._source(context), context.object, context.scene, self.frames(context), self.filepath
        )

    def _source(self, context: Context) -> Object:
        if self.source:
            found = bpy.data.objects.get(self.source)
            if found is None:
                raise SinewError(f"There is no object {self.source}")
            return found
        others = [obj for obj in context.selected_objects if obj != context.object]
        if len(others) != 1:
            raise SinewError("Select the mesh that is deformed, then the one to deform, and no other object")
        self.source = others[0].name
        return others[0]
