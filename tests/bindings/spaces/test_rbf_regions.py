# SPDX-License-Identifier: GPL-3.0-or-later
"""Large regions are met by radial basis functions to the tolerance that was asked for, wherever they lie."""

from itertools import pairwise

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import grid

POINTS = grid(95)[0]  # 9,216 of them
X = POINTS[:, 0]
# Regions from one place along x to another, as shares of the length.
CASES = {
    "with a gap": ((0.0, 0.45), (0.6, 1.0)),
    "side by side": ((0.0, 0.5), (0.51, 1.0)),
    "a strip within": ((0.0, 0.4), (0.41, 0.44), (0.46, 1.0)),
}


@pytest.mark.parametrize(
    ("case", "tolerance"), [*((case, 1e-3) for case in CASES), ("with a gap", 1e-4)], ids=str
)
def test_regions_of_thousands_of_points_are_met(case: str, tolerance: float) -> None:
    regions = [np.flatnonzero((95 * low <= X) & (95 * high >= X)) for low, high in CASES[case]]
    begins = np.cumsum([0, *map(len, regions)])
    rest = POINTS[np.concatenate(regions)]
    moves = np.array([[0, 0, 0], [1, 2, 3], [-2, 1, 0]])[: len(regions)]
    method = sn.Rbf(rest, [len(region) for region in regions], tolerance=tolerance, precision="double")
    report = method.bind(rest)
    found = method.warp(method.control + np.repeat(moves, 4, axis=0)) - rest
    longest = np.linalg.norm(moves, axis=1).max()
    missed = [
        np.linalg.norm(found[begin:end] - move, axis=1).max() / longest
        for (begin, end), move in zip(pairwise(begins), moves, strict=True)
    ]
    print(f"{case}: {len(method.centres)} of {len(rest)} are centres, missed by {max(missed):.1e}")
    assert max(missed) <= tolerance
    assert report.remarks == [], report.remarks


def test_more_single_points_than_a_dense_system_takes_quickly_are_remarked_on() -> None:
    points = np.random.default_rng(2).uniform(-1, 1, (3001, 3))
    [remark] = sn.Rbf(points).bind(points[:1]).remarks
    assert remark.startswith("3001 handle points")
    assert sn.Rbf(points, kernel="wendland_c2", radius=0.05).bind(points[:1]).remarks == []
