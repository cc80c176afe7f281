# SPDX-License-Identifier: GPL-3.0-or-later
"""Nonlinear space methods against oracles that share no code with them."""

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import STILL, carried, moved, shift, tube, turn
from .embedded_graph import PaperEnergy

POSES = {
    "bend": np.stack((STILL, turn((0, 1, 0), 90, move=(0.5, 0, -3.5)))),
    "twist": np.stack((STILL, turn((0, 0, 1), 135))),
    "stretch": np.stack((STILL, shift(0, 0, 2))),
}


@pytest.mark.parametrize("motion", POSES)
def test_embedded_deformation_has_the_minimum_of_gauss_newton_on_the_paper_s_energy(motion: str) -> None:
    points, faces = tube(29, 12)
    points = points[:, [1, 2, 0]] * (1, 1, 6 / 29)
    ends = [np.flatnonzero(points[:, 2] < 0.5), np.flatnonzero(points[:, 2] > 5.5)]
    mesh, places = sn.SurfaceMesh(points, faces), points[np.concatenate(ends)]
    method = sn.EmbeddedDeformation(mesh, places, [*map(len, ends)], nodes=40)
    method.bind(points)
    graph = method.graph()
    oracle = PaperEnergy(graph, carried(POSES[motion][graph["pull_handles"]], graph["pulls"]))
    least = oracle.gauss_newton()
    answer, report = method.answer(POSES[motion], tolerance=1e-13, max_iterations=2000)
    own = answer.reshape(-1, 4, 3).copy()
    own[:, 3] = own[:, 3] / oracle.unit - oracle.nodes  # t_j
    assert report.energy == pytest.approx(oracle.energy(own.ravel()), rel=1e-9), "the energy is the paper's"
    assert report.energy == pytest.approx(oracle.energy(least), rel=1e-8)
    np.testing.assert_allclose(own, least.reshape(-1, 4, 3), atol=1e-3 * np.ptp(oracle.nodes))

    weights, m = method.weights(), len(graph["nodes"])
    expected = oracle.warped(least, points, weights[:, :m])
    for h, pose in enumerate(POSES[motion]):
        expected += weights[:, m + h, None] * moved(pose, points)
    apart = np.linalg.norm(method.warp_poses(POSES[motion]) - expected)
    assert apart < 0.01 * np.linalg.norm(expected - points), "a frame is within 1 %"


def test_rigid_cells_turn_a_beam_as_an_elastic_one() -> None:
    """A long bar twisted by its ends turns evenly along its length, as Saint-Venant's does."""
    points, faces = tube(60, 12)
    points = points[:, [1, 2, 0]] * (0.4, 0.4, 0.2)
    counts = np.concatenate((np.full(len(faces), 4), [12, 12]))
    corners = np.concatenate((faces.ravel(), np.arange(12)[::-1], 720 + np.arange(12)))
    ends = [np.flatnonzero(points[:, 2] < 1.0), np.flatnonzero(points[:, 2] > 11.0)]
    method = sn.RigidCells(
        sn.SurfaceMesh(points, (counts, corners)), points[np.concatenate(ends)], [len(end) for end in ends],
        cells=2000, tolerance=1e-7, max_iterations=400,
    )  # fmt: skip
    method.bind(points)
    shape = method.warp_poses(np.stack((STILL, turn((0, 0, 1), 90))))
    between = (points[:, 2] > 1.5) & (points[:, 2] < 10.5)
    angle = np.angle((shape[:, 0] + 1j * shape[:, 1]) / (points[:, 0] + 1j * points[:, 1]))
    np.testing.assert_allclose(angle[between], np.radians(90) * (points[between, 2] - 1.0) / 10.0, atol=0.05)
    np.testing.assert_allclose(shape[between, 2], points[between, 2], atol=0.05)
