# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators against SciPy and libigl."""

import igl
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import sinew_native as sn

from ..cages import CUBE, QUADS
from ..meshes import BENT, STILL, closed_bar, grid, joined, messy, shift, sphere
from ..methods import bound

MESHES = {"hill": grid(12), "sphere": sphere(3), "obtuse": grid(9, 0.45)}
KINDS = ("uniform", "cotan", "cotan_voronoi")


@pytest.mark.parametrize("name", MESHES)
def test_laplacians_masses_and_gradients_are_libigls(name: str) -> None:
    points, faces = MESHES[name]
    mesh, faces = sn.SurfaceMesh(points, faces), faces.astype(np.int64)
    L, theirs = sn.laplacian(mesh, "cotan"), igl.cotmatrix(points, faces)
    assert abs(L + theirs).max() < 1e-13 * abs(theirs).max()  # rounding
    voronoi = igl.massmatrix(points, faces, igl.MASSMATRIX_TYPE_VORONOI).diagonal()
    np.testing.assert_allclose(sn.mass(mesh), voronoi, rtol=1e-12)
    G = sn.gradient(mesh)
    assert G.shape == (3 * len(faces), len(points))
    assert abs(sn.divergence(mesh) @ G - L).max() < 1e-12 * abs(L).max()
    assert abs(sn.divergence(mesh).sum(0)).max() < 1e-12, "no field has a source as a whole"
    theirs = igl.grad(points, faces)  # all x, then all y, then all z
    ours = np.asarray(G.todense()).reshape(len(faces), 3, -1).transpose(1, 0, 2).reshape(3 * len(faces), -1)
    np.testing.assert_allclose(ours, theirs.todense(), atol=1e-12 * abs(theirs).max())


def slivers() -> tuple[np.ndarray, np.ndarray]:
    """Slivers, needles and caps of random shape between two regular rows."""
    points, faces = grid(6)
    points *= (1, 1, 0)
    points[:, 1] *= 10 ** (-8 * np.random.default_rng(8).random(len(points))) + 1e-3
    return points, faces


ODD = {
    "messy": messy(),
    "slivers": slivers(),
    "one place": (np.zeros((25, 3)), grid(4)[1]),
    "polygons": closed_bar(5, 2),
    "two parts": joined(sphere(2), (grid(4)[0] + 5, grid(4)[1])),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ODD)
def test_laplacians_of_odd_meshes_are_semi_definite_with_one_zero_a_part(name: str, kind: str) -> None:
    mesh = sn.SurfaceMesh(*ODD[name])
    L = sn.laplacian(mesh, kind).toarray()
    largest = max(np.abs(L).max(), 1e-300)
    assert np.abs(L.sum(1)).max() <= 1e-14 * largest  # some ten terms a row
    assert np.abs(L - L.T).max() <= 1e-15 * largest  # the same terms, summed otherwise
    values = np.linalg.eigvalsh(L)
    assert values.min() >= -1e-14 * max(values.max(), 1e-300)
    if name in ("messy", "two parts", "polygons"):
        # Floored triangles have cotangents of 1e5: the smallest true value is about 1e-7 of the largest.
        assert (values < 1e-11 * values.max()).sum() == mesh.component_count
    a, b, c = mesh.points[mesh.triangles].swapaxes(0, 1)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    mass = sn.mass(mesh, "cotan_voronoi")
    assert mass.min() >= 0
    assert name == "messy" or mass.sum() == pytest.approx(area, rel=1e-12)


def test_edges_of_polygons_count_once_and_faces_without_area_tie_their_corners() -> None:
    square = sn.SurfaceMesh(CUBE, QUADS[:1])
    expected = [[2, -1, -1, 0], [-1, 2, 0, -1], [-1, 0, 2, -1], [0, -1, -1, 2]]
    np.testing.assert_array_equal(sn.laplacian(square, "uniform").toarray()[:4, :4], expected)
    line = np.outer(np.arange(3), (1.0, 0, 0))
    values = np.linalg.eigvalsh(sn.laplacian(sn.SurfaceMesh(line, [(0, 1, 2)]), "cotan").toarray())
    assert (values < 1e-12 * values.max()).sum() == 1
    both = sn.gradient(sn.SurfaceMesh([*line, (0, 1, 0)], [(0, 1, 2), (0, 1, 3)])).toarray()
    assert not both[:3].any()
    assert np.abs(both[3:]).max() > 0.5


def test_thin_triangles_keep_their_cotangents_and_no_size_changes_them() -> None:
    thin = np.array([(0, 0, 0), (1, 0, 0), (0.5, 1e-3, 0)])  # angles of 2e-3: two hundred times the floor
    found = sn.laplacian(sn.SurfaceMesh(thin, [(0, 1, 2)]), "cotan").toarray()
    np.testing.assert_allclose(found, -igl.cotmatrix(thin, np.array([[0, 1, 2]])).toarray(), rtol=1e-9)
    points, faces = grid(5)
    L = sn.laplacian(sn.SurfaceMesh(points, faces), "cotan")
    for scale in (1e-12, 1e12):
        scaled = sn.laplacian(sn.SurfaceMesh(scale * points, faces), "cotan")
        assert abs(scaled - L).max() < 1e-12 * abs(L).max()


