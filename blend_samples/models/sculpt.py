# SPDX-License-Identifier: GPL-3.0-or-later
"""Sculpting: soft unions of shapes on a grid, skinned by quads. The same input gives the same mesh."""

from collections.abc import Iterable, Sequence

import numpy as np

from .shapes import Mirrored, Shape, Tube, Vector


class Clay:
    """A block of grid cells in which shapes are joined and carved softly."""

    def __init__(self, low: Vector, high: Vector, voxel: float) -> None:
        self.low = np.asarray(low, float)
        self.voxel = voxel
        size = np.ceil((np.asarray(high, float) - self.low) / voxel).astype(int) + 1
        self.field = np.full(size, 10.0 * voxel, np.float32)

    def join(self, shape: Shape, blend: float = 0.05) -> None:
        window, distance, old = self._around(shape, blend)
        overlap = np.maximum(blend - np.abs(old - distance), 0.0) / blend
        self.field[window] = np.minimum(old, distance) - overlap**2 * (blend / 4)

    def carve(self, shape: Shape, blend: float = 0.02) -> None:
        """What is left of the block joins with the shape."""
        np.negative(self.field, out=self.field)
        self.join(shape, blend)
        np.negative(self.field, out=self.field)

    def cut_below(self, height: float) -> None:
        """Take away everything under the horizontal plane, so that feet stand flat."""
        depth = height - (self.low[2] + self.voxel * np.arange(self.field.shape[2]))
        np.maximum(self.field, depth.astype(np.float32), out=self.field)

    def onto(self, points: Sequence[Vector]) -> np.ndarray:
        """The points moved onto the present surface, where it is at most a few voxels away."""
        settled = np.array(points, float)
        for _ in range(12):
            slope = self.gradient(settled)
            step = self.sample(settled) / np.maximum((slope**2).sum(1), 0.25)
            settled -= 0.8 * np.clip(step, -4 * self.voxel, 4 * self.voxel)[:, None] * slope
        return settled

    def carve_line(self, points: Sequence[Vector], radii: Sequence[float]) -> Mirrored:
        """Carve a line onto the present surface, from y = 0 to both sides, and return it."""
        line = self.onto(points)
        line[0, 1] = 0.0
        self.carve(carved := Mirrored(Tube(line, radii)))
        return carved

    def _around(self, shape: Shape, blend: float) -> tuple[tuple[slice, ...], np.ndarray, np.ndarray]:
        margin = blend + 3 * self.voxel
        low, high = shape.bounds()
        first = np.clip(((low - margin - self.low) / self.voxel).astype(int), 0, self.field.shape)
        last = np.clip(((high + margin - self.low) / self.voxel).astype(int) + 2, 0, self.field.shape)
        window = tuple(slice(a, b) for a, b in zip(first, last))
        axes = [self.low[k] + self.voxel * np.arange(first[k], last[k]) for k in range(3)]
        points = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
        old = self.field[window]
        return window, shape.distance(points).reshape(old.shape).astype(np.float32), old

    def sample(self, points: np.ndarray) -> np.ndarray:
        """The field (n,) at points, trilinear."""
        place = np.clip((points - self.low) / self.voxel, 0, np.array(self.field.shape) - 1.001)
        cell = place.astype(int)
        t = place - cell
        value = np.zeros(len(points))
        for corner in np.ndindex(2, 2, 2):
            weight = np.prod(np.where(corner, t, 1.0 - t), axis=1)
            value += weight * self.field[tuple((cell + corner).T)]
        return value

    def gradient(self, points: np.ndarray) -> np.ndarray:
        step = np.eye(3) * self.voxel
        rises = [self.sample(points + s) - self.sample(points - s) for s in step]
        return np.stack(rises, 1) / (2 * self.voxel)

    def skin(self, relaxations: int = 8) -> tuple[np.ndarray, np.ndarray]:
        """Points (n, 3) and quads (m, 4), facing outward: surface nets, evened out on the surface."""
        for axis in range(3):  # rounds off what is thinner than a cell, which the net could not tell apart
            f = np.moveaxis(self.field, axis, 0)
            f[1:-1] = 0.125 * f[:-2] + 0.75 * f[1:-1] + 0.125 * f[2:]
        points, quads = self._surface_net()
        for _ in range(relaxations):
            points += 0.6 * (neighbour_mean(points, quads) - points)
            slope = self.gradient(points)
            step = self.sample(points) / np.maximum((slope**2).sum(1), 0.25)
            points -= np.clip(step, -self.voxel, self.voxel)[:, None] * slope
        return points, quads

    def _surface_net(self) -> tuple[np.ndarray, np.ndarray]:
        field = self.field
        inside = field < 0
        size = np.array(field.shape) - 1
        corners = [tuple(slice(c, c + s) for c, s in zip(corner, size)) for corner in np.ndindex(2, 2, 2)]
        count = sum(inside[c].astype(np.int8) for c in corners)
        cells = np.argwhere((count > 0) & (count < 8))
        number = np.full(size, -1)
        number[tuple(cells.T)] = np.arange(len(cells))

        total, hits = np.zeros((len(cells), 3)), np.zeros(len(cells))
        for axis in range(3):
            for start in np.ndindex(2, 2, 2):
                if start[axis]:
                    continue
                end = np.array(start) + np.eye(3, dtype=int)[axis]
                a, b = field[tuple((cells + start).T)], field[tuple((cells + end).T)]
                cross = (a < 0) != (b < 0)
                t = a[cross] / (a[cross] - b[cross])
                total[cross] += start + t[:, None] * np.eye(3)[axis]
                hits[cross] += 1
        points = self.low + self.voxel * (cells + total / hits[:, None])

        quads = []
        for axis in range(3):
            enters = np.diff(inside.astype(np.int8), axis=axis)
            u, v = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
            for sign in (-1, 1):
                edge = np.argwhere(enters == sign)
                ring = [number[tuple((edge - s).T)] for s in (0 * u, u, u + v, v)]
                quads.append(np.stack(ring[::-1] if sign > 0 else ring, 1))
        return points, np.vstack(quads)


