# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators, factors and the thin shell against SciPy and libigl."""

import igl
import numpy as np
import pytest
import scipy.sparse as sparse
from scipy.sparse.linalg import eigsh, splu, spsolve

import sinew_native as sn

from .meshes import BENT, bound, ends, grid, moved, shift, sphere

KINDS = ("uniform", "cotan", "cotan_voronoi")
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
    L, M = sn.laplacian(mesh), sparse.diags(sn.mass(mesh))
    values = np.sort(eigsh(L.tocsc(), 9, M.tocsc(), sigma=-0.1, which="LM")[0])
    # l (l + 1), 2 l + 1 times each; 1,026 vertices resolve them to about h^2.
    np.testing.assert_allclose(values, [0, 2, 2, 2, 6, 6, 6, 6, 6], atol=0.06)


@pytest.mark.parametrize("kind", KINDS)
def test_powers_are_products_of_scipy_matrices(surface, kind: str) -> None:
    _, _, mesh = surface
    L, D = sn.laplacian(mesh, kind), sparse.diags(1 / sn.mass(mesh, kind))
    for order, expected in ((1, L), (2, L @ D @ L), (3, L @ D @ L @ D @ L)):
        power = sn.laplacian_power(mesh, order, kind)
        assert sparse.issparse(power)
        assert abs(power - expected).max() < 1e-13 * abs(expected).max()


def test_gradient_and_divergence_are_sparse_matrices_of_the_stated_shapes(surface) -> None:
    points, faces, mesh = surface
    G, div = sn.gradient(mesh), sn.divergence(mesh)
    assert G.shape == (3 * len(faces), len(points))
    assert div.shape == G.shape[::-1]
    L = sn.laplacian(mesh, "cotan")
    assert abs(div @ G - L).max() < 1e-13 * abs(L).max()
    theirs = igl.grad(points, faces.astype(np.int64))  # all x, then all y, then all z
    ours = np.asarray(G.todense()).reshape(len(faces), 3, -1).transpose(1, 0, 2).reshape(3 * len(faces), -1)
    np.testing.assert_allclose(ours, theirs.todense(), atol=1e-12 * abs(theirs).max())


def test_rotations_are_those_of_numpys_svd() -> None:
    S = np.random.default_rng(3).normal(size=(500, 3, 3))
    R = sn.fit_rotations(S)
    U, _, Vt = np.linalg.svd(S)
    U[:, :, 2] *= np.sign(np.linalg.det(U @ Vt))[:, None]
    # The nearest rotation is as well conditioned as the gap of the two smallest singular values.
    np.testing.assert_allclose(np.einsum("kij,kij->k", R, S), np.einsum("kij,kij->k", U @ Vt, S), rtol=1e-12)
    np.testing.assert_allclose(np.linalg.det(R), 1, atol=1e-13)


@pytest.mark.parametrize("backend", ["automatic", "supernodal", "simplicial", "ldlt"])
@pytest.mark.parametrize(
    "ordering", ["natural", "reverse_cuthill_mckee", "minimum_degree", "nested_dissection"]
)
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


def shell_matrix(mesh: sn.SurfaceMesh, kind: str, k: tuple[float, float, float]) -> sparse.csc_matrix:
    """k_s L + k_b L M^-1 L + k_v L M^-1 L M^-1 L."""
    L, D = sn.laplacian(mesh, kind), sparse.diags(1 / sn.mass(mesh, kind))
    return sparse.csc_matrix(k[0] * L + k[1] * (L @ D @ L) + k[2] * (L @ D @ L @ D @ L))


def displacement(A: sparse.csc_matrix, held: np.ndarray, values: np.ndarray, *, dense: bool) -> np.ndarray:
    """The minimiser of d^T A d with some rows of d given."""
    n = A.shape[0]
    free = np.setdiff1d(np.arange(n), held)
    d = np.zeros((n, 3))
    d[held] = values
    rhs = -(A[free][:, held] @ values)
    inner = A[free][:, free]
    d[free] = np.linalg.solve(inner.toarray(), rhs) if dense else splu(inner.tocsc()).solve(rhs)
    return d


