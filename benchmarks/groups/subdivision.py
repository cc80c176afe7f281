# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh refined to a million vertices every frame, next to OpenSubdiv's evaluator and Blender's modifier.

A frame of Blender moves the vertices of the mesh and evaluates its Subdivision modifier. The row
``subdivision_blender`` compares it with the refinement alone; the row ``subdivision_frame`` adds the time
that Blender takes to write and evaluate the refined mesh.
"""

from pathlib import Path

import numpy as np
from record import Row
from timing import Work, alternate

import sinew_native

from . import Options, Task

SIDE, LEVEL = 128, 3  # quads along a side, splits: 1,050,625 refined vertices
SIZE = 1_000_000
SCRIPT = Path(__file__).resolve().parents[1] / "subdivision_frame.py"


def plan(options: Options) -> list[Task]:
    tasks = [Task("subdivision", ("subdivision",), {"threads": options.threads})]
    works = ("subdivision_blender", "subdivision_frame")
    blender = Task("subdivision", works, {"threads": None, "small": options.smallest})
    return tasks if options.quick and not options.smallest else [*tasks, blender]


def sheet() -> tuple[np.ndarray, np.ndarray]:
    """Points float32 and quads of a bumpy sheet."""
    y, x = np.meshgrid(*[np.linspace(-1.0, 1.0, SIDE + 1)] * 2, indexing="ij")
    points = np.stack((x, y, 0.1 * np.sin(9.0 * x) * np.cos(7.0 * y)), axis=-1)
    number = np.arange((SIDE + 1) ** 2, dtype=np.int32).reshape(SIDE + 1, SIDE + 1)
    quads = np.stack((number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]), axis=-1)
    return points.reshape(-1, 3).astype(np.float32), quads.reshape(-1, 4)


def measure(threads: list[int] | None, small: bool = False) -> list[Row]:
    return _next_to_blender(small) if threads is None else _next_to_evaluator(threads)


def _next_to_evaluator(threads: list[int]) -> list[Row]:
    import sinew_peers

    points, quads = sheet()
    peer = sinew_peers.StencilEvaluator(len(points), quads, LEVEL)
    ours = sinew_native.SubdivisionSurface(sinew_native.SurfaceMesh(points, quads), level=LEVEL)
    out = np.empty((ours.vertex_count, 3), np.float32)
    peer.refine(points)
    if np.abs(peer.result - ours.refine(points, out)).max() > 1e-5:
        raise SystemExit("the points of Sinew and of OpenSubdiv differ")
    works = {"peer": Work(lambda: peer.refine(points))}
    for count in threads:
        works[count] = Work(
            lambda: ours.refine(points, out), lambda count=count: sinew_native.limit_threads(count)
        )
    alternate(works, budget=12.0, most=40)
    row = {"work": "subdivision", "size": SIZE, "vertices": ours.vertex_count, "unit": "s"}
    return [
        {**row, "threads": count, "ours": works[count].best, "peer": works["peer"].best} for count in threads
    ]


def _next_to_blender(small: bool) -> list[Row]:
    from .blender import run_in

    found = run_in("3.4", SCRIPT, ["--small"] if small else [])
    return [{**row, "size": SIZE, "unit": "s"} for row in found]
