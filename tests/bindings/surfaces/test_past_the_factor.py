# SPDX-License-Identifier: GPL-3.0-or-later
"""A thin shell whose factor does not fit the memory is solved by iterations, to the same shape; SciPy is the oracle."""

import os

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

import sinew_native as sn

from .. import limits
from ..meshes import STILL, ends, grid, messy
from ..programs import output_of

POSES = np.stack([STILL, STILL])
POSES[1, :2, :2], POSES[1, :, 3] = [[0.8, -0.6], [0.6, 0.8]], (3.0, -2.0, 40.0)


def shell(points: np.ndarray, faces: np.ndarray, weight: float = 1.0, **options):
    method = sn.ThinShell(sn.SurfaceMesh(points, faces), **options)
    held = ends(points[:81] if len(points) < 100 else points)  # of the messy mesh, without its loose parts
    return method, method.set_handles(held, weights=[1.0, weight])


@pytest.mark.parametrize("mesh", [grid(100), messy()], ids=["hill", "messy"])
@pytest.mark.parametrize("weight", [1.0, 0.6], ids=["hard", "soft"])
@pytest.mark.parametrize("options", [{}, {"stretching": 1, "bending": 0}, {"stretching": 0.01}], ids=repr)
def test_the_multigrid_gives_the_solution_of_the_system(mesh, weight, options) -> None:
    points, _ = mesh
    system = sn.system(shell(*mesh, weight, **options)[0], POSES)
    truth = spsolve(system.matrix, system.right_side)
    method, bound = shell(*mesh, weight, solver="multigrid", **options)
    assert "multigrid" in bound.remarks[0]
    moved, report = method.solve(POSES)
    assert abs((moved - points)[system.vertices] - truth).max() < 1e-4 * abs(truth).max()
    assert report.converged
    np.testing.assert_array_equal(method.solve(POSES)[0], moved)
    with limits.threads(1):
        np.testing.assert_array_equal(method.solve(POSES)[0], moved)


def test_the_multigrid_is_chosen_by_the_limit_and_refuses_by_name_what_it_cannot() -> None:
    points, faces = grid(150)
    method, bound = shell(points, faces)
    assert bound.remarks == []
    expected = method.solve(POSES)[0]
    with limits.memory(bound.factor_bytes - 1):
        method, bound = shell(points, faces)
        moved = method.solve(POSES)[0]
        with pytest.raises(sn.OutOfMemory, match="the factor needs"):
            shell(points, faces, solver="factor")
    assert "the memory limit is" in bound.remarks[0]
    assert abs(moved - expected).max() < 1e-4 * abs(expected - points).max()
    with pytest.raises(sn.InvalidOption, match=r"solver: the multigrid has no matrix; choose the factor"):
        sn.system(method, POSES)
    with limits.memory(3_000_000), pytest.raises(sn.OutOfMemory, match="the factor needs .* and the multigrid"):
        shell(points, faces)
    for words, options in (
        ("variation must be 0", {"variation": 1.0}),
        ("stretching cannot be painted", {"stretching": np.linspace(0, 1, len(points))}),
    ):
        with pytest.raises(sn.InvalidOption, match=f"solver: {words}"):
            shell(points, faces, solver="multigrid", **options)


LARGE = """
import resource, sys, time
import numpy as np
import sinew_native as sn
from tests.bindings.surfaces.test_past_the_factor import POSES, shell
from tests.bindings.meshes import grid

points, faces = grid(int(sys.argv[1]), 0.0)
begin = time.perf_counter()
method, bound = shell(points, faces, solver="multigrid")
between = time.perf_counter()
moved, report = method.solve(POSES)
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
print(len(points), bound.factor_bytes, peak, between - begin, time.perf_counter() - between, report.iterations)
"""


@pytest.mark.skipif("SINEW_LONG_TESTS" not in os.environ, reason="it takes gigabytes, and minutes")
@pytest.mark.parametrize(("side", "most"), [(2236, 4), (3162, 8)], ids=["5M", "10M"])
def test_millions_of_vertices_are_bound_and_solved_in_little_memory(side, most) -> None:
    told = [float(word) for word in output_of(LARGE, str(side), timeout=None).split()]
    assert told[2] < most * 2**30, told
