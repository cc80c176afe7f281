# SPDX-License-Identifier: GPL-3.0-or-later
"""The rig of lattices: a ball in a lattice object that is bent as no affine map does it."""

from __future__ import annotations

import bpy
import numpy as np
from expected import ByPoints, Poses
from mathutils import Matrix
from registry import Control, with_control

from rigs.cages import TURN, ball
from rigs.object_rigs import object_class
from rigs.rig import linked, press, update

WITH_LATTICE = with_control(Control.LATTICE)
TYPES = {f"KEY_{name.upper()}": name for name in ("linear", "cardinal", "catmull_rom", "bspline")}


def lattice_points(lattice: bpy.types.Object) -> np.ndarray:
    """The points of a lattice as they are edited, in its own frame, (c, 3)."""
    return np.array([point.co_deform for point in lattice.data.points], dtype=float)


def resolution(lattice: bpy.types.Object) -> tuple[int, int, int]:
    return lattice.data.points_u, lattice.data.points_v, lattice.data.points_w


def place(lattice: bpy.types.Object, points: np.ndarray) -> None:
    lattice.data.points.foreach_set("co_deform", np.asarray(points, dtype=np.float32).ravel())
    lattice.data.update_tag()


def lattice_object(counts: tuple[int, int, int] = (5, 5, 5), name: str = "Lattice") -> bpy.types.Object:
    """A lattice around the origin whose points are a unit apart, made without Sinew."""
    data = bpy.data.lattices.new(name)
    data.points_u, data.points_v, data.points_w = counts
    obj = linked(bpy.data.objects.new(name, data))
    update()
    return obj


def small_ball(name: str = "Ball", levels: int = 3) -> bpy.types.Object:
    """A ball that fits into it, with some room."""
    obj = ball(name, levels)
    obj.data.transform(Matrix.Scale(0.6, 4))
    return obj


def bent(points: np.ndarray, seed: int = 5, by: float = 0.1) -> np.ndarray:
    spread = by * np.ptp(points, axis=0).max()
    return points + spread * np.random.default_rng(seed).uniform(-0.5, 0.5, points.shape)


def by_lattice(
    obj: bpy.types.Object, lattice: bpy.types.Object, rest: np.ndarray, method: str, **options: object
) -> ByPoints:
    """What a lattice makes of the vertices of a mesh. ``rest`` (c, 3): its points as they were bound."""
    data = lattice.data
    types = [data.interpolation_type_u, data.interpolation_type_v, data.interpolation_type_w]
    told = {"resolution": resolution(lattice), "interpolation": [TYPES[name] for name in types]}
    return ByPoints(obj, lattice, method, lattice_points(lattice), rest, told, **options)


def new_class(base: type) -> type:
    """The class of the rig, derived from that of handles."""

    class LatticeRig(object_class(base)):
        methods = WITH_LATTICE
        point_arrays = 1
        carries = TURN @ Matrix.Diagonal((1.0, 0.6, 0.8, 1.0))

        @classmethod
        def new(cls, name: str = "Marble") -> LatticeRig:
            return cls(small_ball(name, 2), 0.2)

        @classmethod
        def large(cls) -> LatticeRig:
            return cls(small_ball(levels=6), 0.2)

        @property
        def control_size(self) -> int:
            return len(self.control.data.points)

        def bind(self, method: str = WITH_LATTICE[0], **_keywords: object) -> LatticeRig:
            self.bind_at_rest(method)
            self._lattice_rest = lattice_points(self.control)
            place(self.control, bent(self._lattice_rest))
            return self

        def attach(self, method: str) -> None:
            lattice = lattice_object()
            press(self.obj, "lattice_add", source="OBJECT", lattice=lattice.name)

        def relax(self) -> None:
            super().relax()
            place(self.control, self._lattice_rest)

        def expected(self, method: str | None = None, **options: object) -> Poses:
            return by_lattice(
                self.obj, self.control, self._lattice_rest, method or self.methods[0], **options
            )

    return LatticeRig
