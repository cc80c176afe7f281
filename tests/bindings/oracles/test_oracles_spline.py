# SPDX-License-Identifier: GPL-3.0-or-later
"""Spline surfaces against SciPy's B-splines and pseudo-inverse."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

import sinew_native as sn

from ..meshes import STILL, grid, shift


def design(t: np.ndarray, degree: int, count: int) -> np.ndarray:
    """(n, count) uniform B-splines, with the box of the places t divided into count - degree spans."""
    t = (t - t.min()) / (t.max() - t.min())
    knots = (np.arange(count + degree + 1) - degree) / (count - degree)
    return BSpline.design_matrix(t, knots, degree).toarray()


@pytest.mark.parametrize("degree", [1, 2, 3, 4, 5])
def test_few_handles_move_the_spline_of_scipys_pseudo_inverse(degree: int) -> None:
    points, faces = grid(14)
    rng = np.random.default_rng(degree)
    uv = rng.random((len(points), 2))
    held = rng.choice(len(points), 9, replace=False)
    moves = rng.normal(size=(9, 3))
    columns, rows = degree + 5, degree + 3
    B = np.einsum("nj,ni->nji", design(uv[:, 1], degree, rows), design(uv[:, 0], degree, columns))
    B = B.reshape(len(points), -1)
    mean = moves.mean(0)
    expected = points + B @ (np.linalg.pinv(B[held]) @ (moves - mean)) + mean

    words = {"degree": degree, "columns": columns, "rows": rows, "smoothing": 0, "uv_map": uv}
    surface = sn.SplineSurface(sn.SurfaceMesh(points, faces), **words)
    surface.set_handles([[vertex] for vertex in held])
    found, report = surface.solve(np.stack([shift(*move) for move in moves]))
    # Normal equations square the condition number of nine rows, at most some hundreds.
    np.testing.assert_allclose(found, expected, atol=1e-8)
    assert report.residual < 1e-9
    [at_rest] = surface.control_grids([STILL] * 9)
    [posed] = surface.control_grids([shift(*move) for move in moves])
    assert posed.shape == (rows, columns, 3)
    displaced = B @ (posed - at_rest).reshape(-1, 3)
    np.testing.assert_allclose(points + displaced, expected, atol=1e-8)


def test_the_grid_of_a_flat_sheet_is_even_and_moves_with_the_handles() -> None:
    points, faces = grid(20)
    points *= (1, 1, 0)
    surface = sn.SplineSurface(sn.SurfaceMesh(points, faces), columns=8, rows=7)
    assert surface.control_grids(np.zeros((0, 3, 4))) == [], "there are no handles yet"
    surface.set_handles([np.flatnonzero(points[:, 0] < 1.5), np.flatnonzero(points[:, 0] > 18.5)])
    [control] = surface.control_grids([STILL, STILL])
    assert control.shape == (7, 8, 3)
    # 4 and 5 spans of degree 3 bound the region, and the grid goes one span farther on each side.
    for axis, span in ((0, 20 / 4), (1, 20 / 5)):
        steps = np.diff(control, axis=axis)
        assert np.ptp(steps, axis=(0, 1)).max() < 1e-5
        assert np.linalg.norm(steps[0, 0]) == pytest.approx(span, rel=1e-3)
    [moved] = surface.control_grids([shift(1, 2, 3)] * 2)
    np.testing.assert_allclose(moved, control + (1, 2, 3), atol=1e-6)
    [entered] = surface.control_grids([STILL, STILL], incoming=points + (0, 0, 4))
    np.testing.assert_allclose(entered, control + (0, 0, 4), atol=1e-6)
    with pytest.raises(sn.InvalidConstraint):
        surface.control_grids([STILL])


def test_a_map_is_read_from_any_real_array_and_vertices_without_a_place_are_named() -> None:
    points, faces = grid(6)
    mesh, handles = sn.SurfaceMesh(points, faces), [[0, 1], [47, 48]]
    poses = np.stack([STILL, shift(0, 0, 1)])
    shapes = []
    for uv in (points[:, :2], points[:, :2].astype(np.float32).tolist(), np.asfortranarray(points[:, :2])):
        surface = sn.SplineSurface(mesh, uv_map=uv)
        surface.set_handles(handles)
        shapes.append(surface.solve(poses)[0])
    np.testing.assert_allclose(shapes[1:], [shapes[0]] * 2, atol=1e-5)  # float32 in the second
    for wrong in (points, points[:5, :2], np.zeros((0, 2)), np.full((49, 2), np.inf)):
        with pytest.raises(sn.InvalidOption, match="uv_map"):
            sn.SplineSurface(mesh, uv_map=wrong)
    lost = points[:, :2].copy()
    lost[[3, 20]] = np.nan
    with pytest.raises(sn.InvalidOption, match="3, 20") as caught:
        sn.SplineSurface(mesh, uv_map=lost).set_handles(handles)
    assert (caught.value.element_kind, list(caught.value.elements)) == ("vertex", [3, 20])
    lost = points[:, :2].copy()
    lost[0] = np.nan  # deep in a handle, where no grid goes
    sn.SplineSurface(mesh, uv_map=lost, margin=0.0).set_handles([np.flatnonzero(points[:, 0] < 3.5), [48]])


def test_moved_points_of_the_grid_add_scipys_spline_and_held_vertices_stay() -> None:
    points, faces = grid(16)
    columns, rows, uv = 9, 8, points[:, :2]
    B = np.einsum("nj,ni->nji", design(uv[:, 1], 3, rows), design(uv[:, 0], 3, columns)).reshape(len(uv), -1)
    held = np.flatnonzero(points[:, 0] == 0.0)
    words = {"degree": 3, "columns": columns, "rows": rows, "uv_map": uv, "margin": 9.0}
    surface = sn.SplineSurface(sn.SurfaceMesh(points, faces), **words)
    surface.set_handles([held])
    moves = np.random.default_rng(6).normal(size=(rows, columns, 3))
    moves[:, :4] = 0.0  # these reach the held vertices
    moves = moves.reshape(-1, 3)
    poses = np.stack([STILL])
    found, report = surface.solve(poses, grid=moves)
    np.testing.assert_allclose(found, points + B @ moves, atol=1e-12)
    assert report.residual == 0.0
    shown, rest = (surface.control_grids(poses, grid=given)[0] for given in (moves, None))
    np.testing.assert_allclose((shown - rest).reshape(-1, 3), moves, atol=1e-12)
    single = np.empty((len(points), 3), dtype=np.float32)
    surface.solve(poses, grid=moves, out=single)
    np.testing.assert_allclose(single, found, atol=1e-5)
    np.testing.assert_array_equal(surface.solve(poses, grid=0 * moves)[0], surface.solve(poses)[0])
    near = np.ones((rows * columns, 3))
    found, _ = surface.solve(poses, grid=near)
    np.testing.assert_array_equal(found[held], points[held])
    for wrong in (moves[1:], np.full_like(moves, np.nan)):
        for call in (surface.solve, surface.control_grids):
            with pytest.raises(sn.InvalidConstraint, match="grid"):
                call(poses, grid=wrong)
