# SPDX-License-Identifier: GPL-3.0-or-later
"""Ten million points fit into 4 GB with every space method, all memory of the process counted."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import sinew_native as sn

from .methods import SPACE_METHODS

ROOT = Path(__file__).resolve().parents[2]
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
# What it moves are the vertices of a mesh, whose surface it smooths.
OF_A_MESH = {sn.MultiresolutionSpace}
# Handles, wires and tools that move together move what is near them, and not all of space.
LOCAL = {sn.InverseFfd, sn.VectorField, sn.Wires}
BYTES_PER_POINT = {sn.Ffd: 30, sn.InverseFfd: 30}  # that a bind keeps
MOST_BYTES_PER_POINT = 90


@pytest.mark.skipif("SINEW_LONG_TESTS" not in os.environ, reason="it takes gigabytes, and minutes")
@pytest.mark.parametrize("method", [each for each in SPACE_METHODS if each not in OF_A_MESH])
def test_ten_million_points_need_less_than_four_gigabytes(method: type) -> None:
    paths = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])}
    run = subprocess.run(
        [sys.executable, "-c", MOVED, method.__name__], capture_output=True, text=True, check=True, env=paths
    )
    kept, peak, error = map(float, run.stdout.split())
    print(f"{method.__name__} keeps {kept / 1e9:.2f} GB, peak {peak / 1e9:.2f} GB")
    assert kept < BYTES_PER_POINT.get(method, MOST_BYTES_PER_POINT) * 10_000_000
    assert peak < 4e9
    assert error < (0.5 if method in LOCAL else 1e-6)
