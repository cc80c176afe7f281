# SPDX-License-Identifier: GPL-3.0-or-later
"""What a mesh says about itself: how its faces are cut, its parts, its size, and what is unusual."""

from collections import Counter
from collections.abc import Iterator

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import sinew_native as sn

from ..cages import CUBE, QUADS
from ..meshes import bar, closed_bar, grid, halved, joined, messy, quad_grid, sphere, torus


def cut(polygon: np.ndarray) -> np.ndarray:
    """The triangles of a polygon: all corners are used, and each side belongs to one triangle, as it runs."""
    n = len(polygon)
    triangles = sn.SurfaceMesh(polygon, ([n], np.arange(n))).triangles
    assert len(triangles) == n - 2
    sides = Counter(zip(triangles.ravel(), np.roll(triangles, -1, axis=1).ravel(), strict=True))
    assert [sides[k, (k + 1) % n] for k in range(n)] == n * [1]
    return triangles


def area_vectors(polygon: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of the polygon, and of its triangles."""
    a, b, c = polygon[cut(polygon)].swapaxes(0, 1)
    return np.cross(polygon, np.roll(polygon, -1, axis=0)).sum(0) / 2, np.cross(b - a, c - a) / 2


def flat(*corners: tuple[float, float]) -> np.ndarray:
    return np.column_stack([np.array(corners, float), np.zeros(len(corners))])


def around(radii: np.ndarray, angles: np.ndarray) -> np.ndarray:
    return flat(*zip(radii * np.cos(angles), radii * np.sin(angles), strict=True))


def comb(teeth: int) -> np.ndarray:
    tooth = [(2.0, 1.0), (1.9, 8.0), (0.3, 8.0), (0.2, 1.0)]
    return flat((0, 0), (2 * teeth, 0), *((2 * k + x, y) for k in reversed(range(teeth)) for x, y in tooth))


def spiral() -> np.ndarray:
    k = np.arange(25)
    inner, outer = around(1 + 0.2 * k, k * np.pi / 6), around(2 + 0.2 * k, k * np.pi / 6)
    return np.concatenate([outer, inner[::-1]])


def star(rng: np.random.Generator) -> np.ndarray:
    """Seen from its middle all of it is visible; in any plane."""
    n = rng.integers(5, 25)
    angles = 2 * np.pi * (np.arange(n) + 0.8 * rng.random(n)) / n
    return Rotation.random(random_state=rng).apply(around(0.2 + rng.random(n), angles)) + 5 * rng.random(3)


def ring(rng: np.random.Generator) -> np.ndarray:
    """A star around a star-shaped hole, joined by a slit of no width: two corners at each end of it."""
    loops = []
    for least in (3.0, 0.5):
        n = rng.integers(5, 17)
        shifts = np.concatenate([[0], rng.uniform(-0.4, 0.4, n - 1)])
        loop = around(least + rng.random(n), 2 * np.pi * (np.arange(n) + shifts) / n)
        loops.append(np.concatenate([loop, loop[:1]]))
    return Rotation.random(random_state=rng).apply(np.concatenate([loops[0], loops[1][::-1]]))


SLIT = 1e-6
NARROW = [(SLIT, 0), (4, 0), (4, 4), (0, 4), (0, SLIT), (1, 1 + SLIT), (1, 3), (3, 3), (3, 1), (1 + SLIT, 1)]
CLOSED = [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1)]


def polygons() -> Iterator[object]:
    """Simple polygons that differ where they begin, too."""
    rng = np.random.default_rng(3)
    known = {
        "convex": around(np.ones(17), 2 * np.pi * np.arange(17) / 17) * (3, 1, 1),
        "concave": flat((0, 0), (4, 0), (4, 4), (2, 1), (0, 4)),
        "arrow": flat((0, 0), (4, 1), (0, 2), (1, 1)),
        "comb": comb(6),
        "spiral": spiral(),
        "ring with a narrow slit": flat(*NARROW),
        "ring with a slit of no width": flat(*CLOSED),
        # After rounding, only the side to which a corner opens tells which ears are inside.
        "tilted, with a slit that ends": flat((0, 0), (2, 0), (2, 2), (0, 2), (0, 0), (1, 1))
        @ [(-3, 0, 1), (0, -3, -3), (0, 0, 0)],
    }
    yield from (pytest.param([polygon], id=name) for name, polygon in known.items())
    yield pytest.param([star(rng) for _ in range(50)], id="stars")
    yield pytest.param([ring(rng) for _ in range(50)], id="rings")


@pytest.mark.parametrize("shapes", list(polygons()))
def test_a_polygon_is_covered_once_from_every_corner(shapes: list[np.ndarray]) -> None:
    """No triangle is turned over: their areas add up to the polygon's."""
    for shape in shapes:
        for start in range(len(shape)):
            whole, parts = area_vectors(np.roll(shape, start, axis=0))
            area = np.linalg.norm(whole)
            assert np.linalg.norm(parts, axis=1).sum() == pytest.approx(area, rel=1e-12)  # rounding alone
            assert parts.sum(0) @ whole / area == pytest.approx(area, rel=1e-12)


def test_a_polygon_that_is_not_planar_keeps_its_orientation() -> None:
    rng, circle = np.random.default_rng(5), around(np.ones(8), np.pi * np.arange(8) / 4)
    for _ in range(30):
        whole, parts = area_vectors(circle + np.outer(rng.uniform(-0.2, 0.2, 8), (0, 0, 1)))
        np.testing.assert_allclose(parts.sum(0), whole, rtol=0, atol=1e-12)


def test_polygons_without_an_ear_become_triangles_nevertheless() -> None:
    crossed = flat((0, 0), (2, 2), (2, 0), (0, 2), (-1, 1))
    wound = around(np.ones(7), 6 * np.pi * np.arange(7) / 7)
    for polygon in (crossed, wound, np.outer(np.arange(7), (1.0, 2, -1)), np.ones((6, 3)), np.zeros((4, 3))):
        cut(polygon)


SQUARE = [(0, 0), (4, 0), (4, 4), (0, 4)]
HOLES = [[(0.6, 2.4), (0.6, 3.2), (1.4, 3.2), (1.4, 2.4)], [(2.4, 0.6), (2.4, 1.4), (3.2, 1.4), (3.2, 0.6)]]


@pytest.mark.parametrize("count", [1, 2])
def test_triangles_leave_holes_at_the_ends_of_slits_from_whatever_corner_the_polygon_begins(count) -> None:
    """As Blender has them: a corner of theirs comes several times."""
    slits = [corner for hole in HOLES[:count] for corner in (*hole, hole[0], SQUARE[0])]
    corners = flat(SQUARE[0], *slits, *SQUARE[1:])
    places, polygon = np.unique(corners, axis=0, return_inverse=True)
    for start in range(len(corners)):
        mesh = sn.SurfaceMesh(places, [np.roll(polygon.ravel(), -start).tolist()])
        a, b, c = places[mesh.triangles.T]
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
        assert area == pytest.approx(16 - count * 0.8**2, rel=1e-12), start


def test_a_quad_takes_the_diagonal_of_the_better_triangles_and_no_cut_depends_on_the_scale() -> None:
    np.testing.assert_array_equal(cut(flat((0, 0), (5, -1), (10, 0), (5, 1))), [(0, 1, 3), (1, 2, 3)])
    for power in (-40, -20, 20, 40):  # exact, so that ties stay ties
        np.testing.assert_array_equal(cut(2.0**power * comb(3)), cut(comb(3)))


CHAIN = np.arange(5000)[:, None] + (0, 1, 5002, 5001)


@pytest.mark.parametrize(
    ("count", "faces", "labels"),
    [
        (8, QUADS, 8 * [0]),
        (8, [[7, 2, 5], [1, 6, 4]], [0, 1, 2, 3, 1, 2, 1, 2]),  # by their lowest vertices
        (16, np.concatenate([QUADS, 8 + QUADS]), np.repeat([0, 1], 8)),  # through faces, not places
        (10002, CHAIN, 10002 * [0]),
        (3, [], [0, 1, 2]),
    ],
    ids=["cube", "two faces", "two cubes in one place", "chain", "no face"],
)
def test_parts_are_joined_through_faces_and_numbered_by_their_lowest_vertex(count, faces, labels) -> None:
    mesh = sn.SurfaceMesh(np.resize(CUBE, (count, 3)), faces)
    np.testing.assert_array_equal(mesh.components, labels)
    assert mesh.component_count == max(labels) + 1


def test_the_smallest_ball_holds_all_points() -> None:
    assert sn.diameter(CUBE) == pytest.approx(np.sqrt(3), abs=1e-12)
    assert sn.diameter([(3, 4, 5)]) == sn.diameter([(3, 4, 5), (3, 4, 5)]) == 0.0
    assert sn.diameter([(x, y, 0) for x in range(5) for y in range(4)]) == pytest.approx(5, abs=1e-12)
    rng = np.random.default_rng(3)
    for points in rng.normal(size=(20, 40, 3)):
        holds = {"type": "ineq", "fun": lambda b, p=points: b[3] - ((p - b[:3]) ** 2).sum(1)}
        ball = minimize(lambda b: b[3], [0, 0, 0, 99.0], constraints=holds, method="SLSQP", tol=1e-14)
        assert sn.diameter(points) == pytest.approx(2 * np.sqrt(ball.x[3]), rel=1e-7)


WING = [(0, 0, 0), (1, 0, 0), (0.5, 1, 0), (0.5, -1, 0), (0.5, 0, 1)]  # two triangles on 0-1, and a fin
HOURGLASS = [(0, 0, 0), (1, 1, 0), (1, -1, 0), (-1, 1, 0), (-1, -1, 0)]
THIN = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (1e6, 1e-6, 0)]
SHEET, CELLS = quad_grid(3, 3)
LINE = np.outer(np.arange(7), (1.0, 0, 0))
TURNED = [face[::-1] if k == 2 else face for k, face in enumerate(QUADS)]