def grid_faces(rows: int, columns: int, around: bool = False) -> np.ndarray:
    """The quads (m, 4) of a grid of points, row after row; ``around`` joins the last column to the first."""
    number = np.arange(rows * columns).reshape(rows, columns)
    beside = np.roll(number, -1, axis=1)
    quads = np.stack((number[:-1], beside[:-1], beside[1:], number[1:]), axis=-1)
    return quads[:, : columns if around else columns - 1].reshape(-1, 4)


def neighbour_mean(values: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Mean of ``values`` (n, ...) over the ends of the edges at each vertex."""
    ends = np.vstack([np.stack((quads[:, i], quads[:, (i + 1) % 4]), 1) for i in range(4)])
    count = np.bincount(ends[:, 0], minlength=len(values))
    flat = values.reshape(len(values), -1)
    mean = np.stack([np.bincount(ends[:, 0], c[ends[:, 1]], len(values)) for c in flat.T], 1)
    return (mean / np.maximum(count, 1)[:, None]).reshape(values.shape)


def vertex_normals(points: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Unit normals (n, 3), weighted by area."""
    across = np.cross(points[quads[:, 2]] - points[quads[:, 0]], points[quads[:, 3]] - points[quads[:, 1]])
    total = np.stack([sum(np.bincount(quads[:, i], c, len(points)) for i in range(4)) for c in across.T], 1)
    return total / np.maximum(np.linalg.norm(total, axis=1), 1e-12)[:, None]


def ball(centre: Vector, radius: float, cuts: int = 10) -> tuple[np.ndarray, np.ndarray]:
    """A closed sphere of quads: a cube of ``cuts`` by ``cuts`` faces per side, projected to a sphere."""
    line = np.tan(np.linspace(-np.pi / 4, np.pi / 4, cuts + 1))
    u, v = (w.ravel() for w in np.meshgrid(line, line, indexing="ij"))
    sides = [
        np.roll(np.stack((np.full_like(u, s), u, s * v), 1), k, axis=1) for k in range(3) for s in (1, -1)
    ]
    patch = grid_faces(cuts + 1, cuts + 1)[:, [0, 3, 2, 1]]
    points, quads = np.vstack(sides), np.vstack([patch + k * len(u) for k in range(6)])
    _, keep, merged = np.unique(np.round(points, 6), axis=0, return_index=True, return_inverse=True)
    outward = points[keep] / np.linalg.norm(points[keep], axis=1)[:, None]
    return np.asarray(centre) + radius * outward, merged.reshape(-1)[quads]


def weld_lists(parts: Iterable[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """Several (points, quads) as one list; the parts stay loose from each other."""
    points, quads = zip(*parts)
    starts = np.cumsum([0, *map(len, points)])
    return np.vstack(points), np.vstack([own + start for own, start in zip(quads, starts)])
