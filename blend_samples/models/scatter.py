# SPDX-License-Identifier: GPL-3.0-or-later
"""Points scattered over a surface, and the cells around them. The same input gives the same points."""

import numpy as np
from mathutils.kdtree import KDTree


def lobes(points: np.ndarray, spacing: float, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cells around scattered points: offset (n, 3) from it, distance (n,) to the border, cell (n,)."""
    centres = points[scatter(points, spacing, seed)]
    tree = KDTree(len(centres))
    for i, centre in enumerate(centres):
        tree.insert(centre, i)
    tree.balance()
    found = [tree.find_n(point, 2) for point in points]
    gap = np.array([second[2] - first[2] for first, second in found])
    cell = np.array([first[1] for first, _ in found])
    return points - centres[cell], gap, cell


def scatter(points: np.ndarray, spacing: float, seed: int) -> np.ndarray:
    """Indices of points at least ``spacing`` apart, chosen at random but the same each time."""
    tree = KDTree(len(points))
    for i, point in enumerate(points):
        tree.insert(point, i)
    tree.balance()
    free = np.ones(len(points), bool)
    kept = []
    for i in np.random.default_rng(seed).permutation(len(points)):
        if free[i]:
            kept.append(int(i))
            free[[near[1] for near in tree.find_range(points[i], spacing)]] = False
    return np.array(kept)
