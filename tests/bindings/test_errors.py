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
    assert (caught.value.element_kind, caught.value.elements) == (kind, elements)
    assert str(caught.value)


# What all methods of a level can do is bound once (test_contract.py), so one method stands for all.
HANDLES = {
    "no vertices": ([[0], []], None, "handle", [1]),
    "negative index": ([[0], [-1]], None, "handle", [1]),
    "huge index": ([[0], [2**40]], None, "handle", [1]),
    "two hard handles": ([[0, 1, 2], [2, 3, 1]], None, "vertex", [2, 1]),
    "weight not a number": ([[0, 1], [2]], [[NAN, 0.5], None], "vertex", [0]),
    "weights out of range": ([[4, 5, 1, 7]], [[0.5, 1.1, -0.1, INF]], "vertex", [5, 1, 7]),
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


def test_bad_arrays_and_flags_are_refused_by_a_solve() -> None:
    arap, points, _ = bound(sn.Arap)
    one_axis_less = (points[:-1], points[:, :2], points.ravel(), np.zeros((0, 3)))
    wrong = {"incoming": one_axis_less, "start": one_axis_less}
    wrong["from_rest"] = ([True], [True, True, False], [])
    wrong["poses"] = ([], BENT[:1], BENT[0], BENT[:, :, :3], BENT.reshape(2, 12))
    for name, values in wrong.items():
        for value in values:
            with pytest.raises(sn.InvalidConstraint):
                arap.solve(**{"poses": BENT} | {name: value})
    for method in (arap, bound(sn.ThinShellNonlinear)[0]):
        for value in (*one_axis_less, with_value(points, (3, 0), NAN)):
            with pytest.raises(sn.InvalidConstraint):
                method.energy(value)
    with pytest.raises(sn.InvalidConstraint) as caught:
        arap.solve(BENT, incoming=with_value(points, (6, 0), NAN))
    assert caught.value.elements == [6]


@pytest.mark.parametrize(
    ("make", "options"),
    [
        (sn.ThinShell, {"bending": 0.0}),  # nor are the other stiffnesses more
        (sn.ThinShell, {"bending": np.zeros(25)}),
        (sn.Propagation, {"transfer": []}),
        (sn.Propagation, {"transfer": [1.0]}),
        (sn.Propagation, {"transfer": [0.0, NAN, 1.0]}),
        (sn.RotationInvariantCoordinates, {"laplacian": "cotan_voronoi"}),
        (sn.Arap, {"cells": "rims", "point_handles": 0.5}),
        (sn.Arap, {"rigidity": 0.0}),
        (sn.Arap, {"rigidity": np.zeros(25)}),
        (sn.Primo, {"height": 0.0}),
        (sn.Primo, {"height": np.zeros(25)}),
        (sn.ThinShellNonlinear, {"measure": "stiffness", "stretching": 0.0}),
        (sn.laplacian, {"discretization": "cotangent"}),
        (sn.laplacian_power, {"order": 0}),
    ],
)
def test_bad_options_are_refused(make, options: dict) -> None:
    with pytest.raises(sn.InvalidOption):
        make(sn.SurfaceMesh(POINTS, FACES), **options)


def test_a_refused_stiffness_or_continuity_leaves_the_last_one() -> None:
    shell, _, handles = bound(sn.ThinShell)
    before, _ = shell.solve(BENT)
    for continuity in (NAN, -0.1, [1, 2.1], [1.0], [1, 2, 2], [[1, 1]]):
        with pytest.raises(sn.InvalidConstraint):
            shell.set_handles(handles, continuity=continuity)
    for wrong in ((-1.0, 1.0), (0.0, NAN), (0.0, 0.0), (0.0, [1.0, 1.0]), (0.0, 1.0, INF)):
        with pytest.raises(sn.InvalidOption):
            shell.set_stiffness(*wrong)
        np.testing.assert_array_equal(shell.solve(BENT)[0], before)


def test_bad_matrices_are_refused() -> None:
    for bad in (np.zeros((3, 3)), np.zeros((2, 3, 4)), np.full((1, 3, 3), NAN)):
        with pytest.raises(sn.InvalidOption):
            sn.fit_rotations(bad)
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
    with pytest.raises(sn.InvalidConstraint, match=r"call set_handles\(\) first"):
        sn.AffineBasis(sn.ThinShell(surface.rest))
    surface.set_handles([])
    assert sn.AffineBasis(surface).matrix.shape == (81, 0)
