# SPDX-License-Identifier: GPL-3.0-or-later
"""Counts of iterations, which are the same on every machine.

``convergence`` is the excess of the energy of as-rigid-as-possible over its least value, in per cent of the
energy after a long run from the same start. "bend 179" leads to a saddle, a symmetric shape: after 20
iterations the steps become tiny, and only after hundreds the shape leaves it, to an energy that is 0.4 %
lower.
"""

from collections.abc import Sequence

import numpy as np
from cases import Case, bar, own_model
from record import Row

import sinew_native

from .nonlinear import bound

BUDGETS = (0, 4, 10, 20, 40)  # iterations after which the excess energy is reported
REFERENCE = 400  # iterations of the long run
COW = "cow"
CASES = {
    2_000: ("bend 90", COW),
    10_000: ("bend 90", "bend 179", "twist 135", "stretch", "shift 20", "shift (-16, 22)", "turn 120 + move"),
    40_000: ("turn 120 + move",),
    50_000: ("bend 90", "stretch", "shift 20"),
    200_000: ("bend 90",),
}
SETTLING = ("ThinShellNonlinear", "PyramidCoordinates", "Primo", "HandleAwareIsolines", "SubspaceLaplacian")
DEEP = {"max_iterations": 2000, "tolerance": 1e-12}  # leads to the limit
CLOSE = 0.01  # of how far the surface moves, in the mean square


def convergence(size: int, _threads: Sequence[int]) -> list[Row]:
    rows = []
    for name in CASES[size]:
        case = own_model() if name == COW else bar(name, size)
        arap = bound(case)

        def energy(iterations: int, arap=arap, case=case) -> float:
            return arap.solve(case.poses, max_iterations=iterations, tolerance=0.0)[1].energy

        default = arap.solve(case.poses)[1]
        least = min(energy(REFERENCE), default.energy)
        excess = [100 * (energy(budget) / least - 1) for budget in BUDGETS]
        row = {"case": name, "vertices": case.vertex_count, "excess_percent": excess}
        rows.append({**row, "default_iterations": default.iterations})
    return rows


def settled(size: int, _threads: Sequence[int]) -> list[Row]:
    """Iterations from the poses alone until the shape is close to its limit: the worse of two poses."""
    cases = [bar(pose, size) for pose in ("bend 90", "twist 135")]
    about = {"unit": "iterations", "vertices": cases[0].vertex_count}
    kinds = {name: getattr(sinew_native, name) for name in SETTLING}
    worst = {
        name: max(_iterations_to_settle(bound(case, kind), case) for case in cases)
        for name, kind in kinds.items()
    }
    return [{"case": name, **about, "ours": count} for name, count in worst.items()]


def _iterations_to_settle(method: sinew_native.SurfaceMethod, case: Case) -> int:
    limit = method.solve(case.poses, **DEEP)[0]
    moved = np.linalg.norm(limit - case.points)
    for count in range(DEEP["max_iterations"]):
        shape = method.solve(case.poses, max_iterations=count, tolerance=0.0)[0]
        if np.linalg.norm(shape - limit) <= CLOSE * moved:
            return count
    raise SystemExit(f"{type(method).__name__} does not come close to its limit")
