# SPDX-License-Identifier: GPL-3.0-or-later
"""What loose parts that follow add to a bind and to a frame: scales, and loose vertices, over a sheet."""

from collections.abc import Callable

import numpy as np
from cases import STILL, box, turn
from record import Row
from timing import Work, alternate

import sinew_native

from . import Options, Task

VERTICES_PER_SHELL = 50  # of the sheet
VERTICES_PER_LOOSE_ONE = 5  # likewise
MOST_BIND = 1.0  # seconds
SIDE = 10.0
METHODS = {"thin_shell": sinew_native.ThinShell, "arap": sinew_native.Arap}

Parts = tuple[np.ndarray, np.ndarray]  # points and triangles


def plan(options: Options) -> list[Task]:
    size = 10_000 if options.quick else 100_000
    keywords = {"size": size, "threads": options.threads}
    return [
        Task("riders", ("riders_bind", "riders_frame"), {**keywords, "loose": loose}) for loose in LOOSE_PARTS
    ]


def measure(size: int, threads: list[int], loose: str) -> list[Row]:
    points, faces, handles = _sheet(size)
    more, more_faces = LOOSE_PARTS[loose](size)
    mesh = sinew_native.SurfaceMesh(
        np.concatenate([points, more]), np.concatenate([faces, len(points) + more_faces])
    )
    poses = np.stack([STILL, np.column_stack([turn((0, 1, 0), -90), (2.0, 0.0, 5.0)])])
    rows: list[Row] = []
    for name, method in METHODS.items():
        made = {choice: method(mesh) for choice in ("stay", "follow")}
        for count in threads:
            binds = {choice: _bind(made[choice], handles, choice, count) for choice in made}
            if name == "thin_shell":
                alternate(binds, budget=6.0, most=6)
            else:  # what parts that follow add is the same
                for work in binds.values():
                    work.turn()
            frames = {
                choice: Work(
                    lambda one=one: one.solve(poses), lambda count=count: sinew_native.limit_threads(count)
                )
                for choice, one in made.items()
            }
            alternate(frames)
            common = {"size": size, "threads": count, "vertices": mesh.vertex_count, "unit": "s"}
            if name == "thin_shell":
                rows.append(
                    {"work": "riders_bind", "case": loose, **common, **_added(binds), "peer": MOST_BIND}
                )
            rows.append(
                {
                    "work": "riders_frame",
                    "case": f"{name}, {loose}",
                    **common,
                    **_added(frames),
                    "peer": frames["stay"].best,
                }
            )
    return rows


def _added(works: dict[str, Work]) -> dict[str, float]:
    return {
        "ours": max(works["follow"].best - works["stay"].best, 1e-9),
        "median": max(works["follow"].median - works["stay"].median, 1e-9),
        "without": works["stay"].best,
    }


def _bind(made: object, handles: list[np.ndarray], choice: str, threads: int) -> Work:
    def prepare() -> None:
        sinew_native.limit_threads(threads)
        made.set_handles(handles)  # so that no riders can be kept

    return Work(lambda: made.set_handles(handles, free_parts=choice), prepare, repeatable=False)


def _sheet(size: int) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """A square sheet with about ``size`` vertices, and its ends along x."""
    n = round(np.sqrt(size))
    x, y = np.meshgrid(*[np.linspace(0, SIDE, n)] * 2, indexing="ij")
    sheet = np.stack([x, y, 0 * x], -1).reshape(-1, 3)
    v = np.arange(n * n).reshape(n, n)
    a, b, c, d = (part.ravel() for part in (v[:-1, :-1], v[1:, :-1], v[1:, 1:], v[:-1, 1:]))
    ends = [np.flatnonzero(sheet[:, 0] < 0.03 * SIDE), np.flatnonzero(sheet[:, 0] > 0.97 * SIDE)]
    return sheet, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]), ends


def _shells(size: int) -> Parts:
    """Rows of tilted scales."""
    count = size // VERTICES_PER_SHELL
    columns = round(np.sqrt(count))
    pitch = SIDE / columns
    shell, shell_faces = box((pitch, 0.8 * pitch, 0.1 * pitch), 0.3 * pitch)
    shell = (shell - (pitch / 2, 0, 0)) @ turn((0, 1, 0), -7).T
    k = np.arange(count)[:, None]
    places = np.concatenate(
        [k % columns + 0.5, (k // columns + 0.5) * columns / (count / columns), 0 * k + 0.15], 1
    )
    points = (shell + pitch * places[:, None]).reshape(-1, 3)
    return points, (shell_faces + len(shell) * k[:, None]).reshape(-1, 3)


def _vertices(size: int) -> Parts:
    """A scan's dust: half of it close to the sheet, the rest up to half its side above."""
    random = np.random.default_rng(0)
    count = size // VERTICES_PER_LOOSE_ONE
    above = np.where(np.arange(count) % 2, random.random(count) ** 2, 0.01 * random.random(count))
    points = np.column_stack([SIDE * random.random((count, 2)), SIDE / 2 * above])
    return points, np.empty((0, 3), int)


LOOSE_PARTS: dict[str, Callable[[int], Parts]] = {"shells": _shells, "loose vertices": _vertices}
