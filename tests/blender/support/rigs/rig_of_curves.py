# SPDX-License-Identifier: GPL-3.0-or-later
"""A plate with a wire along its far edge, which carries half of it."""

import bpy
import numpy as np
from expected import ByPoints, Poses, scale_of
from mathutils import Matrix
from registry import Control, with_control

from rigs.object_rigs import object_class
from rigs.rig import base_points, linked, make_active, press

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


def new_class(base: type) -> type:
    """The rig of wires, by that of handles."""

    class CurvesRig(object_class(base)):
        methods = with_control(Control.CURVES)
        point_arrays = 1

        @property
        def control_size(self) -> int:
            return len(places_of(self.control))

        @classmethod
        def another_control(cls, obj: bpy.types.Object) -> bpy.types.Object:
            control = super().another_control(obj)
            control.matrix_basis = Matrix.Identity(4)  # on the edge of the plate again
            return control

        @property
        def held(self) -> np.ndarray:
            return np.flatnonzero(base_points(self.obj)[:, 1] > 0.99)

        def attach(self, method: str) -> None:
            edge = base_points(self.obj)
            wire = polyline(edge[edge[:, 1] > 0.99], f"{self.name} Wire")
            press(self.obj, "wire_add", curve=wire.name, radius=RADIUS)
            make_active(self.obj)
            self.choose(method)

        def bind_alone(self, method: str) -> None:
            """The wire reaches so far that it carries everything."""
            self.bind(method)
            self.deformer.controls[0].radius = 1e5

        def expected(self, method: str | None = None, **options: object) -> Poses:
            told = {"radius": RADIUS * scale_of(self.obj, self.control)}
            points = places_of(self.control)
            return ByPoints(self.obj, self.control, method or self.methods[0], points, told=told, **options)

    return CurvesRig
