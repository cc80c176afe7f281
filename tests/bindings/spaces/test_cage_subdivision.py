# SPDX-License-Identifier: GPL-3.0-or-later
"""Cages and subdivision together: which orders agree, and which do not."""

import numpy as np
import pytest

import sinew_native as sn

from ..cages import CUBE as UNIT_CUBE
from ..cages import QUADS, bound

CUBE = 2.0 * UNIT_CUBE - 1.0
LINEAR = (sn.MeanValue, sn.PositiveMeanValue, sn.Harmonic)
AFFINE = np.array([[1.1, -0.3, 0.0], [0.2, 0.9, 0.2], [0.0, 0.1, 1.3]])
SIMILAR = 1.3 * np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
ROUNDING = 1e-12  # of double weights and stencils, some hundred products each


def control() -> tuple[np.ndarray, sn.SubdivisionSurface]:
    """The control mesh of a target, and its smooth surface, which stays inside the cube."""
    points = CUBE * (0.5, 0.4, 0.6) + 0.05
    return points, sn.SubdivisionSurface(sn.SurfaceMesh(points, QUADS), level=2)


def posed(seed: int) -> np.ndarray:
    return CUBE + np.random.default_rng(seed).uniform(-0.4, 0.4, CUBE.shape)


@pytest.mark.parametrize(("method", "kept"), [*((method, AFFINE) for method in LINEAR), (sn.Green, SIMILAR)])
def test_orders_agree_for_maps_that_are_kept_and_differ_for_others(method: type, kept: np.ndarray) -> None:
    points, smooth = control()
    coarse = bound(method, sn.SurfaceMesh(CUBE, QUADS), points)
    fine = bound(method, sn.SurfaceMesh(CUBE, QUADS), smooth.refine(points))
    pose, bent = CUBE @ kept.T + 0.4, posed(2)
    assert np.abs(smooth.refine(coarse.warp(pose)) - fine.warp(pose)).max() < 1e-9
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
