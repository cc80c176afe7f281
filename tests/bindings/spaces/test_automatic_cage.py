# SPDX-License-Identifier: GPL-3.0-or-later
"""Automatic cages, checked by NumPy, and what keeps a mesh from being a good cage, by its elements."""

from collections import Counter

import numpy as np
import pytest

import sinew_native as sn

from .. import limits
from ..cages import CUBE, QUADS
from ..meshes import angles_filled, closed_bar, grid, joined, messy, sphere, spread, torus, turn

GAPS = {60: 0.12, 100: 0.09}  # by number of faces: of a vertex of the cage, as a share of the size
WIDE = 0.06  # a margin that makes the wrap coarse and quick


def good_cage(mesh: sn.SurfaceMesh, faces: int, **options):
    """Closed, outward, embedded and around the mesh: the cage as a mesh, and the report."""
    cage, polygons, report = sn.automatic_cage(mesh, faces, **{"margin": WIDE} | options)
    made = sn.SurfaceMesh(cage, polygons)
    held = mesh.points[np.unique(mesh.triangles)] if len(mesh.triangles) else mesh.points
    assert sn.diagnose_cage(made, held).summary() == "clean"
    sides = np.concatenate([made.triangles[:, [k, (k + 1) % 3]] for k in range(3)]).tolist()
    assert sorted(sides) == sorted(side[::-1] for side in sides), "closed, and turned alike"
    assert angles_filled(held, cage, made.triangles).min() > 0.5
    assert report.clearance > 0
    return made, report


def corners_of(polygons: object) -> list[list[int]]:
    """The faces one by one."""
    if isinstance(polygons, tuple):
        return [face.tolist() for face in np.split(polygons[1], np.cumsum(polygons[0])[:-1])]
    return polygons.tolist()


TARGETS = {"sphere": sphere(3), "bar": closed_bar(8, 2), "hill": grid(12)}
TARGETS |= {"torus": torus(40, 20), "messy": messy()}
MESHES = [sn.SurfaceMesh(*target) for target in TARGETS.values()]
EVERY_TARGET = pytest.mark.parametrize("mesh", MESHES, ids=TARGETS)


@EVERY_TARGET
@pytest.mark.parametrize("faces", [60, 150])
def test_a_cage_encloses_in_as_many_faces_as_asked_and_reports(mesh: sn.SurfaceMesh, faces: int) -> None:
    cage, report = good_cage(mesh, faces)
    assert (report.wanted, report.reached, report.reason) == (faces, True, "")
    assert faces - 2 <= report.faces <= faces + 1
    assert report.faces == cage.face_count < report.wrap_faces
    assert report.margin == WIDE
    assert report.clearance < 3 * WIDE


def test_vertices_without_a_face_are_left_out() -> None:
    """The last one, 20 from all others, would make a spike of the cage or a second part."""
    mesh = sn.SurfaceMesh(*messy())
    cage, _report = good_cage(mesh, 60)
    last, others = mesh.vertex_count - 1, mesh.points[:-1]
    np.testing.assert_array_equal(sn.diagnose_cage(cage, mesh.points).outside_points, [last])
    assert cage.points[:, 1].max() < others[:, 1].max() + 3 * WIDE * np.linalg.norm(np.ptp(others, axis=0))


def test_holes_and_parts_are_kept() -> None:
    ring, _report = good_cage(sn.SurfaceMesh(*torus(40, 20)), 200, margin=0.03)
    assert ring.vertex_count - 3 * ring.face_count // 2 + ring.face_count == 0, "one hole"
    ball, faces = sphere(2)
    both = sn.SurfaceMesh(*joined((ball, faces), (ball + (5, 1, 0), faces)))
    two, _report = good_cage(both, 150, margin=0.03)
    assert sn.diagnose_cage(two).component_count == 2


