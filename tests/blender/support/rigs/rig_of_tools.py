# SPDX-License-Identifier: GPL-3.0-or-later
"""A plate with a tool in its middle, which drags what is around."""

from __future__ import annotations

import bpy
import numpy as np
from expected import Poses
from inside import native
from mathutils import Matrix
from registry import BY_ID, Control, options_of, with_control

from rigs.object_rigs import object_class
from rigs.rig import apply_matrix, base_points, grid_object, make_active, new_empty, press

PLACE = (0.0, 0.0, 0.0)
OUTER = 0.9
INNER = OUTER / 4.0  # as Add Tool makes it
FRAME = np.concatenate((np.zeros((1, 3)), np.eye(3)))


class ByTool(Poses):
    """What a drag makes of the vertices of an object. Made while the tool is at rest."""

    def __init__(self, obj, tool, method: str, **options: object) -> None:
        super().__init__(obj, tool)
        self._frame = apply_matrix(self._at_rest, FRAME)
        self._row = BY_ID[method]
        self._options, _none = options_of(self._row, options)
        self.rebind(obj)

    def rebind(self, obj, points: np.ndarray | None = None) -> None:
        """Take the points as they are now."""
        scale = np.linalg.norm(self._frame[1:] - self._frame[0], axis=1).mean()
        self._solver = getattr(native(), self._row.native)(
            self._frame, inner=INNER * scale, outer=OUTER * scale, **self._options
        )
        self._solver.bind(base_points(obj) if points is None else points)

    def shape(self, pose, incoming: np.ndarray | None = None) -> np.ndarray:
        return self._solver.warp(apply_matrix(pose, self._frame), incoming=incoming)


def new_class(base: type) -> type:
    """The rig of tools, by that of handles."""

    class ToolsRig(object_class(base)):
        methods = with_control(Control.TOOLS)

        @classmethod
        def large(cls):
            return cls(grid_object(cells=80))

        @property
        def control_size(self) -> int:
            return 4

        @classmethod
        def another_control(cls, obj: bpy.types.Object) -> bpy.types.Object:
            return new_empty("Another", PLACE)

        @property
        def held(self) -> np.ndarray:
            """The vertices that stay in the inner ball."""
            away = np.linalg.norm(base_points(self.obj) - PLACE, axis=1)
            return np.flatnonzero(away < 0.99 * INNER)

        def attach(self, method: str) -> None:
            tool = new_empty(f"{self.name} Tool", PLACE)
            press(self.obj, "tool_add", control=tool.name, outer=OUTER)
            make_active(self.obj)
            self.choose(method)

        def bind_alone(self, method: str) -> None:
            """The tool is so large that it carries everything."""
            self.bind(method)
            row = self.deformer.controls[0]
            row.outer, row.inner = 20.0, 10.0

        def relax(self) -> None:
            self.control.matrix_basis = Matrix.Translation(PLACE)

        def expected(self, method: str | None = None, **options: object) -> Poses:
            return ByTool(self.obj, self.control, method or self.methods[0], **options)

    return ToolsRig
