# SPDX-License-Identifier: GPL-3.0-or-later
"""Bind and solve of the thin shell's bi-Laplacian, side by side with SciPy's SuperLU and Eigen's LDLT.

All backends get the same matrix in the same run; ratios are what counts, times are the machine's.

    python tests/benchmarks/thin_shell_bind.py [--sizes 10000 50000] [--repeat 3] [--store]
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import matplotlib
import numpy as np
import scipy.sparse as sparse
from cases import bar
from record import RESULTS, store
from scipy.sparse.linalg import splu

import sinew_native

matplotlib.use("Agg")
import matplotlib.pyplot as plt

OURS = "supernodal"
PEERS = ("supernodal", "simplicial", "ldlt", "scipy splu")


def best_of(repeat: int, work: Callable[[], object]) -> tuple[float, object]:
    """Shortest of several runs: the one that the rest of the machine disturbed least."""
    shortest, result = np.inf, None
    for _ in range(repeat):
        begin = time.perf_counter()
        result = work()
        shortest = min(shortest, time.perf_counter() - begin)
    return shortest, result


def measure(vertices: int, repeat: int) -> list[dict[str, object]]:
    case = bar("bend 90", vertices)
    mesh = sinew_native.SurfaceMesh(case.points, case.faces)
    held = np.zeros(case.vertex_count, bool)
    held[np.concatenate(case.handles)] = True
    A = sparse.csc_matrix(sinew_native.laplacian_power(mesh, 2))[~held][:, ~held].tocsc()
    b = np.random.default_rng(0).normal(size=(A.shape[0], 3))

    rows: list[dict[str, object]] = []
    for peer in PEERS:
        if peer == "scipy splu":
            bind = lambda: splu(A, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})  # noqa: E731
        else:
            bind = lambda peer=peer: sinew_native.SpdFactor(A, backend=peer)  # noqa: E731
        bind_seconds, factor = best_of(repeat, bind)
        solve_seconds, x = best_of(3 * repeat, lambda factor=factor: factor.solve(b))
        rows.append(
            {
                "vertices": case.vertex_count,
                "backend": peer,
                "bind_s": bind_seconds,
                "solve3_s": solve_seconds,
                "residual": float(np.abs(A @ x - b).max() / np.abs(b).max()),
            }
        )

    shell = sinew_native.ThinShell(mesh, affine_basis=False)
    bind_seconds, _ = best_of(repeat, lambda: shell.set_handles(case.handles))
    solve_seconds, _ = best_of(3 * repeat, lambda: shell.solve(case.poses))
    based = sinew_native.ThinShell(mesh)
    based_seconds, _ = best_of(repeat, lambda: based.set_handles(case.handles))
    product_seconds, _ = best_of(3 * repeat, lambda: based.solve(case.poses))
    for name, bind_s, solve_s in (
        ("ThinShell, full solve", bind_seconds, solve_seconds),
        ("ThinShell, affine basis", based_seconds, product_seconds),
    ):
        rows.append({"vertices": case.vertex_count, "backend": name, "bind_s": bind_s, "solve3_s": solve_s})
    own = next(row for row in rows if row["backend"] == OURS)
    for row in rows:
        row["bind_ratio"] = row["bind_s"] / own["bind_s"]
        row["solve3_ratio"] = row["solve3_s"] / own["solve3_s"]
    return rows


def plot(rows: list[dict[str, object]], path: Path) -> None:
    figure, axes = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
    for name in dict.fromkeys(row["backend"] for row in rows):
        own = [row for row in rows if row["backend"] == name]
        for axis, key in zip(axes, ("bind_s", "solve3_s")):
            axis.loglog([row["vertices"] for row in own], [1e3 * row[key] for row in own], "o-", label=name)
    for axis, title in zip(axes, ("bind (ordering + factor)", "solve of x, y and z")):
        axis.set(xlabel="vertices", ylabel="ms", title=title)
        axis.grid(alpha=0.3)
    axes[0].legend(fontsize=7)
    figure.savefig(path, dpi=110)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", type=int, nargs="+", default=[10_000, 50_000])
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--store", action="store_true", help="keep the result and the plot")
    arguments = parser.parse_args()

    print(f"{'vertices':>9} {'backend':24} {'bind ms':>9} {'ratio':>6} {'solve ms':>9} {'ratio':>6}")
    rows = []
    for size in arguments.sizes:
        for row in measure(size, arguments.repeat):
            rows.append(row)
            print(
                f"{row['vertices']:>9} {row['backend']:24}"
                f" {1e3 * row['bind_s']:9.1f} {row['bind_ratio']:6.2f}"
                f" {1e3 * row['solve3_s']:9.2f} {row['solve3_ratio']:6.2f}",
                flush=True,
            )
    if arguments.store:
        print("stored in", store("thin_shell_bind", rows).name)
        plot(rows, RESULTS / "thin_shell_bind.png")


if __name__ == "__main__":
    main()
