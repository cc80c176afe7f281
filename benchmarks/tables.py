# SPDX-License-Identifier: GPL-3.0-or-later
"""The tutorial's Tables 1 and 2 again: Laplacian and bi-Laplacian systems of a bumpy torus, by many solvers.

`benchmarks/run --tables [SIZE ...]` measures systems of about these numbers of unknowns, each solver in a
process of its own, and writes docs/developer/solvers.md. A solver that fails or takes too long has a dash.
"""

import json
import math
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

import numpy as np

import sinew_native as sn

PAGE = Path(__file__).resolve().parents[1] / "docs/developer/solvers.md"
SIZES = (10_000, 50_000, 100_000, 500_000)
SECONDS = 120  # that one solver may take
WRONG = 1e-3  # of the largest unknown: a solution that is farther off is none
NAMES = {1: "Laplacian systems (Table 1)", 2: "Bi-Laplacian systems (Table 2)"}
TUTORIAL = {  # set-up, precomputation and three solutions there, for each of SIZES that a solver reached
    1: {
        "CG": (".11 / 1.56 / .08", ".56 / 9.18 / .98", "1.15 / 16.0 / 3.19", "5.42 / 87.3 / 47.4"),
        "MG": (".15 / .65 / .09", ".92 / 4.00 / .57", "1.73 / 8.10 / .96", "8.70 / 40.2 / 5.57"),
        "LU": (".07 / .22 / .01", ".38 / 2.79 / .10", ".79 / 5.66 / .21", "3.69 / 68.4 / 1.54"),
        "LLT": (".07 / .14 / .03", ".39 / 1.00 / .15", ".80 / 2.26 / .31", "3.74 / 17.4 / 1.74"),
    },
    2: {
        "CG": (".33 / 5.78 / .44", "1.84 / 33.3 / 8.95"),
        "MG": (".40 / .65 / .48", "2.82 / 4.05 / 2.34", "4.60 / 8.13 / 4.08", "24.1 / 40.3 / 23.4"),
        "LU": (".24 / 1.68 / .03", "1.42 / 22.9 / .26", "2.86 / 92.8 / .73"),
        "LLT": (".24 / .35 / .04", "1.42 / 2.82 / .28", "2.88 / 7.29 / .62", "12.9 / 60.4 / 3.60"),
    },
}

# Seconds of what is computed once, and of three solutions, and these.
Solution = tuple[float, float, np.ndarray]
Way = Callable[[sn.LinearSystem], Solution]


def torus(count: int) -> tuple[np.ndarray, np.ndarray]:
    """A bumpy torus with about so many vertices, which are moved a little at random: points, triangles."""
    a = round(np.sqrt(count / 3))
    b = round(count / a)
    i, j = (w.ravel() for w in np.meshgrid(np.arange(b), np.arange(a), indexing="ij"))
    noise = np.random.default_rng(1).uniform(-0.2, 0.2, (2, i.size))
    u, v = 2 * np.pi * (i + noise[0]) / b, 2 * np.pi * (j + noise[1]) / a
    r = 1.0 + 0.08 * np.sin(7 * u) * np.sin(3 * v)
    points = np.stack(((3 + r * np.cos(v)) * np.cos(u), (3 + r * np.cos(v)) * np.sin(u), r * np.sin(v)), 1)
    right, up = (i + 1) % b * a + j, i * a + (j + 1) % a
    both = (i + 1) % b * a + (j + 1) % a
    return points, np.vstack((np.stack((i * a + j, right, both), 1), np.stack((i * a + j, both, up), 1)))


def system(order: int, count: int) -> tuple[sn.LinearSystem, float]:
    """With a tenth of the vertices held, and those at the other end pulled; and the seconds of its matrix."""
    points, triangles = torus(round(count / 0.9))
    free = np.flatnonzero(points[:, 0] > np.quantile(points[:, 0], 0.1))
    begin = time.perf_counter()
    mesh = sn.SurfaceMesh(points, triangles)
    matrix = (sn.laplacian(mesh, "cotan") if order == 1 else sn.laplacian_power(mesh, 2)).tocsc()[free][
        :, free
    ]
    seconds = time.perf_counter() - begin
    given = {"points": points, "graph": sn.laplacian(mesh, "cotan"), "mass": sn.mass(mesh), "vertices": free}
    pull = np.exp(-np.square(points[free] - (4.0, 0.0, 0.0)).sum(1))[:, None] * (1.0, -2.0, 3.0)
    return sn.LinearSystem(matrix, given["mass"][free, None] * pull, order=order, **given), seconds


def ours(given: sn.LinearSystem, **options: object) -> Solution:
    x, report = sn.solve(given, **options)
    return report.setup + report.precompute, report.solve, x


