# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of the surface methods with few unknowns, next to the time that is wanted at 100,000 vertices.

Their iterations do not grow with the mesh; what does is one product, which memory limits.
"""

import numpy as np
from cases import bar
from record import Row
from timing import Work, alternate, rounds

import sinew_native

from . import Options, Task

WANTED = {"isolines_frame": 0.010, "subspace_frame": 0.020}  # seconds, at 100,000 vertices
CLASSES = {"isolines_frame": "HandleAwareIsolines", "subspace_frame": "SubspaceLaplacian"}
LONG_RUN = {"max_iterations": 2000, "tolerance": 1e-12}
CLOSE = 0.01  # of the root mean square of all moves


def plan(options: Options) -> list[Task]:
    size = 3_000 if options.smallest else 100_000
    keywords = {"size": size, "threads": options.threads}
    return [Task("reduced", (work, f"{work[:-6]}_iterations"), {"work": work, **keywords}) for work in WANTED]


def measure(work: str, size: int, threads: list[int]) -> list[Row]:
    rows = []
    for pose in ("bend 90", "twist 135"):
        case = bar(pose, size)
        method = getattr(sinew_native, CLASSES[work])(sinew_native.SurfaceMesh(case.points, case.faces))
        report = method.set_handles(case.handles)
        works = {
            count: Work(
                lambda method=method, case=case: method.solve(case.poses),
                lambda count=count: sinew_native.limit_threads(count),
            )
            for count in threads
        }
        alternate(works, budget=4.0, least=rounds(size))
        found = method.solve(case.poses)[1]
        about = {"vertices": case.vertex_count, "pose": pose, "iterations": found.iterations}
        about |= {"bind_seconds": report.seconds, "factor_bytes": report.factor_bytes}
        rows += [
            {"work": work, "size": size, "unit": "s", "threads": count, **about}
            | {"ours": works[count].best, "ours_median": works[count].median, "peer": WANTED[work]}
            for count in threads
        ]
        fewest = iterations_to(method, case)
        rows.append(
            {"work": f"{work[:-6]}_iterations", "size": size, "unit": "iterations", "threads": threads[-1]}
            | {"vertices": case.vertex_count, "pose": pose, "ours": fewest, "peer": 12}
        )
    return rows


def iterations_to(method: object, case: object) -> int:
    """The least number of iterations from which on the shape stays close to the converged one."""
    end = method.solve(case.poses, **LONG_RUN)[0]
    size = np.sqrt(((end - case.points) ** 2).sum(1).mean())
    for count in range(200):
        shape = method.solve(case.poses, max_iterations=count, tolerance=0.0)[0]
        if np.sqrt(((shape - end) ** 2).sum(1).mean()) <= CLOSE * size:
            return max(count, 1)
    raise SystemExit(f"{type(method).__name__} does not come close to its converged shape")