@pytest.mark.parametrize("dense", [True, False], ids=["dense", "sparse"])
@pytest.mark.parametrize("k", [(1, 0, 0), (0, 1, 0), (0.5, 1, 0), (0, 0, 1), (0.2, 1, 3)])
@pytest.mark.parametrize("kind", KINDS)
def test_thin_shell_is_scipys_solution(kind: str, k: tuple[float, float, float], dense: bool) -> None:
    points, faces = grid(12)
    mesh = sn.SurfaceMesh(points, faces)
    handles = ends(points, 2.6)
    held = np.concatenate(handles)
    wanted = np.concatenate([moved(pose, points[h]) - points[h] for pose, h in zip(BENT, handles)])
    expected = points + displacement(shell_matrix(mesh, kind, k), held, wanted, dense=dense)
    for basis in (True, False):
        stiffness = dict(zip(("stretching", "bending", "variation"), k))
        shell = sn.ThinShell(mesh, **stiffness, laplacian=kind, affine_basis=basis)
        shell.set_handles(handles)
        positions, report = shell.solve(BENT)
        np.testing.assert_allclose(positions, expected, rtol=0, atol=1e-6)  # condition up to 1e9 in order 3
        assert report.residual < 1e-8
        d = positions - points
        energy = 0.5 * np.sum(d * (shell_matrix(mesh, kind, k) @ d))
        # Order 3 loses nine digits of d in A d before they are summed.
        assert report.energy == pytest.approx(energy, rel=1e-5)


def test_affine_basis_is_the_answer_to_x_y_z_and_one() -> None:
    shell, points, handles = bound(sn.ThinShell, n=12)
    basis = sn.AffineBasis(shell)
    A = shell_matrix(sn.SurfaceMesh(*grid(12)), "cotan_voronoi", (0, 1, 0))
    held = np.concatenate(handles)
    values = np.zeros((len(held), 8))
    first = len(handles[0])
    values[:first, :3], values[:first, 3] = points[handles[0]], 1
    values[first:, 4:7], values[first:, 7] = points[handles[1]], 1
    expected = np.hstack([displacement(A, held, values[:, k : k + 3], dense=True) for k in (0, 3, 5)])
    expected = expected[:, [0, 1, 2, 3, 4, 5, 7, 8]]
    np.testing.assert_allclose(basis.matrix, expected, atol=1e-8)
    np.testing.assert_allclose(basis.solve(BENT)[0], shell.solve(BENT)[0], rtol=0, atol=1e-10)
    stacked = np.concatenate([(pose - np.eye(3, 4)).T for pose in BENT])
    np.testing.assert_allclose(points + basis.matrix @ stacked, basis.solve(BENT)[0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(basis.matrix[:, [3, 7]].sum(1), 1, atol=1e-10)


def test_soft_handles_are_springs_in_units_of_the_diagonal() -> None:
    points, faces = grid(10)
    mesh = sn.SurfaceMesh(points, faces)
    handles = ends(points, 2.1)
    weights = np.linspace(0.05, 0.95, len(handles[1]))
    shell = sn.ThinShell(mesh)
    report = shell.set_handles(handles, [None, weights])
    assert (report.soft_vertices, report.constrained_vertices) == (len(weights), len(handles[0]))
    A = shell_matrix(mesh, "cotan_voronoi", (0, 1, 0))
    spring = np.zeros(len(points))
    spring[handles[1]] = weights / (1 - weights) * A.diagonal()[handles[1]]
    free = np.setdiff1d(np.arange(len(points)), handles[0])
    rhs = spring[:, None] * (moved(BENT[1], points) - points)
    d = np.zeros_like(points)
    d[free] = np.linalg.solve((A + sparse.diags(spring))[free][:, free].toarray(), rhs[free])
    np.testing.assert_allclose(shell.solve(BENT)[0], points + d, rtol=0, atol=1e-9)


def test_ten_solves_take_one_factorisation() -> None:
    for basis in (True, False):
        shell, _, handles = bound(sn.ThinShell, affine_basis=basis)
        for k in range(10):
            shell.solve([shift(0, 0, k), shift(k, 0, 0)])
        assert shell.set_handles(handles).factorizations == 2
