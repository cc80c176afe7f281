# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes, handles and poses of the benchmarks."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
OWN_MODEL = ROOT / "blend_samples" / "models" / "spot.obj"


@dataclass(frozen=True)
class Case:
    """A mesh with its handles and their poses."""

    name: str
    points: np.ndarray  # (n, 3)
    faces: np.ndarray  # (m, 3) or (m, 4)
    handles: list[np.ndarray]  # vertex indices, one array per handle
    poses: np.ndarray  # (k, 3, 4)

    @property
    def vertex_count(self) -> int:
        return len(self.points)

    def points_posed(self, pose: np.ndarray) -> np.ndarray:
        return self.points @ pose[:, :3].T + pose[:, 3]


def box(size: tuple[float, float, float], step: float) -> tuple[np.ndarray, np.ndarray]:
    """A closed box of triangles with alternating diagonals; x from 0, y and z about 0."""
    counts = [max(1, round(length / step)) for length in size]
    lattice = np.stack(np.meshgrid(*(np.arange(k + 1) for k in counts), indexing="ij"), -1)
    on_surface = ((lattice == 0) | (lattice == counts)).any(-1)
    index = np.full(on_surface.shape, -1)
    index[on_surface] = np.arange(on_surface.sum())
    points = lattice[on_surface] / counts * size - (0, size[1] / 2, size[2] / 2)

    faces = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side, far in enumerate((0, counts[axis])):
            grid = np.take(index, far, axis)
            if u > v:  # np.take keeps the remaining axes in rising order
                grid = grid.T
            a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
            even = (np.add.outer(np.arange(a.shape[0]), np.arange(a.shape[1])) % 2).astype(bool)[..., None]
            first = np.where(even, np.stack([a, b, c], -1), np.stack([a, b, d], -1))
            second = np.where(even, np.stack([a, c, d], -1), np.stack([b, c, d], -1))
            both = np.concatenate([first.reshape(-1, 3), second.reshape(-1, 3)])
            faces.append(both if side else both[:, ::-1])
    return points, np.concatenate(faces)


def read_mesh(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Points and faces (all triangles or all quads) of an OBJ file."""
    lines = [line.split() for line in path.read_text(encoding="utf-8").splitlines()]
    points = [[float(word) for word in words[1:4]] for words in lines if words[:1] == ["v"]]
    faces = [[int(word.split("/")[0]) - 1 for word in words[1:]] for words in lines if words[:1] == ["f"]]
    return np.array(points), np.array(faces)


def turn(axis: tuple[float, float, float], degrees: float) -> np.ndarray:
    """(3, 3) rotation about an axis through the origin."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.radians(degrees)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def about(centre, axis, degrees: float, move=(0.0, 0.0, 0.0)) -> np.ndarray:
    """(3, 4) rotation about an axis through `centre`, then a translation."""
    rotation = turn(axis, degrees)
    shift = np.asarray(centre, float) - rotation @ np.asarray(centre, float) + move
    return np.column_stack([rotation, shift])


STILL = np.column_stack([np.eye(3), np.zeros(3)])
LENGTH, SLAB = 40.0, 2.0


def _bend(degrees: float) -> np.ndarray:
    """The pose of the far slab at the end of a circular arc that is as long as the free part."""
    radius = (LENGTH - 2 * SLAB) / np.radians(degrees)
    angle = np.radians(degrees)
    end = np.array([SLAB + radius * np.sin(angle), radius * (1 - np.cos(angle)), 0])
    return about((LENGTH - SLAB, 0, 0), (0, 0, 1), degrees, end - (LENGTH - SLAB, 0, 0))


BAR_POSES = {
    "bend 90": _bend(90),
    "bend 179": about((38, 0, 0), (0, 0, 1), 179, (2 - 38, 2 * 36 / np.pi, 0)),
    "twist 135": about((0, 0, 0), (1, 0, 0), 135),
    "stretch": about((0, 0, 0), (1, 0, 0), 0, (20, 0, 0)),
    "shift 20": about((0, 0, 0), (1, 0, 0), 0, (0, 20, 0)),
    "shift (-16, 22)": about((0, 0, 0), (1, 0, 0), 0, (-16, 22, 0)),
    "turn 120 + move": about((38, 0, 0), (1, 0.5, 1), 120, (-12, 15, 8)),
}


def bar(pose: str, vertices: int) -> Case:
    """A bar of 40 x 10 x 10. A slab of 2 at each end is held, and the far slab moves."""
    points, faces = box((LENGTH, 10, 10), np.sqrt(1800 / vertices))
    near = np.flatnonzero(points[:, 0] <= SLAB + 1e-4)
    far = np.flatnonzero(points[:, 0] >= LENGTH - SLAB - 1e-4)
    return Case(pose, points, faces, [near, far], np.stack([STILL, BAR_POSES[pose]]))


def bumpy_plate(vertices: int) -> Case:
    """A plate of side 10 with bumps of height .2, three per unit of length; its far end is bent up by 60
    degrees."""
    k = max(8, round(np.sqrt(vertices)) - 1)
    x, y = (w.ravel() for w in np.meshgrid(*2 * [np.linspace(0, 10, k + 1)], indexing="ij"))
    points = np.column_stack([x, y, 0.1 * (np.sin(3 * np.pi * x) * np.sin(3 * np.pi * y) + 1)])
    a = (np.arange(k)[:, None] * (k + 1) + np.arange(k)).ravel()
    faces = np.concatenate([np.stack([a, a + k + 1, a + k + 2], 1), np.stack([a, a + k + 2, a + 1], 1)])
    near, far = np.flatnonzero(x < 0.5), np.flatnonzero(x > 9.5)
    pose = about((9.5, 0, 0), (0, 1, 0), -60, (-2.0, 0, 4.0))
    return Case("bumpy plate", points, faces, [near, far], np.stack([STILL, pose]))


def own_model() -> Case:
    """The cow of the samples, with its hooves held and its head turned and lowered."""
    points, faces = read_mesh(OWN_MODEL)
    low, size = points.min(0), np.ptp(points, axis=0)
    u = (points - low) / size
    hooves = np.flatnonzero(u[:, 1] < 0.12)
    head = np.flatnonzero((u[:, 2] < 0.22) & (u[:, 1] > 0.55))
    pose = about(points[head].mean(0), (0, 1, 0), 50, np.array([0.2, -0.1, -0.1]) * size)
    return Case("cow", points, faces, [hooves, head], np.stack([STILL, pose]))
