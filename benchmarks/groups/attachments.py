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

Parts = tuple[np.ndarray, np.ndarray]  # points and triangles


def plan(options: Options) -> list[Task]:
    size = 10_000 if options.quick else 100_000
    keywords = {"size": size, "threads": options.threads}
    return [
        Task("attachments", ("attachments_bind", "attachments_frame"), {**keywords, "loose": loose})
        for loose in LOOSE_PARTS
    ]


def measure(size: int, threads: list[int], loose: str) -> list[Row]:
    points, faces, handles = _sheet(size)
    more, more_faces = LOOSE_PARTS[loose](size)
    mesh = sinew_native.SurfaceMesh(
        np.concatenate([points, more]), np.concatenate([faces, len(points) + more_faces])
    )
    poses = np.stack([STILL, np.column_stack([turn((0, 1, 0), -90), (2.0, 0.0, 5.0)])])
    shells = {choice: sinew_native.ThinShell(mesh) for choice in ("stay", "follow")}
    arap = sinew_native.Arap(mesh)
    arap.set_handles(handles)
    rows: list[Row] = []
    for count in threads:
        binds = {choice: _bind(shells[choice], handles, choice, count) for choice in shells}
        alternate(binds, budget=6.0, most=6)
        frames = {
            name: Work(
                lambda made=made: made.solve(poses), lambda count=count: sinew_native.limit_threads(count)
            )
            for name, made in {**shells, "arap": arap}.items()
        }
        alternate(frames)
        common = {"size": size, "threads": count, "vertices": mesh.vertex_count, "unit": "s"}
        bind = {"work": "attachments_bind", "case": loose, "ours": _added(binds), "peer": MOST_BIND}
        rows.append({**bind, **common})
        # They take as long with every method, and beside `Arap` the difference would be lost in its noise.
        rows += [
            {
                "work": "attachments_frame",
                "case": f"{method}, {loose}",
                "ours": _added(frames),
                "peer": best,
                **common,
            }
            for method, best in (("thin_shell", frames["stay"].best), ("arap", frames["arap"].best))
        ]
    return rows


def _added(works: dict[str, Work]) -> float:
    return max(works["follow"].best - works["stay"].best, 1e-9)


def _bind(shell: sinew_native.ThinShell, handles: list[np.ndarray], choice: str, threads: int) -> Work:
    def prepare() -> None:
        sinew_native.limit_threads(threads)
        shell.set_handles(handles)  # so that no attachments can be kept

    return Work(lambda: shell.set_handles(handles, free_parts=choice), prepare, repeatable=False)


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
