# SPDX-License-Identifier: GPL-3.0-or-later
"""What weights of cages promise: maps that they keep, the data on the cage, and how they go on beyond it."""

import numpy as np
import pytest

import sinew_native as sn

from ..cages import CUBE, QUADS, bound, u_prism
from ..meshes import halved, joined, moved, sphere, turn
from .test_cages import bumpy, near

CUT = halved(QUADS)
SHEAR = np.column_stack([[(1.2, 0.3, 0), (-0.4, 0.8, 0.1), (0.5, 0.2, 2)], (1, -2, 3)])
SIMILAR = np.column_stack([2.5 * turn((1, 2, -1), 130)[:, :3], (3, -1, 2)])
GREEN = [(sn.Green, {"faces": "triangles"}), (sn.Green, {"faces": "quads"})]
BOTH_GREEN = pytest.mark.parametrize("faces", ["triangles", "quads"])
BOUNDARY = {"quality": "fast", "solver": "boundary"}
LATTICE = {"quality": "fast", "solver": "lattice"}
POSITIVE = [(sn.PositiveMeanValue, {}), (sn.Harmonic, BOUNDARY), (sn.Harmonic, LATTICE)]


def quad_ball(n: int, bumps: float) -> sn.SurfaceMesh:
    """A cube of 6 n^2 quads on a bumpy sphere, none of them flat."""
    line, corners = np.linspace(-1, 1, n + 1), []
    for axis in range(3):
        for side in (-1, 1):
            for i, j in np.ndindex(n, n):
                square = np.full((4, 3), float(side))
                square[:, (axis + 1) % 3] = line[[i, i + 1, i + 1, i]]
                square[:, (axis + 2) % 3] = line[[j, j, j + 1, j + 1]]
                corners.append(square[::side])
    points, index = np.unique(np.concatenate(corners).round(9), axis=0, return_inverse=True)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    points += np.random.default_rng(12).uniform(-bumps, bumps, points.shape)
    return sn.SurfaceMesh(points, index.reshape(-1, 4))


CAGES = {
    "cube": sn.SurfaceMesh(CUBE, QUADS),
    "octahedron": sn.SurfaceMesh(*sphere(0)),
    "bumpy": sn.SurfaceMesh(*bumpy(2, 3)),
    "quads": quad_ball(2, 0.2),
    "more quads": quad_ball(4, 0.05),
    "u": u_prism(),
    "two": sn.SurfaceMesh(*joined((CUBE, CUT), (sphere(0)[0] + (4, 1, 0), sphere(0)[1]))),
}


def around(cage: sn.SurfaceMesh, count: int, reach: float, seed: int = 1) -> np.ndarray:
    """In a box around the middle, `reach` times as large as the cage's."""
    low, high = cage.points.min(0), cage.points.max(0)
    shares = np.random.default_rng(seed).uniform(-reach, reach, (count, 3))
    return (low + high) / 2 + shares * (high - low) / 2


def in_u(points: np.ndarray, depth: float = 0.0) -> np.ndarray:
    """Whether they lie in the U, at least that deep."""
    x, y, z = points.T
    box = (points > depth).all(1) & (x < 3 - depth) & (y < 3 - depth) & (z < 1 - depth)
    return box & ~((x > 1 - depth) & (x < 2 + depth) & (y > 1 - depth))


def inside_u(count: int, depth: float) -> np.ndarray:
    points = np.random.default_rng(1).uniform(0, (3, 3, 1), (4 * count, 3))
    return points[in_u(points, depth)][:count]


def star(at: tuple, step: float) -> np.ndarray:
    """A point and its six neighbours along the axes."""
    return at + step * np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)])


def off_the_mean(weights: np.ndarray) -> float:
    """How far a star's middle is from the mean of its neighbours, six times."""
    return np.abs(weights[1:].sum(0) - 6 * weights[0]).max()


def expect_barycentric(weights: np.ndarray, cage: sn.SurfaceMesh, points: np.ndarray) -> None:
    np.testing.assert_allclose(weights.sum(1), 1, rtol=0, atol=1e-12)
    size = np.linalg.norm(np.ptp(cage.points, axis=0))
    np.testing.assert_allclose(weights @ cage.points, points, rtol=0, atol=1e-9 * size)
    assert weights.min() >= 0


