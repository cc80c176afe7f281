# SPDX-License-Identifier: GPL-3.0-or-later
"""automatic_cage and diagnose_cage from Python, checked by NumPy."""

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import grid, sphere, spread

GAPS = {60: 0.12, 100: 0.09}  # by number of faces: of a vertex of the cage, as a share of the size
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


def angles_around(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """The sum (n,) of the angles of the triangles at each vertex."""
    sums = np.zeros(len(points))
    for k in range(3):
        at, u, v = (points[triangles[:, (k + i) % 3]] for i in range(3))
        u, v = u - at, v - at
        np.add.at(
            sums,
            triangles[:, k],
            np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), (u * v).sum(axis=1)),
        )
    return sums


def character() -> tuple[np.ndarray, np.ndarray]:
    """A head with two large flat ears and a trunk, symmetric about x = 0 but for the division into faces.

    It is rounded: sines and products differ in their last bits from system to system, and so would cages.
    """
    parts = (
        ((0.0, 0.0, 0.0), (1.0, 0.9, 1.0), 0.3),
        ((1.5, 0.2, 0.3), (0.8, 0.15, 0.7), 0.5),
        ((-1.5, 0.2, 0.3), (0.8, 0.15, 0.7), 0.1),
        ((0.0, -1.1, -0.6), (0.25, 0.3, 0.9), 0.2),
    )
    ball, faces = sphere(4)
    points, corners = [], []
    for middle, radii, turn in parts:
        c, s = np.cos(turn), np.sin(turn)
        turned = ball @ np.array(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)))
        corners.append(faces + len(ball) * len(points))
        points.append(turned * radii + middle)
    return np.round(np.concatenate(points), 9), np.concatenate(corners)


@pytest.mark.parametrize("faces", [60, 100])
def test_a_cage_of_few_faces_has_no_spikes_and_both_sides_alike(faces: int):
    points, corners = character()
    cage, triangles, report = sn.automatic_cage(sn.SurfaceMesh(points, corners), faces)
    assert sn.diagnose_cage(sn.SurfaceMesh(cage, triangles), points).clean
    assert report.mirror_axis == 0
    assert report.asymmetry < 0.01
    assert faces - 2 <= report.faces <= faces + 1
    assert {tuple(p) for p in cage} == {(-x, y, z) for x, y, z in cage}
    a, b, c = (cage[triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    sides = sum(((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a)))
    assert (4 * np.sqrt(3) * area / sides).min() > 0.3  # 1 for equal sides
    assert angles_around(cage, triangles).min() > 3.3  # 2 pi where the cage is flat, 0 in a needle's tip
    size = np.linalg.norm(np.ptp(points, axis=0))
    gaps = np.linalg.norm(cage[:, None] - points, axis=2).min(axis=1) / size
    assert gaps.max() < GAPS[faces]


def test_twelve_faces_are_reached_around_ears_and_trunk() -> None:
    points, corners = character()
    points[:, 1] *= 1.3
    for symmetry in ("automatic", "none"):
        cage, faces, report = sn.automatic_cage(sn.SurfaceMesh(points, corners), 12, WIDE, symmetry=symmetry)
        assert (report.reached, report.reason) == (True, "")
        assert sn.diagnose_cage(sn.SurfaceMesh(cage, faces), points).clean


def test_sides_that_differ_get_no_symmetry_and_the_report_says_by_how_much() -> None:
    points, corners = character()
    ear = points[:, 0] < -0.9
    points[ear, 2] += 0.5  # as far as the ear is thick at its upper edge, and above its lower one
    mesh = sn.SurfaceMesh(points, corners)
    size = spread(points, mesh.triangles)
    report = sn.automatic_cage(mesh, 60, WIDE)[2]
    assert report.mirror_axis == -1
    assert 0.3 / size < report.asymmetry < 0.52 / size


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
    shares, stages = zip(*seen)
    assert shares[-1] == 1.0
    assert list(shares) == sorted(shares)
    assert list(dict.fromkeys(stages)) == ["wrapping", "simplifying", "tightening", "checking"]
    for stage in set(stages):
        with pytest.raises(sn.Cancelled, match=stage):
            sn.automatic_cage(mesh, 60, WIDE, progress=lambda _share, now, stage=stage: now != stage)


@pytest.mark.parametrize(
    ("keywords", "error"),
    [
        *(({"faces": count}, sn.InvalidOption) for count in (3, 11, 100_001)),
        *(({"margin": share}, sn.InvalidOption) for share in (0.0, -1.0, 0.3, np.nan)),
        ({"symmetry": "w"}, sn.InvalidOption),
        ({"progress": 3}, TypeError),
    ],
)
def test_options_out_of_range_are_refused(keywords: dict, error: type) -> None:
    with pytest.raises(error, match=next(iter(keywords))):
        sn.automatic_cage(sn.SurfaceMesh(*sphere(1)), **keywords)


@pytest.mark.parametrize("points", [[(1, 2, 3), (1, 2, 3)], [(-1e308, 0, 0), (1e308, 0, 0)]])
def test_targets_without_a_size_are_refused(points: list) -> None:
    with pytest.raises(sn.InvalidMesh):
        sn.automatic_cage(sn.SurfaceMesh(points, []))


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
