# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of the nonlinear space methods.

Embedded deformation is measured next to Gauss-Newton steps on the paper's energy in SciPy, as Open3D takes
them: from rest, each assembles and factorises the normal equations, until the shape is within 1 % of the
limit; then SciPy's sparse product moves the points. Rigid cells are measured next to a frame of `Arap`.
"""

import numpy as np
from cases import Case, bar
from embedded_graph import PaperEnergy
from record import Row
from scipy import sparse
from timing import Work, alternate, rounds

import sinew_native

from . import Options, Task

NODES, CELLS = 500, 2000
DRAG_SECONDS = 0.020
WITHIN = 0.01  # of how far the points move
POSES = ("bend 90", "twist 135")


def plan(options: Options) -> list[Task]:
    graph = {"size": 2_000 if options.smallest else 100_000, "nodes": 40 if options.smallest else NODES}
    cells = {"size": 2_000 if options.smallest else 50_000, "cells": 100 if options.smallest else CELLS}
    return [
        Task(
            "space_nonlinear",
            ("embedded_frame", "embedded_drag", "embedded_steps"),
            {"part": "graph", "threads": options.threads, **graph},
        ),
        Task("space_nonlinear", ("cells_frame",), {"part": "cells", "threads": options.threads, **cells}),
    ]


def measure(part: str, size: int, threads: list[int], **keywords: int) -> list[Row]:
    run = {"graph": _graph, "cells": _cells}[part]
    return [
        {"size": size, **row} for pose in POSES for row in run(bar(pose, size), pose, threads, **keywords)
    ]


def _bound(kind: type, case: Case, **options: int) -> object:
    held = [case.points[handle] for handle in case.handles]
    mesh = sinew_native.SurfaceMesh(case.points, case.faces)
    method = kind(mesh, np.concatenate(held), [len(own) for own in held], **options)
    method.bind(case.points)
    return method


def _timed(method: object, case: Case, threads: list[int]) -> dict[int, Work]:
    out = np.empty(case.points.shape, np.float32)
    works = {
        count: Work(
            lambda: method.warp_poses(case.poses, out=out),
            lambda count=count: sinew_native.limit_threads(count),
        )
        for count in threads
    }
    alternate(works, budget=3.0, least=rounds(len(case.points)))
    return works


def _graph(case: Case, pose: str, threads: list[int], nodes: int) -> list[Row]:
    method = _bound(sinew_native.EmbeddedDeformation, case, nodes=nodes)
    works = _timed(method, case, threads)
    graph = method.graph()
    maps = case.poses[graph["pull_handles"]]
    targets = np.einsum("pij,pj->pi", maps[:, :, :3], graph["pulls"]) + maps[:, :, 3]
    weights = sparse.csr_matrix(method.weights())
    by_nodes, by_handles = weights[:, : len(graph["nodes"])], weights[:, len(graph["nodes"]) :]
    moved = [case.points @ own[:, :3].T + own[:, 3] for own in case.poses]
    paper = PaperEnergy(graph, targets)

    def shown(nodes: np.ndarray) -> np.ndarray:
        shape = paper.warped(nodes, case.points, by_nodes)
        for handle, own in enumerate(moved):
            shape += by_handles[:, [handle]].multiply(own)
        return shape

    iterates = list(paper.iterates(60))
    limit = shown(iterates[-1])
    size = np.linalg.norm(limit - case.points)
    close = [np.linalg.norm(shown(nodes) - limit) <= WITHIN * size for nodes in iterates]
    steps = 1 + close.index(True)
    peer = alternate({"": Work(lambda: shown(paper.gauss_newton(steps)))}, budget=10.0, least=1)[""]
    apart = np.linalg.norm(method.warp_poses(case.poses) - limit) / size
    if apart > WITHIN:
        raise SystemExit(f"a frame is {apart:.3f} of its moves away from the limit of Gauss-Newton")
    report = method.report_for(case.poses)
    about = {"vertices": len(case.points), "pose": pose, "nodes": len(graph["nodes"]), "apart": float(apart)}
    rows: list[Row] = [
        {"work": work, "unit": "s", "threads": count, "ours": works[count].best, "peer": wanted, **about}
        for count in threads
        for work, wanted in (("embedded_frame", peer.best), ("embedded_drag", DRAG_SECONDS))
    ]
    rows.append({"work": "embedded_steps", "unit": "", "ours": report.iterations, "peer": steps, **about})
    return rows


def _cells(case: Case, pose: str, threads: list[int], cells: int) -> list[Row]:
    method = _bound(sinew_native.RigidCells, case, cells=cells)
    works = _timed(method, case, threads)
    arap = sinew_native.Arap(sinew_native.SurfaceMesh(case.points, case.faces))
    arap.set_handles(case.handles)
    peers = {
        count: Work(lambda: arap.solve(case.poses), lambda count=count: sinew_native.limit_threads(count))
        for count in threads
    }
    alternate(peers, budget=4.0, least=rounds(len(case.points)))
    about = {"vertices": len(case.points), "pose": pose, "cells": len(method.cells()["sides"])}
    about["iterations"] = method.report_for(case.poses).iterations
    return [
        {"work": "cells_frame", "unit": "s", "threads": count, **about}
        | {"ours": works[count].best, "peer": peers[count].best}
        for count in threads
    ]
