# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles whose points go where they like: what the native module gets."""

import numpy as np
import pytest
from rows import default_options, rotation

from sinew.core.methods import METHODS, Control, Posed

POINTS = np.random.default_rng(3).uniform(-1.0, 1.0, (12, 3))
CHAIN = np.array([(k, k + 1) for k in range(8)])
BY_HANDLES = [m for m in METHODS if m.is_space and m.control is Control.HANDLES and not m.wraps]


def moved(points: np.ndarray, turn: np.ndarray, by=(0.4, -0.2, 0.7)) -> np.ndarray:
    return points @ turn.T + by


@pytest.fixture
def mixed(backend):
    """A handle of three points that move by one map, and the others apart, joined in a chain."""

    def control(method):
        return backend.HandlePoints(POINTS, (3, 9), apart={1: backend.Apart(CHAIN, method.takes_segments)})

    return control


@pytest.mark.parametrize("method", BY_HANDLES, ids=lambda method: method.id)
def test_points_apart_and_regions_together_reproduce_what_the_method_promises(backend, mixed, method):
    points = np.concatenate((POINTS, np.random.default_rng(4).uniform(-1.0, 1.0, (50, 3))))
    recipe = backend.Recipe(
        method,
        backend.Shape(points, (np.zeros(0, dtype=np.int32), np.zeros(0, dtype=np.int32))),
        default_options(method),
        mixed(method),
    )
    factor = backend.build_factor(recipe)
    still = np.tile(np.eye(4)[:3], (2, 1, 1))
    assert np.abs(factor.solve(still, placed=POINTS[3:])[0] - points).max() < 1e-6
    if method.reproduces.value == "rest" or method.id == "space_propagation":
        return  # the latter fits nothing to points, and a single one has no turn to spread
    turn = rotation((0.3, 0.9, -0.2), 0.7 if method.reproduces.value != "translations" else 0.0)
    poses = np.tile(np.column_stack((turn, (0.4, -0.2, 0.7))), (2, 1, 1))
    found = factor.solve(poses, placed=moved(POINTS[3:], turn))[0]
    assert np.abs(found - moved(points, turn)).max() < 1e-5


def test_a_handle_of_the_native_method_is_found_again(mixed):
    control = mixed(BY_HANDLES[0])
    assert control.native_counts.tolist() == [3] + [1] * 9
    assert control.located(0) == (0, None)
    assert [control.located(row) for row in (1, 9)] == [(1, 0), (1, 8)]
    assert control.located(10) == (10, None)


def test_a_space_method_that_handles_move_says_how(backend):
    native = backend.availability().module
    for method in METHODS:
        is_posed = method.is_space and method.control is Control.HANDLES
        assert (method.posed is not None) == is_posed, method.id
        made = getattr(native, method.native)
        assert (method.posed is Posed.POSES) == issubclass(made, native.HandleMethod), method.id
        assert hasattr(made, "warp_poses") == is_posed, method.id
        assert not method.takes_segments or method.posed is Posed.CONTROL


def test_the_cost_of_a_bind_counts_segments(mixed):
    """So that a bind of many of them runs in a thread."""
    for method in METHODS:
        if method.posed is not None:
            assert mixed(method).size == 12 + 12 * 8 * method.takes_segments
