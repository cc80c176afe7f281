# SPDX-License-Identifier: GPL-3.0-or-later
"""Rings and arrows in the viewports: how far the active wire or tool of the active object reaches.

Each arrow changes one length, as its tooltip says. A drag of it is one step of undo.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from bpy.types import Context, Depsgraph, Gizmo, GizmoGroup
from bpy.utils import register_classes_factory
from mathutils import Matrix, Vector

from ...core.geometry import frames
from ...ids import Operators
from ...operators import ring
from ...operators.tools.reach_drag import LENGTHS, reach_of, world_of
from ...properties import SinewControl
from ...session.actions.controls.control_list import active_row
from ..drag_tool import is_hand_tool
from ..places import active_deformer

_HEIGHT, _WIDTH = 0.35, 0.11  # of an arrow, in units of gizmos
_ORANGE, _PALE, _WHITE = (1.0, 0.6, 0.1), (1.0, 0.8, 0.3), (1.0, 1.0, 1.0)


def rings(row: SinewControl, depsgraph: Depsgraph) -> list[np.ndarray]:
    """Lines (k, 3) of the world: the radius of a wire at its middle; the lengths of a tool."""
    reach = reach_of(row, depsgraph)
    return (
        [] if reach is None else [frames.transformed(world_of(row, depsgraph), line) for line in reach.lines]
    )


class SINEW_GT_lines(Gizmo):
    """Lines, which nothing can be done with, in the frame ``world``. ``kind``: LINE_STRIP; LINES, which are
    the pairs of their points; or TRIS, the discs that they enclose. What is drawn is made once per ``lines``.
    """

    bl_idname = "SINEW_GT_lines"
    __slots__ = ("drawn", "kind", "lines", "shapes", "world")

    def setup(self) -> None:
        self.kind = "LINE_STRIP"
        self.lines: Sequence[np.ndarray] = ()
        self.drawn: Sequence[np.ndarray] = self.lines  # what the shapes were made of
        self.shapes: list[object] = []
        self.world = Matrix.Identity(4)

    def draw(self, _context: Context) -> None:
        if self.drawn is not self.lines:
            flat = [(_disc(line) if self.kind == "TRIS" else line).tolist() for line in self.lines]
            self.shapes = [self.new_custom_shape(self.kind, points) for points in flat]
            self.drawn = self.lines
        for shape in self.shapes:
            self.draw_custom_shape(shape, matrix=self.world)


def _disc(line: np.ndarray) -> np.ndarray:
    """The corners of triangles (3 t, 3) between a closed line (t + 1, 3) and its middle."""
    middle = np.broadcast_to(line[1:].mean(axis=0), line[1:].shape)
    return np.stack((middle, line[:-1], line[1:]), axis=1).reshape(-1, 3)


class SINEW_GT_arrow(Gizmo):
    """An arrow of the same size in every view. That of Blender would move ahead of its operator."""

    bl_idname = "SINEW_GT_arrow"
    __slots__ = ("shape",)

    def setup(self) -> None:
        self.shape = self.new_custom_shape("TRIS", _cone())

    def draw(self, _context: Context) -> None:
        self.draw_custom_shape(self.shape)

    def draw_select(self, _context: Context, select_id: int) -> None:
        self.draw_custom_shape(self.shape, select_id=select_id)


def _cone() -> list[list[float]]:
    """The triangles of a cone that stands at the origin."""
    rim = ring(np.zeros(3), np.array((0.0, 0.0, 1.0)), _WIDTH)[::6]
    ends = np.array((0.0, 0.0, _HEIGHT)), np.zeros(3)
    corners = [(one, other, end) for one, other in pairwise(rim) for end in ends]
    return np.array(corners).reshape(-1, 3).tolist()


class OverViewports:
    """Where a group of gizmos is drawn: in every 3D viewport, also while an operator runs."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "WINDOW"
    bl_options = {"3D", "PERSISTENT", "SHOW_MODAL_ALL"}


class SINEW_GGT_reach(OverViewports, GizmoGroup):
    """How far the active wire or tool reaches"""

    bl_idname = "SINEW_GGT_reach"
    bl_label = "Reach of Sinew's Controls"

    @classmethod
    def poll(cls, context: Context) -> bool:
        deformer = active_deformer(context) if is_hand_tool(context) else None
        return deformer is not None and active_row(deformer) is not None

    def setup(self, _context: Context) -> None:
        self.lines = self.gizmos.new(SINEW_GT_lines.bl_idname)
        self.lines.color, self.lines.alpha, self.lines.line_width = _ORANGE, 0.9, 1.5
        self.lines.hide_select = True
        self.arrows = {name: self.gizmos.new(SINEW_GT_arrow.bl_idname) for name in LENGTHS}
        for name, arrow in self.arrows.items():
            arrow.target_set_operator(Operators.REACH_DRAG).length = name
            arrow.color, arrow.color_highlight, arrow.alpha = _PALE, _WHITE, 0.9
            arrow.use_draw_modal = True

    def draw_prepare(self, context: Context) -> None:
        deformer, depsgraph = active_deformer(context), context.evaluated_depsgraph_get()
        row = None if deformer is None else active_row(deformer)
        reach = None if row is None else reach_of(row, depsgraph)
        measured = {} if reach is None else reach.measured
        for name, arrow in self.arrows.items():
            arrow.hide = name not in measured
            if not arrow.hide:
                place, direction = measured[name]
                world, tip = world_of(row, depsgraph), place + getattr(row, name) * direction
                along = Vector(world[:3, :3] @ direction).to_track_quat("Z", "Y")
                place = frames.transformed(world, tip[None])[0]
                arrow.matrix_basis = Matrix.Translation(place) @ along.to_matrix().to_4x4()
        self.lines.lines = rings(row, depsgraph) if row is not None else ()


register, unregister = register_classes_factory((SINEW_GT_lines, SINEW_GT_arrow, SINEW_GGT_reach))
