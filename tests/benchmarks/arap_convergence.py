# SPDX-License-Identifier: GPL-3.0-or-later
"""How far as-rigid-as-possible is from its minimum after a few iterations.

Excess energy in per cent over a long run from the same start, after 0, 4, 10, 20 and 40 iterations, next
to the figures of the study that the method builds on. Figures count iterations, so they are the same on
every machine; the times beside them are not. "bend 179" is a saddle: a symmetric shape, at which the steps
become tiny after 20 iterations and which a run of hundreds leaves sideways, to an energy 0.4 % lower.

    python tests/benchmarks/arap_convergence.py [--largest 200000] [--meshes FOLDER] [--smoothness 0]
"""

import argparse
import time
from pathlib import Path

import matplotlib
import numpy as np
from cases import OWN_MODEL, Case, armadillo, bar, knight, own_model
from record import RESULTS, store

import sinew_native

matplotlib.use("Agg")
import matplotlib.pyplot as plt

BUDGETS = (0, 4, 10, 20, 40)
LIMITS = {10: 1.0, 40: 0.1}  # per cent: what the method promises with its default smoothness
NAN = float("nan")

# Excess % after 0, 4, 10, 20 iterations, by case and size; 0 stands for "below the digits printed".
STUDY = {
    ("bend 90", 2_000): (0.99, 0.06, 0.01, 0),
    ("bend 90", 50_000): (0.47, 0.11, 0.03, 0),
    ("bend 90", 200_000): (0.30, 0.04, 0, 0),
    ("bend 179", 10_000): (2.1, 0.70, 0.18, 0.04),
    ("twist 135", 10_000): (1.4, 0.05, 0.003, 0),
    ("shift 20", 50_000): (0.12, 0.003, 0, 0),
    ("shift (-16, 22)", 10_000): (1.2, 0.22, 0.04, 0),
    ("turn 120 + move", 10_000): (3.9, 2.0, 0.83, 0.20),
    ("turn 120 + move", 40_000): (0.75, 0.04, 0.01, 0),
    ("armadillo turned", 43_000): (0.12, 0.02, 0.002, 0),
    ("armadillo moved", 43_000): (0.13, 0.01, 0, 0),
    ("knight", 502): (6.1, 0.66, 0.16, 0.02),
}
BARS = [
    ("bend 90", 2_000), ("bend 90", 10_000), ("bend 90", 50_000), ("bend 90", 200_000),
    ("bend 179", 10_000), ("twist 135", 10_000), ("stretch", 10_000), ("stretch", 50_000),
    ("shift 20", 10_000), ("shift 20", 50_000), ("shift (-16, 22)", 10_000),
    ("turn 120 + move", 10_000), ("turn 120 + move", 40_000),
]  # fmt: skip


def cases(largest: int, meshes: Path | None) -> list[tuple[Case, int]]:
    """Each case with the size by which the study calls it."""
    chosen = [(bar(pose, size), size) for pose, size in BARS if size <= largest]
    if OWN_MODEL.is_file():
        own = own_model()
        chosen.append((own, own.vertex_count))
    if meshes is not None:
        chosen.append((knight(meshes), 502))
        if largest >= 43_000:
            chosen += [(armadillo(meshes, turned=turned), 43_000) for turned in (True, False)]
    return chosen


def measure(case: Case, size: int, smoothness: float, reference_budget: int) -> dict[str, object]:
    mesh = sinew_native.SurfaceMesh(case.points, case.faces)
    arap = sinew_native.Arap(mesh, smoothness=smoothness)
    bind = arap.set_handles(case.handles)

    energies, seconds = [], []
    for budget in BUDGETS:
        start = time.perf_counter()
        _, report = arap.solve(case.poses, max_iterations=budget, tolerance=0.0)
        seconds.append(time.perf_counter() - start)
        energies.append(report.energy)
    _, default = arap.solve(case.poses)
    _, reference = arap.solve(case.poses, max_iterations=reference_budget, tolerance=0.0)
    per_iteration = (seconds[-1] - seconds[0]) / BUDGETS[-1]
    least = min(reference.energy, default.energy)
    return {
        "case": case.name,
        "size": size,
        "vertices": case.vertex_count,
        "smoothness": smoothness,
        "bind_s": bind.seconds,
        "ms_per_iteration": 1e3 * per_iteration,
        "start_in_iterations": seconds[0] / per_iteration if per_iteration > 0 else NAN,
        "energy": least,
        "reference_iterations": reference.iterations,
        "excess_percent": [100 * (energy / least - 1) for energy in energies],
        "default_iterations": default.iterations,
        "default_excess_percent": 100 * (default.energy / least - 1),
        "default_converged": default.converged,
    }


def line(row: dict[str, object]) -> str:
    excess = dict(zip(BUDGETS, row["excess_percent"]))
    study = STUDY.get((row["case"], row["size"]), ()) if row["smoothness"] > 0 else ()
    late = "".join(f"  OVER {limit} % at {k}" for k, limit in LIMITS.items() if excess[k] > limit)
    return (
        f"{row['case']:18}{row['vertices']:>8}  "
        + " ".join(f"{value:9.4f}" for value in excess.values())
        + f"  | {'/'.join(f'{value:g}' for value in study) or '-':22}"
        + f"| {row['default_iterations']:3} it {row['default_excess_percent']:8.4f}"
        + f" | start {row['start_in_iterations']:4.1f} it, {row['ms_per_iteration']:7.2f} ms/it{late}"
    )


def plot(rows: list[dict[str, object]], path: Path) -> None:
    figure, axes = plt.subplots(figsize=(10, 5.5), layout="constrained")
    for number, row in enumerate(rows):
        excess = np.maximum(row["excess_percent"], 1e-5)
        style = ("-", "--", ":")[number // 10]
        axes.semilogy(
            BUDGETS, excess, style, marker="o", markersize=3, label=f"{row['case']}, {row['vertices']:,}"
        )
    for budget, limit in LIMITS.items():
        axes.plot(budget, limit, "kv", markersize=9)
        axes.annotate(f"{limit:g} %", (budget, limit), (6, 4), textcoords="offset points")
    axes.set(xlabel="iterations", ylabel="energy above the minimum, %", title="As-rigid-as-possible")
    axes.grid(alpha=0.3)
    figure.legend(fontsize=8, loc="outside right center")
    figure.savefig(path, dpi=110)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--largest", type=int, default=50_000, help="leave out larger bars (200000 takes minutes)"
    )
    parser.add_argument("--meshes", type=Path, help="folder with armadillo.obj and decimated-knight.off")
    parser.add_argument("--smoothness", type=float, default=5e-4)
    parser.add_argument("--reference", type=int, default=400, help="iterations of the long run")
    parser.add_argument("--store", action="store_true", help="keep the result and the plot")
    arguments = parser.parse_args()

    print(f"{'case':18}{'vertices':>8}  " + " ".join(f"{k:>9}" for k in BUDGETS)
          + f"  | {'study 0/4/10/20':22}| default          | cost")  # fmt: skip
    rows = []
    for case, size in cases(arguments.largest, arguments.meshes):
        rows.append(measure(case, size, arguments.smoothness, arguments.reference))
        print(line(rows[-1]), flush=True)
    if arguments.store:
        name = "arap_convergence" if arguments.smoothness > 0 else "arap_convergence_textbook"
        print("stored in", store(name, rows).name)
        plot(rows, RESULTS / f"{name}.png")


if __name__ == "__main__":
    main()
