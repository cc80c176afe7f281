# SPDX-License-Identifier: GPL-3.0-or-later
"""What loose parts that follow add to a bind and to a frame: scales on a sheet, next to fixed limits."""

import numpy as np
from cases import STILL, box, turn
from record import Row
from timing import Work, alternate

import sinew_native

from . import Options, Task

VERTICES_PER_SHELL = 50  # of the sheet
LIMITS = {"riders_bind": 1.0, "riders_frame": 3e-3}  # seconds, for 2,000 shells
SIDE = 10.0


def plan(options: Options) -> list[Task]:
    size = 10_000 if options.quick else 100_000
    return [Task("riders", tuple(LIMITS), {"size": size, "threads": options.threads})]


def measure(size: int, threads: list[int]) -> list[Row]:
    points, faces, handles = _scaled_sheet(size)
    mesh = sinew_native.SurfaceMesh(points, faces)
    poses = np.stack([STILL, np.column_stack([turn((0, 1, 0), -90), (2.0, 0.0, 5.0)])])
    rows: list[Row] = []
    for count in threads:
        shells = {choice: sinew_native.ThinShell(mesh) for choice in ("stay", "follow")}
        binds = {choice: _bind(shells[choice], handles, choice, count) for choice in shells}
        alternate(binds, budget=6.0, most=6)
        frames = {
            choice: Work(
                lambda shell=shell: shell.solve(poses), lambda count=count: sinew_native.limit_threads(count)
            )
            for choice, shell in shells.items()
        }
        alternate(frames)
        for work, works in (("riders_bind", binds), ("riders_frame", frames)):
            rows.append(
                {
                    "work": work,
                    "size": size,
                    "threads": count,
                    "vertices": mesh.vertex_count,
                    "unit": "s",
                    "ours": max(works["follow"].best - works["stay"].best, 1e-9),
                    "peer": LIMITS[work],
                    "without": works["stay"].best,
                }
            )
    return rows


def _bind(shell: sinew_native.ThinShell, handles: list[np.ndarray], choice: str, threads: int) -> Work:
    def prepare() -> None:
        sinew_native.limit_threads(threads)
        shell.set_handles(handles)  # so that no riders can be kept

    return Work(lambda: shell.set_handles(handles, free_parts=choice), prepare, repeatable=False)


def _scaled_sheet(size: int) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """A square sheet with about ``size`` vertices under rows of tilted scales, and its ends along x."""
    n = round(np.sqrt(size))
    x, y = np.meshgrid(*[np.linspace(0, SIDE, n)] * 2, indexing="ij")
    sheet = np.stack([x, y, 0 * x], -1).reshape(-1, 3)
    v = np.arange(n * n).reshape(n, n)
    a, b, c, d = (part.ravel() for part in (v[:-1, :-1], v[1:, :-1], v[1:, 1:], v[:-1, 1:]))
    faces = [np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])]
    count = size // VERTICES_PER_SHELL
    columns = round(np.sqrt(count))
    pitch = SIDE / columns
    shell, shell_faces = box((pitch, 0.8 * pitch, 0.1 * pitch), 0.3 * pitch)
    shell = (shell - (pitch / 2, 0, 0)) @ turn((0, 1, 0), -7).T
    points = [sheet]
    for k in range(count):
        place = (k % columns + 0.5, (k // columns + 0.5) * columns / (count / columns), 0.15)
        faces.append(len(sheet) + k * len(shell) + shell_faces)
        points.append(shell + pitch * np.array(place))
    ends = [np.flatnonzero(sheet[:, 0] < 0.03 * SIDE), np.flatnonzero(sheet[:, 0] > 0.97 * SIDE)]
    return np.concatenate(points), np.concatenate(faces), ends
