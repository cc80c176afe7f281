# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad input: each a typed error that names the elements, or a documented result; the object stays usable."""

import contextlib

import numpy as np
import pytest
import scipy.sparse as sparse

import sinew_native as sn

from .meshes import BENT, METHODS, STILL, bound, grid, shift

POINTS, FACES = grid(4)
NAN, INF = float("nan"), float("inf")


def with_value(array: np.ndarray, index: tuple[int, ...], value: float) -> np.ndarray:
    copy = np.array(array, float)
    copy[index] = value
    return copy


@pytest.mark.parametrize(
    ("points", "faces", "kind", "elements"),
    [
        (np.zeros((0, 3)), [], "", []),
        (with_value(POINTS, (7, 1), NAN), FACES, "vertex", [7]),
        (with_value(POINTS, (3, 2), -INF), FACES, "vertex", [3]),
        (POINTS, [[0, 1, 2], [0, 1, 25]], "face", [1]),
        (POINTS, [[0, 1, -1]], "face", [0]),
        (POINTS, np.array([[0, 1, 2**40]]), "face", [0]),
        (POINTS, np.array([[0, 1, 2**63 + 1]], np.uint64), "face", [0]),
        (POINTS, [[0, 1]], "face", [0]),
        (POINTS, ([3, 2], [0, 1, 2, 3, 4]), "face", [1]),
        (POINTS, ([3], [0, 1, 2, 3]), "", []),
        (POINTS, ([3, 3], [0, 1, 2]), "", []),
        (POINTS, ([-3], [0, 1, 2]), "face", [0]),
        (POINTS, ([3], [0, 1, 2], [0]), "", []),
        (POINTS[:, :2], FACES, "", []),
        (POINTS.ravel(), FACES, "", []),
        (POINTS[None], FACES, "", []),
        (POINTS, FACES.ravel(), "", []),
        (POINTS, FACES[None], "", []),
        (POINTS, [[0, 1, 2], [0, 1]], "", []),
    ],
)
def test_bad_meshes_are_refused(points, faces, kind: str, elements: list[int]) -> None:
    with pytest.raises(sn.InvalidMesh) as caught:
        sn.SurfaceMesh(points, faces)
    assert caught.value.element_kind == kind
    assert caught.value.elements == elements
    assert str(caught.value)


HANDLES = {
    "no vertices": ([[0], []], None, "handle", [1]),
    "out of range": ([[0], [1, 81]], None, "handle", [1]),
    "negative index": ([[0], [-1]], None, "handle", [1]),
    "huge index": ([[0], [2**40]], None, "handle", [1]),
    "two hard handles": ([[0, 1, 2], [2, 3]], None, "vertex", [2]),
    "negative weight": ([[0, 1], [2]], [[0.5, -0.1], None], "vertex", [1]),
    "large weight": ([[0, 1], [2]], [[0.5, 1.1], None], "vertex", [1]),
    "weight not a number": ([[0, 1], [2]], [[NAN, 0.5], None], "vertex", [0]),
    "too many weights": ([[0, 1], [2]], [[0.5, 0.5, 0.5], None], "handle", [0]),
    "weights for one handle": ([[0, 1], [2]], [None], "", []),
}


@pytest.mark.parametrize("name", HANDLES)
@pytest.mark.parametrize("method", METHODS)
def test_bad_handles_are_refused_and_nothing_is_lost(method: type, name: str) -> None:
    handles, weights, kind, elements = HANDLES[name]
    surface, _, _ = bound(method)
    before, _ = surface.solve(BENT)
    with pytest.raises(sn.InvalidConstraint) as caught:
        surface.set_handles(handles, weights)
    assert (caught.value.element_kind, caught.value.elements) == (kind, elements)
    np.testing.assert_array_equal(surface.solve(BENT)[0], before)


@pytest.mark.parametrize("continuity", [-0.1, 2.1, NAN, [1.0], [1, 2, 2], [[1, 1]]])
def test_bad_continuity_is_refused(continuity) -> None:
    surface, _, handles = bound(sn.ThinShell)
    with pytest.raises(sn.InvalidConstraint):
        surface.set_handles(handles, continuity=continuity)


@pytest.mark.parametrize(
    "poses",
    [
        BENT[:1],
        np.concatenate([BENT, BENT]),
        BENT[0],
        BENT[:, :, :3],
        BENT.reshape(2, 12),
        with_value(BENT, (1, 0, 0), NAN),
        with_value(BENT, (0, 2, 3), INF),
        [],
    ],
)
@pytest.mark.parametrize("method", METHODS)
def test_bad_poses_are_refused(method: type, poses) -> None:
    surface, _, _ = bound(method)
    with pytest.raises(sn.InvalidConstraint):
        surface.solve(poses)


@pytest.mark.parametrize("method", METHODS)
def test_bad_incoming_points_are_refused(method: type) -> None:
    surface, points, _ = bound(method)
    for bad in (points[:-1], points[:, :2], points.ravel(), np.zeros((0, 3))):
        with pytest.raises(sn.InvalidConstraint):
            surface.solve(BENT, incoming=bad)
    with pytest.raises(sn.InvalidConstraint) as caught:
        surface.solve(BENT, incoming=with_value(points, (6, 0), NAN))
    assert caught.value.elements == [6]
    for flags in ([True], [True, True, False], []):
        with pytest.raises(sn.InvalidConstraint):
            surface.solve(BENT, from_rest=flags)


