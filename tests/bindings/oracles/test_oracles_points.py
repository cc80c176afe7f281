# SPDX-License-Identifier: GPL-3.0-or-later
"""Methods that handle points control, against the formulas of their papers in NumPy."""

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import STILL, grid, moved, nearest_rotations, off, shift, turn
from ..methods import bound_to

KERNELS = {
    "triharmonic": lambda r: r**3,
    "biharmonic": lambda r: -r,
    "wendland_c0": lambda r: np.maximum(1 - r, 0) ** 2,
    "wendland_c2": lambda r: np.maximum(1 - r, 0) ** 4 * (4 * r + 1),
    "wendland_c4": lambda r: np.maximum(1 - r, 0) ** 6 * (35 * r * r + 18 * r + 3) / 3,
}
POSES = np.stack([STILL, turn((1, 2, 3), 70, (3, 0, 0), (0, 1, 0)), shift(0, 0.5, 0.2)])


def cloud(count: int, reach: float, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-reach, reach, (count, 3))


def regions(each: int) -> tuple[np.ndarray, list[int], np.ndarray]:
    """Two regions and a point of its own, their counts, and where the poses take them."""
    points = cloud(2 * each + 1, 1.0, 7)
    points[:each, 0] -= 3.0
    points[each:-1, 0] += 3.0
    points[-1] = (0, 2, 0)
    parts = np.split(points, [each, 2 * each])
    return points, [each, each, 1], np.concatenate([moved(pose, p) for pose, p in zip(POSES, parts)])


def posed(control: np.ndarray) -> np.ndarray:
    """A region has four control points, a single point has one."""
    return np.concatenate([moved(pose, c) for pose, c in zip(POSES, np.split(control, [4, 8]))])


def by_a_dense_system(centres, moves, points, kernel: str, degree: int, radius: float) -> np.ndarray:
    """The saddle point system of the textbooks; `radius` is a length."""
    corner, size = centres.min(0), np.ptp(centres, axis=0).max()
    scale = size / radius if kernel.startswith("wendland") else 1.0

    def rows(x: np.ndarray) -> np.ndarray:
        away = np.linalg.norm((x[:, None] - centres) / size, axis=2)
        x = (x - corner) / size
        monomials = np.column_stack([np.ones(len(x)), x, x**2, x * np.roll(x, -1, axis=1)])
        return np.column_stack([KERNELS[kernel](away * scale), monomials[:, : (0, 1, 4, 10)[degree + 1]]])

    A = rows(centres)
    n, q = len(centres), A.shape[1] - len(centres)
    A = np.concatenate([A, np.column_stack([A[:, n:].T, np.zeros((q, q))])])
    return points + rows(points) @ np.linalg.solve(A, np.concatenate([moves, np.zeros((q, 3))]))


@pytest.mark.parametrize(
    ("kernel", "asked", "degree", "radius"),
    [
        ("triharmonic", 2, 2, 4.5),
        ("triharmonic", 0, 1, 4.5),
        ("biharmonic", 2, 1, 4.5),
        ("biharmonic", 0, 0, 4.5),
        ("wendland_c0", 1, 1, 0.4),
        ("wendland_c0", 1, 1, 4.5),
        ("wendland_c2", -1, -1, 0.16),
        ("wendland_c2", -1, -1, 4.5),
        ("wendland_c2", 0, 0, 4.5),
        ("wendland_c2", 1, 1, 0.04),
        ("wendland_c2", 1, 1, 1.8),
        ("wendland_c4", 0, 0, 0.2),
        ("wendland_c4", 2, 1, 4.5),
    ],
)
def test_rbf_solves_the_saddle_point_system(kernel: str, asked: int, degree: int, radius: float) -> None:
    """Some points are far from all centres; their order has nothing to do with where they are."""
    centres, moves, points = cloud(400, 1.0, 31), cloud(400, 0.1, 32), cloud(1003, 1.4, 33)
    centres[:100] *= 0.1
    if radius > 2:  # functions that reach far, of few centres
        centres, moves, points = cloud(80, 2.0, 11), cloud(80, 1.0, 12), cloud(200, 2.5, 13)
    rbf = sn.Rbf(centres, kernel=kernel, degree=asked, radius=radius / sn.diameter(centres))
    assert rbf.bind(points).remarks == []
    assert len(rbf.centres) == len(centres)
    expected = by_a_dense_system(centres, moves, points, kernel, degree, radius)
    found = rbf.warp(centres + moves)
    # The radius 1.8 makes the system nearly singular.
    close = {4.5: 1e-9, 1.8: 1e-7}.get(radius, 1e-12)
    np.testing.assert_allclose(found, expected, rtol=0, atol=close)
    if degree == -1:
        far = np.linalg.norm(points[:, None] - centres, axis=2).min(1) > radius
        np.testing.assert_array_equal(found[far], points[far])


