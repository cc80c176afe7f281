# SPDX-License-Identifier: GPL-3.0-or-later
"""A plate with a tool in its middle, which drags what is around."""

import bpy
import numpy as np
from expected import ByPoints, Poses, scale_of
from registry import Control, with_control

from rigs.object_rigs import object_class
from rigs.rig import base_points, grid_object, make_active, new_empty, press

OUTER = 0.9
INNER = OUTER / 4.0  # as Add Tool makes it
FRAME = np.concatenate((np.zeros((1, 3)), np.eye(3)))


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
            return new_empty("Another")

        @property
        def held(self) -> np.ndarray:
            away = np.linalg.norm(base_points(self.obj), axis=1)
            return np.flatnonzero(away < 0.99 * INNER)

        def attach(self, method: str) -> None:
            tool = new_empty(f"{self.name} Tool")
            press(self.obj, "tool_add", control=tool.name, outer=OUTER)
            make_active(self.obj)
            self.choose(method)

        def bind_alone(self, method: str) -> None:
            """The tool is so large that it carries everything."""
            self.bind(method)
            row = self.deformer.controls[0]
            row.outer, row.inner = 20.0, 10.0

        def expected(self, method: str | None = None, **options: object) -> Poses:
            scale = scale_of(self.obj, self.control)
            told = {"inner": INNER * scale, "outer": OUTER * scale}
            return ByPoints(self.obj, self.control, method or self.methods[0], FRAME, told=told, **options)

    return ToolsRig
