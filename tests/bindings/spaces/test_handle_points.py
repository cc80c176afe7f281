# SPDX-License-Identifier: GPL-3.0-or-later
"""Space methods on handle points next to SciPy's interpolator and to NumPy, point by point."""

import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator

import sinew_native as sn

from ..figures import animal
from ..meshes import carried, edges_of, grid, moved, nearest_rotations, quad_grid, shift, turn
from ..methods import bound_to
from ..oracles.test_oracles_points import least_squares

RANDOM = np.random.default_rng(7)
HANDLES = RANDOM.uniform(-1.0, 2.0, (60, 3))
POINTS = RANDOM.uniform(-1.2, 2.2, (150, 3))
MOVES = RANDOM.uniform(-0.3, 0.3, HANDLES.shape)
TURN = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])


@pytest.mark.parametrize(
    "method", [sn.Rbf, sn.Mls, sn.SpacePropagation, sn.MultiresolutionSpace, sn.InverseFfd]
)
def test_poses_do_what_the_posed_control_does(method: type) -> None:
    """A method of points takes them where the poses of their handles do."""
    counts = [20, 1, 39]
    more = {"base": sn.Rbf(HANDLES, counts), "mesh": sn.SurfaceMesh(POINTS, np.zeros((0, 3), int))}
    given = more if method is sn.MultiresolutionSpace else {}
    made = bound_to(method(HANDLES, **given, counts=counts), POINTS)
    poses = np.array([np.column_stack((TURN, (0.1, 0.2, k))) for k in (-0.3, 0.0, 0.4)])
    control, rows = (HANDLES, counts) if method is sn.InverseFfd else (made.control, [4, 1, 4])
    posed = carried(np.repeat(poses, rows, axis=0), control)
    incoming = POINTS + 0.1
    for entering in (None, incoming):
        expected = made.warp(posed, incoming=entering)
        for from_rest in (None, True, [True, False, True]):
            found = made.warp_poses(poses, incoming=entering, from_rest=from_rest)
            assert np.abs(found - expected).max() < 1e-12
    out = np.zeros((len(POINTS), 3), np.float32)
    assert made.warp_poses(poses, out) is out
    assert np.abs(out - made.warp(posed)).max() < 1e-5
    assert np.array_equal(made.warp_poses(np.tile(np.eye(3, 4), (3, 1, 1)), incoming=incoming), incoming)
    with pytest.raises(sn.InvalidConstraint, match="poses: 2 given for 3 handles"):
        made.warp_poses(poses[:2])
    with pytest.raises(sn.InvalidConstraint, match="finite"):
        made.warp_poses(np.full_like(poses, np.nan))


def test_multiresolution_puts_details_back_on_the_base_of_any_of_them() -> None:
    points, quads = quad_grid(11, 8)
    x, y, _ = points.T
    points[:, 2] = 0.3 * np.sin(2 * x) * np.cos(y)
    places, counts = np.concatenate([points[x < 1], points[x > 10]]), [np.sum(x < 1), np.sum(x > 10)]
    for base in (sn.Rbf, sn.Mls, sn.SpacePropagation):
        made = sn.MultiresolutionSpace(
            places, base(places, counts), sn.SurfaceMesh(points, quads), counts, wavelength=6.0
        )
        made.bind(points)
        assert np.array_equal(made.warp(made.control), points)
        found = made.warp(made.control @ TURN.T + 1.0)
        assert np.abs(found - points @ TURN.T - 1.0).max() < 1e-5
        poses = [np.eye(3, 4), turn((0, 1, 0), 60, (11, 0, 0), (-2, 0, 4))]
        alone = base(places, counts)
        alone.bind(points)
        found = made.warp_poses(poses)
        assert np.abs(found - alone.warp_poses(poses)).max() > 1e-3, "details turn"
        for pose, held in zip(poses, (x < 1, x > 10), strict=True):
            np.testing.assert_allclose(found[held], moved(pose, points[held]), rtol=0, atol=1e-5)


