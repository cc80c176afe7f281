# SPDX-License-Identifier: GPL-3.0-or-later
"""Thin shells on the ring 1 <= r <= 2, lifted by 1 at r = 1 and held at r = 2, against closed solutions."""

import mpmath as mp
import numpy as np
import pytest

import sinew_native as sn

from ..meshes import STILL, shift

# Radial solutions of Delta^3 u = 0.
SOLUTIONS = [lambda r, p=p, q=q: r**p * mp.log(r) ** q for p in (0, 2, 4) for q in (0, 1)]


def slope_of_laplacian(u, r):
    return mp.diff(lambda s: mp.diff(u, s, 2) + mp.diff(u, s) / s, r)


def triharmonic(third) -> float:
    """u(1.5) for the values 1 and 0 and the slope 0 at the borders, and ``third`` = 0 there."""
    conditions = [(condition, r) for condition in (lambda u, r: u(r), mp.diff, third) for r in (1, 2)]
    K = mp.matrix([[condition(u, mp.mpf(r)) for u in SOLUTIONS] for condition, r in conditions])
    share = mp.lu_solve(K, mp.matrix([1, 0, 0, 0, 0, 0]))
    return float(sum(c * u(mp.mpf(1.5)) for c, u in zip(share, SOLUTIONS)))


def annulus(cells: int, depth: int, sectors: int) -> tuple[sn.SurfaceMesh, list[np.ndarray], np.ndarray]:
    """``cells`` rings between the borders and ``depth`` more on either side: mesh, handles, and r = 1.5."""
    i, j = (part.ravel() for part in np.mgrid[: cells + 2 * depth + 1, :sectors])
    r, angle = 1 + (i - depth) / cells, 2 * np.pi * (j + 0.5 * (i % 2)) / sectors
    points = np.stack([r * np.cos(angle), r * np.sin(angle), 0 * r], 1)
    a, b = sectors * i + j, sectors * i + (j + 1) % sectors
    c, d, odd = a + sectors, b + sectors, i % 2 == 1  # rings are turned by half a sector in turn
    faces = [np.stack([a, np.where(odd, d, c), b], 1), np.stack([c, d, np.where(odd, a, b)], 1)]
    mesh = sn.SurfaceMesh(points, np.concatenate([part[:-sectors] for part in faces]))
    handles = [np.flatnonzero(i <= depth), np.flatnonzero(i >= cells + depth)]
    return mesh, handles, np.flatnonzero(i == depth + cells // 2)


def height(cells: int, depth: int, stiffness: tuple, continuity: float = 2.0) -> float:
    mesh, handles, middle = annulus(cells, depth, 6 * cells)
    shell = sn.ThinShell(mesh, **dict(zip(("stretching", "bending", "variation"), stiffness)))
    shell.set_handles(handles, continuity=continuity)
    heights = shell.solve([shift(0, 0, 1), STILL])[0][middle, 2]
    assert np.ptp(heights) < 2e-6, "the mesh has the symmetry of its sectors"
    return heights.mean()


MEMBRANE, PLATE, VARIATION = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def test_a_membrane_is_logarithmic() -> None:
    """No slope is asked for, so the error is of second order."""
    exact = 1 - np.log(1.5) / np.log(2)
    coarse, fine = (height(cells, 0, MEMBRANE) for cells in (8, 16))
    assert fine == pytest.approx(exact, abs=1e-6)
    assert abs(fine - exact) < 0.4 * abs(coarse - exact)


@pytest.mark.parametrize(
    ("stiffness", "depth", "continuity", "exact", "extrapolated"),
    [
        (PLATE, 1, 2.0, 0.4584346, 1e-4),
        ((1.0, 1.0, 0.0), 1, 2.0, 0.4575608, 1e-4),
        ((1.0, 0.1, 0.0), 1, 2.0, 0.4512592, 1e-4),
        (VARIATION, 2, 2.0, triharmonic(lambda u, r: mp.diff(u, r, 2)), 2e-4),
        # Left at C1, the third condition becomes natural.
        (VARIATION, 2, 1.0, triharmonic(slope_of_laplacian), 2e-4),
    ],
    ids=["plate", "both", "mostly membrane", "variation", "variation at C1"],
)
def test_others_tend_to_their_closed_solutions(stiffness, depth, continuity, exact, extrapolated) -> None:
    """Zero slope between the last two held rings is off by half a ring: an error of first order in h.

    Halving h twice lets Richardson take the first two orders away.
    """
    coarse, middle, fine = (height(cells, depth, stiffness, continuity) for cells in (8, 16, 32))
    assert fine == pytest.approx(exact, abs=3e-3)
    assert (middle - exact) / (fine - exact) == pytest.approx(2.0, abs=0.2)
    first, second = 2 * middle - coarse, 2 * fine - middle
    assert (4 * second - first) / 3 == pytest.approx(exact, abs=extrapolated)


def test_deeper_handles_change_nothing_and_without_their_curvature_all_is_a_membrane() -> None:
    """A handle of two rings is all that the plate sees, of three what order 3 sees."""
    assert height(8, 1, PLATE) == pytest.approx(height(8, 3, PLATE), abs=1e-8)
    assert height(8, 2, VARIATION) == pytest.approx(height(8, 4, VARIATION), abs=1e-7)
    assert height(16, 1, PLATE, 0.0) == pytest.approx(height(16, 1, MEMBRANE), abs=1e-8)
    assert height(8, 2, VARIATION, 0.0) == pytest.approx(height(8, 2, MEMBRANE), abs=1e-6)


def test_the_nonlinear_shell_comes_close_to_the_plate() -> None:
    """Of nearly equilateral triangles, lifted a little: the hinges of this pattern come to .4561."""
    mesh, handles, middle = annulus(32, 1, 302)
    shell = sn.ThinShellNonlinear(mesh, measure="length", thickness=1.0, max_iterations=300, tolerance=1e-14)
    shell.set_handles(handles)
    shape, _ = shell.solve([shift(0, 0, 1e-3), STILL])
    assert 1e3 * shape[middle, 2].mean() == pytest.approx(0.4561, abs=1e-3)