@pytest.mark.parametrize(
    ("kernel", "degree", "radius"),
    [("wendland_c2", 1, 0.05), ("wendland_c2", 1, 0.2), ("triharmonic", 2, 1.0)],
)
def test_regions_equal_the_sum_over_all_centres(kernel: str, degree: int, radius: float) -> None:
    centres, counts, goals = regions(250)
    points = np.concatenate([cloud(1003, 4.0, 5), centres])
    words = {"kernel": kernel, "degree": degree, "radius": radius, "tolerance": 0, "precision": "double"}
    rbf = sn.Rbf(centres, counts, **words)
    rbf.bind(points)
    lengths = radius * sn.diameter(centres)
    expected = by_a_dense_system(centres, goals - centres, points, kernel, degree, lengths)
    # Four functions of a region, of which each has a rounding of its own.
    found = rbf.warp(posed(rbf.control))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10)
    np.testing.assert_allclose(found[1003:], goals, rtol=0, atol=1e-11)


def test_propagation_fades_a_turn_by_the_closed_form_of_two_handles() -> None:
    """By the share of the distance to the handle that stays, of both; of one pose of both nothing fades."""
    places = np.array([(0, 0, 0), (0, 1, 0), (0, 0, 1), (4, 0, 0), (4, 1, 0), (4, 0, 1)], float)
    points, middle, move = cloud(60, 2.0, 3) + (2, 0, 0), places[3:].mean(0), np.array([0.3, -0.2, 0.5])
    method = bound_to(sn.SpacePropagation(places, [3, 3]), points)
    still, turned = np.split(method.control, 2)
    found = method.warp(np.concatenate([still, moved(turn((0, 0, 1), 80, middle, move), turned)]))
    away = np.linalg.norm(points[:, None] - places, axis=2).reshape(-1, 2, 3).min(2)
    share = away[:, 0] / away.sum(1)
    expected = [moved(turn((0, 0, 1), 80 * s, middle, s * move), x) for s, x in zip(share, points)]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6)  # shares in single precision
    shear = np.array([(1.2, 0.3, 0, 1), (-0.4, 0.8, 0.1, 2), (0.5, 0.2, 2, 3)])
    np.testing.assert_allclose(method.warp(moved(shear, method.control)), moved(shear, points), atol=1e-11)


def least_squares(p, q, share, v, maps: str, alpha: float) -> np.ndarray:
    """Where the map fitted at v takes it (Schaefer et al. 2006; Zhu & Gortler 2007)."""
    w = share * np.linalg.norm(p - v, axis=1) ** (-2 * alpha)
    p_star, q_star = w @ p / w.sum(), w @ q / w.sum()
    P, Q = p - p_star, q - q_star
    spread, N = P.T @ (w[:, None] * P), P.T @ (w[:, None] * Q)
    if maps == "affine":
        return N.T @ np.linalg.inv(spread) @ (v - p_star) + q_star
    R = nearest_rotations(N.T)
    scale = np.trace(R @ N) / np.trace(spread) if maps == "similarity" else 1.0
    return scale * R @ (v - p_star) + q_star


MAPS = ("affine", "similarity", "rigid")


@pytest.mark.parametrize("of_regions", [False, True])
@pytest.mark.parametrize("alpha", [1.0, 2.0, 0.7])
@pytest.mark.parametrize("maps", MAPS)
def test_mls_is_what_the_papers_say_at_every_point(maps: str, alpha: float, of_regions: bool) -> None:
    """Points of a region share its weight and move by one map."""
    p, counts, q = regions(40)
    if not of_regions:
        p, counts = cloud(30, 1.0, 1), np.ones(30, int)
        q = p + cloud(30, 0.4, 2)
    points, share = cloud(150, 3.0, 5), np.repeat(1 / np.array(counts), counts)
    mls = bound_to(sn.Mls(p, counts, maps=maps, alpha=alpha, precision="double"), points)
    expected = [least_squares(p, q, share, v, maps, alpha) for v in points]
    found = mls.warp(posed(mls.control) if of_regions else q)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10)


