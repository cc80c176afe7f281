# SPDX-License-Identifier: GPL-3.0-or-later
"""The systems of methods, and every solver of the tutorial's appendix A on them; SciPy is the oracle."""

import numpy as np
import pytest
import scipy.sparse as sparse
from scipy.sparse.linalg import spsolve

import sinew_native as sn

from . import limits
from .meshes import ends, grid, messy

ITERATIVE = ("conjugate_gradients", "multigrid")
ORDERINGS = ("natural", "reverse_cuthill_mckee", "minimum_degree", "nested_dissection")
WAYS = [{"solver": name} for name in ("automatic", "cholesky", "simplicial", "lu")]
WAYS += [{"solver": f"dense_{name}"} for name in ("cholesky", "lu", "qr", "svd")]
PRECONDITIONERS = ("none", "jacobi", "incomplete_cholesky", "shifted_incomplete_cholesky")
WAYS += [{"solver": "conjugate_gradients", "preconditioner": name} for name in PRECONDITIONERS]
WAYS += [{"solver": "multigrid", "cycle": name} for name in ("v", "full", "cascading")]
# Errors by condition numbers of up to 1e6, of iterations by their tolerance times that.
EXACT, ITERATED = 1e-8, 1e-5


def shell(side: int, mesh=grid, **options) -> sn.LinearSystem:
    """Of a thin shell that is held at one end and bent at the other."""
    points, faces = mesh(side) if mesh is grid else mesh()
    method = sn.ThinShell(sn.SurfaceMesh(points, faces), **options)
    held, moved = ends(points)
    method.set_handles([held, moved], weights=[1.0, 0.5 if options else 1.0])
    poses = np.tile(np.eye(3, 4), (2, 1, 1))
    poses[1, :, 3] = 1.0, 2.0, 3.0
    return sn.system(method, poses)


def expected(system: sn.LinearSystem) -> np.ndarray:
    return spsolve(system.matrix, system.right_side)


@pytest.fixture(scope="module", params=[{}, {"bending": 0, "stretching": 1}, {"stretching": 0.5}], ids=repr)
def system(request) -> sn.LinearSystem:
    return shell(20, **request.param)


@pytest.mark.parametrize("way", WAYS, ids=lambda way: " ".join(way.values()))
def test_all_solvers_agree(system, way) -> None:
    iterates = way["solver"] in ITERATIVE
    if system.order == 2 and way.get("preconditioner") == "incomplete_cholesky":
        with pytest.raises(sn.FactorizationFailed, match="breaks down; choose shifted_incomplete_cholesky"):
            sn.solve(system, **way)
        return
    x, report = sn.solve(system, **way, tolerance=1e-10)
    truth = expected(system)
    close = (ITERATED if iterates else EXACT) * abs(truth).max()
    np.testing.assert_allclose(x, truth, rtol=0, atol=close)
    assert report.solver == ("cholesky" if way["solver"] == "automatic" else way["solver"])
    assert report.residual < 1e-6
    assert (report.iterations > 0) == iterates


@pytest.mark.parametrize(
    "name", ["ThinShell", "GradientEditing", "LaplacianEditing", "RotationInvariantCoordinates"]
)
def test_the_system_is_that_of_the_solve(name) -> None:
    points, faces = grid(9)
    method = getattr(sn, name)(sn.SurfaceMesh(points, faces))
    method.set_handles(ends(points))
    poses = np.tile(np.eye(3, 4), (2, 1, 1))
    poses[1, :2, :2], poses[1, :, 3] = [[0.8, -0.6], [0.6, 0.8]], (1.0, -2.0, 3.0)
    system, (moved, _) = sn.system(method, poses), method.solve(poses)
    np.testing.assert_allclose(expected(system), (moved - points)[system.vertices], atol=1e-7)
    graph, free = system.graph, system.vertices
    if system.order == 2:
        graph = graph @ sparse.diags(1 / system.mass) @ graph
    np.testing.assert_allclose(graph.tocsr()[free][:, free].toarray(), system.matrix.toarray(), atol=1e-9)


def test_multigrid_needs_as_many_iterations_for_four_times_the_unknowns_and_no_manifold() -> None:
    counts = [sn.solve(shell(side), solver="multigrid", tolerance=1e-4)[1].iterations for side in (80, 160)]
    assert max(counts) <= 6
    from_zero = sn.solve(shell(160), solver="multigrid", cycle="v", tolerance=1e-4)[1].iterations
    assert from_zero >= 2 * counts[1]  # a guess of 0 has a jump beside each handle
    system = shell(0, messy)
    x = sn.solve(system, solver="multigrid", tolerance=1e-10)[0]
    np.testing.assert_allclose(x, expected(system), rtol=0, atol=1e-5)
    alone = sn.solve(shell(80), solver="multigrid", tolerance=1e-6)[0]
    with limits.threads(1):
        np.testing.assert_array_equal(sn.solve(shell(80), solver="multigrid", tolerance=1e-6)[0], alone)


def test_the_error_bound_holds(system) -> None:
    x, report = sn.solve(system, solver="conjugate_gradients", tolerance=1e-6, error_bound=True)
    error = np.linalg.norm(x - expected(system), axis=0).max()
    assert error < 1.01 * report.error_bound < 1e3 * error


