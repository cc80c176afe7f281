# SPDX-License-Identifier: GPL-3.0-or-later
"""A factor that is too large is refused before its memory is taken, and nothing is lost."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import sinew_native as sn

from . import limits
from .meshes import BENT, ends, grid
from .methods import SURFACE_METHODS, made

POINTS, FACES = grid(40)
SIZE = re.compile(r"needs [\d.]+ MB, the memory limit is [\d.]+ MB")


@pytest.mark.parametrize("method", SURFACE_METHODS)
def test_report_tells_the_memory_that_the_limit_is_about(method: type) -> None:
    surface = made(method, sn.SurfaceMesh(POINTS, FACES))
    needed = surface.set_handles(ends(POINTS)).factor_bytes
    assert 8 * len(POINTS) < needed < 1000 * 8 * len(POINTS)
    with limits.memory(needed):
        assert made(method, sn.SurfaceMesh(POINTS, FACES)).set_handles(ends(POINTS)).factor_bytes == needed


def test_bind_above_the_limit_is_refused_and_the_last_one_stays() -> None:
    surface = sn.ThinShell(sn.SurfaceMesh(POINTS, FACES))
    surface.set_handles(ends(POINTS))
    before, _ = surface.solve(BENT)
    with limits.memory(50_000), pytest.raises(sn.OutOfMemory, match=SIZE) as caught:
        surface.set_handles(ends(POINTS, 4.0))
    assert isinstance(caught.value, sn.FactorizationFailed)
    assert "raise the limit or use fewer vertices" in str(caught.value)
    np.testing.assert_array_equal(surface.solve(BENT)[0], before)


BIND_WITH_LITTLE_ROOM = """
import resource, sys
import sinew_native as sn
sys.path.insert(0, sys.argv[1])
from meshes import ends, grid

points, faces = grid(180)
mesh = sn.SurfaceMesh(points, faces)

def bind():
    return sn.ThinShell(mesh, affine_basis=False).set_handles(ends(points)).factor_bytes

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
print("needed", f"{needed / 2**20:.1f} MB")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits the address space as Linux does")
def test_memory_that_runs_out_is_an_error_that_tells_the_size() -> None:
    command = [sys.executable, "-c", BIND_WITH_LITTLE_ROOM, str(Path(__file__).parent)]
    answer = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert answer.returncode == 0, answer.stderr
    *refusals, needed = answer.stdout.splitlines()
    size = needed.removeprefix("needed ")
    assert f"the factor needs {size}, more than is left on this machine" in refusals[-1]
