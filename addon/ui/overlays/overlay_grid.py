# SPDX-License-Identifier: GPL-3.0-or-later
"""Control grids and graphs as meshes that an overlay draws: bars along their lines, beads at their points."""

from collections.abc import Sequence

import numpy as np

_BAR = 0.012  # half the thickness of a bar, as a share of the mean distance of neighbouring points
_BEAD = 0.05
_LINE_COLOUR = (0.30, 0.55, 0.90)
_POINT_COLOUR = (0.98, 0.80, 0.25)
_AXES = np.concatenate((np.eye(3), -np.eye(3)))
_OCTAHEDRON = np.array(
    [(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5)]
)
_SIDES = np.array(
    [(k, (k + 1) % 4, 4 + k) for k in range(4)] + [((k + 1) % 4, 4 + (k + 1) % 4, 4 + k) for k in range(4)]
)


def grid_mesh(grids: Sequence[np.ndarray], opacity: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points float32 (m, 3), triangles int32 (t, 3), colours float32 (m, 4). A grid is (rows, columns, 3)."""
    return _mesh([shape for grid in grids for shape in _grid(np.asarray(grid, dtype=np.float64))], opacity)


def graph_mesh(
    nodes: np.ndarray, links: np.ndarray, opacity: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The same for nodes (m, 3) and links (l, 2) between them."""
    return _mesh(_shapes(nodes[links[:, 0]], nodes[links[:, 1]], nodes), opacity)


_Shape = tuple[np.ndarray, np.ndarray, tuple[float, float, float]]


def _mesh(parts: Sequence[_Shape], opacity: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    points, triangles, paints, count = [], [], [], 0
    for corners, faces, colour in parts:
        points.append(corners)
        triangles.append(faces + count)
        paints.append(np.broadcast_to((*colour, opacity), (len(corners), 4)))
        count += len(corners)
    return (
        np.concatenate(points).astype(np.float32),
        np.concatenate(triangles).astype(np.int32),
        np.concatenate(paints).astype(np.float32),
    )


def _grid(grid: np.ndarray) -> list[_Shape]:
    starts = np.concatenate((grid[:, :-1].reshape(-1, 3), grid[:-1].reshape(-1, 3)))
    ends = np.concatenate((grid[:, 1:].reshape(-1, 3), grid[1:].reshape(-1, 3)))
    return _shapes(starts, ends, grid.reshape(-1, 3))


def _shapes(starts: np.ndarray, ends: np.ndarray, beaded: np.ndarray) -> list[_Shape]:
    lengths = np.linalg.norm(ends - starts, axis=1)
    size = lengths.mean() if len(lengths) else 0.0
    along = (ends - starts) / np.maximum(lengths, 1e-30)[:, None]
    away = np.eye(3)[np.abs(along).argmin(axis=1)]  # the axis that is farthest from the line
    across = np.cross(along, away)
    across /= np.maximum(np.linalg.norm(across, axis=1), 1e-30)[:, None]
    corners = np.stack((across, np.cross(along, across), -across, -np.cross(along, across)), axis=1)
    bars = np.concatenate(
        (starts[:, None] + _BAR * size * corners, ends[:, None] + _BAR * size * corners), axis=1
    )
    beads = beaded[:, None] + _BEAD * size * _AXES
    return [
        (bars.reshape(-1, 3), _repeated(_SIDES, len(bars), 8), _LINE_COLOUR),
        (beads.reshape(-1, 3), _repeated(_OCTAHEDRON, len(beads), 6), _POINT_COLOUR),
    ]


def _repeated(faces: np.ndarray, times: int, corners: int) -> np.ndarray:
    return (faces + corners * np.arange(times)[:, None, None]).reshape(-1, 3)
