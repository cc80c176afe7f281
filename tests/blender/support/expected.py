# SPDX-License-Identifier: GPL-3.0-or-later
"""The expected shape, computed from Blender's data (mesh, vertex groups, matrices) by a new native object.

It uses neither the session nor anything that Sinew stores.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

import bpy
import numpy as np
from inside import native
from mathutils import Matrix
from registry import BY_ID, Posed, base_of, options_of
from rigs.rig import Rig, apply_matrix, base_points, painted, update

Warp = Callable[[np.ndarray], np.ndarray]
_warped: dict[tuple, np.ndarray] = {}


def faces_of(mesh: bpy.types.Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Corners per face (m,), and vertex indices face after face."""
    counts = np.empty(len(mesh.polygons), dtype=np.int32)
    corners = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.polygons.foreach_get("loop_total", counts)
    mesh.loops.foreach_get("vertex_index", corners)
    return counts, corners


def members_of(obj: bpy.types.Object, group: str) -> tuple[np.ndarray, np.ndarray]:
    """Indices and weights of a vertex group."""
    weights = painted(obj.data, obj.vertex_groups[group].index)
    return np.flatnonzero(weights), weights[weights > 0.0]


def in_frame(obj: bpy.types.Object, control: bpy.types.Object) -> np.ndarray:
    """The control's matrix in the space of the object, (4, 4)."""
    update()
    return np.linalg.inv(np.array(obj.matrix_world)) @ np.array(control.matrix_world, dtype=np.float64)


def scale_of(obj: bpy.types.Object, control: bpy.types.Object) -> float:
    """How long a length of the control is in the space of the object."""
    return float(np.cbrt(abs(np.linalg.det(in_frame(obj, control)[:3, :3]))))


def new_native(row: object, target: object, options: dict[str, object]) -> object:
    """The native object of a row; one around another gets its first base, unless the options have one."""
    base = base_of(row)
    if base is not None and "base" not in options:
        options = options | {"base": new_native(base, target, options_of(base, {})[0])}
    return getattr(native(), row.native)(target, **options)


def space_warp(row: object, rest: np.ndarray, faces: tuple, members: list, options: dict, strengths: list):
    """A warp of ``rest`` (n, 3) for poses (k, 3, 4), by a new native object; members have strengths. The base
    of one around another is its native object, or its row with options; else the first one."""
    mesh, places = native().SurfaceMesh(rest, faces), np.concatenate(members)
    held = {"counts": [len(points) for points in members], "weights": np.concatenate(strengths)}
    options = options | held
    if row.wraps:
        base = options.get("base") or (base_of(row), options_of(base_of(row), {})[0])
        if isinstance(base, tuple):
            base = new_native(base[0], places, base[1] | held)
        options |= {"mesh": mesh, "base": base}
    if any(parameter.id == "frame" for parameter in row.parameters) and options.get("frame") is None:
        options["frame"] = mesh  # the lattice is along the axes of the surface
    if row.posed is Posed.POSES:
        solver = new_native(row, mesh, options | {"points": places})
    else:
        solver = new_native(row, places, options)
    solver.bind(rest)
    return lambda poses, incoming: solver.warp_poses(poses, incoming=incoming)


class Poses(ABC):
    """What a control at rest, moved by a motion of its object, makes of a shape. Made while it is at rest."""

    def __init__(self, obj: bpy.types.Object, control: bpy.types.Object) -> None:
        self._at_rest = in_frame(obj, control)

    @abstractmethod
    def shape(self, pose: Matrix | np.ndarray, incoming: np.ndarray | None = None) -> np.ndarray:
        """With the control moved by ``pose`` (4x4, object space) from rest, (n, 3)."""

    def now(
        self, obj: bpy.types.Object, control: bpy.types.Object, incoming: np.ndarray | None = None
    ) -> np.ndarray:
        """With the control where it is."""
        return self.shape(in_frame(obj, control) @ np.linalg.inv(self._at_rest), incoming)

    def lifted(self, height: float) -> np.ndarray:
        """With the control moved along z."""
        return self.shape(Matrix.Translation((0.0, 0.0, height)))


