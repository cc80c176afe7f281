# SPDX-License-Identifier: GPL-3.0-or-later
"""Cage coordinates with closed forms next to the loops of their papers, and warps next to BLAS."""

import numpy as np
import sinew_peers
from record import Row
from timing import Work, alternate

import sinew_native

from . import Options, Task

CAGES = {100: (14, 8), 300: (25, 13), 1000: (37, 28)}  # vertices -> meridians, parallels
POINTS = (10_000, 100_000)
SAMPLE = 30_000  # weights that the loops of the papers compute; each point takes them the same time
BINDS = {
    "mean_value_double": (sinew_native.MeanValue, "double"),
    "mean_value": (sinew_native.MeanValue, "single"),
    "green": (sinew_native.Green, "single"),
}
QUAD_WORKS = ("green_quads", "green_quads_frame")  # beside the same cage, cut into triangles


def plan(options: Options) -> list[Task]:
    sizes = POINTS[:1] if options.quick else POINTS
    return [
        Task("cages", works, {"work": works[0], "size": size, "cage": cage, "threads": options.threads})
        for works in (*((bind,) for bind in BINDS), ("cage_warp",), QUAD_WORKS)
        for size in sizes
        for cage in ((100,) if options.smallest else (300,) if options.quick else CAGES)
    ]


def bumpy_sphere(vertices: int) -> tuple[np.ndarray, np.ndarray]:
    """A closed sphere of triangles with bumps, of about that number of vertices."""
    around, down = CAGES[vertices]
    latitude = np.pi * np.arange(1, down)[:, None] / down
    longitude = 2 * np.pi * np.arange(around)[None] / around
    rings = np.stack(
        np.broadcast_arrays(
            np.sin(latitude) * np.cos(longitude), np.sin(latitude) * np.sin(longitude), np.cos(latitude)
        ),
        -1,
    )
    points = np.concatenate([[(0, 0, 1)], rings.reshape(-1, 3), [(0, 0, -1)]])
    index = 1 + np.arange((down - 1) * around).reshape(down - 1, around)
    a, b = index, np.roll(index, -1, axis=1)
    last = np.full(around, len(points) - 1)
    faces = [
        np.stack([np.zeros_like(last), a[0], b[0]], -1),
        np.stack([a[:-1], a[1:], b[1:]], -1).reshape(-1, 3),
        np.stack([a[:-1], b[1:], b[:-1]], -1).reshape(-1, 3),
        np.stack([last, b[-1], a[-1]], -1),
    ]
    bumps = np.random.default_rng(3).uniform(0.95, 1.05, (len(points), 1))
    return points * bumps, np.concatenate(faces).astype(np.int32)


def measure(work: str, size: int, cage: int, threads: list[int]) -> list[Row]:
    vertices, triangles = bumpy_sphere(cage)
    points = np.random.default_rng(0).uniform(-0.5, 0.5, (size, 3))
    if work in QUAD_WORKS:
        rows = _quads(cage, size, threads)
        common = {"size": size, "case": f"{size // 1000}k, cage of {cage}", "vertices": size, "unit": "s"}
        return [{**common, **row} for row in rows]
    if work == "cage_warp":
        rows = _warp(vertices, triangles, points, threads)
    else:
        rows = _bind(work, vertices, triangles, points, threads)
    common = {"size": size, "case": f"{size // 1000}k, cage of {cage}", "vertices": size, "unit": "s"}
    return [{"work": work, **common, **row} for row in rows]