def refusals():
    good, b = sparse.csc_matrix(np.diag([2.0, 3, 4])), np.ones(3)
    loose = sparse.csc_matrix([[1.0, -1, 0], [-1, 2, -1], [0, -1, 1]])
    wrong = sparse.csc_matrix([[2.0, 1, 0], [0, 2, 0], [0, 0, 2]])
    big = sparse.identity(5001, format="csc")
    for solver in ("cholesky", "dense_cholesky", "conjugate_gradients"):
        yield wrong, b, {"solver": solver}, sn.InvalidOption, r"not symmetric.*\(0, 1\).*choose lu"
        yield -good, b, {"solver": solver}, sn.FactorizationFailed, "not positive definite"
    for solver in ("cholesky", "lu", "dense_lu", "dense_qr", "dense_svd"):
        yield loose, b, {"solver": solver}, sn.FactorizationFailed, "singular"

    closed = sn.laplacian(sn.SurfaceMesh(*grid(20)), "uniform")  # of constants it makes 0
    at_random = np.random.default_rng(3).normal(size=closed.shape[0])
    for solver in ("automatic", "simplicial", "lu", "conjugate_gradients", "dense_qr"):
        yield (
            closed,
            at_random,
            {"solver": solver},
            (sn.FactorizationFailed, sn.NotConverged),
            "singular|iteration",
        )
    yield wrong, b, {"error_bound": True}, sn.InvalidOption, "error_bound: the matrix is not symmetric"
    yield good * 1j, b, {}, TypeError, "real numbers"
    yield "x", b, {}, TypeError, "SciPy sparse"
    yield good, np.ones(4), {}, sn.InvalidOption, "b: 4 rows given for a matrix of 3"
    yield good, [1, np.nan, 1], {}, sn.InvalidOption, "b: NaN or infinite entry in row 1"
    yield good * np.inf, b, {}, sn.InvalidOption, "matrix: NaN or infinite"
    yield good[:2], b, {}, sn.InvalidOption, "not square"
    yield good, None, {}, sn.InvalidOption, "b: give one"
    yield big, np.ones(5001), {"solver": "dense_qr"}, sn.InvalidOption, r"at most 5000 unknowns.*choose"
    yield good, b, {"solver": "multigrid"}, sn.InvalidOption, "multigrid needs the points"
    yield good, b, {"solver": "lu", "ordering": "natural"}, sn.InvalidOption, "ordering: only"
    yield good, b, {"tolerance": -1}, sn.InvalidOption, "tolerance"
    for word in ("solver", "ordering", "preconditioner", "cycle"):
        yield good, b, {word: "magic"}, sn.InvalidOption, rf"{word}: 'magic' is not one of '"


@pytest.mark.parametrize(("matrix", "b", "options", "error", "words"), list(refusals()))
def test_refusals_name_what_is_wrong(matrix, b, options, error, words) -> None:
    with pytest.raises(error, match=words):
        sn.solve(matrix, b, **options)


def test_budgets_cycles_and_methods_that_do_not_fit_are_refused_by_name() -> None:
    system = shell(80)
    for solver in ITERATIVE:
        with pytest.raises(sn.NotConverged, match="max_iterations: after 2 iterations"):
            sn.solve(system, solver=solver, max_iterations=2)
    nodes = {"points": system.points, "vertices": system.vertices, "mass": system.mass}
    negative = sn.LinearSystem(system.matrix, system.right_side, graph=-system.graph, order=1, **nodes)
    with pytest.raises((sn.NotConverged, sn.FactorizationFailed), match=r"diverges|singular"):
        sn.solve(negative, solver="multigrid")
    with pytest.raises(sn.InvalidOption, match="order 3"):
        sn.solve(shell(20, variation=1.0), solver="multigrid")
    with pytest.raises(sn.InvalidOption, match="mass: 3 given for"):
        sn.LinearSystem(
            system.matrix, points=system.points, graph=system.graph, vertices=system.vertices, mass=np.ones(3)
        )
    points, faces = grid(4)
    method = sn.Propagation(sn.SurfaceMesh(points, faces))
    with pytest.raises(sn.InvalidConstraint, match="call set_handles"):
        sn.system(method, np.zeros((0, 3, 4)))
    method.set_handles(ends(points, 0.5))
    with pytest.raises(sn.InvalidOption, match="no linear system"):
        sn.system(method, np.tile(np.eye(3, 4), (2, 1, 1)))
    for solver in ITERATIVE:  # a coarse solution is no sign of a singular matrix
        assert sn.solve(system, solver=solver, tolerance=0.3)[1].residual < 1e3
    with limits.memory(3_000_000):
        report = sn.solve(system, tolerance=1e-3)[1]
    assert (report.solver, report.why[:10]) == ("multigrid", "the factor")


@pytest.mark.parametrize("ordering", [*ORDERINGS, "cuthill_mckee", "patch_dissection"])
def test_an_order_of_elimination_has_the_entries_and_the_envelope_that_are_reported(system, ordering) -> None:
    A = system.matrix
    order = sn.elimination_order(np.argwhere(np.triu(A.toarray())), A.shape[0], ordering)
    pattern = A.toarray()[np.ix_(order, order)] != 0.0
    lower = np.tril(pattern)
    first = lower.argmax(1)
    for k in range(len(lower)):
        rows = np.flatnonzero(lower[k + 1 :, k]) + k + 1
        lower[np.ix_(rows, rows)] = True
    entries = np.tril(lower).sum()
    report = sn.solve(system, solver="simplicial", ordering=ordering)[1]
    assert report.envelope == (np.arange(len(first)) - first + 1).sum()
    assert report.fill == pytest.approx(entries / np.tril(pattern).sum())
    for wrong in (([[0, 1]], 0), ([[0, 1]], -1), ([[0, 2]], 2), ([[-1, 0]], 2)):
        with pytest.raises(sn.InvalidOption):
            sn.elimination_order(*wrong, ordering)