@pytest.mark.parametrize("cage", CAGES.values(), ids=CAGES)
@pytest.mark.parametrize(("method", "options"), [(sn.MeanValue, {}), *GREEN])
def test_maps_are_kept_inside_outside_and_on_the_cage(method: type, options: dict, cage) -> None:
    on = [near(cage, distance) for distance in (0.0, 1e-13, 1e-11, 1e-9, 1e-4)]
    points = np.concatenate([around(cage, 200, 1.0), around(cage, 200, 2.0), *on])
    pose = SHEAR if method is sn.MeanValue else SIMILAR
    coordinates = bound(method, cage, points, **options)
    found = coordinates.warp(moved(pose, cage.points))
    np.testing.assert_allclose(found, moved(pose, points), rtol=0, atol=1e-10)
    if method is sn.MeanValue:
        np.testing.assert_allclose(coordinates.vertex_weights.sum(1), 1, rtol=0, atol=1e-11)


@pytest.mark.parametrize(("method", "options"), [(sn.MeanValue, {}), *POSITIVE])
def test_weights_are_linear_on_the_triangles_of_a_cage(method: type, options: dict) -> None:
    shares = np.array([(1, 0, 0), (0, 0.25, 0.75), (0.2, 0.3, 0.5)])
    for cage in (CAGES["octahedron"], sn.SurfaceMesh(*bumpy(1, 2))):
        corners = cage.triangles[3]
        expected = shares @ np.eye(cage.vertex_count)[corners]
        found = bound(method, cage, shares @ cage.points[corners], **options).vertex_weights
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14 if method is sn.MeanValue else 1e-9)
    at_vertices = bound(method, u_prism(), u_prism().points, **options).vertex_weights
    np.testing.assert_allclose(at_vertices, np.eye(16), rtol=0, atol=1e-9)


@pytest.mark.parametrize(("method", "options"), POSITIVE)
@pytest.mark.parametrize("depth", [0.05, 0.02, 1e-5, 1e-6])
def test_weights_in_a_concave_cage_are_barycentric(method: type, options: dict, depth: float) -> None:
    points = inside_u(300, depth)
    expect_barycentric(bound(method, u_prism(), points, **options).vertex_weights, u_prism(), points)
    ball, faces = sphere(1)
    spiky = sn.SurfaceMesh(ball * np.random.default_rng(4).uniform(0.5, 1, (len(ball), 1)), faces)
    points = 0.25 * ball * np.random.default_rng(1).uniform(0, 1, (len(ball), 1))
    expect_barycentric(bound(method, spiky, points, **options).vertex_weights, spiky, points)


@pytest.mark.parametrize("method", [sn.MeanValue, sn.Green])
def test_points_outside_are_those_that_the_shape_says(method: type) -> None:
    points = around(u_prism(), 500, 1.3)
    outside = np.flatnonzero(~in_u(points))
    np.testing.assert_array_equal(method(u_prism()).bind(points).outside, outside)
    assert len(outside) > 100


PREVIEW = (sn.PositiveMeanValue, {"exact": False})


@pytest.mark.parametrize(("method", "options"), [*POSITIVE, PREVIEW, (sn.Green, {"outside": "error"})])
def test_points_outside_are_refused_or_fall_back_on_mean_values(method: type, options: dict) -> None:
    points = np.array([(0.5, 0.5, 0.5), (1.5, 2, 0.5), (0.2, 0.9, 0.4), (9, 9, 9), (0.5, 0.5, -0.1)])
    with pytest.raises(sn.PointsOutside, match="outside") as refused:
        bound(method, u_prism(), points, **options)
    assert (refused.value.elements, refused.value.element_kind) == ([1, 3, 4], "vertex")
    if "outside" not in options:
        both = bound(method, u_prism(), points, outside="mean_value", **options).vertex_weights
        plain = bound(sn.MeanValue, u_prism(), points).vertex_weights
        np.testing.assert_allclose(both[[1, 3, 4]], plain[[1, 3, 4]], rtol=0, atol=1e-12)


@pytest.mark.parametrize(("method", "options"), POSITIVE)
def test_parts_of_a_cage_are_apart(method: type, options: dict) -> None:
    two = sn.SurfaceMesh(*joined((CUBE, QUADS), (CUBE + (1.5, 0, 0), QUADS)))
    points = np.random.default_rng(1).uniform(0.05, 0.95, (50, 3))
    weights = bound(method, two, np.concatenate([points, points + (1.5, 0, 0)]), **options).vertex_weights
    expect_barycentric(weights, two, np.concatenate([points, points + (1.5, 0, 0)]))
    assert np.abs(weights[:50, 8:]).max() < (1e-15 if method is sn.PositiveMeanValue else 1e-3)
    np.testing.assert_allclose(weights[50:, 8:], weights[:50, :8], rtol=0, atol=1e-3)


