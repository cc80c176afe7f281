# SPDX-License-Identifier: GPL-3.0-or-later
"""Move deformers and handles up and down in their lists."""

from bpy.props import EnumProperty
from bpy.types import Context, Object, Operator

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


class _Moves(OnDeformer):
    """Moves a row of a list by one place."""

    direction: field(EnumProperty, items=DIRECTIONS).named(
        "Direction", "Choose whether to move up or down in the list"
    )

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        index, count = self.place(obj)
        target = _neighbour(index, self.direction, count)
        if target < 0:
            return {"CANCELLED"}
        self.move(obj, index, target)
        return {"FINISHED"}


class SINEW_OT_deformer_move(_Moves, Operator):
    """Move the deformer in the list, and its modifier in the stack. The upper deformer is applied first.

    Other modifiers keep their places; keyframes and drivers move with their deformer
    """

    bl_idname = Operators.DEFORMER_MOVE
    bl_label = "Move Deformer"

    index: row_index("Choose which deformer; -1 is the active one")

    def place(self, obj: Object) -> tuple[int, int]:
        return deformer_index(obj, self.index), len(obj.sinew.deformers)

    def move(self, obj: Object, index: int, target: int) -> None:
        order.move_deformer(obj, index, target)


class SINEW_OT_handle_move(_Moves, Operator):
    """Move the region in the list. The order does not affect the shape"""

    bl_idname = Operators.HANDLE_MOVE
    bl_label = "Move Handle"

    index: row_index("Choose which handle; -1 is the active one")

    def place(self, obj: Object) -> tuple[int, int]:
        deformer = obj.sinew.active
        return handle_index(deformer, self.index), len(deformer.handles)

    def move(self, obj: Object, index: int, target: int) -> None:
        order.move_handle(obj, obj.sinew.active, index, target)
