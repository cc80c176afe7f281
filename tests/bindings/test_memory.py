# SPDX-License-Identifier: GPL-3.0-or-later
"""What is too large is refused before its memory is taken; ten million points fit into 4 GB."""

import os
import sys
from functools import partial

import numpy as np
import pytest

import sinew_native as sn

from . import limits
from .cages import CUBE, QUADS
from .meshes import ends, grid
from .methods import SPACE_METHODS, SURFACE_METHODS, made
from .programs import output_of

POINTS, FACES = grid(40)
MESH = sn.SurfaceMesh(POINTS, FACES)
SIZES = r"needs [\d.]+ [kM]B, the memory limit is [\d.]+ [kM]B"
PLACES = np.random.default_rng(7).uniform(-1, 2, (60, 3))


@pytest.mark.parametrize("method", SURFACE_METHODS)
def test_report_tells_the_memory_that_the_limit_is_about(method: type) -> None:
    needed = made(method, MESH).set_handles(ends(POINTS)).factor_bytes
    assert 8 * len(POINTS) < needed < 1000 * 8 * len(POINTS)
    with limits.memory(needed):
        assert made(method, MESH).set_handles(ends(POINTS)).factor_bytes == needed


@pytest.mark.parametrize(
    ("limit", "call", "argument"),
    [
        (50_000, sn.ThinShell(MESH).set_handles, ends(POINTS)),
        (1 << 20, sn.Harmonic(sn.SurfaceMesh(CUBE, QUADS), solver="boundary").bind, np.full((1, 3), 0.4)),
        *((1000, m(PLACES).bind, PLACES) for m in (sn.Rbf, sn.Mls, sn.SpacePropagation, sn.Wires)),
        (1 << 20, partial(sn.SubdivisionSurface, level=3), MESH),
    ],
)
def test_what_takes_more_than_the_limit_is_refused_with_both_sizes(limit, call, argument) -> None:
    with limits.memory(limit), pytest.raises(sn.OutOfMemory, match=SIZES) as refused:
        call(argument)
    assert isinstance(refused.value, sn.FactorizationFailed)
    assert "raise the limit or use fewer" in str(refused.value)
    call(argument)


BIND_WITH_LITTLE_ROOM = """
import resource
import sinew_native as sn
from tests.bindings.meshes import ends, grid

points, faces = grid(180)
mesh = sn.SurfaceMesh(points, faces)

def bind():
    return sn.ThinShell(mesh, affine_basis=False, solver="factor").set_handles(ends(points)).factor_bytes

needed = bind()  # also takes what every bind needs once: threads, buffers of the BLAS
with open("/proc/self/statm") as pages:
    used = int(pages.read().split()[0]) * resource.getpagesize()
for room in range(20, 500, 10):
    resource.setrlimit(resource.RLIMIT_AS, (used + (room << 20), resource.RLIM_INFINITY))
    try:
        assert bind() == needed
        break
    except sn.OutOfMemory as error:
        print(error)
    except MemoryError:
        pass  # it ran out before the factor
print(f"{needed / 2**20:.1f} MB")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits the address space as Linux does")
def test_memory_that_runs_out_is_an_error_that_tells_the_size() -> None:
    *refusals, needed = output_of(BIND_WITH_LITTLE_ROOM).splitlines()
    assert f"the factor needs {needed}, more than is left on this machine" in refusals[-1]


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
    """With every space method, all memory of the process counted."""
    kept, peak, error = map(float, output_of(MOVED, method.__name__, timeout=None).split())
    assert kept < (30 if method in (sn.Ffd, sn.InverseFfd) else 90) * 10_000_000
    assert peak < 4e9
    assert error < (0.5 if method in LOCAL else 1e-6)