@pytest.mark.parametrize(
    ("points", "faces", "found"),
    [
        (*quad_grid(2, 1), {"boundary_loops": [(0, 1, 2, 5, 4, 3)]}),
        (WING, [(0, 1, 2), (1, 0, 3), (0, 1, 4)], {"non_manifold_edges": [(0, 1)], "inconsistent_edges": []}),
        (HOURGLASS, [(0, 2, 1), (0, 3, 4)], {"non_manifold_vertices": [0]}),
        # A fin touches along a whole edge: one fan at each of its ends.
        (WING, [(0, 1, 2), (1, 0, 3), (0, 1, 4)], {"non_manifold_vertices": []}),
        # The third has an area of 1e-6 under a longest edge of 1e6: 1e-18 of its square.
        (THIN, [(0, 1, 3), (0, 1, 2), (0, 0, 3), (0, 2, 4)], {"degenerate_faces": [1, 2, 3]}),
        (THIN, ([4, 3], [0, 1, 2, 3, 0, 1, 2]), {"degenerate_faces": [1]}),  # a corner on a side is no matter
        (WING, [(0, 1, 2), (1, 2, 0), (1, 0, 3), (2, 1, 0), (0, 3, 1)], {"duplicate_faces": [1, 3, 4]}),
        (WING, [(0, 1, 2), (0, 1, 3)], {"inconsistent_edges": [(0, 1)]}),
        (CUBE, TURNED, {"inconsistent_edges": [(0, 1), (0, 4), (1, 5), (4, 5)]}),
        (
            [*WING, WING[2], WING[2]],
            [(0, 1, 2), (1, 0, 3), (0, 1, 5)],
            {"loose_vertices": [4, 6], "coincident_vertices": [5, 6], "component_count": 3},
        ),
        (WING[:2], [], {"loose_vertices": [0, 1], "component_count": 2}),
        (LINE, [(0, 1, 2), (3, 4, 5)], {"summary": "2 faces without area, 1 loose vertex"}),
    ],
)
def test_a_diagnosis_names_the_elements(points, faces, found: dict[str, object]) -> None:
    diagnosis = sn.SurfaceMesh(points, faces).diagnose()
    for name, expected in found.items():
        value = getattr(diagnosis, name)
        told = value() if callable(value) else value
        assert np.array(told).tolist() == np.array(expected).tolist(), name