def bones(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How strongly two bones along x hold points, and which points they share: weights sum to 1."""
    far = np.clip(0.5 + 2.0 * points[:, 0], 0.0, 1.0)
    return np.stack((1.0 - far, far)), np.flatnonzero((far > 0.0) & (far < 1.0))


def held_by_bones(method: type, points: np.ndarray, **options) -> tuple[object, np.ndarray]:
    """A method whose two handles share points, and the control posed: one stays, one is turned and moved."""
    weights, _shared = bones(points)
    bone, rows = np.nonzero(weights)
    made = method(points[rows], np.bincount(bone), weights=weights[bone, rows], **options)
    posed = made.control.copy()
    posed[4:] = posed[4:] @ TURN.T + 0.5
    return made, posed


BLEND = np.random.default_rng(3).uniform(-1.0, 1.0, (90, 3))


def blended(points: np.ndarray) -> np.ndarray:
    near, far = bones(points)[0][:, :, None]
    return near * points + far * (points @ TURN.T + 0.5)


def test_rbf_takes_places_that_handles_share_to_the_mean_of_their_targets() -> None:
    made, posed = held_by_bones(sn.Rbf, BLEND, precision="double")
    assert made.bind(POINTS).remarks == []
    expected = RBFInterpolator(BLEND, blended(BLEND) - BLEND, kernel="cubic", degree=2)(POINTS)
    assert np.abs(made.warp(posed) - POINTS - expected).max() < 1e-9


def test_mls_takes_places_that_handles_share_to_the_mean_of_their_targets() -> None:
    weights, shared = bones(BLEND)
    assert len(shared) > 10
    made, posed = held_by_bones(sn.Mls, BLEND, precision="double")
    made.bind(np.concatenate((BLEND, POINTS)))
    found = made.warp(posed)
    assert np.abs(found[: len(BLEND)] - blended(BLEND)).max() < 1e-12
    for v, place in zip(POINTS[:20], found[len(BLEND) : len(BLEND) + 20], strict=True):
        share = weights / (weights > 0.0).sum(axis=1)[:, None]
        p, q = np.tile(BLEND, (2, 1)), np.concatenate((BLEND, BLEND @ TURN.T + 0.5))
        assert np.abs(place - least_squares(p, q, share.ravel(), v, "rigid", 2.0)).max() < 1e-9


def test_a_segment_counts_as_much_as_its_ends_are_held() -> None:
    """A third of the weight for one segment is the same as the other one three times."""
    ends = HANDLES[:4]
    apart = np.concatenate((ends[:2], ends[2:], ends[2:], ends[2:]))
    pairs = [[0, 1], [2, 3], [4, 5], [6, 7]]
    strong = sn.Mls(apart, segments=pairs, precision="double")
    weak = sn.Mls(ends, segments=pairs[:2], weights=[1 / 3, 1 / 3, 1.0, 1.0], precision="double")
    strong.bind(POINTS)
    weak.bind(POINTS)
    posed = ends + MOVES[:4]
    expected = strong.warp(np.concatenate((posed[:2], posed[2:], posed[2:], posed[2:])))
    assert np.abs(weak.warp(posed) - expected).max() < 1e-9


def test_propagation_lets_points_give_way_that_are_held_weakly() -> None:
    made, posed = held_by_bones(sn.SpacePropagation, BLEND)
    made.bind(BLEND)
    far = np.clip(0.5 + 2.0 * BLEND[:, 0], 0.0, 1.0)
    away = np.linalg.norm(made.warp(posed) - BLEND, axis=1)
    whole = np.linalg.norm(BLEND @ TURN.T + 0.5 - BLEND, axis=1)
    assert np.abs(away[far == 0.0]).max() == 0.0
    assert np.abs(away - whole)[far == 1.0].max() < 1e-6
    share = away / whole
    assert share[(far > 0.6) & (far < 1.0)].min() > 0.1 + share[(far > 0.0) & (far < 0.4)].max()


@pytest.mark.parametrize("method", [sn.Rbf, sn.Mls, sn.SpacePropagation])
def test_the_handle_that_holds_a_place_fully_overrules_the_others(method: type) -> None:
    points = np.concatenate((HANDLES[:20], HANDLES[20:40], HANDLES[:5]))
    made = bound_to(method(points, [20, 25], weights=[*np.ones(40), *np.full(5, 0.4)]), HANDLES[:5])
    posed = made.control.copy()
    posed[4:] += 1.0
    assert np.abs(made.warp(posed) - HANDLES[:5]).max() < 1e-6


def test_refusals_name_handles() -> None:
    twice = np.concatenate((HANDLES[:3], HANDLES[:1]))
    rbf = bound_to(sn.Rbf(twice), POINTS)
    apart = twice.copy()
    apart[3] += 1.0
    with pytest.raises(sn.InvalidConstraint) as caught:
        rbf.warp(apart)
    assert (caught.value.element_kind, list(caught.value.elements)) == ("handle", [0, 3])
    for wrong in ([], [60, 1], [59]):
        with pytest.raises(sn.InvalidConstraint):
            sn.Rbf(HANDLES, wrong)
    for transfer in ([1.0], [0.0, np.nan]):
        with pytest.raises(sn.InvalidOption):
            sn.SpacePropagation(HANDLES, transfer=transfer)
    for weights in ([0.5], np.full(60, 1.5), np.zeros(60)):
        with pytest.raises((sn.InvalidConstraint, sn.InvalidOption), match="weights"):
            sn.Rbf(HANDLES, weights=weights)
    for handles, counts, elements in ((HANDLES, [2, 58], []), (twice, None, [0, 3])):
        with pytest.raises(sn.InvalidConstraint) as caught:
            sn.Mls(handles, counts, segments=[[0, 3]])
        assert list(caught.value.elements) == elements
    with pytest.raises(sn.InvalidConstraint):
        sn.Mls(HANDLES, segments=[[0, 60]])
    assert sn.Mls(HANDLES * (1, 1, 0), maps="affine").maps == "rigid"


def longest_edge(before: np.ndarray, after: np.ndarray, faces: np.ndarray) -> float:
    """By how much an edge has become longer, at most."""
    a, b = edges_of(faces).T
    return (np.linalg.norm(after[a] - after[b], axis=1) / np.linalg.norm(before[a] - before[b], axis=1)).max()


@pytest.mark.parametrize("sizes", [(0.45, 0.55), (0.7, 0.8)], ids=["alike", "large and small"])
def test_mls_does_not_tear_at_the_border_of_large_regions(sizes: tuple[float, float]) -> None:
    points, faces = grid(60)
    x = points[:, 0] / 60
    regions = [np.flatnonzero(x <= sizes[0]), np.flatnonzero(x >= sizes[1])]
    method = sn.Mls(points[np.concatenate(regions)], [len(region) for region in regions])
    method.bind(points)
    middle = points[(x > sizes[0]) & (x < sizes[1])].mean(axis=0)
    for name, pose in {"bent": turn((0, 1, 0), 60.0, middle), "lifted": shift(0, 0, 6)}.items():
        control = method.control.copy()
        control[4:] = moved(pose, control[4:])
        longest = longest_edge(points, method.warp(control), faces)
        assert longest < 2.5, name


def test_mls_does_not_tear_a_figure_whose_limbs_are_large_regions() -> None:
    """A leg and the head, bent by 60 degrees where a limb is free for about its thickness; the body stays."""
    points, faces = animal()
    x, y, z = points.T
    body, leg = (np.abs(x) < 1.0) & (z > 0.85), (x > 0) & (y > 0) & (z < 0.55)
    regions = [np.flatnonzero(region) for region in (body, leg, x > 1.4)]
    longest = {}
    for alpha in (2.0, 1.0):
        method = sn.Mls(points[np.concatenate(regions)], [len(region) for region in regions], alpha=alpha)
        method.bind(points)
        control = method.control.copy()
        for rows, degrees, joint in ((4, 60.0, (0.85, 0.32, 0.7)), (8, -60.0, (1.2, 0.0, 1.3))):
            control[rows : rows + 4] = moved(turn((0, 1, 0), degrees, joint), control[rows : rows + 4])
        longest[alpha] = longest_edge(points, method.warp(control), faces)
    assert longest[2.0] < 2.5 < 4.0 < longest[1.0]


def test_a_line_of_points_turned_around_turns_space_by_half_a_turn() -> None:
    """About any axis across the line: from one direction to its opposite, no turn is the smallest."""
    line = np.linspace(-1.0, 1.0, 5)[:, None] * [0.6, 0.8, 0.0]
    places = np.array([0.3 * line[-1], [0.1, 0.5, 0.2]])
    method = bound_to(sn.Mls(line), places)
    found = method.warp(-line)
    np.testing.assert_allclose(found[0], -places[0], atol=1e-9)
    np.testing.assert_allclose(found[1] @ line[-1], -places[1] @ line[-1], atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(found[1]), np.linalg.norm(places[1]), atol=1e-9)


CLOUD = np.random.default_rng(3).uniform(-1.0, 1.0, (12, 3))
CHAIN = np.array([(k, k + 1) for k in range(11)])
NO_EDGES = np.zeros((0, 2), dtype=int)
LITTLE = 1e-3  # how much the turn of all points counts beside that of the edges at a point
LEAST = 1e-9  # how much no turn at all counts, so that points on a line turn as little as they can


def turned_by_numpy(rest: np.ndarray, posed: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """The motions, with NumPy's singular values."""
    local, there = rest - rest.mean(axis=0), posed - posed.mean(axis=0)
    size = max(float((local**2).sum()), 1e-300)
    everything = nearest_rotations(there.T @ local / size + LEAST * np.eye(3))
    before, after = (points[edges[:, 1]] - points[edges[:, 0]] for points in (rest, posed))
    squares = (before**2).sum(axis=1)
    shares = np.divide(1.0, squares, out=np.zeros_like(squares), where=squares > 0.0)
    products = after[:, :, None] * (shares[:, None] * before)[:, None, :]
    together = np.tile(LITTLE * everything, (len(rest), 1, 1))
    for end in (0, 1):
        np.add.at(together, edges[:, end], products)
    turns = nearest_rotations(together)
    moves = posed - np.einsum("nij,nj->ni", turns, rest)
    return np.concatenate((turns, moves[:, :, None]), axis=2)


@pytest.mark.parametrize("edges", [NO_EDGES, CHAIN, CHAIN[3:7]], ids=["cloud", "chain", "in part"])
def test_the_poses_are_numpys(edges: np.ndarray) -> None:
    random = np.random.default_rng(5)
    for scale in (1e-3, 0.3, 3.0):  # at the largest, edges turn by any angle
        posed = CLOUD + scale * random.uniform(-1.0, 1.0, CLOUD.shape)
        found = sn.turned_poses(CLOUD, posed, edges)
        # A single edge leaves a turn open, which a thousandth of the common turn decides.
        assert np.abs(found - turned_by_numpy(CLOUD, posed, edges)).max() < 1e-11


@pytest.mark.parametrize("edges", [NO_EDGES, CHAIN], ids=["cloud", "chain"])
@pytest.mark.parametrize("degrees", [0.0, 40.0, 172.0])
def test_points_that_move_rigidly_turn_with_all(edges: np.ndarray, degrees: float) -> None:
    pose = turn((0.3, 0.9, -0.2), degrees, move=(0.4, -0.2, 0.7))
    # A billionth of no turn is in the fit.
    assert np.abs(sn.turned_poses(CLOUD, moved(pose, CLOUD), edges) - pose).max() < 1e-7


def test_points_on_a_line_turn_as_little_as_they_can() -> None:
    line = np.array([(0.0, 0.0, 0.0), (0.0, 0.0, 1.0)])
    pose = turn((0.0, 1.0, 0.0), 46.0)
    poses = sn.turned_poses(line, moved(pose, line), np.array([(0, 1)]))
    assert np.abs(poses - pose).max() < 1e-6
    (pose,) = sn.turned_poses(line[:1], line[:1] + 2.0, NO_EDGES)
    assert np.abs(pose - np.column_stack((np.eye(3), (2.0, 2.0, 2.0)))).max() < 1e-12


def test_coincident_points_and_edges_without_length_give_numbers() -> None:
    points = np.zeros((3, 3))
    assert np.isfinite(sn.turned_poses(points, np.eye(3), np.array([(0, 1), (1, 2)]))).all()


def test_turned_poses_refuse_what_does_not_fit() -> None:
    assert sn.turned_poses(np.zeros((0, 3)), np.zeros((0, 3))).shape == (0, 3, 4)
    with pytest.raises(sn.InvalidConstraint, match="posed: 2 points given for 12"):
        sn.turned_poses(CLOUD, CLOUD[:2])
    with pytest.raises(sn.InvalidConstraint, match="finite"):
        sn.turned_poses(CLOUD, np.full_like(CLOUD, np.inf))
    for point in (-1, 12):
        with pytest.raises(sn.InvalidConstraint, match=f"no point {point}"):
            sn.turned_poses(CLOUD, CLOUD, [(0, point)])