@pytest.mark.parametrize("alpha", [1.0, 2.0])
@pytest.mark.parametrize("maps", MAPS)
def test_a_segment_weighs_as_the_many_points_on_it(maps: str, alpha: float) -> None:
    ends = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0.2), (1, 1, 0.5), (0.4, 0.3, 1)], float)
    control, many = ends + cloud(5, 0.3, 9), 20_000
    t = ((np.arange(many) + 0.5) / many)[:, None]
    p, q = (np.concatenate([x[0] + t * (x[1] - x[0]), x[2:]]) for x in (ends, control))
    share = np.ones(many + 3)
    share[:many] = 1 / sn.diameter(ends) / many  # the length, 1, as a share of the size of all handles
    points = cloud(60, 1.0, 4) + 0.5
    mls = bound_to(sn.Mls(ends, maps=maps, alpha=alpha, segments=[[0, 1]], precision="double"), points)
    expected = [least_squares(p, q, share, v, maps, alpha) for v in points]
    np.testing.assert_allclose(mls.warp(control), expected, rtol=0, atol=2e-3)  # 8 nodes on each side


@pytest.mark.parametrize("maps", MAPS)
def test_places_on_handles_and_segments_go_where_these_take_them(maps: str) -> None:
    """And what is near gets near: the map is continuous."""
    points, counts, goals = regions(40)
    share = np.linspace(0, 1, 9)[:, None]
    ends = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0.2), (1, 1, 0), (0.4, 0.3, 1)])
    posed_ends = ends + np.array([(0, 0, 0), (-0.2, 0.5, 0.1), (0, 0, 0), (0, 0, 0), (0, 0, 0.4)])
    on, there = (x[0] + share * (x[1] - x[0]) for x in (ends, posed_ends))
    for precision in ("single", "double"):
        words = {"maps": maps, "alpha": 1.0, "precision": precision}
        by_regions, by_segments = (
            sn.Mls(points, counts, **words),
            sn.Mls(ends, segments=[[0, 1], [2, 3]], **words),
        )
        for made, places, control, wanted in (
            (by_regions, points, posed(by_regions.control), goals),
            (by_segments, on, posed_ends, there),
        ):
            for away, tolerance in ((0.0, 1e-13), (1e-7, 1e-4)):
                made.bind(places + away)
                np.testing.assert_allclose(made.warp(control), wanted, rtol=0, atol=tolerance)


def test_handles_in_a_plane_or_on_a_line_carry_rigid_maps_and_the_report_says_so() -> None:
    points, plane = cloud(40, 1.0, 6), cloud(12, 1.0, 5) * (1, 1, 0)
    line = np.array([(0.0, 0, 0), (1, 0, 0), (2.5, 0, 0)])
    mls = sn.Mls(plane, maps="affine", alpha=1.0, precision="double")
    assert len(mls.bind(points).remarks) == 1
    assert mls.maps == "rigid"
    pose = turn((1, 2, 3), 80, (0, 0, 1), (1, 0, 0))
    np.testing.assert_allclose(mls.warp(moved(pose, plane)), moved(pose, points), rtol=0, atol=1e-12)
    pose = turn((0, 0, 1), 50, move=(1, 2, 3))  # the smallest angle from one line to the other
    for maps in ("rigid", "similarity"):
        mls = sn.Mls(line, maps=maps, alpha=1.0, precision="double")
        mls.bind(points)
        np.testing.assert_allclose(mls.warp(moved(pose, line)), moved(pose, points), rtol=0, atol=1e-9)
    alone = sn.Mls(line[:1])
    alone.bind(points)
    np.testing.assert_allclose(alone.warp(line[1:2]), points + (1, 0, 0), rtol=0, atol=1e-15)


def bump(points: np.ndarray, **options: object) -> np.ndarray:
    """How high the points go if the middle of {0, .5, 1}^3 goes up by one."""
    places = np.array([(x, y, z) for x in (0, 0.5, 1) for y in (0, 0.5, 1) for z in (0, 0.5, 1)])
    raised = places.copy()
    raised[13, 2] += 1
    rbf = bound_to(sn.Rbf(places, **options), points)
    return rbf.warp(raised) - points


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("radius", [1e-9, 0.5, 1e9])
def test_points_anywhere_stay_finite(kernel: str, radius: float) -> None:
    points = np.array([(1e200, 0, 0), (-1e300, 1e300, 0), (0, 0, 1e308), (0.5, 0.5, 0.5)])
    found = bump(points, kernel=kernel, radius=radius)
    assert np.isfinite(found).all()
    if radius < 1:  # else all centres are nearly one
        assert found[3, 2] == pytest.approx(1, abs=1e-12)


HILL = grid(95)[0]  # 9,216 points
# Regions from one place along x to another, as shares of the length.
REGIONS = {
    "with a gap": ((0.0, 0.45), (0.6, 1.0)),
    "side by side": ((0.0, 0.5), (0.51, 1.0)),
    "a strip within": ((0.0, 0.4), (0.41, 0.44), (0.46, 1.0)),
}


