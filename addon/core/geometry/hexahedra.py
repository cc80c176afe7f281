# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes of hexahedra, as NumPy arrays: points (c, 3) and the quads (q, 4) that are the sides of cells."""

import numpy as np

Cells = tuple[np.ndarray, np.ndarray]

_SIDES = np.array(((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)))
_CORNERS = np.array([(k & 1, k >> 1 & 1, k >> 2) for k in range(8)])


def sides(cells: np.ndarray) -> np.ndarray:
    """The sides (q, 4) of cells (n, 8), each once; corner k is at (k & 1, k >> 1 & 1, k >> 2)."""
    quads = cells[:, _SIDES].reshape(-1, 4)
    _same, first = np.unique(np.sort(quads, axis=1), axis=0, return_index=True)
    return quads[np.sort(first)]


def boxes(kept: np.ndarray) -> Cells:
    """The boxes of a grid that are ``kept`` (u, v, w), in the unit cube around the origin."""
    counts = np.array(kept.shape)
    cells = np.argwhere(kept)
    stride = np.array((1, counts[0] + 1, (counts[0] + 1) * (counts[1] + 1)))
    corners = (cells[:, None] + _CORNERS) @ stride
    used, renumbered = np.unique(corners, return_inverse=True)
    places = np.stack((used % stride[1], used % stride[2] // stride[1], used // stride[2]), axis=1)
    return places / counts - 0.5, sides(renumbered.reshape(-1, 8))


def cylinder(across: int, rings: int, along: int) -> Cells:
    """A cylinder of diameter and height 1 about z: a square core of ``across``^2 cells, and rings around it.

    So no cell is a wedge, and each ring has 4 ``across`` cells. ``along`` is how many layers there are.
    """
    line = np.linspace(-1.0, 1.0, across + 1)
    x, y = np.meshgrid(line, line, indexing="xy")
    square = np.stack((x.ravel(), y.ravel()), axis=1)
    inner = 0.5 / (rings + 1.0)
    core = inner * _towards_disk(square)
    at = np.arange((across + 1) ** 2).reshape(across + 1, across + 1)
    rim = np.concatenate((at[0, :-1], at[:-1, -1], at[-1, :0:-1], at[:0:-1, 0]))
    circle = square[rim] / np.linalg.norm(square[rim], axis=1, keepdims=True)
    shares = np.arange(1, rings + 1)[:, None, None] / rings
    outer = ((1.0 - shares) * core[rim] + shares * 0.5 * circle).reshape(-1, 2)
    flat = np.concatenate((core, outer))
    quads = [(at[j, i], at[j, i + 1], at[j + 1, i], at[j + 1, i + 1]) for j, i in np.ndindex(across, across)]
    lines = np.concatenate((rim, len(core) + np.arange(rings * len(rim)))).reshape(rings + 1, -1)
    after = np.roll(lines, -1, axis=1)
    for ring in range(rings):
        ends = (lines[ring], after[ring], lines[ring + 1], after[ring + 1])
        quads += list(zip(*ends, strict=True))
    layer = np.array(quads)
    points = np.concatenate(
        [np.column_stack((flat, np.full(len(flat), k / along - 0.5))) for k in range(along + 1)]
    )
    low = np.concatenate([layer + k * len(flat) for k in range(along)])
    return points, sides(np.concatenate((low, low + len(flat)), axis=1))


def _towards_disk(square: np.ndarray) -> np.ndarray:
    """Points of the square from -1 to 1, moved halfway to a disk, so that the core bulges a little."""
    radius = np.abs(square).max(axis=1, keepdims=True)
    length = np.maximum(np.linalg.norm(square, axis=1, keepdims=True), 1e-12)
    return square * (0.5 + 0.5 * radius / length)


def touched(points: np.ndarray, triangles: np.ndarray, counts: tuple[int, int, int]) -> np.ndarray:
    """The boxes (u, v, w) of the unit cube around the origin that hold points or triangles, or lie inside.

    ``points`` (n, 3) lie in the cube; ``triangles`` (t, 3) are sampled more densely than the boxes.
    """
    kept = np.zeros(counts, dtype=bool)
    _mark(kept, points)
    if len(triangles):
        a, b, c = (points[triangles[:, k]] * counts for k in range(3))
        longest = max(np.abs(b - a).max(), np.abs(c - a).max(), np.abs(c - b).max())
        steps = int(np.ceil(3.0 * longest)) + 1
        for i in range(steps + 1):
            for j in range(steps + 1 - i):
                u, v = i / steps, j / steps
                _mark(kept, (a + u * (b - a) + v * (c - a)) / counts)
    return kept | ~_reached_from_outside(kept)


def _mark(kept: np.ndarray, points: np.ndarray) -> None:
    counts = np.array(kept.shape)
    cells = np.clip(((points + 0.5) * counts).astype(int), 0, counts - 1)
    kept[tuple(cells.T)] = True


def _reached_from_outside(kept: np.ndarray) -> np.ndarray:
    """The empty boxes that are connected to the outside through sides."""
    free = np.pad(~kept, 1, constant_values=True)
    reached = np.zeros_like(free)
    reached[0] = True
    while True:
        grown = reached.copy()
        for axis in range(3):
            for step in (1, -1):
                moved = np.roll(reached, step, axis=axis)
                np.moveaxis(moved, axis, 0)[0 if step > 0 else -1] = False
                grown |= moved
        grown &= free
        if np.array_equal(grown, reached):
            return reached[1:-1, 1:-1, 1:-1]
        reached = grown
