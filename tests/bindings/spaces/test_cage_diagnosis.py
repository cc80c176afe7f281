# SPDX-License-Identifier: GPL-3.0-or-later
"""diagnose_cage: what keeps a mesh from being a good cage, by its elements."""

import numpy as np
import pytest

import sinew_native as sn

from ..cages import CUBE, QUADS
from ..meshes import closed_bar, grid, joined, messy, sphere

CUBE_MESH = (CUBE, QUADS)
NESTED = joined(CUBE_MESH, (CUBE / 2 + 0.25, QUADS))
BESIDE = joined(CUBE_MESH, (CUBE + (3, 0, 0), QUADS))
FOLDED = sphere(0)[0].copy()
FOLDED[4] = FOLDED[2]  # an edge of the octahedron is a point
TETRAHEDRON = np.concatenate([np.zeros((1, 3)), np.eye(3)])
PLACES = [(0.5, 0.5, 0.5), (1.5, 0.5, 0.5), (1, 1, 1), (1, 0.5, 0.5), (0.5, 0.5, 1 + 1e-6)]


def flipped(mesh: tuple[np.ndarray, np.ndarray], faces) -> tuple[np.ndarray, np.ndarray]:
    points, all_faces = mesh[0], mesh[1].copy()
    all_faces[faces] = all_faces[faces][:, ::-1]
    return points, all_faces


@pytest.mark.parametrize("mesh", [CUBE_MESH, sphere(0), sphere(2), closed_bar(6, 2)])
def test_nothing_is_wrong_with_a_good_cage(mesh) -> None:
    found = sn.diagnose_cage(sn.SurfaceMesh(*mesh))
    assert (found.summary(), found.component_count, len(found.crowded_diagonals)) == ("clean", 1, 0)


@pytest.mark.parametrize(
    ("mesh", "found"),
    [
        ((CUBE, QUADS[:5]), {"open_edges": [(1, 3), (1, 5), (3, 7), (5, 7)], "summary": "4 open edges"}),
        # Two faces of a tetrahedron as one quad: its other diagonal is the edge opposite.
        ((TETRAHEDRON, ([4, 3, 3], [0, 2, 1, 3, 0, 3, 1, 1, 2, 0])), {"crowded_diagonals": [(0, 1)]}),
        (flipped(CUBE_MESH, [2, 4]), {"inverted_faces": [2, 4]}),
        (flipped(CUBE_MESH, range(6)), {"inverted_faces": [*range(6)]}),
        (BESIDE, {"component_count": 2, "summary": "clean"}),
        (flipped(BESIDE, range(6, 12)), {"inverted_faces": [*range(6, 12)]}),  # each part for itself
        (NESTED, {"inverted_faces": [*range(6, 12)]}),  # the inner one is a cavity and has to look inward
        (flipped(NESTED, range(6, 12)), {"summary": "clean"}),
        ((FOLDED, sphere(0)[1]), {"degenerate_faces": [0, 1]}),
        (
            (CUBE, ([4] * 6 + [3], [*QUADS.ravel(), 0, 4, 7])),
            {"non_manifold_edges": [(0, 4)], "open_edges": [(0, 7), (4, 7)]},
        ),
    ],
)
def test_what_is_wrong_is_named(mesh, found: dict[str, object]) -> None:
    diagnosis = sn.diagnose_cage(sn.SurfaceMesh(*mesh))
    for name, expected in found.items():
        value = getattr(diagnosis, name)
        told = value() if callable(value) else value
        assert np.array(told).tolist() == np.array(expected).tolist(), name
    assert diagnosis.clean == (diagnosis.summary() == "clean")


@pytest.mark.parametrize("sides", [4, 5])
def test_a_pillow_of_two_polygons_has_crowded_diagonals(sides: int) -> None:
    """Of quads both, twice; of pentagons those that it is cut along."""
    angles = 2 * np.pi * np.arange(sides) / sides
    rim = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    found = sn.diagnose_cage(sn.SurfaceMesh(rim, [range(sides), range(sides)[::-1]]))
    assert len(found.crowded_diagonals) >= 1
    assert "more than two triangles" in found.summary()


def test_faces_that_cross_are_pairs_of_one_of_each_cube() -> None:
    found = sn.diagnose_cage(sn.SurfaceMesh(*joined(CUBE_MESH, (CUBE + (0.5, 0.5, 0.25), QUADS))))
    assert len(found.crossing_faces) > 4, "an edge of each cube goes through two faces of the other"
    assert ((found.crossing_faces < 6) == (True, False)).all()
    assert len(found.open_edges) == len(found.inverted_faces) == 0


@pytest.mark.parametrize(("faces", "outside"), [(QUADS, [1, 4]), ([], [0, 1, 2, 3, 4])])
def test_points_outside_are_named_but_none_on_a_corner_or_a_face(faces, outside: list[int]) -> None:
    found = sn.diagnose_cage(sn.SurfaceMesh(CUBE, faces), PLACES)
    np.testing.assert_array_equal(found.outside_points, outside)


def test_many_loose_faces_take_no_longer_than_one_part() -> None:
    points = np.arange(20_000)[:, None, None] * (1.0, 0, 0) + [(0, 0, 0), (0.5, 0, 0), (0, 0.5, 0)]
    found = sn.diagnose_cage(sn.SurfaceMesh(points.reshape(-1, 3), np.arange(60_000).reshape(-1, 3)))
    assert (len(found.open_edges), found.component_count) == (60_000, 20_000)
    assert found.crossing_faces.shape == (0, 2)


def test_everything_may_be_wrong_at_once() -> None:
    found = sn.diagnose_cage(sn.SurfaceMesh(*messy()), messy()[0])
    assert all(map(len, (found.open_edges, found.degenerate_faces, found.crossing_faces)))
    points, faces = sphere(1)
    broken = flipped((points, np.delete(faces, 5, axis=0)), [3])
    summary = sn.diagnose_cage(sn.SurfaceMesh(*broken), [(0, 0, 0), (2, 0, 0)]).summary()
    assert summary == "3 open edges, 1 inverted face, 1 point outside"


def test_points_that_are_not_finite_are_named() -> None:
    with pytest.raises(sn.InvalidConstraint) as caught:
        sn.diagnose_cage(sn.SurfaceMesh(*grid(2)), [(0, 0, 0), (np.nan, 0, 0)])
    assert caught.value.elements == [1]
