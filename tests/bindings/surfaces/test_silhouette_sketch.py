# SPDX-License-Identifier: GPL-3.0-or-later
"""Silhouette sketches through the Python module."""

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import sinew_native as sn

from ..meshes import edges_of, grid, joined, messy, moved, shift, sphere, turn

POINTS, FACES = grid(8, jitter=0.0)
MESH = sn.SurfaceMesh(POINTS, FACES)
ABOVE = np.eye(3)


def border() -> tuple[np.ndarray, np.ndarray]:
    ((edges, shares, closed),) = sn.silhouette_lines(MESH, ABOVE)
    assert closed
    return edges, shares


def test_the_outline_of_a_sheet_is_its_border_and_goes_where_it_is_drawn() -> None:
    edges, _shares = border()
    assert len(edges) == 4 * (len(np.unique(POINTS[:, 0])) - 1)
    np.testing.assert_array_equal(edges[:, 0], edges[:, 1])
    right = POINTS[POINTS[:, 0] == POINTS[:, 0].max()]
    stroke = right[np.argsort(right[:, 1])] + (0.5, 0.0, 7.0)
    edges, shares, targets = sn.fit_stroke(MESH, stroke, ABOVE, nearness=1.0)
    held = np.flatnonzero(POINTS[:, 0] < POINTS[:, 0].mean())
    sketch = sn.SilhouetteSketch(MESH, edges, shares, held, weight=0.9999)
    moved = sketch.solve(targets)
    np.testing.assert_array_equal(moved[held], POINTS[held])
    np.testing.assert_allclose(moved[edges[:, 0]], targets, atol=2e-3)
    assert "free" in repr(sketch)


def test_selected_edges_and_an_eye_may_be_given() -> None:
    row = np.flatnonzero(POINTS[:, 1] == np.unique(POINTS[:, 1])[3])
    edges = np.column_stack((row[:-1], row[1:]))
    eye = POINTS.mean(axis=0) + (0.0, 0.0, 9.0)
    found, shares, targets = sn.fit_stroke(MESH, POINTS[row], ABOVE, eye, edges)
    assert set(found[:, 0]) == set(row)
    np.testing.assert_array_equal(shares, 0.0)
    np.testing.assert_allclose(targets, POINTS[found[:, 0]], atol=1e-12)


def test_what_does_not_fit_is_refused() -> None:
    edges, shares = border()
    stroke = POINTS[:3]
    assert sn.fit_stroke(MESH, stroke + 1e3, ABOVE) is None
    for wrong, words in (
        (POINTS[:1], "it has fewer than two points"),
        (stroke[:, :2], ""),
        (np.full_like(stroke, np.nan), "NaN or infinite coordinates"),
        (stroke[[0, 0]] + [[0, 0, 0], [0, 0, 2]], "it has no length in this view"),
    ):
        with pytest.raises(sn.InvalidConstraint, match=f"stroke: {words}"):
            sn.fit_stroke(MESH, wrong, ABOVE)
    with pytest.raises(sn.InvalidConstraint, match="stroke: a point is behind the viewer"):
        sn.fit_stroke(MESH, stroke, ABOVE, POINTS.min(0) - 9)
    for axes, eye in ((np.eye(2), None), (2 * ABOVE, None), (ABOVE, (0.0, 0.0)), (ABOVE, np.full(3, np.inf))):
        with pytest.raises(sn.InvalidOption, match=r"axes|eye"):
            sn.silhouette_lines(MESH, axes, eye)
    with pytest.raises(sn.InvalidConstraint, match="edges"):
        sn.fit_stroke(MESH, stroke, ABOVE, edges=[0, 1])
    for given, words, elements in (
        (([(0, 81)], [0.5], []), "", [81]),
        (([(0, 1)], [0.5], [-1]), "", [-1]),
        (([(0, 1)], [1.5], []), "a share is not in", None),
        ((np.zeros((0, 2), int), [], []), "no vertex of it", None),
        ((edges, shares[1:], []), "shares", None),
        ((edges, shares, np.arange(len(POINTS))), "no vertex of it", None),
    ):
        with pytest.raises(sn.InvalidConstraint, match=words or None) as refused:
            sn.SilhouetteSketch(MESH, *given)
        assert elements is None or refused.value.elements == elements
    for option in ({"weight": 1.0}, {"weight": -0.1}, {"refits": -1}, {"sharpness": -2.0}):
        with pytest.raises(sn.InvalidOption, match=next(iter(option))):
            sn.SilhouetteSketch(MESH, edges, shares, [], **option)
    for wrong in (POINTS[:2], np.full((len(edges), 3), np.nan)):
        with pytest.raises(sn.InvalidConstraint, match="targets"):
            sn.SilhouetteSketch(MESH, edges, shares, []).solve(wrong)


NEAR_OR_AFAR = pytest.mark.parametrize("near", [False, True], ids=["afar", "near"])


