# SPDX-License-Identifier: GPL-3.0-or-later
"""Harmonic coordinates against finite differences in NumPy, and what their report tells."""

import numpy as np
import scipy.sparse as sparse
import scipy.sparse.linalg as linalg

import sinew_native as sn

from ..cages import bound, u_prism

CAPS = [(0, 1, 4), (0, 4, 5), (1, 2, 3), (1, 3, 4), (0, 5, 6), (0, 6, 7)]  # triangles of the outline


def surface() -> sn.SurfaceMesh:
    """Of triangles."""
    quads = u_prism(CAPS)
    return sn.SurfaceMesh(quads.points, quads.triangles)


def on_surface(points: np.ndarray) -> np.ndarray:
    """(n, 16) the vertices as linear functions on the triangles, for points on these."""
    cage, found = surface(), np.zeros((len(points), 16))
    for corners in cage.triangles:
        a, b, c = cage.points[corners]
        frame = np.column_stack([b - a, c - a, np.cross(b - a, c - a)])
        u, v, away = np.linalg.solve(frame, (points - a).T)
        holds = (abs(away) < 1e-9) & (np.minimum(u, v) > -1e-9) & (u + v < 1 + 1e-9)
        found[holds] = 0.0
        found[np.ix_(holds, corners)] = np.stack([1 - u - v, u, v], 1)[holds]
    return found


def by_differences(cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes inside the U and the harmonic functions there, by the seven-point Laplacian on an even grid."""
    x, y, z = (part.ravel() for part in np.mgrid[: 3 * cells + 1, : 3 * cells + 1, : cells + 1])
    hollow = (x > cells) & (x < 2 * cells) & (y > cells)
    rim = (x == 0) | (x == 3 * cells) | (y == 0) | (y == 3 * cells)
    rim |= ((x == cells) | (x == 2 * cells)) & (y >= cells)
    rim |= (y == cells) & (x >= cells) & (x <= 2 * cells)
    used = ~hollow
    free = used & ~rim & (z > 0) & (z < cells)
    nodes = np.stack((x, y, z), -1) / cells
    data = np.zeros((len(x), 16))
    data[used & ~free] = on_surface(nodes[used & ~free])
    strides = ((3 * cells + 1) * (cells + 1), cells + 1, 1)
    at = np.flatnonzero(free)
    number = np.full(len(x), -1)
    number[at] = np.arange(len(at))
    matrix = sparse.identity(len(at), format="csr") * 6.0
    right = np.zeros((len(at), 16))
    for step in (*strides, *(-stride for stride in strides)):
        beside = at + step
        linked = number[beside] >= 0
        entries = np.ones(linked.sum()), (np.flatnonzero(linked), number[beside[linked]])
        matrix -= sparse.csr_matrix(entries, shape=(len(at), len(at)))
        right[~linked] += data[beside[~linked]]
    solution = linalg.splu(matrix.tocsc()).solve(right)
    return nodes[at], solution


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
