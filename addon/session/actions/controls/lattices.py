# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits lattices to objects. Main thread only."""

from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np
from bpy.types import Mesh, Object
from mathutils import Matrix

from ....core.errors import MeshError, OptionError
from ....core.geometry import hexahedra
from ....mesh_io import RestShape
from ...controls import kinds
from ...controls.lattice.kind import KIND as LATTICE
from ...state import sessions
from .around import follow, leader, shape_of

LATTICE_METHODS = kinds.methods_of(LATTICE)
_THINNEST = 0.05  # of the longest side of a box around something flat


@dataclass(frozen=True)
class LatticeShape:
    """``kind``: BOX is a lattice object; CYLINDER and FITTED are mesh objects of hexahedra.

    ``counts`` are points of a box along its axes, or cells: of a fitted mesh along its axes, of a cylinder
    across its core, between core and border, and along its axis. ``axes``: OBJECT, PRINCIPAL or WORLD.
    ``margin`` is how much longer the box is on each side, as a share of its longest side.
    """

    kind: str = "BOX"
    counts: tuple[int, int, int] = (4, 4, 4)
    axes: str = "OBJECT"
    margin: float = 0.02


@sessions.suspended()
def add_lattice_object(objects: Sequence[Object], shape: LatticeShape) -> Object:
    """A new lattice around what objects show without Sinew, oriented by the first of them.

    It follows what all of them follow. Refuses what has no points.
    """
    shown = [shape_of(obj, None) for obj in objects]
    worlds = [np.array(obj.matrix_world, dtype=np.float64) for obj in objects]
    places = [rest.points @ world[:3, :3].T + world[:3, 3] for rest, world in zip(shown, worlds, strict=True)]
    points = np.concatenate(places) if places else np.zeros((0, 3))
    if not len(points):
        names = ", ".join(obj.name for obj in objects) or "Nothing"
        raise MeshError(f"{names} has no points - add some, or check the modifiers before Sinew")
    if not np.isfinite(points).all():
        raise MeshError("Some points are not finite - use Repair first")
    axes = _axes(points, worlds[0], shape.axes)
    low, high = (points @ axes).min(axis=0), (points @ axes).max(axis=0)
    longest = (high - low).max() or 1.0
    sides = np.maximum(high - low, _THINNEST * longest) + 2.0 * shape.margin * longest
    frame = np.eye(4)
    frame[:3, :3] = axes * sides
    frame[:3, 3] = axes @ (0.5 * (low + high))
    name = f"{objects[0].name} Lattice"
    if shape.kind == "BOX":
        obj = bpy.data.objects.new(name, _lattice(name, shape.counts))
        frame[:3, :3] /= np.maximum(np.array(shape.counts) - 1, 1)  # its points are a unit apart
    else:
        inside = (points - frame[:3, 3]) @ np.linalg.inv(frame[:3, :3]).T
        obj = bpy.data.objects.new(name, _mesh(name, shape, inside, shown))
    for collection in objects[0].users_collection or (bpy.context.scene.collection,):
        collection.objects.link(obj)
    follow(obj, leader(objects), Matrix(frame.tolist()))
    obj.show_in_front = True
    bpy.context.view_layer.update()
    return obj


def _axes(points: np.ndarray, world: np.ndarray, kind: str) -> np.ndarray:
    """Columns of a rotation, (3, 3)."""
    if kind == "WORLD":
        return np.eye(3)
    if kind == "OBJECT":
        q, r = np.linalg.qr(world[:3, :3])
        axes = q * np.where(np.diag(r) < 0.0, -1.0, 1.0)
    else:
        _values, axes = np.linalg.eigh(np.cov(points.T - points.mean(axis=0)[:, None], bias=True))
        axes = axes[:, ::-1]  # the longest first
        axes = axes * np.where(axes[np.abs(axes).argmax(axis=0), np.arange(3)] < 0.0, -1.0, 1.0)
    if np.linalg.det(axes) < 0.0:
        axes[:, 2] *= -1.0
    return axes


def _lattice(name: str, counts: tuple[int, int, int]) -> bpy.types.Lattice:
    """A lattice around the origin, whose points are a unit apart."""
    data = bpy.data.lattices.new(name)
    data.points_u, data.points_v, data.points_w = counts
    return data


def _mesh(name: str, shape: LatticeShape, inside: np.ndarray, shown: Sequence[RestShape]) -> Mesh:
    """A mesh of hexahedra in the cube from -1/2 to 1/2; ``inside`` are the points of all shapes there."""
    if shape.kind == "CYLINDER":
        across, rings, along = shape.counts
        points, quads = hexahedra.cylinder(across, rings, along)
        points = points * (np.sqrt(2.0), np.sqrt(2.0), 1.0)  # around the box
    elif shape.kind == "FITTED":
        triangles, first = [], 0
        for rest in shown:
            triangles.append(_triangles(rest) + first)
            first += len(rest.points)
        points, quads = hexahedra.boxes(hexahedra.touched(inside, np.concatenate(triangles), shape.counts))
    else:
        raise OptionError(f"There is no shape '{shape.kind}' - choose BOX, CYLINDER or FITTED")
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], quads.tolist())
    return mesh


def _triangles(rest: RestShape) -> np.ndarray:
    """The faces cut into fans, (t, 3)."""
    fans = [
        np.column_stack((np.full(len(face) - 2, face[0]), face[1:-1], face[2:]))
        for face in np.split(rest.corners, np.cumsum(rest.counts)[:-1])
        if len(face) > 2
    ]
    return np.concatenate(fans) if fans else np.zeros((0, 3), dtype=int)