@pytest.mark.parametrize(("method", "options"), [(sn.MeanValue, {}), *GREEN])
def test_faces_without_area_are_left_out(method: type, options: dict) -> None:
    points = CUBE.copy()
    points[3] = (points[1] + points[7]) / 2  # on the diagonal of one half of the top
    cage = sn.SurfaceMesh(points, CUT)
    inside = around(cage, 100, 0.8)
    found = bound(method, cage, inside, **options).warp(moved(SIMILAR, points))
    np.testing.assert_allclose(found, moved(SIMILAR, inside), rtol=0, atol=1e-8)
    if method is sn.MeanValue:
        close = np.concatenate([near(cage, distance) for distance in (0.0, 1e-9)])
        assert np.isfinite(bound(method, cage, close).vertex_weights).all()


def test_a_collapsed_edge_is_taken_by_positive_mean_values_and_named_by_harmonic_ones() -> None:
    points = CUBE.copy()
    points[7] = points[5]  # the faces at x = 1 and z = 1 are triangles, half of each a line
    cage, middle = sn.SurfaceMesh(points, QUADS), np.full((1, 3), 0.25)
    expect_barycentric(bound(sn.PositiveMeanValue, cage, middle).vertex_weights, cage, middle)
    with pytest.raises(sn.Error) as refused:
        bound(sn.Harmonic, cage, middle, solver="boundary")
    assert refused.value.element_kind == "face"
    assert set(refused.value.elements) <= {1, 3, 5}
    touching = sn.SurfaceMesh(*joined((CUBE, QUADS), (CUBE + (1, 0, 0), QUADS)))
    with pytest.raises(sn.Error) as refused:
        bound(sn.Harmonic, touching, middle, solver="boundary")
    assert (refused.value.element_kind, refused.value.elements) == ("face", [1, 6])


def test_mean_values_have_one_gradient_on_both_sides_of_a_triangles_plane() -> None:
    """They are smooth off the cage, also where the formula changes: in planes and on their rims."""
    step = 1e-4
    for away in (0.0, 1e-9, 1e-3):  # through the plane y = 3, in the notch
        line = (1.5, 3 + away, 0.4) + step * np.outer(np.arange(-3, 4), (0, 1, 0))
        weights = bound(sn.MeanValue, u_prism(), line).vertex_weights
        assert np.abs(np.diff(weights[::2], 3, axis=0)).max() < 1e-9  # 8 step^3 w''', 100 at most


def test_positive_mean_values_are_mean_values_in_a_convex_cage_and_see_no_hidden_vertex() -> None:
    points = 0.5 * sphere(2)[0] * np.random.default_rng(1).uniform(0, 1, (66, 1))
    for cage in (CAGES["octahedron"], sn.SurfaceMesh(*sphere(2))):
        both = [bound(method, cage, points).vertex_weights for method in (sn.PositiveMeanValue, sn.MeanValue)]
        np.testing.assert_allclose(*both, rtol=0, atol=1e-10)
    seen = bound(sn.PositiveMeanValue, u_prism(), np.array([(0.5, 2.5, 0.5)])).vertex_weights[0]
    assert seen[[2, 3, 10, 11]].max() < 1e-15, "the top of the other arm is out of sight"
    close = np.array([(1e-9, 1.4, 0.3), (1e-9, 1.5, 1e-9), (1e-9,) * 3, (1 - 1e-9, 1 - 1e-9, 0.4)])
    expect_barycentric(bound(sn.PositiveMeanValue, u_prism(), close).vertex_weights, u_prism(), close)


def test_positive_mean_values_do_not_jump_where_a_preview_by_rays_does() -> None:
    path = np.linspace((0.5, 2.8, 0.5), (0.95, 0.5, 0.52), 2001)
    steps = []
    for options in ({}, {"exact": False, "directions": 1024}):
        weights = bound(sn.PositiveMeanValue, u_prism(), path, **options).vertex_weights
        steps.append(np.abs(np.diff(weights, axis=0)).max())
    assert steps[0] < min(2e-3, steps[1])
    points = inside_u(50, 0.1)
    exact, few, many = (
        bound(sn.PositiveMeanValue, u_prism(), points, **options).vertex_weights
        for options in ({}, *({"exact": False, "directions": count} for count in (1024, 16384)))
    )
    expect_barycentric(many, u_prism(), points)
    assert np.abs(few - exact).max() < 5e-3
    assert np.abs(many - exact).max() < np.abs(few - exact).max() / 3


