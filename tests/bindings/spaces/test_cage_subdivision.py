# SPDX-License-Identifier: GPL-3.0-or-later
"""Cages and subdivision together: which orders agree, and which do not."""

import numpy as np
import pytest

import sinew_native as sn

from ..cages import CUBE as UNIT_CUBE
from ..cages import QUADS, bound

CUBE = 2.0 * UNIT_CUBE - 1.0
LINEAR = (sn.MeanValue, sn.PositiveMeanValue, sn.Harmonic)
ROUNDING = 1e-12  # of double weights and stencils, some hundred products each


def control() -> tuple[np.ndarray, sn.SubdivisionSurface]:
    """The control mesh of a target, and its smooth surface, which stays inside the cube."""
    points = CUBE * (0.5, 0.4, 0.6) + 0.05
    return points, sn.SubdivisionSurface(sn.SurfaceMesh(points, QUADS), level=2)


def posed(seed: int) -> np.ndarray:
    return CUBE + np.random.default_rng(seed).uniform(-0.4, 0.4, CUBE.shape)


@pytest.mark.parametrize("method", LINEAR)
def test_control_level_then_subdivide_is_the_product_of_both_matrices(method: type) -> None:
    points, smooth = control()
    coordinates = bound(method, sn.SurfaceMesh(CUBE, QUADS), points)
    pose = posed(1)
    by_steps = smooth.refine(coordinates.warp(pose))
    at_once = smooth.matrix @ (coordinates.vertex_weights @ pose)
    assert np.abs(by_steps - at_once).max() < ROUNDING


@pytest.mark.parametrize("method", LINEAR)
def test_orders_agree_for_affine_poses_and_differ_for_others(method: type) -> None:
    points, smooth = control()
    coarse = bound(method, sn.SurfaceMesh(CUBE, QUADS), points)
    fine = bound(method, sn.SurfaceMesh(CUBE, QUADS), smooth.refine(points))
    affine = CUBE @ np.array([[1.1, 0.2, 0.0], [-0.3, 0.9, 0.1], [0.0, 0.2, 1.3]]) + 0.4
    subdivided_last = smooth.refine(coarse.warp(affine))
    assert np.abs(subdivided_last - fine.warp(affine)).max() < 1e-9
    bent = posed(2)
    assert np.abs(smooth.refine(coarse.warp(bent)) - fine.warp(bent)).max() > 1e-3


@pytest.mark.parametrize("method", LINEAR)
def test_a_subdivided_cage_has_weights_of_its_control_vertices(method: type) -> None:
    """W (S c) = (W S) c: the smooth cage moves points as if its few control vertices had weights."""
    cage = sn.SubdivisionSurface(sn.SurfaceMesh(1.5 * CUBE, QUADS), level=2)
    points = np.random.default_rng(3).uniform(-0.5, 0.5, (200, 3))
    coordinates = bound(method, sn.SurfaceMesh(cage.refine(1.5 * CUBE), cage.faces), points)
    pose = 1.5 * posed(4)
    of_controls = coordinates.vertex_weights @ cage.matrix.toarray()
    assert np.abs(of_controls.sum(axis=1) - 1.0).max() < ROUNDING
    assert np.abs(coordinates.warp(cage.refine(pose)) - of_controls @ pose).max() < ROUNDING


def test_green_agrees_in_either_order_for_similarities() -> None:
    points, smooth = control()
    coarse = bound(sn.Green, sn.SurfaceMesh(CUBE, QUADS), points)
    fine = bound(sn.Green, sn.SurfaceMesh(CUBE, QUADS), smooth.refine(points))
    turn = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
    similar = 1.3 * CUBE @ turn.T - 0.2
    assert np.abs(smooth.refine(coarse.warp(similar)) - fine.warp(similar)).max() < 1e-9
