# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad input: each a typed error that names the elements; the object stays usable."""

import numpy as np
import pytest
import scipy.sparse as sparse

import sinew_native as sn

from .meshes import BENT, grid
from .methods import bound

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
        (with_value(POINTS, (1, 2), INF), FACES, "vertex", [1]),
        (POINTS, [[0, 1, 2], [0, 1, 25]], "face", [1]),
        (POINTS, [[0, 1, -1]], "face", [0]),
        (POINTS, np.array([[0, 1, 2**40]]), "face", [0]),
        (POINTS, np.array([[0, 1, 2**63 + 1]], np.uint64), "face", [0]),
        (POINTS, [[0, 1]], "face", [0]),
        (POINTS, ([3, 2, 3, 0], [0, 1, 2, 3, 4, 0, 1, 2]), "face", [1, 3]),
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


# What all methods of a level can do is bound once (test_contract.py), so one method stands for all.
HANDLES = {
    "no vertices": ([[0], []], None, "handle", [1]),
    "negative index": ([[0], [-1]], None, "handle", [1]),
    "huge index": ([[0], [2**40]], None, "handle", [1]),
    "two hard handles": ([[0, 1, 2], [2, 3]], None, "vertex", [2]),
    "weight not a number": ([[0, 1], [2]], [[NAN, 0.5], None], "vertex", [0]),
    "too many weights": ([[0, 1], [2]], [[0.5, 0.5, 0.5], None], "handle", [0]),
    "weights for one handle": ([[0, 1], [2]], [None], "", []),
}


@pytest.mark.parametrize("name", HANDLES)
def test_bad_handles_are_refused_and_nothing_is_lost(name: str) -> None:
    handles, weights, kind, elements = HANDLES[name]
    surface, _, _ = bound(sn.ThinShell)
    before, _ = surface.solve(BENT)
    with pytest.raises(sn.InvalidConstraint) as caught:
        surface.set_handles(handles, weights)
    assert (caught.value.element_kind, caught.value.elements) == (kind, elements)
    np.testing.assert_array_equal(surface.solve(BENT)[0], before)


@pytest.mark.parametrize("continuity", [NAN, [1.0], [1, 2, 2], [[1, 1]]])
def test_bad_continuity_is_refused(continuity) -> None:
    surface, _, handles = bound(sn.ThinShell)
    with pytest.raises(sn.InvalidConstraint):
        surface.set_handles(handles, continuity=continuity)


def test_bad_arrays_and_flags_are_refused_by_a_solve() -> None:
    arap, points, _ = bound(sn.Arap)
    one_axis_less = (points[:-1], points[:, :2], points.ravel(), np.zeros((0, 3)))
    wrong = {
        "poses": ([], BENT[:1], BENT[0], BENT[:, :, :3], BENT.reshape(2, 12)),
        "incoming": one_axis_less,
        "start": one_axis_less,
        "from_rest": ([True], [True, True, False], []),
    }
    for name, values in wrong.items():
        for value in values:
            with pytest.raises(sn.InvalidConstraint):
                arap.solve(**{"poses": BENT} | {name: value})
    for value in one_axis_less:
        with pytest.raises(sn.InvalidConstraint):
            arap.energy(value)
    with pytest.raises(sn.InvalidConstraint) as caught:
        arap.solve(BENT, incoming=with_value(points, (6, 0), NAN))
    assert caught.value.elements == [6]


@pytest.mark.parametrize(
    ("make", "options"),
    [
        (sn.ThinShell, {"bending": NAN}),
        (sn.ThinShell, {"bending": []}),
        (sn.ThinShell, {"bending": np.ones((25, 1))}),
        (sn.ThinShell, {"laplacian": "cotangent"}),
        (sn.Arap, {"smoothness": -1}),
        (sn.Arap, {"cells": "elements"}),
        (sn.Arap, {"rigidity": [1.0] * 3}),
        (sn.Arap, {"max_iterations": -5}),
        (sn.Arap, {"tolerance": NAN}),
        (sn.laplacian, {"discretization": "cotangent"}),
        (sn.laplacian_power, {"order": 0}),
    ],
)
def test_bad_options_are_refused(make, options: dict) -> None:
    with pytest.raises(sn.InvalidOption):
        make(sn.SurfaceMesh(POINTS, FACES), **options)


def test_bad_paint_is_named_and_bad_matrices_are_refused() -> None:
    with pytest.raises(sn.InvalidOption) as caught:
        sn.Arap(sn.SurfaceMesh(POINTS, FACES), rigidity=with_value(np.ones(25), (4,), -1))
    assert (caught.value.element_kind, caught.value.elements) == ("vertex", [4])
    for bad in (np.zeros((3, 3)), np.zeros((2, 3, 4)), np.full((1, 3, 3), NAN)):
        with pytest.raises(sn.InvalidOption):
            sn.fit_rotations(bad)


def test_factors_refuse_what_they_cannot_factorise_or_solve() -> None:
    with pytest.raises(sn.FactorizationFailed) as caught:
        sn.SpdFactor(sparse.diags([1.0, -1.0, 2.0], format="csc"))
    assert caught.value.elements == [1]
    for bad in (sparse.csc_matrix((3, 4)), sparse.diags([1.0, NAN], format="csc")):
        with pytest.raises(sn.Error):
            sn.SpdFactor(bad)
    identity = sparse.identity(3, format="csc")
    for bad in (np.ones(2), np.ones((4, 2)), np.ones((3, 1, 1))):
        with pytest.raises(sn.InvalidConstraint):
            sn.SpdFactor(identity).solve(bad)
    for options in ({"backend": "magic"}, {"ordering": "alphabetical"}):
        with pytest.raises(sn.InvalidOption, match="is not one of"):
            sn.SpdFactor(identity, **options)


def test_messages_tell_what_to_do() -> None:
    with pytest.raises(sn.InvalidMesh, match=r"finite"):
        sn.SurfaceMesh(with_value(POINTS, (7, 1), NAN), FACES)
    surface, _, _ = bound(sn.ThinShell)
    with pytest.raises(sn.InvalidConstraint, match=r"vertices 2 are held by two handles \(0 and 1\)"):
        surface.set_handles([[0, 1, 2], [2, 3]])
    with pytest.raises(sn.InvalidConstraint, match="2 handles"):
        surface.solve(BENT[:1])
