# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators and factors against SciPy and libigl."""

import igl
import numpy as np
import pytest
import scipy.sparse as sparse
from scipy.linalg import eigh
from scipy.sparse.linalg import spsolve

import sinew_native as sn

from ..meshes import BENT, STILL, grid, shift, sphere
from ..methods import bound

MESHES = {"hill": grid(12), "sphere": sphere(3)}


@pytest.fixture(params=MESHES)
def surface(request) -> tuple[np.ndarray, np.ndarray, sn.SurfaceMesh]:
    points, faces = MESHES[request.param]
    return points, faces, sn.SurfaceMesh(points, faces)


def test_laplacian_is_minus_libigls(surface) -> None:
    points, faces, mesh = surface
    theirs = igl.cotmatrix(points, faces.astype(np.int64))
    assert abs(sn.laplacian(mesh, "cotan") + theirs).max() < 1e-13 * abs(theirs).max()  # rounding


def test_mass_is_libigls_voronoi_hybrid(surface) -> None:
    points, faces, mesh = surface
    theirs = igl.massmatrix(points, faces.astype(np.int64), igl.MASSMATRIX_TYPE_VORONOI).diagonal()
    np.testing.assert_allclose(sn.mass(mesh), theirs, rtol=1e-12)


def test_smallest_eigenvalues_of_a_sphere_are_those_of_spherical_harmonics() -> None:
    mesh = sn.SurfaceMesh(*sphere(4))
    L, M = sn.laplacian(mesh).toarray(), np.diag(sn.mass(mesh))
    # Dense, as the iteration of a sparse solver begins at random and may miss one of five equal values.
    values = eigh(L, M, eigvals_only=True, subset_by_index=(0, 8))
    # l (l + 1), 2 l + 1 times each; 1,026 vertices resolve them to about h^2.
    np.testing.assert_allclose(values, [0, 2, 2, 2, 6, 6, 6, 6, 6], atol=0.06)


def test_gradient_is_libigls(surface) -> None:
    points, faces, mesh = surface
    G = sn.gradient(mesh)
    assert G.shape == (3 * len(faces), len(points))
    L = sn.laplacian(mesh, "cotan")
    assert abs(sn.divergence(mesh) @ G - L).max() < 1e-12 * abs(L).max()
    assert abs(sn.divergence(mesh).sum(0)).max() < 1e-12, "no field has a source as a whole"
    theirs = igl.grad(points, faces.astype(np.int64))  # all x, then all y, then all z
    ours = np.asarray(G.todense()).reshape(len(faces), 3, -1).transpose(1, 0, 2).reshape(3 * len(faces), -1)
    np.testing.assert_allclose(ours, theirs.todense(), atol=1e-12 * abs(theirs).max())


@pytest.mark.parametrize("kind", ["uniform", "cotan", "cotan_voronoi"])
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


BACKENDS = ("automatic", "supernodal", "simplicial", "ldlt")
ORDERINGS = ("natural", "reverse_cuthill_mckee", "minimum_degree", "nested_dissection")


@pytest.mark.parametrize(("backend", "ordering"), list(zip(BACKENDS, ORDERINGS, strict=True)))
def test_factors_solve_as_scipy_does(backend: str, ordering: str) -> None:
    mesh = sn.SurfaceMesh(*grid(12))
    A = (sn.laplacian_power(mesh, 2) + sparse.diags(sn.mass(mesh))).tocsc()
    b = np.random.default_rng(2).normal(size=(A.shape[0], 4))
    factor = sn.SpdFactor(A, ordering=ordering, backend=backend)
    expected = spsolve(A, b)
    close = {"rtol": 0, "atol": 1e-10 * abs(expected).max()}  # a condition of 1e4
    np.testing.assert_allclose(factor.solve(b), expected, **close)
    np.testing.assert_allclose(factor.solve(b[:, 0]), expected[:, 0], **close)
    for form in (sparse.csr_matrix(A), sparse.coo_matrix(A), sparse.csc_array(A)):
        np.testing.assert_array_equal(sn.SpdFactor(form, ordering, backend).solve(b), factor.solve(b))
    factor.factorize((2 * A).tocsc())
    np.testing.assert_allclose(factor.solve(b), expected / 2, **close)
    assert (factor.analyses, factor.factorizations, factor.size) == (1, 2, len(b))
    assert factor.nonzeros >= sparse.tril(A).nnz


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