def test_bad_options_are_refused() -> None:
    mesh = sn.SurfaceMesh(POINTS, FACES)
    paint = with_value(np.ones(25), (4,), -1)
    for options in (
        {"stretching": -1},
        {"bending": NAN},
        {"variation": INF},
        {"bending": 0},
        {"bending": [1, 1]},
        {"bending": []},
        {"bending": np.ones((25, 1))},
        {"laplacian": "cotangent"},
        {"bending": paint},
    ):
        with pytest.raises(sn.InvalidOption):
            sn.ThinShell(mesh, **options)
    for options in (
        {"smoothness": -1},
        {"smoothness": NAN},
        {"cells": "elements"},
        {"rigidity": -1},
        {"rigidity": [1.0] * 3},
        {"rigidity": paint},
        {"max_iterations": 0},
        {"max_iterations": -5},
        {"tolerance": -1e-3},
        {"tolerance": NAN},
    ):
        with pytest.raises(sn.InvalidOption):
            sn.Arap(mesh, **options)
    with pytest.raises(sn.InvalidOption) as caught:
        sn.Arap(mesh, rigidity=paint)
    assert (caught.value.element_kind, caught.value.elements) == ("vertex", [4])
    with pytest.raises(sn.InvalidOption):
        sn.laplacian(mesh, "cotangent")
    with pytest.raises(sn.InvalidOption):
        sn.laplacian_power(mesh, 0)
    for bad in (np.zeros((3, 3)), np.zeros((2, 3, 4)), np.full((1, 3, 3), NAN)):
        with pytest.raises(sn.InvalidOption):
            sn.fit_rotations(bad)


def test_bad_solve_options_are_refused() -> None:
    arap, points, _ = bound(sn.Arap)
    for options in ({"max_iterations": -1}, {"tolerance": -1.0}, {"tolerance": NAN}):
        with pytest.raises(sn.InvalidOption):
            arap.solve(BENT, **options)
    for start in (points[:3], with_value(points, (0, 0), NAN)):
        with pytest.raises(sn.InvalidConstraint):
            arap.solve(BENT, start=start)
        with pytest.raises(sn.InvalidConstraint):
            arap.energy(start)


@pytest.mark.parametrize("backend", ["automatic", "supernodal", "simplicial", "ldlt"])
def test_singular_and_indefinite_matrices_are_refused(backend: str) -> None:
    for values, broken in (([1.0, 2.0, 0.0, 3.0], 2), ([1.0, -1.0, 2.0, 3.0], 1)):
        with pytest.raises(sn.FactorizationFailed) as caught:
            sn.SpdFactor(sparse.diags(values, format="csc"), backend=backend)
        assert caught.value.elements == [broken]
    for bad in (sparse.csc_matrix((3, 4)), sparse.diags([1.0, NAN], format="csc")):
        with pytest.raises(sn.Error):
            sn.SpdFactor(bad, backend=backend)
    factor = sn.SpdFactor(sparse.identity(3, format="csc"), backend=backend)
    for bad in (np.ones(2), np.ones((4, 2)), np.ones((3, 1, 1))):
        with pytest.raises(sn.InvalidConstraint):
            factor.solve(bad)
    for options in ({"backend": "magic"}, {"ordering": "alphabetical"}):
        with pytest.raises(sn.InvalidOption, match="is not one of"):
            sn.SpdFactor(sparse.identity(3, format="csc"), **options)


@pytest.mark.parametrize("backend", ["supernodal", "simplicial", "ldlt"])
def test_a_factor_survives_a_refused_matrix(backend: str) -> None:
    factor = sn.SpdFactor(sparse.diags([1.0, 2.0, 4.0], format="csc"), backend=backend)
    with pytest.raises(sn.FactorizationFailed):
        factor.factorize(sparse.diags([1.0, -2.0, 4.0], format="csc"))
    with contextlib.suppress(sn.Error):  # a number or a refusal is an answer; a crash is none
        assert factor.solve(np.ones(3)).shape == (3,)
    factor.factorize(sparse.diags([1.0, 2.0, 8.0], format="csc"))
    np.testing.assert_allclose(factor.solve(np.ones(3)), [1, 0.5, 0.125])


@pytest.mark.parametrize("method", METHODS)
def test_no_handle_and_every_vertex_in_one_are_answers(method: type) -> None:
    surface = method(sn.SurfaceMesh(POINTS, FACES))
    np.testing.assert_array_equal(surface.solve(np.zeros((0, 3, 4)))[0], POINTS)  # before any handle
    report = surface.set_handles([])
    assert (report.free_parts, len(report.free_vertices)) == (1, 25)
    np.testing.assert_array_equal(surface.solve([])[0], POINTS)
    surface.set_handles([range(25)])
    np.testing.assert_allclose(surface.solve([shift(1, 2, 3)])[0], POINTS + (1, 2, 3), atol=1e-13)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("points", [np.zeros((25, 3)), POINTS * (1, 0, 0)], ids=["a point", "a line"])
def test_a_mesh_without_area_is_solved_or_refused_by_type(method: type, points: np.ndarray) -> None:
    surface = method(sn.SurfaceMesh(points, FACES))
    with contextlib.suppress(sn.FactorizationFailed):
        surface.set_handles([[0, 1, 2], [24]])
        positions, _ = surface.solve([STILL, shift(0, 0, 1)])
        assert np.isfinite(positions).all()


def test_messages_tell_what_to_do() -> None:
    with pytest.raises(sn.InvalidMesh, match=r"finite"):
        sn.SurfaceMesh(with_value(POINTS, (7, 1), NAN), FACES)
    surface, _, _ = bound(sn.ThinShell)
    with pytest.raises(sn.InvalidConstraint, match=r"vertices 2 are held by two handles \(0 and 1\)"):
        surface.set_handles([[0, 1, 2], [2, 3]])
    with pytest.raises(sn.InvalidConstraint, match="2 handles"):
        surface.solve(BENT[:1])
