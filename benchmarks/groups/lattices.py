# SPDX-License-Identifier: GPL-3.0-or-later
"""Lattices next to a product with stored weights, which is how one would do it in NumPy."""

import numpy as np
from record import Row
from timing import Work, alternate

import sinew_native

from . import Options, Task

SIZES = (100_000, 1_000_000)
CELLS = 4  # points along each axis


def plan(options: Options) -> list[Task]:
    sizes = (10_000,) if options.smallest else SIZES[:1] if options.quick else SIZES
    return [
        Task("lattices", (work,), {"work": work, "size": size, "threads": options.threads})
        for work in ("ffd_bind", "ffd_warp")
        for size in sizes
    ]


def lattice() -> np.ndarray:
    """The points of the unit cube, the first axis first."""
    line = np.linspace(0.0, 1.0, CELLS)
    w, v, u = np.meshgrid(line, line, line, indexing="ij")
    return np.stack((u, v, w), axis=-1).reshape(-1, 3)


def measure(work: str, size: int, threads: list[int]) -> list[Row]:
    rest = lattice()
    points = np.random.default_rng(0).uniform(0.0, 1.0, (size, 3))
    method = sinew_native.Ffd(rest)
    method.bind(points)
    limit = sinew_native.limit_threads
    if work == "ffd_bind":
        works = {count: Work(lambda: method.bind(points), lambda c=count: limit(c)) for count in threads}
        alternate(works)
        peers = size / 1e6
    else:
        weights, posed = _weights(points), rest + np.random.default_rng(1).uniform(-0.3, 0.3, rest.shape)
        out, moves = np.empty((size, 3), np.float32), (posed - rest).astype(np.float32)
        works = {
            count: Work(lambda: method.warp(posed, out=out), lambda c=count: limit(c)) for count in threads
        }
        works["peer"] = Work(lambda: points + weights @ moves)
        alternate(works)
        if np.abs(out - (points + weights @ moves)).max() > 1e-5:
            raise SystemExit("the shapes of Sinew and of NumPy differ")
        peers = works.pop("peer").best
    common = {"work": work, "size": size, "case": f"{size // 1000}k points", "vertices": size, "unit": "s"}
    return [{**common, "threads": count, "ours": one.best, "peer": peers} for count, one in works.items()]


def _weights(points: np.ndarray) -> np.ndarray:
    """Cubic B-splines that end at four points are Bernstein polynomials."""
    t = points[:, :, None]
    along = np.concatenate(((1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3), axis=2)
    product = np.einsum("pi,pj,pk->pkji", along[:, 0], along[:, 1], along[:, 2])
    return product.reshape(len(points), -1).astype(np.float32)
