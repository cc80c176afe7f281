# SPDX-License-Identifier: GPL-3.0-or-later
"""The edits that a surface method is asked for: a mesh, its two handles, and where they go.

They are those of the survey's comparison, M. Botsch, O. Sorkine, "On Linear Variational Surface Deformation
Methods", IEEE TVCG 14, 2008: a translation, a bend, a twist, and an affine pull. The models are our own, and
the poses such that the thin shell is strained about as much as on the models of the survey.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..models.sculpt import Clay
from ..models.shapes import Tube

STILL = np.eye(3, 4)


@dataclass(frozen=True)
class Case:
    """One edit: a mesh of ``points`` (n, 3) and ``triangles`` (t, 3), and the poses (2, 3, 4) of two handles.

    The first handle stays. The picture is seen from -y, with z up, after a turn by ``heading`` degrees about
    z. Only a ``closed`` mesh has a volume.
    """

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


def plane(cells: int = 60, lift: float = 0.82, angle: float = 0.0, bumps: float = 0.055) -> Case:
    """A plane with bumps of a height. The strip at its right is lifted, or bent by ``angle`` degrees."""
    points, triangles = sheet(cells, cells, 2.0, 2.0)
    x, y = points[:, 0], points[:, 1]
    points[:, 2] = bumps * (np.sin(4.0 * np.pi * x) * np.sin(4.0 * np.pi * y)) ** 2
    pose = bend(angle, 0, 1.6, 0.2) if angle else moved(0.0, 0.0, lift)
    edit = f"bent by {angle:.0f}°" if angle else "lifted"
    return _case(
        f"Bumpy plane, {edit}", points, triangles, (x <= 0.201, x >= 1.799), pose, 24.0, closed=False
    )


def cylinder(rings: int = 56, angle: float = 120.0, hinge: float = 0.6) -> Case:
    """A round bar of radius 1, its top turned about a hinge inside, ``hinge`` away from the axis."""
    points, triangles = tube(40, rings, 1.0, 10.0)
    z = points[:, 2]
    turn = _turn(angle, 2)
    centre = np.array((hinge, 0.0, 5.0))
    pose = np.column_stack((turn, centre - turn @ centre))
    return _case(f"Cylinder, bent by {angle:.0f}°", points, triangles, (z <= 1.501, z >= 8.499), pose)


def bar(cells: int = 9, angle: float = 135.0) -> Case:
    """A square bar, its top twisted about its axis; ``cells`` across each side."""
    points, triangles = tube(4 * cells, 8 * cells, 1.0, 10.0)
    side, radius = np.arctan2(points[:, 1], points[:, 0]), np.linalg.norm(points[:, :2], axis=1)
    points[:, :2] = radius[:, None] * _on_square(side)
    z = points[:, 2]
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    pose = np.array(((c, -s, 0, 0), (s, c, 0, 0), (0, 0, 1, 0)))
    return _case(f"Bar, twisted by {angle:.0f}°", points, triangles, (z <= 0.501, z >= 9.499), pose, 25.0)


def branches(voxel: float = 0.07) -> Case:
    """A trunk with two arms; its crown is turned by 70 degrees, stretched and pulled."""
    clay = Clay((-1.7, -0.7, -0.1), (1.7, 0.7, 4.9), voxel)
    clay.join(Tube([(0, 0, 0.3), (0, 0, 2.2), (0, 0, 4.3)], [0.40, 0.37, 0.32]))
    right = [(0, 0, 1.1), (0.8, 0, 1.15), (1.15, 0, 1.6), (1.15, 0, 2.5)]
    left = [(0, 0, 1.9), (-0.75, 0, 1.95), (-1.05, 0, 2.3), (-1.05, 0, 2.9)]
    clay.join(Tube(right, [0.26, 0.26, 0.25, 0.22]), 0.2)
    clay.join(Tube(left, [0.24, 0.24, 0.23, 0.20]), 0.2)
    points, quads = clay.skin(12)
    linear, centre = _turn(70.0, 2) @ np.diag((1.0, 1.0, 1.15)), np.array((0.0, 0.0, 2.2))
    pose = np.column_stack((linear, centre - linear @ centre + (0.2, 0.0, 0.1)))
    ends = points[:, 2] < 0.4, (np.abs(points[:, 0]) < 0.6) & (points[:, 2] > 3.7)
    return _case("Branches, affine pull", points, split(quads), ends, pose, 15.0)


def moved(x: float, y: float, z: float) -> np.ndarray:
    """The pose (3, 4) of a translation."""
    return np.column_stack((np.eye(3), (x, y, z)))


def bend(angle: float, axis: int, length: float, start: float) -> np.ndarray:
    """The pose (3, 4) of what lies beyond ``start + length`` along an axis, if that length becomes an arc.

    The z axis bends towards x, and the x axis towards z.
    """
    along, across = np.eye(3)[axis], np.eye(3)[2 - axis]
    turn, radius = np.radians(angle), length / np.radians(angle)
    end = start * along + radius * (np.sin(turn) * along + (1.0 - np.cos(turn)) * across)
    linear = _turn(angle, axis)
    return np.column_stack((linear, end - linear @ ((start + length) * along)))


def _turn(angle: float, axis: int) -> np.ndarray:
    """The rotation (3, 3) of the z axis towards x (``axis`` 2), or of the x axis towards z (0)."""
    along, across = np.eye(3)[axis], np.eye(3)[2 - axis]
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    plane_of_turn = np.outer(along, along) + np.outer(across, across)
    return np.eye(3) + (c - 1.0) * plane_of_turn + s * (np.outer(across, along) - np.outer(along, across))


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
    rims = [(r, 0.0) for r in inner]
    rims += [(radius, z) for z in np.linspace(0.0, height, rings + 1)]
    rims += [(r, height) for r in inner[::-1]]
    angle = 2.0 * np.pi * np.arange(around) / around
    circle = np.stack((np.cos(angle), np.sin(angle)), 1)
    points = np.vstack([np.column_stack((r * circle, np.full(around, z))) for r, z in rims])
    number = np.arange(len(points)).reshape(-1, around)
    beside = np.roll(number, -1, 1)
    quads = np.stack((number[:-1], beside[:-1], beside[1:], number[1:]), -1)
    odd = (np.add.outer(np.arange(quads.shape[0]), np.arange(around)) % 2 == 1).ravel()
    foot, top = len(points), len(points) + 1
    fans = [np.stack((beside[0], number[0], np.full(around, foot)), 1)]
    fans += [np.stack((number[-1], beside[-1], np.full(around, top)), 1)]
    ends = ((0.0, 0.0, 0.0), (0.0, 0.0, height))
    return np.vstack((points, ends)), np.vstack((split(quads.reshape(-1, 4), odd), *fans))


def split(quads: np.ndarray, odd: np.ndarray | bool = False) -> np.ndarray:
    """Two triangles per quad (m, 4), along the other diagonal where it is ``odd`` (m,)."""
    other = np.broadcast_to(odd, len(quads))[:, None]
    turned = np.where(other, np.roll(quads, 1, axis=1), quads)
    return turned[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def _on_square(angle: np.ndarray) -> np.ndarray:
    """Where the rays at angles (n,) meet a square of half width 1, spaced evenly along its sides; (n, 2)."""
    quarter = np.round(angle / (np.pi / 2))
    beside = (angle - quarter * np.pi / 2) / (np.pi / 4)
    x, y = np.ones_like(angle), beside
    turn = quarter * np.pi / 2
    return np.stack((np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y), 1)


def _case(
    name: str,
    points: np.ndarray,
    triangles: np.ndarray,
    ends: tuple[np.ndarray, np.ndarray],
    pose: np.ndarray,
    heading: float = 0.0,
    closed: bool = True,
) -> Case:
    handles = np.flatnonzero(ends[0]), np.flatnonzero(ends[1])
    return Case(name, points, triangles, handles, np.stack((STILL, pose)), heading, closed)


CASES: dict[str, Callable[[], Case]] = {
    "plane": plane,
    "cylinder": cylinder,
    "bar": bar,
    "branches": branches,
}
