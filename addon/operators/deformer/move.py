# SPDX-License-Identifier: GPL-3.0-or-later
"""Move deformers and handles up and down in their lists."""

from bpy.props import EnumProperty
from bpy.types import Context, Operator

from ...ids import Operators
from ...properties import field
from ...session.actions import order
from ..arguments import row_index
from ..offered import OnDeformer
from ..reporting import reports_errors
from ..target import deformer_index, handle_index, target_of

DIRECTIONS = (
    ("UP", "Up", "Towards the top of the list", "TRIA_UP", 0),
    ("DOWN", "Down", "Towards the bottom of the list", "TRIA_DOWN", 1),
)


def _neighbour(index: int, direction: str, count: int) -> int:
    """The index of the row above or below; -1 at the end of the list."""
    target = index - 1 if direction == "UP" else index + 1
    return target if 0 <= target < count else -1


class SINEW_OT_deformer_move(OnDeformer, Operator):
    """Move the deformer in the list, and its modifier in the stack. The upper deformer is applied first.

    Other modifiers keep their places; keyframes and drivers move with their deformer
    """

    bl_idname = Operators.DEFORMER_MOVE
    bl_label = "Move Deformer"

    direction: field(EnumProperty, items=DIRECTIONS).named(
        "Direction", "Choose whether to move up or down in the list"
    )
    index: row_index("Choose which deformer; -1 is the active one")

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        index = deformer_index(obj, self.index)
        target = _neighbour(index, self.direction, len(obj.sinew.deformers))
        if target < 0:
            return {"CANCELLED"}
        order.move_deformer(obj, index, target)
        return {"FINISHED"}


class SINEW_OT_handle_move(OnDeformer, Operator):
    """Move the region in the list. The order does not affect the shape"""

    bl_idname = Operators.HANDLE_MOVE
    bl_label = "Move Handle"

    direction: field(EnumProperty, items=DIRECTIONS).named(
        "Direction", "Choose whether to move up or down in the list"
    )
    index: row_index("Choose which handle; -1 is the active one")

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        index = handle_index(deformer, self.index)
        target = _neighbour(index, self.direction, len(deformer.handles))
        if target < 0:
            return {"CANCELLED"}
        order.move_handle(obj, deformer, index, target)
        return {"FINISHED"}