@pytest.mark.parametrize(
    ("name", "tolerances"), [(name, [1e-3]) for name in REGIONS] + [("with a gap", [1e-2, 1e-3, 1e-4])]
)
def test_large_regions_are_met_within_the_tolerance_by_ever_more_centres(name: str, tolerances) -> None:
    x, moves, last = HILL[:, 0] / 95, np.array([[0, 0, 0], [1, 2, 3], [-2, 1, 0]])[: len(REGIONS[name])], 0
    counts = [np.sum((low <= x) & (x <= high)) for low, high in REGIONS[name]]
    rest = np.concatenate([HILL[(low <= x) & (x <= high)] for low, high in REGIONS[name]])
    for tolerance in tolerances:
        rbf = sn.Rbf(rest, counts, tolerance=tolerance, precision="double")
        report = rbf.bind(rest)
        found = rbf.warp(rbf.control + np.repeat(moves, 4, axis=0))
        missed = off(found, rest + np.repeat(moves, counts, axis=0))
        assert missed <= report.error * np.linalg.norm(moves, axis=1).max()
        assert report.error <= 1.001 * tolerance
        assert report.remarks == []
        assert last < len(rbf.centres) < len(rest)
        last = len(rbf.centres)


def test_more_single_points_than_a_dense_system_takes_quickly_are_remarked_on() -> None:
    points = cloud(3001, 1.0, 2)
    [remark] = sn.Rbf(points).bind(points[:1]).remarks
    assert remark.startswith("3001 handle points")
    assert sn.Rbf(points, kernel="wendland_c2", radius=0.05).bind(points[:1]).remarks == []


CLOUD = cloud(60, 1.0, 51)
LINE = np.column_stack([np.linspace(-1, 1, 60), np.full((60, 2), -0.2)])
FLAT = {
    "anywhere": (CLOUD, ""),
    "plane": (CLOUD * (1, 1, 0) + (0, 0, 0.3), "in a plane"),
    "line": (LINE, "on a line"),
    "sphere": (CLOUD / np.linalg.norm(CLOUD, axis=1, keepdims=True), "quadratic maps"),
    "one point": (CLOUD[:1], "at one place"),
    "two points": (CLOUD[:2], "on a line"),
    "twice": (np.tile(CLOUD[:30], (2, 1)), None),
    "one place": (np.full((60, 3), 0.7), None),
    "almost a plane": (CLOUD * (1, 1, 1e-7), None),
}


@pytest.mark.parametrize("degree", [-1, 0, 1, 2])
@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("name", FLAT)
def test_handles_of_any_shape_are_met_and_what_they_do_not_carry_is_told(name, kernel, degree) -> None:
    points, says = FLAT[name]
    moves = cloud(60, 0.2, 52)[: len(points)]
    if name == "twice":
        moves = np.tile(moves[:30], (2, 1))
    if name == "one place":
        moves = moves[:1]
    rbf = sn.Rbf(points, kernel=kernel, degree=degree, radius=0.4, precision="double")
    report = rbf.bind(np.concatenate([points, cloud(101, 3.0, 53)]))
    if degree == 2 and says is not None and (says != "quadratic maps" or kernel == "triharmonic"):
        assert len(report.remarks) == bool(says)
        assert says in "".join(report.remarks)
    found = rbf.warp(points + moves)
    assert np.isfinite(found).all()
    # Rounding of weights that are up to 1e8 times the moves, for the smoothest functions.
    np.testing.assert_allclose(found[: len(points)], points + moves, rtol=0, atol=1e-6)
    if degree >= 0:
        rbf.bind(CLOUD)
        np.testing.assert_allclose(rbf.warp(points + (1, 2, 3)), CLOUD + (1, 2, 3), rtol=0, atol=1e-6)
    if len(points) == 60:  # in two regions
        pair = sn.Rbf(points, [30, 30], kernel=kernel, degree=degree, radius=0.4, precision="double")
        pair.bind(points)
        np.testing.assert_allclose(pair.warp(pair.control + 0.1), points + 0.1, rtol=0, atol=1e-6)


def test_points_that_nearly_coincide_are_met_in_the_mean() -> None:
    points = cloud(30, 1.0, 5)
    points[29] = points[0] + (1e-9, 0, 0)
    raised = points.copy()
    raised[[0, 29], 2] += 0.1, -0.1
    rbf = sn.Rbf(points)
    assert rbf.bind(points).remarks
    found = rbf.warp(raised)
    np.testing.assert_allclose(found[1:29], raised[1:29], rtol=0, atol=1e-3)
    np.testing.assert_allclose(found[0], points[0], rtol=0, atol=1e-3)
