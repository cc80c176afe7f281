# SPDX-License-Identifier: GPL-3.0-or-later
"""automatic_cage and diagnose_cage from Python, checked by NumPy."""

import numpy as np
import pytest

import sinew_native as sn

from .meshes import grid, sphere

WIDE = 0.06  # a margin that makes the wrap coarse and quick


def inside(points: np.ndarray, cage: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """By the angles that the faces fill, seen from each point."""
    a, b, c = (cage[faces[:, k]] - points[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=2) for v in (a, b, c))
    volume = np.einsum("ijk,ijk->ij", a, np.cross(b, c))
    dots = [np.einsum("ijk,ijk->ij", u, v) for u, v in ((a, b), (b, c), (c, a))]
    angles = np.arctan2(volume, la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb)
    return angles.sum(axis=1) / (2 * np.pi) > 0.5


def test_cage_encloses_the_mesh_and_reports() -> None:
    points, faces = sphere(3)
    points *= (1.0, 0.6, 2.0)
    cage, triangles, report = sn.automatic_cage(sn.SurfaceMesh(points, faces), 80, WIDE)
    assert triangles.shape == (report.faces, 3)
    assert report.faces == 80
    assert report.reached
    assert report.mirror_axis == 0
    assert inside(points, cage, triangles).all()
    assert sn.diagnose_cage(sn.SurfaceMesh(cage, triangles), points).clean
    assert 0.0 < report.clearance < 3 * WIDE
    assert report.margin == WIDE
    assert report.wrap_faces > 80


def test_quads_come_as_counts_and_indices() -> None:
    points, faces = sphere(3)
    cage, polygons, report = sn.automatic_cage(sn.SurfaceMesh(points, faces), 100, WIDE, quads=True)
    counts, _ = polygons
    assert (counts == 4).sum() == report.quads > 0
    assert sn.diagnose_cage(sn.SurfaceMesh(cage, polygons), points).clean


def test_progress_may_cancel() -> None:
    mesh = sn.SurfaceMesh(*sphere(2))
    seen = []
    sn.automatic_cage(mesh, 60, WIDE, progress=lambda share, stage: seen.append((share, stage)))
    assert seen[-1][0] == 1.0
    with pytest.raises(sn.Cancelled, match="wrapping"):
        sn.automatic_cage(mesh, 60, WIDE, progress=lambda share, stage: False)


@pytest.mark.parametrize(
    ("keywords", "error"),
    [
        ({"faces": 3}, sn.InvalidOption),
        ({"margin": 0.0}, sn.InvalidOption),
        ({"symmetry": "w"}, sn.InvalidOption),
        ({"progress": 3}, TypeError),
    ],
)
def test_options_out_of_range_are_refused(keywords: dict, error: type) -> None:
    with pytest.raises(error, match=next(iter(keywords))):
        sn.automatic_cage(sn.SurfaceMesh(*sphere(1)), **keywords)


def test_diagnosis_names_elements() -> None:
    points, faces = sphere(1)
    broken = np.delete(faces, 5, axis=0)
    broken[3] = broken[3][::-1]
    found = sn.diagnose_cage(sn.SurfaceMesh(points, broken), [(0, 0, 0), (2, 0, 0)])
    edges = {tuple(sorted((faces[5][k], faces[5][(k + 1) % 3]))) for k in range(3)}
    assert {tuple(edge) for edge in found.open_edges} == edges
    np.testing.assert_array_equal(found.inverted_faces, [3])
    np.testing.assert_array_equal(found.outside_points, [1])
    assert found.crossing_faces.shape == (0, 2)
    assert not found.clean
    assert found.summary() == "3 open edges, 1 inverted face, 1 point outside"


def test_points_that_are_not_finite_are_named() -> None:
    with pytest.raises(sn.InvalidConstraint) as caught:
        sn.diagnose_cage(sn.SurfaceMesh(*grid(2)), [(0, 0, 0), (np.nan, 0, 0)])
    assert caught.value.elements == [1]
