# SPDX-License-Identifier: GPL-3.0-or-later
"""The nonlinear thin shell against its definition in NumPy and Gauss-Newton in SciPy, without shared code."""

import numpy as np
import pytest
import scipy.sparse as sparse

import sinew_native as sn

from ..meshes import STILL, bar, grid, sphere, spread, turn
from ..methods import bound_to
from .rows import Rows

POINTS, FACES = sphere(3)
POLES = [np.flatnonzero(POINTS[:, 2] < -0.8), np.flatnonzero(POINTS[:, 2] > 0.8)]
TURNED = np.stack([STILL, turn((1, 0, 0), 50, (0, 0, 1), (0.3, 0.4, 0.2))])
THICKNESSES = (0.05, 0.2)


def shell_rows(points: np.ndarray, faces: np.ndarray, k_s: float, k_b: float) -> Rows:
    """The energy of the header, for manifold meshes of sound triangles: seven rows per hinge."""
    sides: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for t, face in enumerate(faces.tolist()):
        for k in range(3):
            a, b = face[(k + 1) % 3], face[(k + 2) % 3]
            sides.setdefault((min(a, b), max(a, b)), []).append((t, face[k]))
    pairs = [(edge, found) for edge, found in sides.items() if len(found) == 2]
    corners = np.array([(*edge, found[0][1], found[1][1]) for edge, found in pairs])
    triangles = np.array([[side[0] for side in found] for _edge, found in pairs])
    share = 1.0 / np.bincount(triangles.ravel(), minlength=len(faces))[triangles]

    p = points[corners]  # (m, 4, 3): both ends of the edge, then what lies opposite
    e = p[:, 1] - p[:, 0]
    areas, rows, weights, bend = [], [], [], np.zeros((len(corners), 4))
    for side in range(2):
        a, b, c = 0, 1, 2 + side
        area = 0.5 * np.linalg.norm(np.cross(e, p[:, c] - p[:, 0]), axis=1)
        areas.append(area)
        for i, j, k in ((a, b, c), (b, c, a), (c, a, b)):  # the edge (i, j) opposite k
            cotan = np.einsum("mi,mi->m", p[:, i] - p[:, k], p[:, j] - p[:, k]) / (2 * area)
            row = np.zeros((len(corners), 4))
            row[:, i], row[:, j] = 1.0, -1.0
            rows.append(row)
            weights.append(0.5 * k_s * share[:, side] * cotan)
            if k != c:  # this cotangent stands at an end of the hinge, at k
                bend[:, b if k == a else a] += cotan
                bend[:, c] -= cotan
    areas_of_both = areas[0] + areas[1]
    own = k_s * share.mean(1) * areas_of_both**2 / (4 * np.einsum("mi,mi->m", e, e))
    rows.append(bend)
    weights.append(np.maximum(k_b - own, 0.0) / areas_of_both)
    m = len(corners)
    columns = np.repeat(corners, 7, axis=0)
    at = np.repeat(np.arange(7 * m), 4)
    D = sparse.csr_matrix((np.stack(rows, 1).ravel(), (at, columns.ravel())), (7 * m, len(points)))
    return Rows(D, D @ points, np.repeat(np.arange(m), 7), np.stack(weights, 1).ravel())


def shells(thickness: float) -> tuple["sn.ThinShellNonlinear", Rows]:
    shell = sn.ThinShellNonlinear(sn.SurfaceMesh(POINTS, FACES), measure="length", thickness=thickness)
    shell.set_handles(POLES)
    return shell, shell_rows(POINTS, FACES, 1.0, thickness**2)


@pytest.mark.parametrize("thickness", [0.01, 0.3, 2.0])
@pytest.mark.parametrize("surface", [(POINTS, FACES), grid(4), bar(4, 2)], ids=["sphere", "hill", "squares"])
def test_energy_is_that_of_the_definition(surface, thickness: float) -> None:
    """Of acute triangles, obtuse ones, and right angles on both sides of each edge."""
    points, faces = surface
    mesh = sn.SurfaceMesh(points, faces)
    shell = bound_to(sn.ThinShellNonlinear(mesh, measure="length", thickness=thickness), [[0]])
    oracle = shell_rows(points, mesh.triangles, 1.0, thickness**2)
    rng = np.random.default_rng(4)
    for size in (0.01, 0.1, 1.0):
        q = points + size * rng.normal(size=points.shape)
        # Thousands of terms round.
        assert shell.energy(q) == pytest.approx(oracle.energy(q), rel=1e-10)


def test_gradient_of_the_definition_is_that_of_differences() -> None:
    shell, oracle = shells(0.2)
    rng = np.random.default_rng(5)
    q = POINTS + 0.05 * rng.normal(size=POINTS.shape)
    way = rng.normal(size=q.shape)
    step = 1e-5
    slope = (shell.energy(q + step * way) - shell.energy(q - step * way)) / (2 * step)
    assert slope == pytest.approx(float((oracle.gradient(q) * way).sum()), rel=1e-7)


@pytest.mark.parametrize("thickness", THICKNESSES)
def test_gauss_newton_ends_in_the_same_shape(thickness: float) -> None:
    shell, oracle = shells(thickness)
    start, _ = shell.solve(TURNED, max_iterations=0)
    ours, report = shell.solve(TURNED, max_iterations=2000, tolerance=1e-14)
    shape, energy, _turns = oracle.minimum(start, np.setdiff1d(np.arange(len(POINTS)), np.concatenate(POLES)))
    assert report.energy == pytest.approx(energy, rel=1e-4)
    # Both energies are flat at their minimum: half of the digits of the energy.
    assert np.abs(ours - shape).max() < 1e-3


def test_reported_energy_is_that_of_the_returned_shape() -> None:
    shell, oracle = shells(0.1)
    for budget in (0, 3, 40):
        shape, report = shell.solve(TURNED, max_iterations=budget, tolerance=0.0)
        assert report.energy == pytest.approx(oracle.energy(shape), rel=1e-9)


def test_vertices_where_the_sheet_is_too_thin_for_the_mesh_are_named() -> None:
    points, faces = grid(8, jitter=0.0)
    points *= (1, 1, 0)

    def thin(thickness: float | np.ndarray) -> np.ndarray:
        shell = sn.ThinShellNonlinear(sn.SurfaceMesh(points, faces), measure="length", thickness=thickness)
        return shell.set_handles([[0]]).thin_vertices

    assert len(thin(1.0)) == 0
    assert len(thin(0.1)) == 79  # two corners lie at no inner edge
    named = thin(np.where(points[:, 0] < 3.5, 0.0, 1.0))
    assert points[named, 0].max() < 4.5
    assert len(named) >= 27


def test_measures_are_ways_to_say_the_same() -> None:
    points, faces = bar(12, 3)
    handles = [np.flatnonzero(points[:, 0] <= 2), np.flatnonzero(points[:, 0] >= 10)]
    size = spread(points, faces)
    shapes = []
    for words in (
        {"thickness": 0.05},
        {"measure": "length", "thickness": 0.05 * size},
        {"measure": "stiffness", "stretching": 4.0, "bending": 0.01 * size**2},  # four times both
    ):
        shell = bound_to(sn.ThinShellNonlinear(sn.SurfaceMesh(points, faces), **words), handles)
        shapes.append(shell.solve([STILL, turn((0, 0, 1), 60, (10, 0, 0), (-2, 4, 0))])[0])
    np.testing.assert_allclose(shapes[1:], [shapes[0]] * 2, rtol=0, atol=1e-6)
