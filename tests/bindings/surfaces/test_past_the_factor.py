# SPDX-License-Identifier: GPL-3.0-or-later
"""Methods whose factor does not fit the memory are solved by iterations, to the same shape."""

import os

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

import sinew_native as sn

from .. import limits
from ..meshes import STILL, ends, grid, joined, messy, off, spread, turn
from ..programs import output_of

POSES = np.stack([STILL, [[0.8, -0.6, 0, 3], [0.6, 0.8, 0, -2], [0, 0, 1, 40]]])


def bound(mesh, regions=None, method="ThinShell", **options):
    made = getattr(sn, method)(sn.SurfaceMesh(*mesh), **options)
    points = mesh[0][:81] if len(mesh[0]) < 100 else mesh[0]  # of the messy mesh, without its loose parts
    return made, made.set_handles(ends(points, 2.6), **regions or {})


GRADIENTS = {"method": "GradientEditing"}
SYSTEMS = [
    {},
    {"stretching": 1, "bending": 0},
    {"stretching": 0.01},
    GRADIENTS,
    GRADIENTS | {"field": "geodesic"},
]


@pytest.mark.parametrize("mesh", [grid(100), messy()], ids=["hill", "messy"])
@pytest.mark.parametrize("regions", [{}, {"weights": [1.0, 0.6]}, {"continuity": [0.0, 2.0]}], ids=repr)
@pytest.mark.parametrize("options", SYSTEMS, ids=repr)
def test_the_multigrid_gives_the_solution_of_the_system(mesh, regions, options) -> None:
    system = sn.system(bound(mesh, regions, solver="factor", **options)[0], POSES)
    truth = spsolve(system.matrix, system.right_side)
    method = bound(mesh, regions, solver="multigrid", **options)[0]
    with limits.threads(1):
        moved = method.solve(POSES)[0]
    assert abs((moved - mesh[0])[system.vertices] - truth).max() < 1e-4 * abs(truth).max()
    np.testing.assert_array_equal(method.solve(POSES)[0], moved)


def test_the_multigrid_is_chosen_by_the_limit_and_refuses_by_name_what_it_cannot() -> None:
    mesh = grid(150)
    factor = bound(mesh)[1]
    with limits.memory(factor.factor_bytes - 1):
        less = bound(mesh)[1]
        with pytest.raises(sn.OutOfMemory, match="the factor needs"):
            bound(mesh, solver="factor")
    assert (factor.remarks, "the memory limit is" in less.remarks[0]) == ([], True)
    assert less.factor_bytes < factor.factor_bytes
    for options in ({}, GRADIENTS):
        with pytest.raises(sn.InvalidOption, match="solver: the multigrid has no matrix; choose the factor"):
            sn.system(bound(mesh, solver="multigrid", **options)[0], POSES)
        with (
            limits.memory(3_000_000),
            pytest.raises(sn.OutOfMemory, match=r"needs .* and the multigrid needs"),
        ):
            bound(mesh, **options)
    painted = np.linspace(0, 1, len(mesh[0]))
    for options in ({"variation": 1}, {"stretching": painted}):
        with pytest.raises(sn.InvalidOption, match=f"solver: {next(iter(options))} .*multigrid"):
            bound(mesh, solver="multigrid", **options)


@pytest.mark.parametrize("options", [{}, {"cells": "rims"}, {"smoothness": 0.01}], ids=repr)
@pytest.mark.parametrize("regions", [{}, {"weights": [1.0, 0.6]}], ids=repr)
@pytest.mark.parametrize("mesh", [grid(60), joined(grid(40), messy())], ids=["hill", "messy"])
def test_natural_bend_on_the_multigrid_ends_in_the_shape_of_the_factor(mesh, regions, options) -> None:
    surface, rigid = sn.SurfaceMesh(*mesh), np.stack([POSES[1]] * 2)
    bent = np.stack([STILL, turn((0, 1, 0), 40, (20, 0, 0))])
    options = options | {"tolerance": 1e-5, "max_iterations": 200}  # so that both come to the end
    exact, method = (sn.Arap(surface, solver=solver, **options) for solver in ("factor", "multigrid"))
    bound = [each.set_handles(ends(mesh[0], 2.6), **regions) for each in (exact, method)]
    assert [(report.factorizations > 0, report.remarks) for report in bound] == [(True, []), (False, [])]
    (truth, by_factor), (moved, report) = exact.solve(bent), method.solve(bent)
    assert off(moved, truth) < 1e-4 * spread(*mesh)
    assert report.energy == pytest.approx(by_factor.energy, 1e-5)
    assert report.iterations < 1.5 * by_factor.iterations
    assert off(method.solve(rigid)[0], exact.solve(rigid)[0]) < 1e-7 * spread(*mesh)
    with limits.threads(1):
        np.testing.assert_array_equal(method.solve(bent)[0], moved)


def test_natural_bend_takes_the_multigrid_by_the_limit_and_refuses_by_name_what_it_cannot() -> None:
    mesh = grid(150)
    with limits.memory(385 * len(mesh[0])):
        assert "the memory limit is" in bound(mesh, method="Arap")[1].remarks[0]
        with pytest.raises(sn.OutOfMemory, match="the factor needs"):
            bound(mesh, method="Arap", solver="factor")
    with limits.memory(1_000_000), pytest.raises(sn.OutOfMemory, match=r"needs .* and the multigrid needs"):
        bound(mesh, method="Arap")
    with pytest.raises(sn.InvalidOption, match="solver: point_handles must be 0 for the multigrid"):
        bound(mesh, method="Arap", solver="multigrid", point_handles=0.5)


LARGE = """
import resource, sys
from tests.bindings.surfaces.test_past_the_factor import POSES, bound, grid

method, report = bound(grid(int(sys.argv[1])), solver="multigrid")
print(method.solve(POSES)[1], resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024, report.seconds)
"""


@pytest.mark.skipif("SINEW_LONG_TESTS" not in os.environ, reason="it takes gigabytes, and minutes")
@pytest.mark.parametrize(("side", "most"), [(2236, 4), (3162, 8)], ids=["5M", "10M"])
def test_millions_of_vertices_need_few_gigabytes(side, most) -> None:
    told = output_of(LARGE, str(side), timeout=None)
    assert float(told.split()[-2]) < most * 2**30, told
