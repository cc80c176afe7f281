# SPDX-License-Identifier: GPL-3.0-or-later
"""Binds of cages: closed forms next to the loops of their papers, quads next to triangles, harmonic weights
next to Blender's Mesh Deform.
"""

import tempfile
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np
import sinew_peers
from cases import OWN_MODEL, read_mesh
from record import Row
from timing import compare, require_equal

import sinew_native

from .blender import output_of

CAGES = (100, 300, 1000)  # vertices, about
SAMPLE = 30_000  # weights that the loops of the papers compute; each point takes them the same time


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
            quads = np.stack((grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]), 2)
            quads = quads.reshape(-1, 4, 3)
            corners.append(quads if side > 0 else quads[:, ::-1])
    every = np.concatenate(corners).reshape(-1, 3)
    _, first, index = np.unique(np.round(every, 9), axis=0, return_index=True, return_inverse=True)
    points = every[first] / np.linalg.norm(every[first], axis=1, keepdims=True)
    bumps = np.random.default_rng(3).uniform(0.95, 1.05, (len(points), 1))
    return bumps * points, index.reshape(-1, 4).astype(np.int32)


def _beside_paper(kind: type, peer: Callable[..., None], size: int, threads: Sequence[int]) -> list[Row]:
    found: list[Row] = []
    points = np.random.default_rng(0).uniform(-0.5, 0.5, (size, 3))
    for cage in CAGES:
        vertices, quads = quad_ball(cage)
        triangles = quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
        coordinates = kind(sinew_native.SurfaceMesh(vertices, triangles))
        sample = points[:: max(1, size * len(vertices) // SAMPLE)].copy()
        outputs = [np.zeros((len(sample), len(vertices)))]
        if kind is sinew_native.Green:
            outputs.append(np.zeros((len(sample), len(triangles))))
        loop = partial(peer, vertices, triangles, sample, *outputs)
        loop()
        coordinates.bind(sample)
        require_equal(coordinates.vertex_weights, outputs[0], 1e-6)  # ours have single precision
        rows = compare(partial(coordinates.bind, points), loop, threads)
        share = size / len(sample)
        found += [{**row, "case": _case(size, cage), "peer": share * row["peer"]} for row in rows]
    return found


def _case(size: int, cage: int) -> str:
    return f"{size // 1000}k, cage of {cage}"


def mean_value(size: int, threads: Sequence[int]) -> list[Row]:
    return _beside_paper(sinew_native.MeanValue, sinew_peers.mean_value, size, threads)


def green(size: int, threads: Sequence[int]) -> list[Row]:
    return _beside_paper(sinew_native.Green, sinew_peers.green, size, threads)


def green_quads(size: int, threads: Sequence[int]) -> list[Row]:
    """Points of a surface under the cage, of which each has some quads near it."""
    rng = np.random.default_rng(0)
    points = rng.normal(size=(size, 3))
    points *= rng.uniform(0.6, 0.88, (size, 1)) / np.linalg.norm(points, axis=1, keepdims=True)
    found: list[Row] = []
    for cage in CAGES:
        mesh = sinew_native.SurfaceMesh(*quad_ball(cage))
        quads, triangles = (sinew_native.Green(mesh, faces=faces) for faces in ("quads", "triangles"))
        rows = compare(partial(quads.bind, points), partial(triangles.bind, points), threads)
        found += [{**row, "case": _case(size, cage)} for row in rows]
    return found


def harmonic(size: int, _threads: Sequence[int]) -> list[Row]:
    """Points of a cow in its automatic cage. The truth is Sinew at its finest quality, after minutes."""
    random = np.random.default_rng(0)
    points, faces = read_mesh(OWN_MODEL)
    cage, triangles = sinew_native.automatic_cage(sinew_native.SurfaceMesh(points, faces), 150)[:2]
    mesh = sinew_native.SurfaceMesh(cage, triangles)
    corners = points[faces[random.integers(0, len(faces), size)]]
    inside = np.einsum("nk,nkx->nx", random.dirichlet(np.ones(corners.shape[1]), size), corners)

    def weights(quality: str) -> np.ndarray:
        harmonic = sinew_native.Harmonic(mesh, quality=quality)
        harmonic.bind(inside)
        return harmonic.vertex_weights

    with tempfile.TemporaryDirectory() as folder:
        case = Path(folder) / "case.npz"
        np.savez(case, cage=cage, faces=triangles, points=inside)
        with output_of("3.4", "mesh_deform.py", case) as out, np.load(out) as found:
            seconds, theirs = float(found["seconds"]), found["weights"]
    truth = weights("finest" if size >= 10_000 else "fine")
    (time,) = compare(lambda: weights("fast"), None, [0])
    errors = [float(np.abs(found - truth).max()) for found in (weights("fast"), theirs)]
    about = {"case": "cow, 150 faces", "quality": "fast"}
    return [
        {"work": "harmonic", **about, "ours": time["ours_median"], "peer": seconds},
        {"work": "harmonic_error", **about, "unit": "", "ours": errors[0], "peer": errors[1]},
    ]