@pytest.mark.parametrize(
    ("mesh", "borders"),
    [
        *((closed, []) for closed in ((CUBE, QUADS), sphere(0), sphere(2), closed_bar(4, 2))),
        (bar(4, 2), [8, 8]),
        (grid(3), [12]),
        ((SHEET, np.delete(CELLS, 4, axis=0)), [12, 4]),
    ],
)
def test_a_surface_is_clean_and_each_border_is_a_loop(mesh, borders: list[int]) -> None:
    found = sn.SurfaceMesh(*mesh).diagnose()
    assert (found.summary(), found.component_count) == ("clean", 1)
    assert [len(loop) for loop in found.boundary_loops] == borders


INSIDE = joined(sphere(1), (0.5 * sphere(1)[0], sphere(1)[1][:, ::-1]))  # with a cavity


@pytest.mark.parametrize(
    ("mesh", "found"),
    [
        (INSIDE, {"flipped_faces": [], "component_count": 2, "euler_characteristic": 4}),
        ((INSIDE[0], INSIDE[1][:, ::-1]), {"flipped_faces": list(range(32))}),
        ((CUBE, TURNED), {"flipped_faces": [2]}),
        ((SHEET, [*CELLS[:2], CELLS[2][::-1], *CELLS[3:]]), {"flipped_faces": [2], "slit_edges": []}),
        (([*WING, WING[0], WING[1]], [(0, 1, 2), (6, 5, 3)]), {"slit_edges": [(0, 1), (5, 6)]}),
        (torus(6, 5), {"euler_characteristic": 0, "one_sided_count": 0, "summary": "clean"}),
    ],
)
def test_sides_slits_and_the_genus_are_found(mesh, found: dict[str, object]) -> None:
    test_a_diagnosis_names_the_elements(*mesh, found)


