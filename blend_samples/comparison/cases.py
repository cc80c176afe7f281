# SPDX-License-Identifier: GPL-3.0-or-later
"""The edits that a surface method is asked for: a mesh, its two handles, and where they go.

They are those of the survey's comparison, M. Botsch, O. Sorkine, "On Linear Variational Surface Deformation
Methods", IEEE TVCG 14, 2008: a translation, a bend, a twist, and an affine pull. The models are our own, and
the poses such that the thin shell is strained about as much as on the models of the survey.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..models.sculpt import Clay, grid_faces
from ..models.shapes import Tube, rotation

STILL = np.eye(3, 4)


@dataclass(frozen=True)
class Case:
    """One edit: a mesh of ``points`` (n, 3) and ``triangles`` (t, 3), and the poses (2, 3, 4) of two handles.
    The first handle stays. The picture is seen from -y, with z up, after a turn by ``heading`` degrees about
    z. Only a ``closed`` mesh has a volume."""

    name: str
    points: np.ndarray
    triangles: np.ndarray
    handles: tuple[np.ndarray, np.ndarray]
    poses: np.ndarray
    heading: float = 0.0
    closed: bool = True

    @property
    def held(self) -> np.ndarray:
        """The vertices of both handles."""
        return np.concatenate(self.handles)

    @property
    def free(self) -> np.ndarray:
        """(n,) whether a vertex is in no handle."""
        free = np.ones(len(self.points), bool)
        free[self.held] = False
        return free

    @property
    def targets(self) -> np.ndarray:
        """(n, 3): the handles where they go, and everything else at rest."""
        where = self.points.copy()
        for handle, pose in zip(self.handles, self.poses):
            where[handle] = self.points[handle] @ pose[:, :3].T + pose[:, 3]
        return where


def case_of(
    name: str,
    mesh: tuple[np.ndarray, np.ndarray],
    ends: tuple[np.ndarray, np.ndarray],
    pose: np.ndarray,
    heading: float = 0.0,
    closed: bool = True,
) -> Case:
    """The case of a mesh whose ends are masks (n,), and whose second end moves by a pose (3, 4)."""
    handles = np.flatnonzero(ends[0]), np.flatnonzero(ends[1])
    return Case(name, *mesh, handles, np.stack((STILL, pose)), heading, closed)


def plane(cells: int = 60, lift: float = 0.82, angle: float = 0.0, bumps: float = 0.055) -> Case:
    """A plane with bumps of a height. The strip at its right is lifted, or bent by ``angle`` degrees."""
    points, triangles = sheet(cells, cells, 2.0, 2.0)
    x, y = points[:, 0], points[:, 1]
    points[:, 2] = bumps * (np.sin(4.0 * np.pi * x) * np.sin(4.0 * np.pi * y)) ** 2
    pose = bend(angle, 0, 1.6, 0.2) if angle else moved(0.0, 0.0, lift)
    name = f"Bumpy plane, {f'bent by {angle:.0f}°' if angle else 'lifted'}"
    return case_of(name, (points, triangles), (x <= 0.201, x >= 1.799), pose, 24.0, closed=False)


def cylinder(rings: int = 56, angle: float = 120.0, hinge: float = 0.6) -> Case:
    """A round bar of radius 1, its top turned about a hinge inside, ``hinge`` away from the axis."""
    points, triangles = tube(40, rings, 1.0, 10.0)
    z = points[:, 2]
    pose = about((hinge, 0.0, 5.0), rotation(y=angle))
    return case_of(f"Cylinder, bent by {angle:.0f}°", (points, triangles), (z <= 1.501, z >= 8.499), pose)


def bar(cells: int = 9, angle: float = 135.0) -> Case:
    """A square bar, its top twisted about its axis; ``cells`` across each side."""
    points, triangles = tube(4 * cells, 8 * cells, 1.0, 10.0)
    side, radius = np.arctan2(points[:, 1], points[:, 0]), np.linalg.norm(points[:, :2], axis=1)
    points[:, :2] = radius[:, None] * _on_square(side)
    z, pose = points[:, 2], about((0.0, 0.0, 0.0), rotation(z=angle))
    name = f"Bar, twisted by {angle:.0f}°"
    return case_of(name, (points, triangles), (z <= 0.501, z >= 9.499), pose, 25.0)


def branches(voxel: float = 0.07) -> Case:
    """A trunk with two arms; its crown is turned by 70 degrees, stretched and pulled."""
    clay = Clay((-1.7, -0.7, -0.1), (1.7, 0.7, 4.9), voxel)
    clay.join(Tube([(0, 0, 0.3), (0, 0, 2.2), (0, 0, 4.3)], [0.40, 0.37, 0.32]))
    right = [(0, 0, 1.1), (0.8, 0, 1.15), (1.15, 0, 1.6), (1.15, 0, 2.5)]
    left = [(0, 0, 1.9), (-0.75, 0, 1.95), (-1.05, 0, 2.3), (-1.05, 0, 2.9)]
    clay.join(Tube(right, [0.26, 0.26, 0.25, 0.22]), 0.2)
    clay.join(Tube(left, [0.24, 0.24, 0.23, 0.20]), 0.2)
    points, quads = clay.skin(12)
    pose = about((0.0, 0.0, 2.2), rotation(y=70.0) @ np.diag((1.0, 1.0, 1.15))) + moved(0.2, 0.0, 0.1) - STILL
    ends = points[:, 2] < 0.4, (np.abs(points[:, 0]) < 0.6) & (points[:, 2] > 3.7)
    return case_of("Branches, affine pull", (points, split(quads)), ends, pose, 15.0)


def moved(x: float, y: float, z: float) -> np.ndarray:
    return np.column_stack((np.eye(3), (x, y, z)))


def about(centre: tuple[float, float, float], linear: np.ndarray) -> np.ndarray:
    """The pose (3, 4) of a linear map about a centre."""
    return np.column_stack((linear, centre - linear @ centre))


def bend(angle: float, axis: int, length: float, start: float) -> np.ndarray:
    """The pose (3, 4) of what lies beyond ``start + length`` along an axis, if that length becomes an arc.
    The z axis bends towards x, and the x axis towards z."""
    along, across = np.eye(3)[axis], np.eye(3)[2 - axis]
    turn, radius = np.radians(angle), length / np.radians(angle)
    end = start * along + radius * (np.sin(turn) * along + (1.0 - np.cos(turn)) * across)
    linear = rotation(y=angle if axis == 2 else -angle)
    return np.column_stack((linear, end - linear @ ((start + length) * along)))


def sheet(across: int, deep: int, width: float, depth: float) -> tuple[np.ndarray, np.ndarray]:
    """A flat grid from the origin, with diagonals by turns."""
    u, v = np.meshgrid(np.linspace(0, width, across + 1), np.linspace(0, depth, deep + 1), indexing="ij")
    number = np.arange(u.size).reshape(u.shape)
    a, b, c, d = (n.ravel() for n in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    odd = (np.add.outer(np.arange(across), np.arange(deep)) % 2 == 1).ravel()[:, None]
    faces = np.where(odd, np.stack((a, b, d, b, c, d), 1), np.stack((a, b, c, a, c, d), 1))
    return np.stack((u.ravel(), v.ravel(), np.zeros(u.size)), 1), faces.reshape(-1, 3)


def tube(around: int, rings: int, radius: float, height: float) -> tuple[np.ndarray, np.ndarray]:
    """A closed round bar along z, from the origin, with rings in its two ends."""
    caps = max(2, around // 8)
    inner = radius * np.arange(1, caps) / caps
    sides = [(radius, z) for z in np.linspace(0.0, height, rings + 1)]
    rims = [*((r, 0.0) for r in inner), *sides, *((r, height) for r in inner[::-1])]
    angle = 2.0 * np.pi * np.arange(around) / around
    circle = np.stack((np.cos(angle), np.sin(angle)), 1)
    points = np.vstack([np.column_stack((r * circle, np.full(around, z))) for r, z in rims])
    quads = grid_faces(len(rims), around, around=True)
    odd = np.add.outer(np.arange(len(rims) - 1), np.arange(around)).ravel() % 2 == 1
    first, beside = np.arange(around), np.roll(np.arange(around), -1)
    last, foot, top = len(points) - around, np.full(around, len(points)), np.full(around, len(points) + 1)
    fans = np.stack((beside, first, foot), 1), np.stack((first + last, beside + last, top), 1)
    return np.vstack((points, ((0.0, 0.0, 0.0), (0.0, 0.0, height)))), np.vstack((split(quads, odd), *fans))


def split(quads: np.ndarray, odd: np.ndarray | bool = False) -> np.ndarray:
    """Two triangles per quad (m, 4), along the other diagonal where it is ``odd`` (m,)."""
    other = np.broadcast_to(odd, len(quads))[:, None]
    turned = np.where(other, np.roll(quads, 1, axis=1), quads)
    return turned[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def _on_square(angle: np.ndarray) -> np.ndarray:
    """Where the rays at angles (n,) meet a square of half width 1, spaced evenly along its sides; (n, 2)."""
    turn = np.pi / 2 * np.round(angle / (np.pi / 2))
    beside, c, s = (angle - turn) / (np.pi / 4), np.cos(turn), np.sin(turn)
    return np.stack((c - s * beside, s + c * beside), 1)


CASES: dict[str, Callable[[], Case]] = {
    "plane": plane,
    "cylinder": cylinder,
    "bar": bar,
    "branches": branches,
}
