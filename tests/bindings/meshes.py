# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes, handles and poses that the tests of the Python module share."""

import numpy as np

STILL = np.column_stack([np.eye(3), np.zeros(3)])


def grid(n: int, jitter: float = 0.2) -> tuple[np.ndarray, np.ndarray]:
    """A hill over n x n cells of the plane, cut into triangles: points and faces."""
    y, x = np.mgrid[: n + 1, : n + 1].astype(float)
    inner = (x > 0) & (x < n) & (y > 0) & (y < n)
    moves = np.random.default_rng(1).uniform(-jitter, jitter, (2, *x.shape)) * inner
    x, y = x + moves[0], y + moves[1]
    points = np.stack([x, y, 0.1 * n * np.sin(3 * x / n) * np.cos(2 * y / n)], -1).reshape(-1, 3)
    v = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = (part.ravel() for part in (v[:-1, :-1], v[:-1, 1:], v[1:, 1:], v[1:, :-1]))
    return points, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def quad_grid(columns: int, rows: int, spacing: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Squares of the plane, row by row."""
    j, i = np.mgrid[: rows + 1, : columns + 1].reshape(2, -1)
    first = np.flatnonzero((i < columns) & (j < rows))
    points = spacing * np.column_stack([i, j, 0.0 * i])
    return points, first[:, None] + (0, 1, columns + 2, columns + 1)


def tube(along: int, around: int) -> tuple[np.ndarray, np.ndarray]:
    """Of quads, outward and open, around the x axis: of the radius 1, with rings at 0, 1, 2..."""
    x, j = np.mgrid[: along + 1, :around].reshape(2, -1)
    a = np.flatnonzero(x < along)
    b = a - j[a] + (j[a] + 1) % around
    angle = 2 * np.pi * j / around
    return np.column_stack([x, np.cos(angle), np.sin(angle)]), np.stack([a, a + around, b + around, b], 1)


def halved(quads: np.ndarray) -> np.ndarray:
    return np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])


def bar(along: int, across: int) -> tuple[np.ndarray, np.ndarray]:
    """An open tube of quads with a square section, around the x axis."""
    ring = [(across / 2, y - across / 2) for y in range(across)]
    ring += [(across / 2 - z, across / 2) for z in range(across)]
    ring += [(-across / 2, across / 2 - y) for y in range(across)]
    ring += [(z - across / 2, -across / 2) for z in range(across)]
    points = np.array([(x, y, z) for x in range(along + 1) for y, z in ring], float)
    k = len(ring)
    i, a = np.arange(k * along) % k, np.arange(k * along)
    b = a - i + (i + 1) % k
    return points, np.stack([a, b, b + k, a + k], 1)


def closed_bar(along: int, across: int) -> tuple[np.ndarray, tuple[list[int], np.ndarray]]:
    """The same with a polygon at each end: points, and faces as counts and corners."""
    points, quads = bar(along, across)
    k = 4 * across
    lids = [np.arange(k)[::-1], len(points) - k + np.arange(k)]
    return points, ([4] * len(quads) + [k, k], np.concatenate([quads.ravel(), *lids]))


def torus(around: int, across: int) -> tuple[np.ndarray, np.ndarray]:
    """Of quads, outward, around the z axis at distance 3, with the radius 1."""
    a, b = np.mgrid[:around, :across].reshape(2, -1)
    u, v = 2 * np.pi * a / around, 2 * np.pi * b / across
    far = 3 + np.cos(v)
    next_a, next_b = (a + 1) % around * across, (b + 1) % across
    faces = np.stack([a * across + b, next_a + b, next_a + next_b, a * across + next_b], 1)
    return np.column_stack([far * np.cos(u), far * np.sin(u), np.sin(v)]), faces


def messy() -> tuple[np.ndarray, np.ndarray]:
    """A hill with a doubled face, one without area, a needle, one with a corner twice, a fin on an inner
    edge, a part of its own and a loose vertex.
    """
    points, faces = grid(8)
    n = len(points)
    middle, near, fin = points[10:12].mean(0), points[30] + (0, 1e-9, 1e-9), points[50] + (0, 0, 2)
    more = [middle, near, fin, (20, 0, 0), (21, 0, 0), (20, 1, 0), (0, 20, 0)]
    odd = [faces[20], (10, 11, n), (30, 31, n + 1), (40, 40, 41), (50, 51, n + 2), (n + 3, n + 4, n + 5)]
    return np.concatenate([points, more]), np.concatenate([faces, odd])


def joined(*meshes: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """All in one, faces of as many corners each."""
    firsts = np.cumsum([0] + [len(points) for points, _ in meshes])
    faces = [first + faces for first, (_, faces) in zip(firsts, meshes)]
    return np.concatenate([points for points, _ in meshes]), np.concatenate(faces)


def sphere(level: int) -> tuple[np.ndarray, np.ndarray]:
    """An octahedron refined onto the unit sphere; no obtuse triangle, so all cotangents are positive."""
    corners = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    points = [np.array(corner, float) for corner in corners]
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    for _ in range(level):
        middles: dict[tuple[int, int], int] = {}

        def middle(i: int, j: int, middles=middles) -> int:
            key = (min(i, j), max(i, j))
            if key not in middles:
                middles[key] = len(points)
                points.append((points[i] + points[j]) / np.linalg.norm(points[i] + points[j]))
            return middles[key]

        finer = []
        for i, j, k in faces:
            a, b, c = middle(i, j), middle(j, k), middle(k, i)
            finer += [(i, a, c), (a, j, b), (c, b, k), (a, b, c)]
        faces = finer
    return np.array(points), np.array(faces)


def spread(points: np.ndarray, faces: np.ndarray) -> float:
    """The size of a surface: four times the root mean square of the distance of its area from its middle."""
    fans = [np.stack((faces[:, 0], faces[:, k - 1], faces[:, k]), axis=1) for k in range(2, faces.shape[1])]
    corners = points[np.concatenate(fans)]
    sides = corners[:, 1:] - corners[:, :1]
    doubled = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    middles = (corners + np.roll(corners, 1, axis=1)) / 2  # three points with a third of the area: exact
    weights = np.repeat(doubled[:, None], 3, axis=1) / (3 * doubled.sum())
    centre = np.einsum("tk,tkx->x", weights, middles)
    return 4 * np.sqrt(np.einsum("tk,tkx->", weights, (middles - centre) ** 2))


def ends(points: np.ndarray, depth: float = 1.6) -> list[np.ndarray]:
    """Vertices near the lowest and the highest x."""
    x = points[:, 0]
    return [np.flatnonzero(x <= x.min() + depth), np.flatnonzero(x >= x.max() - depth)]


def shift(x: float, y: float, z: float) -> np.ndarray:
    return np.column_stack([np.eye(3), (x, y, z)])


def turn(axis, degrees: float, centre=(0.0, 0.0, 0.0), move=(0.0, 0.0, 0.0)) -> np.ndarray:
    """(3, 4) rotation about an axis through `centre`, then a translation."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.radians(degrees)
    rotation = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return np.column_stack([rotation, np.asarray(centre) - rotation @ centre + move])


def moved(pose: np.ndarray, points: np.ndarray) -> np.ndarray:
    return points @ pose[:, :3].T + pose[:, 3]


def carried(poses: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Each point (n, 3) by a pose of its own."""
    return np.einsum("nij,nj->ni", poses[:, :, :3], points) + poses[:, :, 3]


def off(a: np.ndarray, b: np.ndarray) -> float:
    """The longest way from a point to its fellow."""
    return np.linalg.norm(a - b, axis=1).max()


def nearest_rotations(matrices: np.ndarray) -> np.ndarray:
    """(..., 3, 3), by singular values."""
    U, _, Vt = np.linalg.svd(matrices)
    U[..., 2] *= np.sign(np.linalg.det(U @ Vt))[..., None]
    return U @ Vt


def edges_of(faces: np.ndarray) -> np.ndarray:
    """Each edge of faces of as many corners once, (e, 2)."""
    sides = np.stack([faces, np.roll(faces, -1, axis=1)], -1).reshape(-1, 2)
    return np.unique(np.sort(sides, axis=1), axis=0)


def angles_filled(points: np.ndarray, mesh: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """How often (n,) a surface winds around points (n, 3), by the angles that its triangles fill."""
    a, b, c = (mesh[triangles[:, k]] - points[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=2) for v in (a, b, c))
    dots = [np.einsum("ijk,ijk->ij", u, v) for u, v in ((a, b), (b, c), (c, a))]
    volume = np.einsum("ijk,ijk->ij", a, np.cross(b, c))
    angles = np.arctan2(volume, la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb)
    return angles.sum(axis=1) / (2 * np.pi)


BENT = np.stack([STILL, turn((0, 1, 0), 40, (6, 0, 0), (-1, 0.5, 2))])