def seen_from(seed: int, eye: tuple | None = None) -> tuple[np.ndarray, np.ndarray | None]:
    """Axes of a view, and an eye in them."""
    axes = Rotation.random(random_state=seed).as_matrix()
    return axes, None if eye is None else eye @ axes


def places(points: np.ndarray, edges: np.ndarray, shares: np.ndarray) -> np.ndarray:
    return (1 - shares[:, None]) * points[edges[:, 0]] + shares[:, None] * points[edges[:, 1]]


@NEAR_OR_AFAR
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_silhouette_of_a_sphere_is_the_circle_that_is_seen(seed: int, near: bool) -> None:
    """Where the line of sight touches: p . e = 1 from the eye e, p . v = 0 from afar."""
    axes, eye = seen_from(seed, (0.3, 0, 2.5) if near else None)
    off = []
    for level in (2, 3, 4, 5):
        points, faces = sphere(level)
        ((edges, shares, closed),) = sn.silhouette_lines(sn.SurfaceMesh(points, faces), axes, eye)
        assert closed
        on = places(points, edges, shares)
        heights = on @ axes[2] if eye is None else (on @ eye - 1) / np.linalg.norm(eye)
        off.append(max(np.abs(heights).max(), np.abs(np.linalg.norm(on, axis=1) - 1).max()))
    # Linear interpolation: a quarter, which irregular edges disturb.
    assert all(now < before / 2.5 for before, now in itertools.pairwise(off))
    assert off[-1] < 2e-3, "edges of length 0.05: a chord is 3e-4 below the sphere"


def test_silhouettes_are_before_the_viewer_and_sketches_finite_on_a_messy_mesh() -> None:
    axes, eye = np.array([(1, 0, 0), (0, 0, 1), (0, -1, 0)]), np.array((4, 3, 3))  # along y, above the sheet
    for edges, shares, _closed in sn.silhouette_lines(MESH, axes, eye):
        assert ((eye - places(POINTS, edges, shares)) @ axes[2] > 0).all()
    points, faces = messy()
    for seed in (1, 2, 3, 4):
        for edges, shares, _closed in sn.silhouette_lines(sn.SurfaceMesh(points, faces), seen_from(seed)[0]):
            assert len(edges) >= 2
            assert np.isfinite(places(points, edges, shares)).all()
    line, held = np.flatnonzero(points[:, 0] > 3), np.flatnonzero(points[:, 0] < 1)
    sketch = sn.SilhouetteSketch(sn.SurfaceMesh(points, faces), np.stack([line, line], 1), 0.0 * line, held)
    found = sketch.solve(points[line] + (0, 0, 1))
    assert np.linalg.norm(found - points, axis=1).max() < 3 * np.linalg.norm(np.ptp(points, axis=0))


@NEAR_OR_AFAR
@pytest.mark.parametrize("backwards", [False, True])
def test_a_stroke_along_the_silhouette_moves_nothing(near: bool, backwards: bool) -> None:
    points, faces = sphere(3)
    ball = sn.SurfaceMesh(points, faces)
    axes, eye = seen_from(4, (0, 0, 3) if near else None)
    ((edges, shares, _closed),) = sn.silhouette_lines(ball, axes, eye)
    on = places(points, edges, shares)
    for count in (9, len(on) // 2, len(on) - 1, len(on) + 1):  # the last one is closed
        stroke = on[np.arange(count) % len(on)][:: -1 if backwards else 1]
        stroke = eye + 0.3 * (stroke - eye) if near else stroke + 7 * axes[2]  # at another depth
        found, along, targets = sn.fit_stroke(ball, stroke, axes, eye)
        assert len(found) >= min(count, len(on))
        np.testing.assert_allclose(places(points, found, along), targets, rtol=0, atol=1e-12)


def test_the_nearer_side_of_the_outline_goes_onto_the_stroke_and_keeps_its_depth() -> None:
    """From the top over the right to the bottom, with a bump."""
    points, faces = sphere(4)
    ball = sn.SurfaceMesh(points, faces)
    axes, eye = seen_from(6, (0, 0, 4))
    angles = np.pi * (0.5 - np.arange(21) / 20)
    round_it = np.stack([np.cos(angles), np.sin(angles)], 1) @ axes[:2]
    stroke = (1 + 0.3 * np.cos(angles))[:, None] * round_it
    edges, shares, targets = sn.fit_stroke(ball, stroke, axes, eye)

    def on_screen(x: np.ndarray) -> np.ndarray:
        away = (x - eye) @ axes.T
        return away[:, :2] / -away[:, 2:]

    on = places(points, edges, shares)
    np.testing.assert_allclose((targets - on) @ axes[2], 0, atol=1e-12)
    assert on_screen(on)[:, 0].min() > -0.01, "an end goes to the nearest place, which is near the top"
    a, b, at = on_screen(stroke)[:-1], on_screen(stroke)[1:], on_screen(targets)[:, None]
    share = np.clip(((at - a) * (b - a)).sum(2) / ((b - a) ** 2).sum(1), 0, 1)[..., None]
    assert np.linalg.norm(at - a - share * (b - a), axis=2).min(1).max() < 1e-12
    ((whole, _shares, _closed),) = sn.silhouette_lines(ball, axes, eye)
    assert len(edges) > len(whole) / 3


def test_lines_that_are_hidden_or_far_away_count_only_if_asked_for() -> None:
    ball, faces = sphere(3)
    angles = 0.05 * np.pi * np.arange(-10, 11)
    stroke = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])  # along the one behind
    for front, found in ((1.3, True), (3.0, False)):
        both = sn.SurfaceMesh(*joined((front * ball, faces), (ball - (0, 0, 9), faces)))
        assert sn.fit_stroke(both, stroke, ABOVE, hidden=True)[0].min() >= len(ball), "the nearest one"
        seen = sn.fit_stroke(both, stroke, ABOVE)
        assert (seen is not None) == found
        assert seen is None or seen[0].max() < len(ball)
    aside = np.array([(3, -0.2, 0), (3, 0.2, 0)])
    assert sn.fit_stroke(sn.SurfaceMesh(ball, faces), aside, ABOVE) is None
    assert sn.fit_stroke(sn.SurfaceMesh(ball, faces), aside, ABOVE, nearness=10) is not None


