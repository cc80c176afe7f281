# SPDX-License-Identifier: GPL-3.0-or-later
"""Animals on four legs, upright along z and looking along x: points (n, 3) and triangles (t, 3)."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.cases import OWN_MODEL, read_mesh
from blend_samples.comparison.figures import beast


def spot() -> tuple[np.ndarray, np.ndarray]:
    """A young cow."""
    points, faces = read_mesh(OWN_MODEL)
    return points @ np.array([(0, 1, 0), (0, 0, 1), (-1, 0, 0)], float), faces


def animal() -> tuple[np.ndarray, np.ndarray]:
    """The one of the comparison, with thin legs."""
    case = beast()
    return case.points, case.triangles