def test_a_strip_with_one_side_has_no_face_on_the_wrong_one() -> None:
    angle = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    far = np.array([-0.3, 0.3])[:, None] * np.cos(angle / 2) + 1
    rims = np.stack([far * np.cos(angle), far * np.sin(angle), [[-0.3], [0.3]] * np.sin(angle / 2)], -1)
    strip = [(k, k + 1, k + 9, k + 8) for k in range(7)] + [(7, 8, 0, 15)]
    found = sn.SurfaceMesh(rims.reshape(-1, 3), strip).diagnose()
    assert (found.one_sided_count, found.euler_characteristic, len(found.boundary_loops)) == (1, 0, 1)
    assert len(found.flipped_faces) == 0 < len(found.inconsistent_edges)


@pytest.mark.parametrize("seed", range(8))
def test_random_damage_is_found_again(seed: int) -> None:
    """Balls and rings lose, turn over and double some faces."""
    rng = np.random.default_rng(seed)
    rings = [(cut[0], halved(cut[1])) for cut in [torus(12, 8)] * rng.integers(1, 4)]
    parts = [*rings, *[sphere(3)] * rng.integers(1, 4)]
    places = rng.permutation(len(parts))
    points, faces = joined(*((at + (9.0 * k, 0, 0), cut) for k, (at, cut) in zip(places, parts, strict=True)))
    hit = []  # faces that have no vertex in common
    for face in rng.permutation(len(faces)):
        if len(hit) < 15 and not np.isin(faces[face], faces[hit]).any():
            hit.append(face)
    lost, turned, doubled = np.split(np.array(hit), 3)
    faces[turned] = faces[turned][:, ::-1]
    kept = np.delete(np.arange(len(faces)), lost)
    order = rng.permutation(len(kept))
    damaged = np.concatenate([faces[kept[order]], np.roll(faces[doubled], 1, axis=1)])
    mesh = sn.SurfaceMesh(points, damaged)
    found = mesh.diagnose()
    assert (found.component_count, len(found.boundary_loops)) == (len(parts), 5)
    assert found.euler_characteristic == 2 * (len(parts) - len(rings)) - 5 + 5
    np.testing.assert_array_equal(found.flipped_faces, np.flatnonzero(np.isin(kept[order], turned)))
    np.testing.assert_array_equal(found.duplicate_faces, np.arange(len(kept), len(damaged)))
    assert len(found.non_manifold_edges) == 15
    twins = np.stack([np.flatnonzero(np.isin(kept[order], d))[0] for d in doubled])
    pairs = [(a, len(kept) + k) for k, a in enumerate(twins)]
    assert mesh.crossing_faces().tolist() == sorted(map(list, pairs))


def test_faces_that_pass_through_each_other_are_found_in_pairs() -> None:
    one, other = quad_grid(3, 3), quad_grid(1, 1)
    wall = other[0][:, [2, 0, 1]] + (1.5, 1.25, -0.5)  # 1.25 <= y <= 2.25 at x = 1.5
    mesh = sn.SurfaceMesh(*joined(one, (wall, other[1])))
    assert mesh.crossing_faces().tolist() == [[4, 9], [7, 9]]
    assert mesh.diagnose().clean
    assert sn.SurfaceMesh(*one).crossing_faces().shape == (0, 2)


def test_all_that_is_odd_is_counted_in_one_mesh() -> None:
    found = sn.SurfaceMesh(*messy()).diagnose()
    assert len(found.duplicate_faces) == len(found.loose_vertices) == 1
    assert len(found.degenerate_faces) == 2, "the needle has 1e-9 of its longest edge squared"
    assert found.component_count == 3, "the hill, the triangle, the loose vertex"
    assert len(found.non_manifold_edges) > 0
