# SPDX-License-Identifier: GPL-3.0-or-later
"""A plate with a wire along its far edge, which carries half of it."""

from __future__ import annotations

import bpy
import numpy as np
from expected import Poses
from inside import native
from mathutils import Matrix
from registry import BY_ID, Control, options_of, with_control
from rig import add_group, apply_matrix, base_points, grid_object, linked, make_active

RADIUS = 1.1  # of the wire, in its own space


def polyline(places: np.ndarray, name: str = "Wire") -> bpy.types.Object:
    """A curve object of straight lines: Blender draws it at its points alone."""
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions = "3D"
    spline = data.splines.new("POLY")
    spline.points.add(len(places) - 1)
    for point, place in zip(spline.points, places, strict=True):
        point.co = (*place, 1.0)
    return linked(bpy.data.objects.new(name, data))


def places_of(wire: bpy.types.Object) -> np.ndarray:
    """Its points, in its own space, (c, 3)."""
    return np.array([point.co[:3] for spline in wire.data.splines for point in spline.points], dtype=float)


def stroke_through(places: np.ndarray) -> list[dict[str, object]]:
    """A stroke for an operator: which members its elements have differs between releases."""
    members = bpy.types.OperatorStrokeElement.bl_rna.properties
    element = {
        member.identifier: tuple(member.default_array)
        if getattr(member, "is_array", False)
        else member.default
        for member in members
        if member.identifier != "rna_type"
    }
    return [{**element, "location": tuple(place)} for place in np.asarray(places, dtype=float).tolist()]


class ByWires(Poses):
    """What a wire makes of the vertices of an object. Made while the wire is at rest."""

    def __init__(self, obj, wire, method: str, radius: float = RADIUS, **options: object) -> None:
        super().__init__(obj, wire)
        self._wire = apply_matrix(self._at_rest, places_of(wire))
        self._row, self._radius = BY_ID[method], radius
        self._options, _none = options_of(self._row, options)
        self.rebind(obj)

    def rebind(self, obj, points: np.ndarray | None = None) -> None:
        """Take the points as they are now."""
        scale = np.cbrt(abs(np.linalg.det(self._at_rest[:3, :3])))
        self._solver = getattr(native(), self._row.native)(
            self._wire, radius=self._radius * scale, **self._options
        )
        self._solver.bind(base_points(obj) if points is None else points)

    def shape(self, pose, incoming: np.ndarray | None = None) -> np.ndarray:
        return self._solver.warp(apply_matrix(pose, self._wire), incoming=incoming)


def new_class(base: type) -> type:
    """The rig of wires, by that of handles."""

    class CurvesRig(base):
        methods = with_control(Control.CURVES)
        goes_on = False
        counts_in_no_scene = False
        hidden_meshes = 5  # the wire at rest, too
        point_arrays = 1
        carries = Matrix.Translation((0.3, -0.2, 0.7))

        def __init__(self, obj: bpy.types.Object) -> None:
            self.name = obj.name
            self.top = add_group(obj, "Top", lambda point: point[1] > 0.75)
            self.base = add_group(obj, "Base", lambda point: point[1] < -0.75)

        @classmethod
        def new(cls, name: str = "Plate"):
            return cls(grid_object(name))

        @classmethod
        def large(cls):
            return cls(grid_object(cells=60))

        @property
        def control_size(self) -> int:
            return len(places_of(self.control))

        @staticmethod
        def control_of(obj: bpy.types.Object) -> bpy.types.Object:
            return obj.sinew.deformers[0].controls[0].object

        @staticmethod
        def set_control(obj: bpy.types.Object, control: bpy.types.Object | None) -> None:
            obj.sinew.deformers[0].controls[0].object = control

        @classmethod
        def another_control(cls, obj: bpy.types.Object) -> bpy.types.Object:
            control = cls.control_of(obj).copy()
            control.data = control.data.copy()
            control.name = "Another"
            control.matrix_basis = Matrix.Identity(4)  # on the edge of the plate again
            return linked(control)

        @staticmethod
        def control_is_missing(obj: bpy.types.Object) -> bool:
            return obj.sinew.deformers[0].controls[0].missing

        @property
        def control(self) -> bpy.types.Object:
            return self.deformer.controls[0].object

        @property
        def held(self) -> np.ndarray:
            """The vertices on the wire."""
            return np.flatnonzero(base_points(self.obj)[:, 1] > 0.99)

        def bind(self, method: str = "wires", fixed: bool = True, **_keywords):
            self.bind_at_rest(method)
            return self

        def bind_at_rest(self, method: str) -> None:
            self.attach(method)
            assert self.deformer.is_bound, self.deformer.status

        def attach(self, method: str) -> None:
            obj = self.obj
            edge = base_points(obj)
            wire = polyline(edge[edge[:, 1] > 0.99][::1], f"{self.name} Wire")
            make_active(obj)
            bpy.ops.sinew.wire_add(curve=wire.name, radius=RADIUS)
            make_active(obj)
            if method != self.deformer.method:
                self.deformer.method = method
                bpy.ops.sinew.bind()

        def bind_alone(self, method: str) -> None:
            """The wire reaches so far that it carries everything."""
            self.bind(method)
            self.deformer.controls[0].radius = 1e5

        def relax(self) -> None:
            self.control.matrix_basis = Matrix.Identity(4)

        def rest(self) -> np.ndarray:
            return base_points(self.obj)

        def expected(self, method: str | None = None, **options: object) -> Poses:
            return ByWires(self.obj, self.control, method or self.methods[0], **options)

    return CurvesRig