class Expected(Poses):
    """What a mesh with one handle and fixed regions must show, whose rest are its own or other ``points``."""

    def __init__(
        self, obj, control, handle="Top", fixed=("Base",), method="thin_shell", points=None, **options: object
    ) -> None:
        super().__init__(obj, control)
        self._regions, self._solver, self._row = (handle, *fixed), None, BY_ID[method]
        self._options, self._steps = options_of(self._row, options)
        self.rebind(obj, points)

    def rebind(self, obj: bpy.types.Object, points: np.ndarray | None = None) -> None:
        """Take the mesh and its vertex groups as they are now."""
        rest = base_points(obj) if points is None else points
        groups = [members_of(obj, name) for name in self._regions]
        self._still = [np.eye(4)[:3]] * (len(groups) - 1)
        self._members = [rest[group[0]] for group in groups]
        if self._row.is_space:
            strengths = [weights for _members, weights in groups]
            faces = faces_of(obj.data)
            self._solver = space_warp(self._row, rest, faces, self._members, self._options, strengths)
            return
        mesh = native().SurfaceMesh(rest, faces_of(obj.data))
        self._solver = new_native(self._row, mesh, self._options)
        members, weights = zip(*groups, strict=True)
        self._solver.set_handles(members, weights=weights, free_parts="follow")

    @classmethod
    def of_rig(cls, plate: Rig, method: str = "thin_shell", **options: object) -> Expected:
        """Of the plate and its control, after ``plate.bind``."""
        return cls(plate.obj, plate.control, method=method, **options)

    def shape(self, pose: Matrix | np.ndarray, incoming: np.ndarray | None = None) -> np.ndarray:
        rows = np.array([np.array(pose)[:3], *self._still])
        if self._row.is_space:
            return self._solver(rows, incoming)
        return self._solver.solve(rows, incoming=incoming, **self._steps)[0]


class ByPoints(Poses):
    """What the points of a control make of those of an object, by a native object that is bound anew to them.

    ``points`` (c, 3) are those of the control, in its own frame, and ``rest`` what they were bound at, if
    that differs; ``told`` is what the native object has to know besides the options of the method.
    """

    def __init__(self, obj, control, method: str, points: np.ndarray, rest=None, told=None, **options):
        super().__init__(obj, control)
        row = BY_ID[method]
        chosen, _none = options_of(row, options)
        self._points = apply_matrix(self._at_rest, points)
        at_rest = self._points if rest is None else apply_matrix(self._at_rest, rest)
        self.native = new_native(row, at_rest, chosen | (told or {}))
        self.rebind(obj)

    def rebind(self, obj: bpy.types.Object, points: np.ndarray | None = None) -> None:
        """Take the points of the object as they are now."""
        self.native.bind(base_points(obj) if points is None else points)

    def shape(self, pose: Matrix | np.ndarray, incoming: np.ndarray | None = None) -> np.ndarray:
        return self.native.warp(apply_matrix(pose, self._points), incoming=incoming)


class ExpectedInCage(Poses):
    """What a cage makes of the points of an object, by coordinates that are bound anew to its rest (c, 3).

    ``by_hand(obj, warp)`` moves what the object is made of. Cages carry similarities over as they are, so a
    motion of the cage object is one of the shape. Made while the cage object is at rest, its vertices posed.
    """

    def __init__(self, obj, cage, cage_rest: np.ndarray, method: str, by_hand: Callable, **options) -> None:
        super().__init__(obj, cage)
        self._row, self._by_hand = BY_ID[method], by_hand
        self._options, _none = options_of(self._row, options)
        self._cage_rest = apply_matrix(self._at_rest, cage_rest)
        self._posed = apply_matrix(self._at_rest, base_points(cage))
        self._cage_faces = faces_of(cage.data)
        self.rebind(obj)

    def warp(self, points: np.ndarray) -> np.ndarray:
        """Where the vertices of the cage take points, (n, 3); the same question is computed once."""
        points = np.ascontiguousarray(points, dtype=np.float64)
        options = repr(sorted(self._options.items()))
        key = (self._row.id, options, *(array.tobytes() for array in (self._cage_rest, self._posed, points)))
        if key not in _warped:
            mesh = native().SurfaceMesh(self._cage_rest, self._cage_faces)
            coordinates = new_native(self._row, mesh, self._options)
            coordinates.bind(points)
            _warped[key] = coordinates.warp(self._posed)
        return _warped[key]

    def rebind(self, obj: bpy.types.Object) -> None:
        """Take the points as they are now."""
        self._rest, self._warped = (self._by_hand(obj, warp) for warp in (lambda points: points, self.warp))

    def shape(self, pose: Matrix | np.ndarray, incoming: np.ndarray | None = None) -> np.ndarray:
        moved = apply_matrix(pose, self._warped)
        return moved if incoming is None else incoming + moved - self._rest
