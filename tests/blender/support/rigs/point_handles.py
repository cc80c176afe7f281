# SPDX-License-Identifier: GPL-3.0-or-later
"""A plate that the edges of another mesh carry: its vertices are handle points, its edges segments."""

from __future__ import annotations

import bpy
import numpy as np
from expected import Poses
from inside import native
from mathutils import Matrix
from registry import BY_ID, options_of

from rigs.object_rigs import another
from rigs.rig import apply_matrix, base_points, make_active, new_object

METHOD = "mls"
PLACES = np.array([(-1.0, 1.0, 0.0), (0.0, 1.0, 0.1), (1.0, 1.0, 0.0), (0.0, -1.0, 0.4)])
EDGES = np.array([(0, 1), (1, 2)])  # the last point stands alone


class ByPoints(Poses):
    """What points and the segments between them make of an object. Made while they are at rest."""

    def __init__(self, obj, points: bpy.types.Object, method: str = METHOD, **options: object) -> None:
        super().__init__(obj, points)
        self._points = apply_matrix(self._at_rest, base_points(points))
        self._row = BY_ID[method]
        self._options, _none = options_of(self._row, options)
        self.rebind(obj)

    def rebind(self, obj, points: np.ndarray | None = None) -> None:
        """Take the points of the object as they are now."""
        made = getattr(native(), self._row.native)
        self._solver = made(self._points, segments=EDGES, **self._options)
        self._solver.bind(base_points(obj) if points is None else points)

    def shape(self, pose, incoming: np.ndarray | None = None) -> np.ndarray:
        return self._solver.warp(apply_matrix(pose, self._points), incoming=incoming)


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

        def bind_alone(self, method: str) -> None:
            self.bind(method)

        def relax(self) -> None:
            self.control.matrix_basis = Matrix.Identity(4)

        def expected(self, method: str | None = None, **options: object) -> Poses:
            return ByPoints(self.obj, self.control, method or METHOD, **options)

    return PointsRig