def trilinear(points: np.ndarray) -> np.ndarray:
    """Of the vertices of the cube."""
    return np.where(CUBE > 0.5, points[:, None], 1 - points[:, None]).prod(2)


@pytest.mark.parametrize("words", [BOUNDARY, BOUNDARY | {"quality": "medium"}, LATTICE])
def test_harmonic_weights_are_trilinear_in_a_cube_of_quads(words: dict) -> None:
    points = np.random.default_rng(1).uniform(0, 1, (500, 3))
    weights = bound(sn.Harmonic, CAGES["cube"], points, **words).vertex_weights
    np.testing.assert_allclose(weights, trilinear(points), rtol=0, atol=1e-4)  # a grid of Blender's: 3e-3
    expect_barycentric(weights, CAGES["cube"], points)


def test_harmonic_weights_are_harmonic_and_come_to_the_data_on_the_cage() -> None:
    assert bound(sn.Harmonic, u_prism(), inside_u(500, 0.05), **BOUNDARY).vertex_weights.max() < 1
    # The mend adds what is not harmonic, of the order of the error.
    at_star = bound(sn.Harmonic, u_prism(), star((0.5, 1.7, 0.5), 0.02), **BOUNDARY).vertex_weights
    assert off_the_mean(at_star) < 6e-4
    places = [(1.5, 0, 0), (0, 1.5, 0.5), (1e-9, 1.5, 0.5), (1e-7, 1.5, 0.5), (1e-5, 1.5, 0.5)]
    edge, face, *close = bound(sn.Harmonic, u_prism(), np.array(places), **BOUNDARY).vertex_weights
    np.testing.assert_allclose(edge[:2], 0.5, rtol=0, atol=1e-9)
    np.testing.assert_allclose(face[[0, 7, 8, 15]], 0.25, rtol=0, atol=1e-9)  # bilinear, not by two triangles
    np.testing.assert_allclose(close, [face] * 3, rtol=0, atol=2e-3)  # the error far from its edges


def test_harmonic_weights_do_not_depend_on_units_or_place() -> None:
    ball, faces = sphere(1)
    cage = ball * np.random.default_rng(4).uniform(0.5, 1, (len(ball), 1))
    points, pose = 0.25 * ball, np.column_stack([1e-3 * turn((1, 2, 3), 40)[:, :3], (5, -7, 2)])
    here, there = (
        bound(sn.Harmonic, sn.SurfaceMesh(c, faces), p, solver="boundary").vertex_weights
        for c, p in ((cage, points), (moved(pose, cage), moved(pose, points)))
    )
    # Rounding of points to 1e-13 of the cage, and a system of condition 1e4.
    np.testing.assert_allclose(there, here, rtol=0, atol=1e-6)


@pytest.mark.parametrize(
    ("stretch", "expected"),
    [
        ([(1, 0.5, 0), (0, 1, 0), (0, 0, 1)], (0.171221, 0.182365, 0.303175)),
        ([(1, 0, 0), (0, 1, 0), (0, 0, 2)], (0.124066, 0.244992, 0.482952)),
    ],
)
def test_green_has_the_known_answers_to_a_shear_and_a_stretch(stretch, expected) -> None:
    cage = CAGES["octahedron"]
    found = bound(sn.Green, cage, np.array([(0.1, 0.2, 0.3)])).warp(cage.points @ np.transpose(stretch))
    np.testing.assert_allclose(found[0], expected, rtol=0, atol=1e-6)  # the digits given


@BOTH_GREEN
@pytest.mark.parametrize("name", ["bumpy", "quads"])
def test_green_weights_are_harmonic_and_sum_to_one(faces: str, name: str) -> None:
    green = bound(sn.Green, CAGES[name], star((0.1, 0.2, 0.3), 0.01), faces=faces)
    np.testing.assert_allclose(green.vertex_weights.sum(1), 1, rtol=0, atol=1e-14)
    for weights in (green.vertex_weights, green.face_weights):
        assert off_the_mean(weights) < 1e-7  # h^4 / 12 times a fourth derivative of some 10


