# SPDX-License-Identifier: GPL-3.0-or-later
"""Sparse Cholesky factors of every engine and ordering: solutions, what they keep, what they refuse."""

import itertools
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import scipy.sparse as sparse
from scipy.sparse.linalg import spsolve

import sinew_native as sn

from . import limits

BACKENDS = ("automatic", "supernodal", "simplicial", "ldlt")
ORDERINGS = ("natural", "cuthill_mckee", "reverse_cuthill_mckee", "minimum_degree", "nested_dissection")
ORDERINGS += ("patch_dissection", "automatic")
CLOSE = 1e-12  # of the solution; conditions are below 1e3


@pytest.fixture(params=itertools.product(BACKENDS, ORDERINGS))
def options(request) -> dict[str, str]:
    return dict(zip(("backend", "ordering"), request.param, strict=True))


def spd(n: int, seed: int = 1) -> sparse.csc_matrix:
    """Of a random pattern; eigenvalues of at least 0.5."""
    B = sparse.random(n, n, min(1.0, 4 / n), random_state=seed)
    return sparse.csc_matrix(B.T @ B + 0.5 * sparse.identity(n))


def grid(side: int, shift: float = 0.01) -> sparse.csc_matrix:
    """The Laplacian of a square grid plus a multiple of the identity, its unknowns shuffled."""
    steps = sparse.diags([1.0, -1.0], [0, 1], (side - 1, side))
    L = sparse.kronsum(steps.T @ steps, steps.T @ steps) + shift * sparse.identity(side**2)
    order = np.random.default_rng(11).permutation(side**2)
    return sparse.csc_matrix(L.tocsr()[order][:, order])


def expect_solves(factor: sn.SpdFactor, A: sparse.csc_matrix, columns: int = 2) -> None:
    b = np.random.default_rng(2).uniform(-1, 1, (A.shape[0], columns))
    expected = np.linalg.solve(A.toarray(), b)
    np.testing.assert_allclose(factor.solve(b), expected, rtol=0, atol=CLOSE * abs(expected).max())


def test_solves_as_dense_elimination_does_from_any_form_at_any_scale(options) -> None:
    for n in (1, 2, 7, 40, 150):
        factor = sn.SpdFactor(spd(n), **options)
        assert factor.size == n
        for columns in (1, 3, 12):
            expect_solves(factor, spd(n), columns)
    A = spd(60, 5)
    expect_solves(sn.SpdFactor(sparse.tril(A, format="csc"), **options), A)  # the lower triangle is enough
    for scale in (1e-60, 1e60):
        expect_solves(sn.SpdFactor(scale * A, **options), scale * A)
    b = np.ones(60)
    expected = sn.SpdFactor(A, **options).solve(b)
    np.testing.assert_allclose(expected, spsolve(A, b), rtol=0, atol=CLOSE)
    for form in (sparse.csr_matrix(A), sparse.coo_matrix(A), sparse.csc_array(A)):
        np.testing.assert_array_equal(sn.SpdFactor(form, **options).solve(b), expected)


def test_the_symbolic_part_is_kept_while_the_pattern_stays(options) -> None:
    factor = sn.SpdFactor(grid(9), **options)
    assert factor.nonzeros >= sparse.tril(grid(9)).nnz
    for k in (2, 3):
        factor.factorize(k * grid(9))
        assert (factor.analyses, factor.factorizations) == (1, k)
        expect_solves(factor, k * grid(9))
    factor.factorize(spd(81, 6))
    assert factor.analyses == 2
    expect_solves(factor, spd(81, 6))
    # 0-1 and 2-3, then 0-2 and 1-3: two entries a column in both
    pairs = np.diag([2.0, 3, 4, 5]) + np.eye(4)[[[1, 0, 3, 2], [2, 3, 0, 1]]]
    one, other = map(sparse.csc_matrix, pairs)
    factor = sn.SpdFactor(one, **options)
    factor.factorize(other)
    expect_solves(factor, other)
    assert factor.analyses == 2


def test_what_has_no_factor_is_refused_and_the_next_one_is_factorised(options) -> None:
    for diagonal, wrong in (([1, 2, 3, -1, 4], 3), ([1, 2, 0, 3], 2)):
        with pytest.raises(sn.FactorizationFailed) as refused:
            sn.SpdFactor(sparse.diags(np.array(diagonal, float), format="csc"), **options)
        assert (refused.value.elements, refused.value.element_kind) == ([wrong], "vertex")
    factor = sn.SpdFactor(grid(8), **options)
    with pytest.raises(sn.FactorizationFailed):
        factor.factorize(grid(8, 0.0))  # a Laplacian without constraints
    with pytest.raises(sn.FactorizationFailed):
        factor.solve(np.ones(64))
    factor.factorize(grid(8))
    expect_solves(factor, grid(8))


def test_memory_is_known_and_above_the_limit_the_old_factor_stays(options) -> None:
    factor, large = sn.SpdFactor(grid(5), **options), grid(40)
    before = factor.solve(np.ones(25))
    refused = pytest.raises(sn.FactorizationFailed, match=r"the memory limit is 0\.1 MB")
    with limits.memory(100_000), refused:
        factor.factorize(large)
    assert (factor.size, factor.factorizations) == (25, 1)
    np.testing.assert_array_equal(factor.solve(np.ones(25)), before)
    factor.factorize(large)
    np.testing.assert_allclose(large @ factor.solve(np.ones(1600)), 1, atol=1e-10)
    # Eight bytes an entry, four more for its row where no block shares them, and a few integers an unknown.
    assert max(100_000, 8 * factor.nonzeros) <= factor.bytes <= 12 * factor.nonzeros + 100 * factor.size


def test_solves_from_several_threads_give_the_same_bits(options) -> None:
    factor, b = sn.SpdFactor(grid(25), **options), np.random.default_rng(5).normal(size=(625, 3))
    alone = factor.solve(b)
    with ThreadPoolExecutor(4) as threads:
        for found in threads.map(factor.solve, 80 * [b]):
            np.testing.assert_array_equal(found, alone)


def test_no_unknowns_are_no_problem() -> None:
    factor = sn.SpdFactor(sparse.csc_matrix((0, 0)))
    assert factor.nonzeros == 0
    assert factor.solve(np.zeros((0, 3))).shape == (0, 3)
