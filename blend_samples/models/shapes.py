# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes as distance fields, from which ``sculpt.Clay`` is joined.

A shape is anything with ``bounds() -> (low, high)`` and ``distance(points) -> (n,)``, negative inside and
exact near the surface, which is all that the blending needs. Points are (n, 3) float arrays.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

Vector = Sequence[float]


class Shape(Protocol):
    def bounds(self) -> tuple[np.ndarray, np.ndarray]: ...

    def distance(self, points: np.ndarray) -> np.ndarray: ...


def rotation(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    """(3, 3) rotation by Euler angles in degrees, first about x, then y, then z."""
    turn = np.eye(3)
    for axis, angle in enumerate(np.radians((x, y, z))):
        c, s = np.cos(angle), np.sin(angle)
        about = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
        turn = np.roll(about, axis, axis=(0, 1)) @ turn
    return turn


def smoothstep(low: float, high: float, value: np.ndarray) -> np.ndarray:
    """0 below ``low``, 1 above ``high``, smooth in between (``low`` may be the larger one)."""
    t = np.clip((value - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def path_length(curve: np.ndarray) -> np.ndarray:
    """The way along a curve (m, 3) to each of its points."""
    return np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))))


def bars(start: np.ndarray, end: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Square bars between points (k, 3): the corners (k, 8, 3) of each, and the quads (4, 4) of its sides."""
    along = (end - start) / np.linalg.norm(end - start, axis=1, keepdims=True)
    across = np.cross(along, np.where(np.abs(along[:, 2:]) < 0.9, (0, 0, 1), (1, 0, 0)))
    across *= radius / np.linalg.norm(across, axis=1, keepdims=True)
    beside = np.cross(along, across)
    ring = np.stack((across, beside, -across, -beside), axis=1)
    sides = np.array([(k, (k + 1) % 4, 4 + (k + 1) % 4, 4 + k) for k in range(4)])
    return np.concatenate((start[:, None] + ring, end[:, None] + ring), axis=1), sides


@dataclass(frozen=True)
class Ellipsoid:
    centre: Vector
    radii: Vector
    turn: np.ndarray | None = None

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        reach = np.asarray(self.radii) if self.turn is None else np.full(3, max(self.radii))
        return self.centre - reach, self.centre + reach

    def distance(self, points: np.ndarray) -> np.ndarray:
        local, radii = points - np.asarray(self.centre), np.asarray(self.radii)
        if self.turn is not None:
            local = local @ self.turn
        level = np.linalg.norm(local / radii, axis=1)
        slope = np.linalg.norm(local / (radii * radii), axis=1)
        return (level - 1.0) * np.where(slope > 1e-9, level / np.maximum(slope, 1e-9), radii.min())


@dataclass(frozen=True)
class Tube:
    """A smooth curve through ``points`` with a radius at each."""

    points: Sequence[Vector]
    radii: Sequence[float]
    steps: int = 6

    def path(self) -> tuple[np.ndarray, np.ndarray]:
        """The curve (m, 3) and its radii (m,): Catmull-Rom through the points."""
        knots = np.column_stack((np.asarray(self.points, float), np.asarray(self.radii, float)))
        if len(knots) == 2:
            return knots[:, :3], knots[:, 3]
        padded = np.vstack((2 * knots[0] - knots[1], knots, 2 * knots[-1] - knots[-2]))
        pieces = []
        for i in range(1, len(padded) - 2):
            p0, p1, p2, p3 = padded[i - 1 : i + 3]
            t = np.linspace(0, 1, self.steps, endpoint=False)[:, None]
            b, c, d = p2 - p0, 2 * p0 - 5 * p1 + 4 * p2 - p3, 3 * p1 - p0 - 3 * p2 + p3
            pieces.append(p1 + 0.5 * (b * t + c * t**2 + d * t**3))
        curve = np.vstack((*pieces, knots[-1:]))
        return curve[:, :3], np.maximum(curve[:, 3], 1e-3)

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        curve, radii = self.path()
        return (curve - radii[:, None]).min(0), (curve + radii[:, None]).max(0)

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distance (n,) to the tube and the place along it (n,), 0 at its start, 1 at its end."""
        curve, radii = self.path()
        length = path_length(curve)
        best, place = np.full(len(points), np.inf), np.zeros(len(points))
        for i in range(len(curve) - 1):
            axis = curve[i + 1] - curve[i]
            t = np.clip((points - curve[i]) @ axis / (axis @ axis), 0.0, 1.0)
            offset = points - curve[i] - t[:, None] * axis
            away = np.sqrt(np.einsum("ij,ij->i", offset, offset))
            away -= radii[i] + t * (radii[i + 1] - radii[i])
            at = (length[i] + t * (length[i + 1] - length[i])) / length[-1]
            place = np.where(away < best, at, place)
            best = np.minimum(away, best)
        return best, place

    def distance(self, points: np.ndarray) -> np.ndarray:
        return self.nearest(points)[0]


@dataclass(frozen=True)
class Mirrored:
    """A shape and its image across the plane y = 0 (the shape itself lies at y > 0)."""

    shape: Shape

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        low, high = self.shape.bounds()
        reach = max(abs(low[1]), abs(high[1]))
        return np.array((low[0], -reach, low[2])), np.array((high[0], reach, high[2]))

    def distance(self, points: np.ndarray) -> np.ndarray:
        x, y, z = points.T
        return self.shape.distance(np.column_stack((x, np.abs(y), z)))


@dataclass(frozen=True)
class Squashed:
    """A shape pressed flat towards the plane at ``centre`` across ``axis``, ``factor`` times thinner."""

    shape: Shape
    centre: Vector
    axis: Vector
    factor: float

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        return self.shape.bounds()

    def distance(self, points: np.ndarray) -> np.ndarray:
        axis = np.asarray(self.axis, float) / np.linalg.norm(self.axis)
        offset = (points - np.asarray(self.centre)) @ axis
        stretched = points + np.outer((self.factor - 1.0) * offset, axis)
        return self.shape.distance(stretched) / np.sqrt(self.factor)
