# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of the space methods that handles, lattices and wires control.

Embedded deformation is measured next to Gauss-Newton steps on the paper's energy in SciPy, as Open3D takes
them: from rest, each assembles and factorises the normal equations, until the shape is within 1 % of the
limit; then SciPy's sparse product moves the points. Rigid cells are measured next to a frame of `Arap`. The
others get random points in a cube, and check that their peer moves them to the same places.
"""

from collections.abc import Callable, Sequence

import numpy as np
import sinew_peers
from cases import Case, bar
from embedded_graph import PaperEnergy
from record import Row
from scipy import sparse
from scipy.interpolate import RBFInterpolator
from timing import compare, require_equal, rounds

import sinew_native

from .nonlinear import bound

WITHIN = 0.01  # of how far the points move
SAME = 1e-5  # ours have single precision
WIRES, SAMPLES, RADIUS = 3, 61, 0.7


def _by_handles(kind: type, case: Case, **options: int) -> object:
    held = [case.points[handle] for handle in case.handles]
    mesh = sinew_native.SurfaceMesh(case.points, case.faces)
    method = kind(mesh, np.concatenate(held), [len(own) for own in held], **options)
    method.bind(case.points)
    return method


def embedded(size: int, threads: Sequence[int]) -> list[Row]:
    case = bar("twist 135", size)
    method = _by_handles(sinew_native.EmbeddedDeformation, case, nodes=min(500, size // 50))
    graph = method.graph()
    maps = case.poses[graph["pull_handles"]]
    targets = np.einsum("pij,pj->pi", maps[:, :, :3], graph["pulls"]) + maps[:, :, 3]
    weights = sparse.csr_matrix(method.weights())
    by_nodes, by_handles = weights[:, : len(graph["nodes"])], weights[:, len(graph["nodes"]) :]
    moved = [case.points_posed(pose) for pose in case.poses]
    paper = PaperEnergy(graph, targets)

    def shown(nodes: np.ndarray) -> np.ndarray:
        shape = paper.warped(nodes, case.points, by_nodes)
        for handle, own in enumerate(moved):
            shape += by_handles[:, [handle]].multiply(own)
        return shape

    iterates = list(paper.iterates(60))
    limit = shown(iterates[-1])
    most = WITHIN * np.linalg.norm(limit - case.points)
    steps = 1 + [np.linalg.norm(shown(nodes) - limit) <= most for nodes in iterates].index(True)
    if np.linalg.norm(method.warp_poses(case.poses) - limit) > most:
        raise SystemExit("a frame is away from the limit of Gauss-Newton")
    out = np.empty(case.points.shape, np.float32)
    ours, peer = lambda: method.warp_poses(case.poses, out=out), lambda: shown(paper.gauss_newton(steps))
    rows = compare(ours, peer, threads, least=1)
    return [{"vertices": case.vertex_count, "iterations": steps, **row} for row in rows]


def cells(size: int, threads: Sequence[int]) -> list[Row]:
    case = bar("twist 135", size)
    method = _by_handles(sinew_native.RigidCells, case, cells=min(2000, size // 20))
    arap, out = bound(case), np.empty(case.points.shape, np.float32)
    ours, peer = lambda: method.warp_poses(case.poses, out=out), lambda: arap.solve(case.poses)
    rows = compare(ours, peer, threads, least=rounds(size))
    return [{"vertices": case.vertex_count, **row} for row in rows]


def rbf(size: int, threads: Sequence[int]) -> list[Row]:
    """A tenth of the points is enough for SciPy, which takes the same time for each."""
    random = np.random.default_rng(1)
    centres, points = random.uniform(0.0, 1.0, (1000, 3)), random.uniform(0.0, 1.0, (size, 3))
    moves = random.uniform(-0.1, 0.1, centres.shape)
    some = points[::10].copy()
    method = sinew_native.Rbf(centres)
    method.bind(points)
    peer = RBFInterpolator(centres, moves, kernel="cubic", degree=2)
    require_equal(method.warp(centres + moves)[::10] - some, peer(some), SAME)
    out = np.zeros((size, 3), np.float32)
    rows = compare(lambda: method.warp(centres + moves, out=out), lambda: peer(some), threads, budget=20.0)
    case = f"1,000 centres, {size:,} points"
    return [{**row, "case": case, "peer": row["peer"] * size / len(some)} for row in rows]


def mls(size: int, threads: Sequence[int]) -> list[Row]:
    random = np.random.default_rng(4)
    handles, points = random.uniform(-1, 1, (50, 3)), random.uniform(-1.2, 1.2, (size, 3))
    posed = handles + random.uniform(-0.2, 0.2, handles.shape)
    method = sinew_native.Mls(handles, alpha=1.0)
    method.bind(points)
    out, peers = np.zeros((size, 3), np.float32), np.zeros((size, 3))
    loop = lambda: sinew_peers.rigid_mls(handles, posed, points, peers)  # noqa: E731
    loop()
    require_equal(method.warp(posed), peers, SAME)
    rows = compare(lambda: method.warp(posed, out=out), loop, threads)
    return [{**row, "case": f"{size:,} points, 50 handles"} for row in rows]


def ffd(size: int, threads: Sequence[int]) -> list[Row]:
    """NumPy multiplies by stored weights: B-splines that end at four points are Bernstein polynomials."""
    random = np.random.default_rng(0)
    line = np.linspace(0.0, 1.0, 4)
    w, v, u = np.meshgrid(line, line, line, indexing="ij")
    rest = np.stack((u, v, w), axis=-1).reshape(-1, 3)
    points, posed = random.uniform(0.0, 1.0, (size, 3)), rest + random.uniform(-0.3, 0.3, rest.shape)
    method = sinew_native.Ffd(rest)
    method.bind(points)
    t = points[:, :, None]
    along = np.concatenate(((1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3), axis=2)
    product = np.einsum("pi,pj,pk->pkji", along[:, 0], along[:, 1], along[:, 2])
    weights = product.reshape(size, -1).astype(np.float32)
    out, moves = np.empty((size, 3), np.float32), (posed - rest).astype(np.float32)
    require_equal(method.warp(posed), points + weights @ moves, SAME)
    rows = compare(lambda: method.warp(posed, out=out), lambda: points + weights @ moves, threads)
    return [{**row, "case": f"{size // 1000}k points"} for row in rows]


def wires(size: int, threads: Sequence[int]) -> list[Row]:
    """Wires along x, not straight. The peer has computed before all that does not depend on the pose."""
    points = np.random.default_rng(0).uniform(-1.0, 1.0, (size, 3))
    x = np.linspace(-1.0, 1.0, SAMPLES)
    rest = [np.stack((x, y + 0.1 * np.sin(5.0 * x), 0.1 * np.cos(4.0 * x)), axis=1) for y in (-0.5, 0.0, 0.5)]
    sway = [np.outer(np.sin(3.0 * x + k), (0.0, 0.1, 0.2)) + (0.1 * k, 0.2, 0.3) for k in range(WIRES)]
    posed = [wire + moved for wire, moved in zip(rest, sway)]
    loop, now = wire_loop(points, rest), np.concatenate(posed)
    out = np.empty((size, 3), np.float32)
    found: list[Row] = []
    for case, options in (
        ("the nearest place, as the peer", {"smoothing": 0.0}),
        ("smoothed, by default", {}),
    ):
        method = sinew_native.Wires(np.concatenate(rest), [SAMPLES] * WIRES, radius=RADIUS, **options)
        method.bind(points)
        if options:
            require_equal(method.warp(now), loop(posed), 1e-10)
        rows = compare(lambda method=method: method.warp(now, out=out), lambda: loop(posed), threads)
        found += [{**row, "case": case} for row in rows]
    return found


def wire_loop(points: np.ndarray, rest: list[np.ndarray]) -> Callable[[list[np.ndarray]], np.ndarray]:
    """The points for poses of wires by NumPy, by the rule of the nearest place, and of those in reach."""
    found = [(*_nearest(points, wire), wire, _tangents(wire)) for wire in rest]

    def warp(posed: list[np.ndarray]) -> np.ndarray:
        total, weights = np.zeros_like(points), np.zeros((len(points), 1))
        for (inside, near, t, y, F, wire, before), now in zip(found, posed, strict=True):
            after = _tangents(now)
            axes = np.cross(before, after)
            sine = np.linalg.norm(axes, axis=1, keepdims=True)
            angle = np.arctan2(sine, (before * after).sum(1, keepdims=True))
            turns = axes * np.divide(angle, sine, out=np.zeros_like(sine), where=sine > 0)
            move = now - wire
            turn = F * ((1 - t) * turns[near] + t * turns[near + 1])
            theta = np.sqrt(np.einsum("ij,ij->i", turn, turn))[:, None]
            axis = turn / np.maximum(theta, 1e-300)
            across = np.cross(axis, y)
            D = np.sin(theta) * across + (1 - np.cos(theta)) * np.cross(axis, across)
            D += F * ((1 - t) * move[near] + t * move[near + 1])
            length = np.sqrt(np.einsum("ij,ij->i", D, D))[:, None]
            total[inside] += length * D
            weights[inside] += length
        return points + total / np.maximum(weights, 1e-300)

    return warp


def _nearest(points: np.ndarray, wire: np.ndarray) -> tuple[np.ndarray, ...]:
    """Of the points in reach: which, the piece of wire and the place on it that are nearest, arm, falloff."""
    sides = np.diff(wire, axis=0)
    along = np.clip([(points - foot) @ side / (side @ side) for foot, side in zip(wire, sides)], 0.0, 1.0)
    arms = points - wire[:-1, None] - along[..., None] * sides[:, None]
    squares = np.einsum("snk,snk->sn", arms, arms)
    near, row = squares.argmin(0), np.arange(len(points))
    inside = np.flatnonzero(squares[near, row] < RADIUS**2)
    near = near[inside]
    falloff = (1 - squares[near, inside] / RADIUS**2) ** 2
    return inside, near, along[near, inside, None], arms[near, inside], falloff[:, None]


def _tangents(wire: np.ndarray) -> np.ndarray:
    ends = np.concatenate((wire[:1], wire, wire[-1:]))
    sides = ends[2:] - ends[:-2]
    return sides / np.linalg.norm(sides, axis=1, keepdims=True)
