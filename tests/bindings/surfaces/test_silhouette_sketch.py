# SPDX-License-Identifier: GPL-3.0-or-later
"""Silhouette sketches through the Python module."""

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import grid

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
    with pytest.raises(sn.InvalidConstraint) as refused:
        sn.SilhouetteSketch(MESH, [(0, 81)], [0.5], [])
    assert refused.value.elements == [81]
    with pytest.raises(sn.InvalidConstraint) as refused:
        sn.SilhouetteSketch(MESH, [(0, 1)], [0.5], [-1])
    assert refused.value.elements == [-1]
    with pytest.raises(sn.InvalidConstraint, match="a share is not in"):
        sn.SilhouetteSketch(MESH, [(0, 1)], [1.5], [])
    with pytest.raises(sn.InvalidConstraint, match="no vertex of it"):
        sn.SilhouetteSketch(MESH, np.zeros((0, 2), int), [], [])
    with pytest.raises(sn.InvalidConstraint, match="shares"):
        sn.SilhouetteSketch(MESH, edges, shares[1:], [])
    with pytest.raises(sn.InvalidConstraint, match="no vertex of it"):
        sn.SilhouetteSketch(MESH, edges, shares, np.arange(len(POINTS)))
    for option in ({"weight": 1.0}, {"weight": -0.1}, {"refits": -1}, {"sharpness": -2.0}):
        with pytest.raises(sn.InvalidOption, match=next(iter(option))):
            sn.SilhouetteSketch(MESH, edges, shares, [], **option)
    for wrong in (POINTS[:2], np.full((len(edges), 3), np.nan)):
        with pytest.raises(sn.InvalidConstraint, match="targets"):
            sn.SilhouetteSketch(MESH, edges, shares, []).solve(wrong)