@BOTH_GREEN
def test_green_continues_through_one_face_if_asked(faces: str) -> None:
    points = np.array([(0.5, 0.5, 1.5), (0.5, 0.5, -0.5)])  # above the top, below the bottom
    pose = CUBE.copy()
    pose[7] += (0.3, -0.2, 0.4)
    nearest, top = (
        bound(sn.Green, CAGES["cube"], points, faces=faces, **words).warp(pose)
        for words in ({}, {"outside": "face", "exit_face": 5})
    )
    assert np.linalg.norm(nearest[1] - top[1]) > 0.1
    if faces == "quads":
        np.testing.assert_allclose(nearest[0], top[0], rtol=0, atol=1e-15)


@BOTH_GREEN
@pytest.mark.parametrize("dented", [False, True])
def test_green_takes_poses_that_flatten_faces_and_dented_cages(faces: str, dented: bool) -> None:
    rest = CUBE.copy()
    if dented:
        rest[7] = 0.9 * rest[1] + 0.05 * (rest[3] + rest[5])
    points = around(CAGES["cube"], 50, 1.2)
    green = bound(sn.Green, sn.SurfaceMesh(rest, QUADS), points, faces=faces)
    pose = rest.copy()
    pose[7] = pose[5]
    assert np.isfinite(green.warp(pose)).all()
    assert np.isfinite(green.warp(1e100 * rest)).all()
    for tiny in (0.0, 1e-100):  # a cage in one point takes all there
        assert np.abs(green.warp(tiny * rest)).max() < 1e-14
    np.testing.assert_allclose(green.warp(moved(SIMILAR, rest)), moved(SIMILAR, points), rtol=0, atol=1e-11)


@pytest.mark.parametrize(("name", "faces", "step"), [("bumpy", "triangles", 1e-3), ("quads", "quads", 1e-4)])
def test_green_passes_a_face_smoothly(name: str, faces: str, step: float) -> None:
    """Through the face that the outside is continued by, the map is analytic: no jump, no kink."""
    cage = CAGES[name]
    # Of face 9 two triangles.
    corners = cage.points[np.unique(cage.triangles[18:20] if faces == "quads" else cage.triangles[7])]
    normal = np.linalg.svd(corners - corners.mean(0))[2][2]
    heights = [*(step * np.arange(-2, 3)), 1e-15, -1e-15, 1e-12, -1e-12, 1e-10, -1e-10]
    pose = cage.points + np.random.default_rng(9).uniform(-0.2, 0.2, cage.points.shape)
    found = bound(sn.Green, cage, corners.mean(0) + np.outer(heights, normal), faces=faces).warp(pose)
    assert np.linalg.norm(found[5:] - found[2], axis=1).max() < 2e-8  # ten times the distance
    inner, outer = found[1] - found[0], found[4] - found[3]
    assert np.linalg.norm(inner - outer) / step < 0.1  # the second derivative is some ten per unit
    if faces == "triangles":
        fourth = np.diff(found[:5], 4, axis=0)
        assert np.linalg.norm(fourth) < 1e-9  # step^4 times a derivative of 1,000; a kink gives some 1e-4


def test_points_on_faces_are_inside_for_green() -> None:
    for cage in (sn.SurfaceMesh(*bumpy(1, 2)), u_prism()):
        shares = np.random.default_rng(8).dirichlet((1, 1, 1), (20, len(cage.triangles)))
        points = np.einsum("stk,tkx->stx", shares, cage.points[cage.triangles]).reshape(-1, 3)
        green = bound(sn.Green, cage, points, outside="error")  # moved in by 1e-12 of the cage's size
        np.testing.assert_allclose(green.warp(cage.points + 1) - 1, points, rtol=0, atol=1e-11)


def test_green_winds_twice_where_parts_overlap_and_its_quads_of_triangles_are_triangles() -> None:
    twice = sn.SurfaceMesh(*joined((CUBE, QUADS), (CUBE + (0.5, 0.4, 0.3), QUADS)))
    points = np.array([(0.7,) * 3, (0.2,) * 3])
    green = sn.Green(twice, precision="double")
    assert not len(green.bind(points).outside)
    found = green.warp(moved(SIMILAR, twice.points))
    np.testing.assert_allclose(found, moved(SIMILAR, points), rtol=0, atol=1e-11)
    cage = CAGES["bumpy"]
    pose, points = cage.points.copy(), around(cage, 100, 1.3)
    pose[3] *= 1.5
    both = [bound(method, cage, points, **options).warp(pose) for method, options in GREEN]
    np.testing.assert_array_equal(*both)
