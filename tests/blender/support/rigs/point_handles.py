# SPDX-License-Identifier: GPL-3.0-or-later
"""A plate that the edges of another mesh carry: its vertices are handle points, its edges segments."""

import bpy
import numpy as np
from expected import ByPoints, Poses
from mathutils import Matrix

from rigs.object_rigs import another
from rigs.rig import base_points, make_active, new_object

METHOD = "mls"
PLACES = np.array([(-1.0, 1.0, 0.0), (0.0, 1.0, 0.1), (1.0, 1.0, 0.0), (0.0, -1.0, 0.4)])
EDGES = np.array([(0, 1), (1, 2)])  # the last point stands alone


def new_class(base: type) -> type:
    """The rig, by that of handles."""

    class PointsRig(base):
        methods = (METHOD,)
        goes_on = False
        counts_in_no_scene = False
        hidden_meshes = 5  # the points at rest, too
        point_arrays = 1
        carries = Matrix.Translation((0.3, -0.2, 0.7)) @ Matrix.Rotation(0.6, 4, (0.2, 0.5, 0.9))

        @property
        def control_size(self) -> int:
            return len(PLACES)

        @classmethod
        def another_control(cls, obj: bpy.types.Object) -> bpy.types.Object:
            control = another(cls.control_of(obj))
            control.matrix_basis = Matrix.Identity(4)
            return control

        @property
        def held(self) -> np.ndarray:
            """The corners of the plate that points lie on."""
            return np.flatnonzero(
                np.abs(base_points(self.obj)[:, None] - PLACES).max(axis=2).min(axis=1) < 1e-6
            )

        def bind(self, method: str = METHOD, fixed: bool = True, **keywords):
            if method not in self.methods:  # beside the points, by regions
                return super().bind(method, fixed, **keywords)
            points = new_object(f"{self.name} Points", PLACES, edges=EDGES.tolist())
            make_active(self.obj, points)
            bpy.ops.sinew.point_add(source="POINTS", method=method, segments=True)
            make_active(self.obj)
            assert self.deformer.status_level == "INFO", self.deformer.status
            return self

        def relax(self) -> None:
            self.control.matrix_basis = Matrix.Identity(4)

        def expected(self, method: str | None = None, **options: object) -> Poses:
            points, told = base_points(self.control), {"segments": EDGES}
            return ByPoints(self.obj, self.control, method or METHOD, points, told=told, **options)

    return PointsRig
