# SPDX-License-Identifier: GPL-3.0-or-later
"""Pyramid coordinates: an iteration next to one of ARAP, a whole frame, and how many iterations settle a bar.

The counts depend on no machine: iterations until the points are within 1 % of their way to the converged
shape, in the mean square, from the poses alone.
"""

import numpy as np
from cases import Case, bar
from record import Row
from timing import Work, alternate, rounds

import sinew_native

from . import Options, Task

POSES = ("bend 90", "twist 135")
SHORT, LONG = 2, 12  # numbers of iterations; the difference of their times is measured
MOST_ITERATIONS = 15  # that the method promises until it is settled
FRAME_SECONDS = 0.1  # that it promises for 50,000 vertices
LONG_RUN = {"max_iterations": 1500, "tolerance": 1e-10}
SETTLED = (2_000, 10_000, 50_000, 200_000)


def plan(options: Options) -> list[Task]:
    threads = {"threads": options.threads}
    tasks = [
        Task("pyramid", ("pyramid_iteration",), {"part": "iteration", "size": size, **threads})
        for size in (*options.sizes, *options.own_sizes)
    ]
    frame = min(options.sizes) if options.smallest else 50_000
    tasks.append(Task("pyramid", ("pyramid_frame",), {"part": "frame", "size": frame, **threads}))
    return tasks + [
        Task("pyramid", ("pyramid_settled",), {"part": "settled", "size": size})
        for size in (SETTLED[:1] if options.quick else SETTLED)
    ]


def measure(part: str, size: int, threads: tuple[int, ...] = ()) -> list[Row]:
    rows = {"iteration": _iteration, "frame": _frame}
    found = _settled(size) if part == "settled" else rows[part](bar("bend 90", size), threads)
    return [{"size": size, **row} for row in found]


def _bound(method: type, case: Case, **options: object) -> "sinew_native.SurfaceMethod":
    made = method(sinew_native.SurfaceMesh(case.points, case.faces), **options)
    made.set_handles(case.handles)
    return made


def _iteration(case: Case, threads: tuple[int, ...]) -> list[Row]:
    methods = {
        "ours": _bound(sinew_native.PyramidCoordinates, case),
        "peer": _bound(sinew_native.Arap, case, smoothness=0.0),
    }
    works: dict[tuple, Work] = {}
    for name, method in methods.items():
        start = method.solve(case.poses, max_iterations=0)[0]
        for budget in (SHORT, LONG):

            def solve(method=method, start=start, budget=budget) -> None:
                method.solve(case.poses, start=start, max_iterations=budget, tolerance=0.0)

            for count in threads:
                limit = lambda count=count: sinew_native.limit_threads(count)  # noqa: E731
                works[name, count, budget] = Work(solve, limit)
    alternate(works, budget=8.0, least=rounds(case.vertex_count))
    return [
        {
            "work": "pyramid_iteration",
            "unit": "s",
            "threads": count,
            "vertices": case.vertex_count,
            **{
                name: (works[name, count, LONG].best - works[name, count, SHORT].best) / (LONG - SHORT)
                for name in methods
            },
        }
        for count in threads
    ]


def _frame(case: Case, threads: tuple[int, ...]) -> list[Row]:
    method = _bound(sinew_native.PyramidCoordinates, case)
    works = {
        count: Work(lambda: method.solve(case.poses), lambda count=count: sinew_native.limit_threads(count))
        for count in threads
    }
    alternate(works)
    iterations = method.solve(case.poses)[1].iterations
    return [
        {
            "work": "pyramid_frame",
            "unit": "s",
            "threads": count,
            "vertices": case.vertex_count,
            "ours": works[count].best,
            "peer": FRAME_SECONDS,
            "iterations": iterations,
        }
        for count in threads
    ]


def _settled(size: int) -> list[Row]:
    rows = []
    for pose in POSES:
        case = bar(pose, size)
        method = _bound(sinew_native.PyramidCoordinates, case)
        limit, _ = method.solve(case.poses, **LONG_RUN)
        way = np.linalg.norm(limit - case.points)
        count = 0
        while count < 10 * MOST_ITERATIONS:
            reached, _ = method.solve(case.poses, max_iterations=count, tolerance=0.0)
            if np.linalg.norm(reached - limit) <= 0.01 * way:
                break
            count += 1
        rows.append(
            {
                "work": "pyramid_settled",
                "unit": "",
                "case": case.name,
                "vertices": case.vertex_count,
                "ours": max(count, 1),
                "peer": MOST_ITERATIONS,
            }
        )
    return rows
