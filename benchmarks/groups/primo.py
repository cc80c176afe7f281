# SPDX-License-Identifier: GPL-3.0-or-later
"""Primo: an iteration next to one of `Arap`, the iterations of a frame, and two peers on the same energy.

The peers are joint Gauss-Newton steps with six unknowns per face, of which CHOLMOD's factor and solve are
counted alone, and the paper's shape matching for single prisms in NumPy. Both begin at Primo's own start.
"""

import time

import numpy as np
import sinew_peers
from cases import Case, bar
from meshes import spread
from prisms import Prisms
from record import Row
from scipy import sparse
from timing import Work, alternate, rounds

import sinew_native

from . import Options, Task

SHORT, LONG = 2, 12  # numbers of iterations; the difference of their times is measured
DEEP = {"max_iterations": 1000, "tolerance": 1e-12}
WITHIN = 0.01  # of how far the surface moves
PEER_SIZE, LARGEST = 10_000, 200_000
SWEEPS = 60
FRAME_SECONDS = 0.15


def plan(options: Options) -> list[Task]:
    tasks = []
    for size in (*options.sizes, *options.own_sizes):
        keywords = {"size": size, "threads": options.threads}
        tasks.append(Task("primo", ("primo_iteration",), {"part": "iteration", **keywords}))
        if size <= LARGEST:
            tasks.append(Task("primo", ("primo_steps", "primo_frame"), {"part": "steps", **keywords}))
    size = 500 if options.smallest else 2_000 if options.quick else PEER_SIZE
    tasks.append(
        Task("primo", ("primo_joint", "primo_matching"), {"part": "peers", "size": size, "threads": [1]})
    )
    return tasks


def measure(part: str, size: int, threads: list[int]) -> list[Row]:
    run = {"iteration": _iteration, "steps": _steps, "peers": _peers}[part]
    return [{"size": size, **row} for row in run(size, threads)]


def _bound(kind: type, case: Case) -> object:
    method = kind(sinew_native.SurfaceMesh(case.points, case.faces))
    method.set_handles(case.handles)
    return method


def _iteration(size: int, threads: list[int]) -> list[Row]:
    case = bar("bend 90", size)
    works: dict[tuple, Work] = {}
    for kind in (sinew_native.Primo, sinew_native.Arap):
        method = _bound(kind, case)
        start = method.solve(case.poses, max_iterations=0)[0]
        for budget in (SHORT, LONG):

            def solve(method=method, start=start, budget=budget) -> None:
                method.solve(case.poses, start=start, max_iterations=budget, tolerance=0.0)

            for count in threads:
                works[kind, count, budget] = Work(
                    solve, lambda count=count: sinew_native.limit_threads(count)
                )
    alternate(works, budget=6.0, least=rounds(case.vertex_count))

    def iteration(kind: type, count: int) -> float:
        return (works[kind, count, LONG].best - works[kind, count, SHORT].best) / (LONG - SHORT)

    return [
        {
            "work": "primo_iteration",
            "unit": "s",
            "threads": count,
            "vertices": case.vertex_count,
            "ours": iteration(sinew_native.Primo, count),
            "peer": iteration(sinew_native.Arap, count),
        }
        for count in threads
    ]


def _steps(size: int, threads: list[int]) -> list[Row]:
    """Iterations from the poses alone to 1 % of the limit, the worse of a bend and a twist; and a frame."""
    sinew_native.limit_threads(0)
    rows: list[Row] = []
    worst, seconds = 0, 0.0
    for pose in ("bend 90", "twist 135"):
        case = bar(pose, size)
        primo = _bound(sinew_native.Primo, case)
        limit = primo.solve(case.poses, **DEEP)[0]
        moved = np.linalg.norm(limit - case.points)
        steps = 0
        while np.linalg.norm(_after(primo, case, steps) - limit) > WITHIN * moved:
            steps += 1
        worst = max(worst, steps)
        frame = alternate({"": Work(lambda primo=primo, case=case: primo.solve(case.poses))}, budget=2.0)[""]
        seconds = max(seconds, frame.best)
    about = {"unit": "", "vertices": case.vertex_count}
    rows.append({"work": "primo_steps", "ours": worst, "peer": 1, **about})
    rows.append(
        {
            "work": "primo_frame",
            "ours": seconds,
            "peer": FRAME_SECONDS,
            **about,
            "unit": "s",
            "threads": threads[-1],
        }
    )
    return rows


def _after(primo: object, case: Case, steps: int) -> np.ndarray:
    return primo.solve(case.poses, max_iterations=steps, tolerance=0.0)[0]


def _peers(size: int, threads: list[int]) -> list[Row]:
    sinew_native.limit_threads(threads[0])
    case = bar("bend 90", size)
    primo = _bound(sinew_native.Primo, case)
    start = primo.solve(case.poses, max_iterations=0)[0]
    limit, report = primo.solve(case.poses, **DEEP)
    begin = time.perf_counter()
    iterations = 10
    primo.solve(case.poses, start=start, max_iterations=iterations, tolerance=0.0)
    ours = (time.perf_counter() - begin) / iterations
    height = 0.05 * spread(case.points, case.faces)

    spent: list[float] = []

    def solve(H: sparse.csc_matrix, rhs: np.ndarray) -> np.ndarray:
        lower = sparse.tril(H, format="csc")
        lower.sort_indices()
        begin = time.perf_counter()
        factor = sinew_peers.Cholmod(lower.indptr, lower.indices, lower.data, "nesdis")
        factor.factorize()
        factor.solve(np.asfortranarray(rhs.reshape(-1, 1)))
        spent.append(time.perf_counter() - begin)
        return factor.solution.ravel()

    joint = Prisms(case.points, case.faces, case.handles, case.poses, height)
    joint.start_from(start)
    energy = joint.gauss_newton(steps=12, solve=solve)
    about = {"unit": "s", "threads": threads[0], "vertices": case.vertex_count}
    rows: list[Row] = [
        {
            "work": "primo_joint",
            "ours": ours,
            "peer": float(np.mean(spent)),
            "peer_steps": len(spent),
            "energy_apart": abs(energy / report.energy - 1),
            **about,
        }
    ]
    single = Prisms(case.points, case.faces, case.handles, case.poses, height)
    single.start_from(start)
    sweeps = 2 if size < 1_000 else SWEEPS
    begin = time.perf_counter()
    single.shape_matching(sweeps)
    rows.append(
        {
            "work": "primo_matching",
            "ours": ours,
            "peer": (time.perf_counter() - begin) / sweeps,
            "peer_sweeps": sweeps,
            "peer_away_percent": 100
            * float(np.linalg.norm(single.vertices() - limit) / np.linalg.norm(limit - case.points)),
            **about,
        }
    )
    return rows
