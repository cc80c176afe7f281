# SPDX-License-Identifier: GPL-3.0-or-later
"""Every surface method on the meshes that artists have: n-gons in parts, a rough scan, 100,000 vertices.

Nothing here names a method.
"""

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import STILL, closed_bar, ends, messy, moved, shift, turn
from ..methods import EVERY_SURFACE_METHOD, called, made

Polygons = tuple[np.ndarray, list[list[int]]]
EVERY_METHOD = pytest.mark.parametrize(("method", "options"), EVERY_SURFACE_METHOD, ids=called)


def honeycomb(columns: int, rows: int) -> Polygons:
    """A hill of hexagons with a ragged border."""
    y, x = np.mgrid[: rows + 1, : 2 * columns + 2].astype(float)
    z = 0.1 * columns * np.sin(3 * x / columns) * np.cos(2 * y / rows)
    points = np.stack([x, y - 0.3 * ((x + y) % 2), z], -1).reshape(-1, 3)
    width = 2 * columns + 2
    below = [(2 * i + j % 2, j) for j in range(rows) for i in range(columns)]
    faces = [
        [j * width + i + k for k in range(3)] + [(j + 1) * width + i + k for k in (2, 1, 0)] for i, j in below
    ]
    used = np.unique(faces)
    place = np.zeros(len(points), dtype=int)
    place[used] = np.arange(len(used))
    return points[used], place[np.array(faces)].tolist()


def check(method: type, options: dict, mesh: sn.SurfaceMesh, handles: list[np.ndarray], scale: float) -> None:
    """Bend it and move it: handles are met, everything is finite, and what moves as a whole keeps its shape.

    Iterative methods take a few steps only.
    """
    points = mesh.points
    surface = made(method, mesh, **options)
    report = surface.set_handles(handles)
    pose = turn((0, 1, 0), 30, points[handles[1]].mean(0), (-0.02 * scale, 0.01 * scale, 0.03 * scale))
    positions, solved = surface.solve(np.stack([STILL, pose]), max_iterations=2)
    assert np.isfinite(positions).all()
    assert np.isfinite([solved.energy, solved.residual]).all()
    np.testing.assert_array_equal(positions[report.free_vertices], points[report.free_vertices])
    for handle, where in zip(handles, (STILL, pose), strict=True):
        np.testing.assert_allclose(positions[handle], moved(where, points[handle]), atol=1e-12 * scale)
    free = np.setdiff1d(np.arange(len(points)), np.concatenate([*handles, report.free_vertices]))
    assert np.abs(positions[free] - points[free]).max() < 3 * scale, "nothing flies off"

    whole = shift(0.3 * scale, -0.2 * scale, 0.1 * scale)
    positions, _ = surface.solve(np.stack([whole, whole]))
    expected = moved(whole, points)
    expected[report.free_vertices] = points[report.free_vertices]
    np.testing.assert_allclose(positions, expected, atol=1e-6 * scale)


@EVERY_METHOD
def test_n_gons_in_two_parts_one_with_a_border(method: type, options: dict) -> None:
    sheet, hexagons = honeycomb(9, 12)
    closed, (counts, corners) = closed_bar(23, 3)
    points = np.concatenate([sheet, closed + (0.0, 6.0, 12.0)])
    counts, corners = [*map(len, hexagons), *counts], [*np.concatenate(hexagons), *(len(sheet) + corners)]
    mesh = sn.SurfaceMesh(points, (counts, corners))
    found = mesh.diagnose()
    assert found.component_count == 2
    assert len(found.non_manifold_edges) == 0
    parts = [np.arange(len(sheet)), np.arange(len(sheet), len(points))]
    handles = [np.concatenate([part[ends(points[part], 2.1)[k]] for part in parts]) for k in (0, 1)]
    check(method, options, mesh, handles, 20.0)


@EVERY_METHOD
def test_a_scan_that_is_no_manifold(method: type, options: dict) -> None:
    """With noise, faces turned over, a hole, two vertices in one place, and all that a messy mesh has."""
    points, faces = messy()
    points[:81, 2] += np.random.default_rng(8).normal(scale=0.15, size=81)
    points[22] = points[23]
    faces[60:70] = faces[60:70, ::-1]
    mesh = sn.SurfaceMesh(points, np.delete(faces, [90, 91], axis=0))
    assert len(mesh.diagnose().non_manifold_edges) > 3
    check(method, options, mesh, ends(points[:81], 1.5), 8.0)


@pytest.mark.slow
@EVERY_METHOD
def test_a_hundred_thousand_vertices(method: type, options: dict) -> None:
    """By the method's defaults. With other options a quarter as many, as one of them takes half a minute."""
    length = 25 if options else 50
    points, faces = closed_bar(10 * length - 1, length)
    assert len(points) == 40 * length**2 == (25_000 if options else 100_000)
    points *= 0.1
    check(method, options, sn.SurfaceMesh(points, faces), ends(points, 1.0), length)
