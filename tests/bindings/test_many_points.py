# SPDX-License-Identifier: GPL-3.0-or-later
"""Ten million points fit into 4 GB with every space method, all memory of the process counted."""

import os

import pytest

import sinew_native as sn

from .methods import SPACE_METHODS
from .programs import output_of

MOVED = """
import resource, sys
import numpy as np
import sinew_native as sn
from tests.bindings.meshes import sphere
from tests.bindings.methods import control, made

kind, count = getattr(sn, sys.argv[1]), 10_000_000
mesh = sn.SurfaceMesh(*sphere(0))
method = made(kind, mesh)
points = np.random.default_rng(0).uniform(-0.3, 0.3, (count, 3))
kept = method.bind(points).weight_bytes
out = np.empty((count, 3), np.float32)
move = np.array((0.0, 0.0, 0.25))
method.warp(control(kind, mesh) + move, out=out)
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
parts = (slice(i, i + 100_000) for i in range(0, count, 100_000))
print(kept, peak, np.max([np.abs(out[part] - points[part] - move).max() for part in parts]))
"""
OF_A_MESH = {sn.MultiresolutionSpace}  # what it moves are the vertices of a mesh, whose surface it smooths
# Handles, wires and tools that move together move what is near them, and not all of space.
LOCAL = {sn.InverseFfd, sn.VectorField, sn.Wires}


@pytest.mark.skipif("SINEW_LONG_TESTS" not in os.environ, reason="it takes gigabytes, and minutes")
@pytest.mark.parametrize("method", [each for each in SPACE_METHODS if each not in OF_A_MESH])
def test_ten_million_points_need_less_than_four_gigabytes(method: type) -> None:
    kept, peak, error = map(float, output_of(MOVED, method.__name__, timeout=None).split())
    assert kept < (30 if method in (sn.Ffd, sn.InverseFfd) else 90) * 10_000_000
    assert peak < 4e9
    assert error < (0.5 if method in LOCAL else 1e-6)