@pytest.mark.parametrize("kind", KINDS)
def test_powers_are_products_of_laplacians_and_inverse_masses(kind: str) -> None:
    mesh = sn.SurfaceMesh(*grid(5))
    L, D = sn.laplacian(mesh, kind).toarray(), np.diag(1 / sn.mass(mesh, kind))
    for order, expected in enumerate((L, L @ D @ L, L @ D @ L @ D @ L), 1):
        close = {"rtol": 0, "atol": 1e-13 * abs(expected).max()}  # the same products, summed in another order
        np.testing.assert_allclose(sn.laplacian_power(mesh, order, kind).toarray(), expected, **close)


def matrices() -> dict[str, np.ndarray]:
    """(k, 3, 3) of any kind, many of them without a single nearest rotation."""
    rng, small = np.random.default_rng(3), [0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3, 1e-2]
    singular = [
        each
        for e in small
        for each in (
            (1, e, e), (1, e, 0), (1, 1, e), (1, 1 + e, -1), (1, e, -e), (1, 0.5, -0.5 - e),
            (1, 0.5 + e, -0.5), (1, 1, -1 + e), (1, 1 + e, 1), (e, e, -e), (1, 0.3, e), (1, 0.3, -e),
        )
    ]  # fmt: skip
    U, V = np.linalg.qr(rng.normal(size=(2, 20, len(singular), 3, 3)))[0]
    a, b, c, d = rng.uniform(-1, 1, (4, 200, 3))
    rank_one = np.einsum("ki,kj->kij", a, b)
    sides = np.stack(np.meshgrid((-1.0, 0, 1), (-1.0, 0, 1, 2), (-1.0, 0, 1)), -1).reshape(-1, 3)
    return {
        "random": rng.normal(size=(20_000, 3, 3)),
        "nearly tied": (U * np.array(singular)[:, None] @ V.swapaxes(-1, -2)).reshape(-1, 3, 3),
        "of rank one and two": np.concatenate([rank_one, rank_one + np.einsum("ki,kj->kij", c, d)]),
        "diagonal": np.eye(3) * sides[:, None],
    }


@pytest.mark.parametrize("kind", matrices())
def test_rotations_have_the_largest_trace_by_numpys_svd(kind: str) -> None:
    S = matrices()[kind]
    R = sn.fit_rotations(S)
    U, sizes, Vt = np.linalg.svd(S)
    sizes[:, 2] *= np.sign(np.linalg.det(U @ Vt))
    lost = sizes.sum(1) - np.einsum("kij,kij->k", R, S)
    assert (lost <= 1e-13 * np.linalg.norm(S, axis=(1, 2))).all()
    np.testing.assert_allclose(R @ R.swapaxes(1, 2), np.tile(np.eye(3), (len(S), 1, 1)), atol=1e-14)
    np.testing.assert_allclose(np.linalg.det(R), 1, atol=1e-14)
    if kind == "random":  # gaps of singular values down to 1e-3 or so
        for scale in (1e-140, 1e-50, 1e50, 1e140):
            np.testing.assert_allclose(sn.fit_rotations(scale * S[:100]), R[:100], atol=1e-10)


def test_the_rotation_of_a_rotation_or_a_stretch_is_exact() -> None:
    """Its singular values are well apart, so that it is not the trace alone that is right."""
    rng = np.random.default_rng(4)
    R, Q = Rotation.random(1000, random_state=rng), Rotation.random(1000, random_state=rng).as_matrix()
    axes = np.repeat([(1, 0, 0), (0, 1, 0), (0, 0, 1), np.ones(3) / np.sqrt(3)], 4, axis=0)
    turns = Rotation.from_rotvec(np.radians(np.tile([1e-9, 90, 179.999999, 180], 4))[:, None] * axes)
    for rotations in (R.as_matrix(), turns.as_matrix()):
        for scale in (1.0, 7.5):
            np.testing.assert_allclose(sn.fit_rotations(scale * rotations), rotations, rtol=0, atol=1e-13)
    stretched = R.as_matrix() @ (Q * rng.uniform(1, 2, (1000, 1, 3))) @ Q.swapaxes(1, 2)
    np.testing.assert_allclose(sn.fit_rotations(stretched), R.as_matrix(), rtol=0, atol=1e-13)
    odd = sn.fit_rotations([np.zeros((3, 3)), np.diag([3.0, 2, -1])])  # any other one loses more than 1
    np.testing.assert_allclose(odd, [np.eye(3)] * 2, atol=1e-14)


def test_affine_basis_is_a_matrix_that_gives_what_the_shell_gives() -> None:
    shell, points, _ = bound(sn.ThinShell, n=12)
    basis = sn.AffineBasis(shell)
    np.testing.assert_allclose(basis.solve(BENT)[0], shell.solve(BENT)[0], rtol=0, atol=1e-10)
    stacked = np.concatenate([(pose - np.eye(3, 4)).T for pose in BENT])
    np.testing.assert_allclose(points + basis.matrix @ stacked, basis.solve(BENT)[0], rtol=0, atol=1e-12)


def test_on_a_plane_whose_border_is_held_implicit_laplacian_editing_is_the_thin_plate() -> None:
    points, faces = grid(16)
    mesh = sn.SurfaceMesh(points * (1, 1, 0), faces)
    ring = np.abs(points[:, :2] - 8).max(axis=1)
    shapes = []
    for transforms in ("none", "implicit"):
        method = sn.LaplacianEditing(mesh, transforms=transforms)
        method.set_handles([np.flatnonzero(ring < 2), np.flatnonzero(ring > 6.5)])
        shapes.append(method.solve([shift(1, 0, 3), STILL])[0])
    np.testing.assert_allclose(*shapes, atol=1e-12)  # lengths are 16