PAIRS = edges_of(FACES)
LEFT = POINTS[PAIRS, 0] < 3.4
PAIRS = PAIRS[LEFT[:, 0] & ~LEFT[:, 1] & (np.ptp(POINTS[PAIRS, 1], 1) < 0.5)]
SHARES = (3.4 - POINTS[PAIRS[:, 0], 0]) / np.ptp(POINTS[PAIRS, 0], 1)
LINE = places(POINTS, PAIRS, SHARES)
HUMP = LINE + np.outer(0.8 * np.sin(0.4 * LINE[:, 1]) + 0.1, (0, 0, 1))
RIM = np.flatnonzero(np.abs(POINTS[:, 0] - 4) > 3.5)


def sketched(targets: np.ndarray, mesh: sn.SurfaceMesh = MESH, **options: object) -> np.ndarray:
    return sn.SilhouetteSketch(mesh, PAIRS, SHARES, RIM, **options).solve(targets)


@pytest.mark.parametrize("laplacian", ["uniform", "cotan", "cotan_voronoi"])
def test_a_line_that_stays_changes_nothing(laplacian: str) -> None:
    # Rotations are fitted to edges that have not turned.
    np.testing.assert_allclose(sketched(LINE, laplacian=laplacian), POINTS, rtol=0, atol=1e-11)


def test_the_line_meets_its_targets_as_its_weight_says() -> None:
    off = [1.0]
    for weight in (0.5, 0.99, 0.9999):
        found = places(sketched(HUMP, weight=weight), PAIRS, SHARES)
        off.append(np.linalg.norm(found - HUMP, axis=1).max())
        assert off[-1] < off[-2] / 4
    assert off[-1] < 1e-3


def test_without_held_vertices_it_follows_a_translation_exactly_and_a_turn_by_refits() -> None:
    some = np.arange(0, len(POINTS), 5)  # a line alone would leave a turn about it open
    edges, shares = np.concatenate([PAIRS, np.stack([some, some], 1)]), np.concatenate([SHARES, 0.0 * some])
    line, off = places(POINTS, edges, shares), [1e9]
    step, pose = shift(1, -2, 3), turn((1, 2, 3), 50)
    found = sn.SilhouetteSketch(MESH, edges, shares, []).solve(moved(step, line))
    np.testing.assert_allclose(found, moved(step, POINTS), rtol=0, atol=1e-9)
    for refits in (0, 4, 64):
        found = sn.SilhouetteSketch(MESH, edges, shares, [], refits=refits).solve(moved(pose, line))
        off.append(np.linalg.norm(found - moved(pose, POINTS), axis=1).max())
        assert off[-1] < off[-2] / 2


def test_held_vertices_and_other_parts_stay_and_each_stroke_is_on_its_own() -> None:
    ball, faces = sphere(1)
    mesh = sn.SurfaceMesh(*joined((POINTS, FACES), (ball + (20, 0, 0), faces)))
    sketch = sn.SilhouetteSketch(mesh, PAIRS, SHARES, RIM)
    found = sketch.solve(HUMP)
    np.testing.assert_array_equal(found[RIM], POINTS[RIM])
    np.testing.assert_array_equal(found[len(POINTS) :], mesh.points[len(POINTS) :])
    assert np.linalg.norm(found - mesh.points, axis=1).max() > 0.5
    sketch.solve(1.1 * HUMP)
    np.testing.assert_array_equal(sketch.solve(HUMP), found)