def _bind(work: str, vertices, triangles, points, threads: list[int]) -> list[Row]:
    method, precision = BINDS[work]
    coordinates = method(sinew_native.SurfaceMesh(vertices, triangles), precision=precision)
    sample = points[:: max(1, len(points) * len(vertices) // SAMPLE)].copy()
    weights = np.zeros((len(sample), len(vertices)))
    faces = np.zeros((len(sample), len(triangles)))

    def peer() -> None:
        if method is sinew_native.Green:
            sinew_peers.green(vertices, triangles, sample, weights, faces)
        else:
            sinew_peers.mean_value(vertices, triangles, sample, weights)

    counts = threads[:1] if work == "mean_value_double" else threads
    works = {
        count: Work(
            lambda: coordinates.bind(points), lambda count=count: sinew_native.limit_threads(count), False
        )
        for count in counts
    }
    works["peer"] = Work(peer)
    alternate(works)
    coordinates.bind(sample)
    _require_equal(coordinates.vertex_weights, weights)
    share = len(points) / len(sample)
    return [
        {"threads": count, "ours": works[count].best, "peer": share * works["peer"].best} for count in counts
    ]


def _require_equal(ours: np.ndarray, peers: np.ndarray) -> None:
    """Stop if the results differ, since a wrong result must not be timed. Weights have single precision."""
    worst = np.abs(ours - peers).max()
    if not worst < 1e-6:
        raise SystemExit(f"the weights of Sinew and of the paper differ by {worst:.1e}")


def _warp(vertices, triangles, points, threads: list[int]) -> list[Row]:
    """Both compute positions in single precision from the posed cage, in arrays that exist already."""
    coordinates = sinew_native.MeanValue(sinew_native.SurfaceMesh(vertices, triangles))
    coordinates.bind(points)
    posed = vertices * (1.2, 1.0, 0.8) + (0.1, 0.2, 0.3)
    weights = coordinates.vertex_weights.astype(np.float32)
    factors = posed.astype(np.float32)
    ours = np.zeros((len(points), 3), np.float32)
    peers = np.zeros_like(ours)
    works = {
        count: Work(
            lambda: coordinates.warp(posed, out=ours), lambda count=count: sinew_native.limit_threads(count)
        )
        for count in threads
    }
    works["peer"] = Work(lambda: sinew_peers.sgemm(weights, factors, peers))
    alternate(works)
    _require_equal(ours / 10, peers / 10)
    return [
        {
            "threads": count,
            "ours": works[count].best,
            "ours_median": works[count].median,
            "peer": works["peer"].best,
        }
        for count in threads
    ]


def quad_ball(vertices: int) -> tuple[np.ndarray, np.ndarray]:
    """A closed ball of quads with bumps, none of them flat, of about that number of vertices."""
    cells = max(1, round((vertices / 6) ** 0.5))
    steps = np.tan(np.pi / 4 * (2 * np.arange(cells + 1) / cells - 1))
    corners: list[np.ndarray] = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            grid = np.empty((cells + 1, cells + 1, 3))
            grid[..., axis] = side
            grid[..., (axis + 1) % 3], grid[..., (axis + 2) % 3] = steps[:, None], steps[None]
            quads = np.stack((grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]), 2).reshape(
                -1, 4, 3
            )
            corners.append(quads if side > 0 else quads[:, ::-1])
    every = np.concatenate(corners).reshape(-1, 3)
    _, first, index = np.unique(np.round(every, 9), axis=0, return_index=True, return_inverse=True)
    points = every[first] / np.linalg.norm(every[first], axis=1, keepdims=True)
    bumps = np.random.default_rng(3).uniform(0.95, 1.05, (len(points), 1))
    return points * bumps, index.reshape(-1, 4).astype(np.int32)


def _quads(cage: int, size: int, threads: list[int]) -> list[Row]:
    """Points of a surface under the cage, of which each has some quads near it."""
    vertices, quads = quad_ball(cage)
    rng = np.random.default_rng(0)
    points = rng.normal(size=(size, 3))
    points *= rng.uniform(0.6, 0.88, (size, 1)) / np.linalg.norm(points, axis=1, keepdims=True)
    mesh = sinew_native.SurfaceMesh(vertices, quads)
    ours, theirs = (sinew_native.Green(mesh, faces=faces) for faces in ("quads", "triangles"))
    posed = vertices * (1.2, 1.0, 0.8) + (0.1, 0.2, 0.3)
    out = np.zeros((size, 3), np.float32)
    rows: list[Row] = []
    for work, call in (
        ("green_quads", lambda green: green.bind(points)),
        ("green_quads_frame", lambda green: green.warp(posed, out=out)),
    ):
        works = {
            f"{count} {faces}": Work(
                lambda green=green, call=call: call(green),
                lambda count=count: sinew_native.limit_threads(count),
            )
            for count in threads
            for faces, green in (("quads", ours), ("triangles", theirs))
        }
        alternate(works)
        rows += [
            {
                "work": work,
                "threads": count,
                "ours": works[f"{count} quads"].best,
                "peer": works[f"{count} triangles"].best,
            }
            for count in threads
        ]
    return rows
