# SPDX-License-Identifier: GPL-3.0-or-later
"""The nonlinear thin shell: an iteration next to one of ARAP, a frame, and Gauss-Newton on its energy."""

import numpy as np
from cases import Case, bar
from joint_shell import JointShell
from meshes import spread
from record import Row
from scipy import sparse
from timing import Work, alternate, rounds

import sinew_native

from . import Options, Task
from .arap import LONG, SHORT, bound, set_threads
from .thin_shell import cholmod

FRAME = 0.15  # seconds that a frame may take with 50,000 vertices on two threads
POSES = ("bend 90", "twist 135")
SAME = 1e-4  # the relative difference of energies that count as the same
CONVERGED = {"max_iterations": 1500, "tolerance": 1e-13}


def plan(options: Options) -> list[Task]:
    tasks = []
    for size in (*options.sizes, *options.own_sizes):
        if size <= 200_000:
            keywords = {"size": size, "threads": options.threads}
            tasks.append(Task("shell", ("shell_iteration",), {"part": "iteration", **keywords}))
            tasks += [
                Task("shell", ("shell_frame",), {"part": "frame", "pose": p, **keywords}) for p in POSES
            ]
    size = 2_000 if options.smallest else 10_000
    joint = {"part": "joint", "size": size, "threads": options.threads}
    return [*tasks, Task("shell", ("shell_joint",), joint)]


def measure(part: str, size: int, threads: list[int], pose: str = "bend 90") -> list[Row]:
    rows = {"iteration": _iteration, "frame": _frame, "joint": _joint}[part](bar(pose, size), threads)
    return [{"size": size, "unit": "s", **row} for row in rows]


def bound_shell(case: Case) -> "sinew_native.ThinShellNonlinear":
    shell = sinew_native.ThinShellNonlinear(sinew_native.SurfaceMesh(case.points, case.faces))
    shell.set_handles(case.handles)
    return shell


def _iteration(case: Case, threads: list[int]) -> list[Row]:
    methods = {"shell": bound_shell(case), "arap": bound(case, smoothness=0.0)}
    works: dict[tuple, Work] = {}
    for name, method in methods.items():
        start = method.solve(case.poses, max_iterations=0)[0]
        for budget in (SHORT, LONG):

            def solve(method=method, start=start, budget=budget) -> None:
                method.solve(case.poses, start=start, max_iterations=budget, tolerance=0.0)

            works |= {(name, count, budget): Work(solve, set_threads(count)) for count in threads}
    alternate(works, budget=8.0, least=rounds(case.vertex_count))

    def iteration(*key: object) -> float:
        return (works[*key, LONG].best - works[*key, SHORT].best) / (LONG - SHORT)

    return [
        {
            "work": "shell_iteration",
            "threads": count,
            "vertices": case.vertex_count,
            "ours": iteration("shell", count),
            "peer": iteration("arap", count),
        }
        for count in threads
    ]


def _frame(case: Case, threads: list[int]) -> list[Row]:
    shell = bound_shell(case)
    limit, _ = shell.solve(case.poses, **CONVERGED)
    size = np.linalg.norm(limit - case.points)

    def away(shape: np.ndarray) -> float:
        return float(np.linalg.norm(shape - limit) / size)

    def after(budget: int) -> np.ndarray:
        return shell.solve(case.poses, max_iterations=budget, tolerance=0.0)[0]

    to_one_percent = next(k for k in range(CONVERGED["max_iterations"]) if away(after(k)) <= 0.01)
    shape, report = shell.solve(case.poses)
    works = alternate(
        {count: Work(lambda: shell.solve(case.poses), set_threads(count)) for count in threads},
        least=rounds(case.vertex_count),
    )
    return [
        {
            "work": "shell_frame",
            "pose": case.name,
            "threads": count,
            "vertices": case.vertex_count,
            "ours": works[count].best,
            "peer": FRAME,
            "iterations": report.iterations,
            "away_percent": 100 * away(shape),
            "iterations_to_one_percent": to_one_percent,
        }
        for count in threads
    ]


def _joint(case: Case, threads: list[int]) -> list[Row]:
    """From the start of the method to an energy that is the same."""
    shell = bound_shell(case)
    start, _ = shell.solve(case.poses, max_iterations=0)
    thickness = 0.02 * spread(case.points, case.faces)
    joint = JointShell(case.points, case.faces, np.concatenate(case.handles), 1.0, thickness**2)

    def by_cholmod(matrix: sparse.csc_matrix):
        factor = cholmod(sparse.tril(matrix, format="csc"))
        factor.factorize()

        def solve(rhs: np.ndarray) -> np.ndarray:
            factor.solve(rhs.reshape(-1, 1))
            return factor.solution.ravel()

        return solve

    _, least, _ = joint.minimize(start, by_cholmod, tolerance=1e-9)
    least = min(least, shell.solve(case.poses, **CONVERGED)[1].energy)

    def energy(budget: int) -> float:
        return shell.solve(case.poses, max_iterations=budget, tolerance=0.0)[1].energy

    ours = next(k for k in range(CONVERGED["max_iterations"]) if energy(k) <= (1 + SAME) * least)
    theirs = next(k for k in range(100) if joint.minimize(start, by_cholmod, k, 0.0)[1] <= (1 + SAME) * least)
    hessian = joint.hessian(start)
    hessian = hessian + 1e-9 * hessian.diagonal().mean() * sparse.identity(hessian.shape[0], format="csc")
    right = joint.gradient(start)[joint.free].ravel()
    works: dict[object, Work] = {
        count: Work(lambda: shell.solve(case.poses, max_iterations=ours, tolerance=0.0), set_threads(count))
        for count in threads
    }
    works["alone"] = Work(lambda: by_cholmod(hessian)(right))
    works["whole"] = Work(lambda: joint.minimize(start, by_cholmod, theirs, 0.0))
    alternate(works)
    peers = {
        "its factors and solves alone": theirs * works["alone"].best,
        "its whole steps, assembled by NumPy": works["whole"].best,
    }
    return [
        {
            "work": "shell_joint",
            "case": case_of_peer,
            "threads": count,
            "vertices": case.vertex_count,
            "ours": works[count].best,
            "peer": seconds,
            "iterations": ours,
            "peer_iterations": theirs,
        }
        for case_of_peer, seconds in peers.items()
        for count in threads
    ]