@pytest.mark.parametrize(("symmetry", "axis", "middle"), [("automatic", 0, 4.0), ("y", 1, 0.0)])
def test_a_cage_mirrors_where_its_target_does(symmetry: str, axis: int, middle: float) -> None:
    bar = sn.SurfaceMesh(*closed_bar(8, 2))  # about y = 0 and z = 0, and x = 4
    cage, report = good_cage(bar, 100, symmetry=symmetry)
    assert report.mirror_axis == axis
    assert report.asymmetry < 1e-12
    mirrored = cage.points.copy()
    mirrored[:, axis] = 2 * middle - mirrored[:, axis]
    gaps = np.linalg.norm(cage.points[:, None] - mirrored, axis=2)
    image = gaps.argmin(axis=0)
    assert gaps.min(axis=0).max() < 1e-14 * 9
    faces = [np.roll(face, -face.argmin()).tolist() for face in cage.triangles]
    images = [np.roll(face, -face.argmin()).tolist() for face in image[cage.triangles[:, ::-1]]]
    assert sorted(faces) == sorted(images)


def test_no_symmetry_and_one_that_the_target_has_not_may_be_asked_for() -> None:
    none = good_cage(sn.SurfaceMesh(*closed_bar(8, 2)), 100, symmetry="none")[1]
    assert (none.mirror_axis, none.asymmetry) == (-1, 0.0)
    good_cage(sn.SurfaceMesh(*grid(12)), 100, symmetry="x")  # the target and its image are inside


def test_quads_are_safe_along_both_diagonals() -> None:
    bar = sn.SurfaceMesh(*closed_bar(8, 2))
    points, (counts, corners), report = sn.automatic_cage(bar, 120, WIDE, quads=True)
    assert (counts == 4).sum() == report.quads > report.faces / 4, "more faces of quads than triangles left"
    for first in (0, 1):
        turned = [np.roll(face, -first) for face in corners_of((counts, corners))]
        fans = [(face[0], face[j - 1], face[j]) for face in turned for j in range(2, len(face))]
        assert sn.diagnose_cage(sn.SurfaceMesh(points, fans), bar.points).clean


@pytest.mark.slow
@EVERY_TARGET
@pytest.mark.parametrize("symmetry", ["none", "x", "y"])
def test_no_diagonal_of_a_quad_is_an_edge_or_a_diagonal_of_another(mesh, symmetry: str) -> None:
    for wanted in (12, 16, 24, 40, 64, 100):
        points, faces, _report = sn.automatic_cage(mesh, wanted, 0.1, symmetry=symmetry, quads=True)
        used: Counter = Counter()  # sides count half, as two faces have each
        for face in corners_of(faces):
            used.update(frozenset(side) for side in zip(face, np.roll(face, 1), strict=True))
            if len(face) == 4:
                used.update(2 * [frozenset(face[::2]), frozenset(face[1::2])])
        assert set(used.values()) == {2}, wanted
        held = mesh.points[np.unique(mesh.triangles)]
        assert sn.diagnose_cage(sn.SurfaceMesh(points, faces), held).clean


def test_the_report_says_why_there_are_more_faces_than_asked_for() -> None:
    """A ring needs more than twelve, where the margin is too small to close its hole."""
    report = sn.automatic_cage(sn.SurfaceMesh(*torus(40, 20)), 12, 0.015)[2]
    assert (report.wanted, report.reached, report.faces > 13) == (12, False, True)
    assert report.reason


def test_the_margin_widens_where_the_wrap_has_too_many_holes() -> None:
    """Loose triangles wrap into a surface of many holes, which no collapse may close."""
    rng = np.random.default_rng(11)
    points = (rng.uniform(-2, 2, (60, 1, 3)) + rng.uniform(-1, 1, (60, 3, 3))).reshape(-1, 3)
    _cage, report = good_cage(sn.SurfaceMesh(points, np.arange(180).reshape(-1, 3)), 60, margin=0.03)
    assert report.reached
    assert report.margin > 0.03


CORNERS = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (3, 3, 3)], float)
ODD = {
    "flat": (grid(6)[0] * (1, 1, 0), grid(6)[1]),
    "one face": (CORNERS[:3], [(0, 1, 2)]),
    "no face": (CORNERS, []),
    "a line": (np.outer(np.arange(3), (1.0, 0, 0)), [(0, 1, 2)]),
    "small and far": (1e-6 * (sphere(2)[0] + (100, 0, 0)), sphere(2)[1]),
    "large and far": (1e6 * (sphere(2)[0] + (100, 0, 0)), sphere(2)[1]),
}


