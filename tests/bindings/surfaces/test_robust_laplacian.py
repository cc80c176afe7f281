# SPDX-License-Identifier: GPL-3.0-or-later
"""The Laplacian 'robust': the plain one on good meshes, libigl's intrinsic one, and no negative weights."""

import igl
import numpy as np
import pytest
from scipy.spatial import Delaunay

import sinew_native as sn

from ..meshes import closed_bar, grid, messy, quad_grid, sphere, torus


def made(points, faces) -> tuple[np.ndarray, np.ndarray]:
    mesh = sn.SurfaceMesh(points, faces)
    return sn.laplacian(mesh, "robust").toarray(), sn.mass(mesh, "robust")


def weights(L: np.ndarray) -> np.ndarray:
    return -L[~np.eye(len(L), dtype=bool)]


def squeezed() -> tuple[np.ndarray, np.ndarray]:
    """A closed surface of slanted, obtuse faces."""
    points, faces = sphere(4)
    return points * (1, 1, 4) + 0.05 * np.sin(9 * points[:, ::-1]), faces


@pytest.mark.parametrize("mesh", [sphere(3), quad_grid(6, 3), torus(30, 9), closed_bar(6, 3)])
def test_clean_delaunay_meshes_get_the_plain_one_to_the_last_bit(mesh) -> None:
    for of in (sn.laplacian, sn.mass):
        one, other = (of(sn.SurfaceMesh(*mesh), kind) for kind in ("robust", "cotan_voronoi"))
        assert (one != other).sum() == 0


def test_it_is_the_intrinsic_delaunay_laplacian_of_a_closed_surface() -> None:
    points, faces = squeezed()
    L, mass = made(points, faces)
    plain = sn.SurfaceMesh(points, faces)
    assert weights(sn.laplacian(plain).toarray()).min() < -0.1, "else there would be nothing to mend"
    np.testing.assert_allclose(L, -igl.intrinsic_delaunay_cotmatrix(points, faces)[0].toarray(), atol=1e-9)
    np.testing.assert_allclose(mass.sum(), sn.mass(plain).sum(), rtol=1e-12)


def test_in_a_plane_it_is_that_of_the_delaunay_triangulation_however_the_faces_are_cut() -> None:
    points, faces = grid(12, 0.35)
    points = points * (1, 1, 0) @ np.array([(1, 0, 0), (0.8, 1, 0), (0, 0, 1)])  # sheared
    L, _ = made(points, faces)
    best = sn.laplacian(sn.SurfaceMesh(points, Delaunay(points[:, :2]).simplices)).toarray()
    inner = np.arange(169).reshape(13, 13)[4:-4, 4:-4].ravel()
    assert abs(L - sn.laplacian(sn.SurfaceMesh(points, faces)).toarray())[inner].max() > 0.1
    np.testing.assert_allclose(L[inner], best[inner], atol=1e-9)


def test_messy_meshes_have_no_negative_weight_and_one_zero_per_part() -> None:
    points, faces = messy()
    squares = np.array([(0, 1, 2), (0, 1, 3), (1, 0, 4), (0, 1, 5)])  # four at one edge, one of them obtuse
    fan = np.array([(0, 0, 0), (0, 0, 1), (1, 0, -3), (0, 1, 0.5), (-1, 0.2, 0), (-0.1, -1, 2)], float)
    for corners, cut in ((points, faces), (fan, squares), (fan[:3], squares[:1])):
        L, mass = made(corners, cut)
        assert np.isfinite(L).all()
        assert (mass >= 0).all()
        assert weights(L).min() >= -1e-9 * abs(L).max()
        np.testing.assert_allclose(L, L.T, atol=1e-12 * abs(L).max())
        values = np.linalg.eigvalsh(L)
        parts = sn.SurfaceMesh(corners, cut).component_count
        assert (values > 1e-9 * values[-1]).sum() == len(corners) - parts


def test_neither_the_order_of_faces_at_an_edge_nor_a_face_without_area_matters() -> None:
    fan = [(0, 0, 0), (0, 0, 1), (0.2, 0, 0.5), (0, 0.3, 0.5), (-1, 0.2, 0.5), (-0.1, -1, 0.5)]
    faces = np.array([(0, 1, 2), (0, 1, 3), (1, 0, 4), (0, 1, 5)])
    for order in ((0, 2, 1, 3), (3, 1, 0, 2)):
        np.testing.assert_allclose(made(fan, faces[list(order)])[0], made(fan, faces)[0], atol=1e-12)
    L, _ = made([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2)])  # without any area
    assert 1e-3 < abs(L).max() < 1e-2, "as conducts a strip as narrow as the root of 1e-5"


@pytest.mark.parametrize("method", [sn.ThinShell, sn.LaplacianEditing, sn.VolumetricGraphLaplacian])
def test_methods_take_it(method) -> None:
    points, faces = squeezed()
    shape = method(sn.SurfaceMesh(points, faces), laplacian="robust")
    shape.set_handles([np.flatnonzero(points[:, 2] > 3), np.flatnonzero(points[:, 2] < -3)])
    still = np.tile(np.eye(3, 4), (2, 1, 1))
    np.testing.assert_allclose(shape.solve(still)[0], points, atol=1e-9)
    still[:, :, 3] = 0.3, -0.2, 0.1
    np.testing.assert_allclose(shape.solve(still)[0], points + (0.3, -0.2, 0.1), atol=1e-8)
