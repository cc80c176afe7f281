# SPDX-License-Identifier: GPL-3.0-or-later
"""How far the energy of as-rigid-as-possible is above its minimum after a few iterations.

The excess is in per cent of the energy after a long run from the same start. The figures depend on numbers of
iterations, so they are the same on every machine. "bend 179" leads to a saddle, a symmetric shape: after 20
iterations the steps become tiny, and only after hundreds the shape leaves it, to an energy that is 0.4 %
lower.
"""

from pathlib import Path

from cases import OWN_MODEL, Case, armadillo, bar, knight, own_model
from record import Row
from works import CONVERGENCE_BUDGETS as BUDGETS

import sinew_native

from . import Options, Task

LIMITS = {10: 1.0, 40: 0.1}  # per cent that the method promises with its default smoothness
REFERENCE = 400  # iterations of the long run
LARGEST, LARGEST_QUICK = 50_000, 2_000
BARS = [
    ("bend 90", 2_000), ("bend 90", 10_000), ("bend 90", 50_000), ("bend 90", 200_000),
    ("bend 179", 10_000), ("twist 135", 10_000), ("stretch", 10_000), ("stretch", 50_000),
    ("shift 20", 10_000), ("shift 20", 50_000), ("shift (-16, 22)", 10_000),
    ("turn 120 + move", 10_000), ("turn 120 + move", 40_000),
]  # fmt: skip


def plan(options: Options) -> list[Task]:
    largest = LARGEST_QUICK if options.quick else max(LARGEST, *options.own_sizes, 0)
    work = ("convergence",)
    tasks = [
        Task("convergence", work, {"model": "bar", "pose": pose, "size": size})
        for pose, size in BARS
        if size <= largest
    ]
    if OWN_MODEL.is_file():
        tasks.append(Task("convergence", work, {"model": "own", "size": 0}))
    if options.meshes is not None and not options.quick:
        for model in ("knight", "armadillo turned", "armadillo moved"):
            keywords = {"model": model, "size": 0, "meshes": str(options.meshes)}
            tasks.append(Task("convergence", work, keywords))
    return tasks


def measure(model: str, size: int, pose: str = "", meshes: str = "") -> list[Row]:
    if model == "bar":
        case = bar(pose, size)
    elif model == "own":
        case = own_model()
    elif model == "knight":
        case = knight(Path(meshes))
    else:
        case = armadillo(Path(meshes), turned=model.endswith("turned"))
    return [{"work": "convergence", "size": size, "vertices": case.vertex_count, **_excess(case)}]


def _excess(case: Case) -> Row:
    arap = sinew_native.Arap(sinew_native.SurfaceMesh(case.points, case.faces))
    arap.set_handles(case.handles)
    energies = []
    for budget in BUDGETS:
        _, report = arap.solve(case.poses, max_iterations=budget, tolerance=0.0)
        energies.append(report.energy)
    _, default = arap.solve(case.poses)
    _, reference = arap.solve(case.poses, max_iterations=REFERENCE, tolerance=0.0)
    least = min(reference.energy, default.energy)
    excess = [100 * (energy / least - 1) for energy in energies]
    return {
        "case": case.name,
        "energy": least,
        "excess_percent": excess,
        "over": [limit for k, limit in LIMITS.items() if excess[BUDGETS.index(k)] > limit],
        "default_iterations": default.iterations,
        "default_excess_percent": 100 * (default.energy / least - 1),
    }