def factorised(
    make: Callable[[object], Callable[[np.ndarray], np.ndarray]], given: sn.LinearSystem
) -> Solution:
    """By a peer: ``make`` takes the matrix, and returns what solves for right sides (m, 3)."""
    matrix, b = given.matrix, given.right_side
    begin = time.perf_counter()
    solve = make(matrix)
    middle = time.perf_counter()
    x = solve(b)
    return middle - begin, time.perf_counter() - middle, x


def super_lu(matrix):
    from scipy.sparse.linalg import splu

    return splu(matrix.tocsc()).solve


def cholmod(matrix):
    import scipy.sparse as sparse
    import sinew_peers

    factor = sinew_peers.Cholmod(sparse.tril(matrix, format="csc"))
    factor.factorize()

    def solve(b: np.ndarray) -> np.ndarray:
        factor.solve(np.asfortranarray(b))
        return np.array(factor.solution)

    return solve


def pardiso(matrix):
    import scipy.sparse as sparse
    from pypardiso import PyPardisoSolver

    solver, upper = PyPardisoSolver(mtype=2), sparse.triu(matrix, format="csr")
    solver.factorize(upper)
    return lambda b: solver.solve(upper, b)


def pyamg(matrix):
    from pyamg import smoothed_aggregation_solver

    grid = smoothed_aggregation_solver(matrix.tocsr())
    columns = partial(grid.solve, tol=1e-6, accel="cg", maxiter=500)
    return lambda b: np.stack([columns(b[:, k]) for k in range(3)], 1)


CG = {"solver": "conjugate_gradients", "tolerance": 1e-3, "preconditioner": "shifted_incomplete_cholesky"}
WAYS: dict[str, Way] = {
    "CG": partial(ours, **CG),
    "MG": partial(ours, solver="multigrid", tolerance=1e-5),
    "LU": partial(ours, solver="lu"),
    "LLT": partial(ours, solver="cholesky"),
    "CHOLMOD": partial(factorised, cholmod),
    "PARDISO": partial(factorised, pardiso),
    "pyamg": partial(factorised, pyamg),
    "SuperLU": partial(factorised, super_lu),
}


def one(order: int, count: int, name: str) -> dict[str, float]:
    """Seconds of a solver, and how far its solution is off."""
    given, setup = system(order, count)
    once, each, x = WAYS[name](given)
    truth = ours(given, solver="cholesky")[2]
    off = float(np.abs(x - truth).max() / np.abs(truth).max())
    return {"unknowns": len(x), "setup": setup, "once": once, "each": each, "off": off}


def measured(order: int, count: int, name: str) -> dict[str, float] | None:
    words = [sys.executable, __file__, "--one", str(order), str(count), name]
    try:
        run = subprocess.run(words, capture_output=True, text=True, timeout=SECONDS)
        found = json.loads(run.stdout.splitlines()[-1])
    except (subprocess.TimeoutExpired, IndexError, json.JSONDecodeError):
        return None
    return found if found["off"] < WRONG else None


def number(seconds: float) -> str:
    digits = max(0, 1 - math.floor(math.log10(seconds)))  # two that count
    return f"{seconds:.{digits}f}".lstrip("0")


def table(order: int, found: dict[tuple[int, str], dict[str, float] | None], sizes: Iterable[int]) -> str:
    lines = [f"## {NAMES[order]}", "", f"| unknowns | {' | '.join(WAYS)} |", "|---" * (len(WAYS) + 1) + "|"]
    for count in sizes:
        cells = [found[count, name] for name in WAYS]
        words = [
            "-" if cell is None else " / ".join(number(cell[key]) for key in ("setup", "once", "each"))
            for cell in cells
        ]
        lines.append(f"| {count // 1000}k | {' | '.join(words)} |")
        there = [dict(zip(SIZES, TUTORIAL[order].get(name, ()))).get(count, "") for name in WAYS]
        if any(there):
            lines.append(f"| *there* | {' | '.join(there)} |")
    return "\n".join(lines)


def main(sizes: Iterable[int]) -> None:
    sizes, parts = list(sizes) or SIZES, []
    for order in NAMES:
        found = {}
        for count in sizes:
            for name in WAYS:
                found[count, name] = measured(order, count, name)
                print(order, count, name, found[count, name], flush=True)
        parts.append(table(order, found, sizes))
    head = PAGE.read_text(encoding="utf-8").partition("## ")[0]
    PAGE.write_text(head + "\n\n".join(parts) + "\n", encoding="utf-8")


if __name__ == "__main__":
    if sys.argv[1] == "--one":
        print(json.dumps(one(int(sys.argv[2]), int(sys.argv[3]), sys.argv[4])))
    else:
        main(int(word) for word in sys.argv[1:] if word.isdigit())
