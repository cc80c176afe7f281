# SPDX-License-Identifier: GPL-3.0-or-later
"""Primo against joint Gauss-Newton steps on the energy of the paper, in NumPy and SciPy."""

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import STILL, bar, grid, halved, quad_grid, shift, spread, turn
from .prisms import Prisms

TUBE, QUADS = bar(16, 4)
HILL, HILL_FACES = grid(10)
ENDS = [np.flatnonzero(TUBE[:, 0] <= 1), np.flatnonzero(TUBE[:, 0] >= 15)]
SIDES = [np.flatnonzero(HILL[:, 0] < 1.5), np.flatnonzero(HILL[:, 0] > 8.5), np.array([60])]
BENDS = np.stack([STILL, turn((0, 0, 1), 70, (15, 0, 0), (-3, 7, 0))])
TWISTS = np.stack([STILL, turn((1, 0, 0), 100)])
PULLS = np.stack([STILL, turn((1, 2, 0.5), 50, (9, 5, 0), (-1, 0, 2)), shift(0, 0, 1.5)])


@pytest.mark.parametrize(
    ("points", "faces", "handles", "poses"),
    [
        (TUBE, QUADS, ENDS, BENDS),
        (TUBE, halved(QUADS), ENDS, BENDS),
        (TUBE, halved(QUADS), ENDS, TWISTS),
        (HILL, HILL_FACES, SIDES, PULLS),  # with a single vertex
    ],
    ids=["quads, bend", "triangles, bend", "triangles, twist", "hill"],
)
def test_ends_where_joint_steps_end(points, faces, handles, poses) -> None:
    size, height = spread(points, faces), 0.05
    primo = sn.Primo(sn.SurfaceMesh(points, faces), height=height)
    primo.set_handles(handles)
    start, first = primo.solve(poses, max_iterations=0)
    found, report = primo.solve(poses, max_iterations=3000, tolerance=1e-13)
    oracle = Prisms(points, faces, handles, poses, height * size)
    oracle.start_from(start)
    energy = oracle.gauss_newton()
    # Rotations lag behind positions by a part of a step: the last steps win nothing, 4e-6 on the hill.
    assert report.energy == pytest.approx(energy, rel=1e-5)
    assert first.energy < 1.3 * energy
    assert np.abs(found - oracle.vertices()).max() < 1e-4 * size
    # A frame is within a per cent.
    assert np.linalg.norm(primo.solve(poses)[0] - found) < 0.01 * np.linalg.norm(found - points)


def test_counts_turned_faces() -> None:
    points, quads = quad_grid(4, 4)
    primo = sn.Primo(sn.SurfaceMesh(points, quads), height=0.5)
    rim = np.flatnonzero((points[:, :2] % 4 == 0).any(1))
    primo.set_handles([np.append(rim, 13), [12]])
    for far, turned in ((0.2, False), (4.0, True)):
        assert (primo.solve([STILL, shift(far, 0, 0)])[1].inverted_faces > 0) == turned