@pytest.mark.parametrize("name", ODD)
def test_flat_open_and_loose_targets_of_any_scale_get_a_cage(name: str) -> None:
    cage, _report = good_cage(sn.SurfaceMesh(*ODD[name]), 80)
    if name == "one face":
        loose, _report = good_cage(sn.SurfaceMesh(CORNERS, [(0, 1, 2)]), 80)
        np.testing.assert_array_equal(loose.points, cage.points)


def test_a_cage_is_the_same_on_one_thread() -> None:
    mesh = sn.SurfaceMesh(*grid(12))
    points, faces, _report = sn.automatic_cage(mesh, 80, WIDE)
    with limits.threads(1):
        one = sn.automatic_cage(mesh, 80, WIDE)
    np.testing.assert_array_equal(one[0], points)
    np.testing.assert_array_equal(one[1], faces)


def angles_around(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """The sum (n,) of the angles of the triangles at each vertex."""
    corners = points[triangles]
    u, v = (np.roll(corners, -k, axis=1) - corners for k in (1, 2))
    angles = np.arctan2(np.linalg.norm(np.cross(u, v), axis=2), (u * v).sum(axis=2))
    return np.bincount(triangles.ravel(), angles.ravel())


def ellipsoid(middle: tuple, radii: tuple, angle: float) -> tuple[np.ndarray, np.ndarray]:
    ball, faces = sphere(4)
    return ball @ turn((0, 0, 1), np.degrees(angle))[:, :3] * radii + middle, faces


def character() -> tuple[np.ndarray, np.ndarray]:
    """A head with two large flat ears and a trunk, symmetric about x = 0 but for the division into faces.

    It is rounded: sines and products differ in their last bits from system to system, and so would cages.
    """
    head, trunk = ((0, 0, 0), (1, 0.9, 1), 0.3), ((0, -1.1, -0.6), (0.25, 0.3, 0.9), 0.2)
    ears = [((side, 0.2, 0.3), (0.8, 0.15, 0.7), angle) for side, angle in ((1.5, 0.5), (-1.5, 0.1))]
    points, corners = joined(*(ellipsoid(*part) for part in (head, *ears, trunk)))
    return np.round(points, 9), corners


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


def test_options_out_of_range_and_targets_without_a_size_are_refused() -> None:
    wrong = {"faces": (3, 11, 100_001), "margin": (0.0, -1.0, 0.3, np.nan), "symmetry": "w", "progress": (3,)}
    for name, values in wrong.items():
        for value in values:
            with pytest.raises(TypeError if name == "progress" else sn.InvalidOption, match=name):
                sn.automatic_cage(sn.SurfaceMesh(*sphere(1)), **{name: value})
    for points in ([(1, 2, 3), (1, 2, 3)], [(-1e308, 0, 0), (1e308, 0, 0)]):
        with pytest.raises(sn.InvalidMesh):
            sn.automatic_cage(sn.SurfaceMesh(points, []))


CUBE_MESH = (CUBE, QUADS)
NESTED = joined(CUBE_MESH, (CUBE / 2 + 0.25, QUADS))
BESIDE = joined(CUBE_MESH, (CUBE + (3, 0, 0), QUADS))
FOLDED = sphere(0)[0].copy()
FOLDED[4] = FOLDED[2]  # an edge of the octahedron is a point
TETRAHEDRON = np.concatenate([np.zeros((1, 3)), np.eye(3)])
GOOD = {"summary": "clean", "component_count": 1, "crowded_diagonals": []}
PLACES = [(0.5, 0.5, 0.5), (1.5, 0.5, 0.5), (1, 1, 1), (1, 0.5, 0.5), (0.5, 0.5, 1 + 1e-6)]


def flipped(mesh: tuple[np.ndarray, np.ndarray], faces) -> tuple[np.ndarray, np.ndarray]:
    points, all_faces = mesh[0], mesh[1].copy()
    all_faces[faces] = all_faces[faces][:, ::-1]
    return points, all_faces


@pytest.mark.parametrize(
    ("mesh", "found"),
    [
        *((mesh, GOOD) for mesh in (CUBE_MESH, sphere(0), sphere(2), closed_bar(6, 2))),
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
