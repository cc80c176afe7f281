# SPDX-License-Identifier: GPL-3.0-or-later
"""Rings in the viewports: how far the active wire or tool of the active object reaches."""

from collections.abc import Sequence

import numpy as np
from bpy.types import Context, Depsgraph, Gizmo, GizmoGroup
from bpy.utils import register_classes_factory
from mathutils import Matrix

from ...core.geometry import frames
from ...operators import ring
from ...properties import SinewControl
from ...session.targets.kinds import kind_of
from ..control.curves import active_row
from ..places import active_deformer

_AXES = np.eye(3)
_Z = _AXES[2]


def rings(row: SinewControl, depsgraph: Depsgraph) -> list[np.ndarray]:
    """Lines (k, 3) of the world: the radius of a wire at its middle; the two distances of a tool."""
    if row.object is None or row.missing:
        return []
    world = np.array(row.object.evaluated_get(depsgraph).matrix_world, dtype=np.float64)
    if row.object.type == "CURVE":
        points = kind_of(row.object).points_shown(row.object, depsgraph)
        found = _around(points.astype(np.float64), row.radius)
    elif row.tools == "drag":
        found = [ring(np.zeros(3), axis, size) for size in (row.inner, row.outer) for axis in _AXES]
    else:
        found = [ring(height * _Z, _Z, row.width) for height in (row.inner, row.outer)]
    return [frames.transformed(world, line) for line in found]


def _around(points: np.ndarray, radius: float) -> list[np.ndarray]:
    """A ring around the middle of a line of points (n, 3)."""
    if len(points) < 2:
        return []
    middle = len(points) // 2
    along = points[middle] - points[middle - 1]
    length = np.linalg.norm(along)
    return [ring(points[middle], along / length, radius)] if length > 0.0 else []


class SINEW_GT_lines(Gizmo):
    """Lines of the world, which nothing can be done with."""

    bl_idname = "SINEW_GT_lines"
    __slots__ = ("lines",)

    def setup(self) -> None:
        self.lines: Sequence[np.ndarray] = ()

    def draw(self, _context: Context) -> None:
        for line in self.lines:
            shape = self.new_custom_shape("LINE_STRIP", line.tolist())
            self.draw_custom_shape(shape, matrix=Matrix.Identity(4))


class SINEW_GGT_reach(GizmoGroup):
    """How far the active wire or tool reaches"""

    bl_idname = "SINEW_GGT_reach"
    bl_label = "Reach of Sinew's Controls"
    bl_space_type = "VIEW_3D"
    bl_region_type = "WINDOW"
    bl_options = {"3D", "PERSISTENT", "SHOW_MODAL_ALL"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        deformer = active_deformer(context)
        return deformer is not None and active_row(deformer) is not None

    def setup(self, _context: Context) -> None:
        lines = self.gizmos.new(SINEW_GT_lines.bl_idname)
        lines.color, lines.alpha, lines.line_width = (1.0, 0.6, 0.1), 0.9, 1.5
        lines.hide_select = True

    def draw_prepare(self, context: Context) -> None:
        row = active_row(active_deformer(context))
        self.gizmos[0].lines = rings(row, context.evaluated_depsgraph_get()) if row is not None else ()


register, unregister = register_classes_factory((SINEW_GT_lines, SINEW_GGT_reach))
