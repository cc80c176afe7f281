# SPDX-License-Identifier: GPL-3.0-or-later
"""Harmonic coordinates against finite differences in NumPy, and what their report tells."""

import numpy as np
import scipy.sparse as sparse
import scipy.sparse.linalg as linalg

import sinew_native as sn

from ..cages import OUTLINE, bound, u_prism

CAPS = [(0, 1, 4), (0, 4, 5), (1, 2, 3), (1, 3, 4), (0, 5, 6), (0, 6, 7)]  # triangles of the outline


def surface() -> sn.SurfaceMesh:
    return u_prism(CAPS)


def caps_data(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(n, 8) the outline's vertices as linear functions on the triangles of a cap."""
    found = np.zeros((len(x), 8))
    done = np.zeros(len(x), bool)
    for triangle in CAPS:
        system = np.vstack((OUTLINE[list(triangle)].T, np.ones(3)))
        hats = np.linalg.solve(system, np.vstack((x, y, np.ones_like(x)))).T
        holds = (hats > -1e-9).all(1) & ~done
        found[np.ix_(holds, triangle)] = hats[holds]
        done |= holds
    return found


def side_data(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(n, 8) the same along the sides of the outline."""
    found = np.zeros((len(x), 8))
    done = np.zeros(len(x), bool)
    for i, (start, along) in enumerate(zip(OUTLINE, np.roll(OUTLINE, -1, 0) - OUTLINE, strict=True)):
        away = np.stack((x, y), -1) - start
        share = away @ along / (along @ along)
        holds = (abs(away[:, 0] * along[1] - away[:, 1] * along[0]) < 1e-9) & (abs(share - 0.5) < 0.5 + 1e-9)
        holds &= ~done
        found[holds, i], found[holds, (i + 1) % 8] = 1 - share[holds], share[holds]
        done |= holds
    return found


def by_differences(cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes inside the U and the harmonic functions there, by the seven-point Laplacian on an even grid."""
    x, y, z = (part.ravel() for part in np.mgrid[: 3 * cells + 1, : 3 * cells + 1, : cells + 1])
    hollow = (x > cells) & (x < 2 * cells) & (y > cells)
    rim = (x == 0) | (x == 3 * cells) | (y == 0) | (y == 3 * cells)
    rim |= ((x == cells) | (x == 2 * cells)) & (y >= cells)
    rim |= (y == cells) & (x >= cells) & (x <= 2 * cells)
    caps = (z == 0) | (z == cells)
    used = ~hollow
    free = used & ~rim & ~caps
    data = np.zeros((len(x), 16))
    for level, half in ((0, slice(0, 8)), (1, slice(8, 16))):
        on_side = used & rim
        height = z[on_side] / cells
        share = height if level else 1 - height
        data[on_side, half] = share[:, None] * side_data(x[on_side] / cells, y[on_side] / cells)
        on_cap = used & ~rim & (z == level * cells)
        data[on_cap, half] = caps_data(x[on_cap] / cells, y[on_cap] / cells)
    strides = ((3 * cells + 1) * (cells + 1), cells + 1, 1)
    at = np.flatnonzero(free)
    number = np.full(len(x), -1)
    number[at] = np.arange(len(at))
    matrix = sparse.identity(len(at), format="csr") * 6.0
    right = np.zeros((len(at), 16))
    for step in (*strides, *(-stride for stride in strides)):
        beside = at + step
        linked = number[beside] >= 0
        rows = np.flatnonzero(linked)
        matrix -= sparse.csr_matrix(
            (np.ones(len(rows)), (rows, number[beside[linked]])), shape=(len(at), len(at))
        )
        right[~linked] += data[beside[~linked]]
    solution = linalg.splu(matrix.tocsc()).solve(right)
    return np.stack((x, y, z), -1)[at] / cells, solution


def test_finite_differences_converge_to_harmonic() -> None:
    errors = []
    for cells in (5, 10):
        nodes, expected = by_differences(cells)
        harmonic = bound(sn.Harmonic, surface(), nodes, quality="medium")
        errors.append(np.abs(harmonic.vertex_weights - expected).max(axis=1))
    coarse, fine = errors
    # The grid errs by h^(2/3) at the two edges of 270 degrees, by h^2 log h elsewhere: 1.6 to 4 a halving.
    assert fine.max() < 4e-2
    assert fine.mean() < 2e-3
    assert coarse.mean() > 1.6 * fine.mean()


def test_the_report_tells_the_quality() -> None:
    x = np.random.default_rng(0).uniform((0.05, 0.05, 0.05), (0.95, 2.95, 0.95), (20, 3))
    for solver in ("boundary", "lattice"):
        steps, weights = [], []
        for quality in ("fast", "medium"):
            harmonic = sn.Harmonic(surface(), quality=quality, solver=solver, precision="double")
            assert harmonic.unknowns == 0
            steps.append((harmonic.bind(x).error, harmonic.residual_rms, harmonic.unknowns))
            weights.append(harmonic.vertex_weights)
        (error, rms, unknowns), (finer_error, finer_rms, more) = steps
        assert 0 < finer_error < error
        assert unknowns < more
        difference = np.abs(weights[1] - weights[0]).max()
        assert 0.02 * error < difference < 2 * error
        if solver == "boundary":
            assert unknowns <= 1000 < more <= 2000
            assert 0 < finer_rms < rms <= harmonic.residual_max < 0.02
        else:
            assert harmonic.residual_max == 0
