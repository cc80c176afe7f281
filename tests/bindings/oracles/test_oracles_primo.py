# SPDX-License-Identifier: GPL-3.0-or-later
"""Primo against joint Gauss-Newton steps on the energy of the paper, in NumPy and SciPy."""

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import STILL, bar, grid, halved, spread, turn
from .prisms import Prisms

TUBE, QUADS = bar(16, 4)
HILL, HILL_FACES = grid(10)
ENDS = [np.flatnonzero(TUBE[:, 0] <= 1), np.flatnonzero(TUBE[:, 0] >= 15)]
SIDES = [np.flatnonzero(HILL[:, 0] < 1.5), np.flatnonzero(HILL[:, 0] > 8.5), np.array([60])]
BENDS = np.stack([STILL, turn((0, 0, 1), 70, (15, 0, 0), (-3, 7, 0))])
TWISTS = np.stack([STILL, turn((1, 0, 0), 100)])
PULLS = np.stack(
    [STILL, turn((1, 2, 0.5), 50, (9, 5, 0), (-1, 0, 2)), turn((0, 0, 1), 0, (0, 0, 0), (0, 0, 1.5))]
)


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
    height = 0.05
    primo = sn.Primo(sn.SurfaceMesh(points, faces), height=height)
    primo.set_handles(handles)
    start, first = primo.solve(poses, max_iterations=0)
    found, report = primo.solve(poses, max_iterations=3000, tolerance=1e-13)
    size = spread(points, faces)
    oracle = Prisms(points, faces, handles, poses, height * size)
    oracle.start_from(start)
    energy = oracle.gauss_newton()
    # Rotations lag behind positions by a part of a step: the last steps win nothing, 4e-6 on the hill.
    assert report.energy == pytest.approx(energy, rel=1e-5)
    assert first.energy < 1.3 * energy
    assert np.abs(found - oracle.vertices()).max() < 1e-4 * size
    # A frame is within a per cent.
    frame = primo.solve(poses)[0]
    assert np.sqrt(((frame - found) ** 2).mean() / ((found - points) ** 2).mean()) < 0.01


def test_counts_turned_faces() -> None:
    x, y = (w.ravel() for w in np.meshgrid(np.arange(5.0), np.arange(5.0)))
    first = np.array([5 * row + column for row in range(4) for column in range(4)])
    quads = np.stack([first, first + 1, first + 6, first + 5], 1)
    primo = sn.Primo(sn.SurfaceMesh(np.stack([x, y, 0 * x], 1), quads), height=0.5)
    rim = np.flatnonzero((x % 4 == 0) | (y % 4 == 0))
    primo.set_handles([np.append(rim, 13), np.array([12])])
    for shift, turned in ((0.2, False), (4.0, True)):
        poses = np.stack([STILL, turn((0, 0, 1), 0, (0, 0, 0), (shift, 0, 0))])
        assert (primo.solve(poses)[1].inverted_faces > 0) == turned
