# SPDX-License-Identifier: GPL-3.0-or-later
"""Wires next to a loop over them in NumPy, and vector fields next to SciPy's integrator.

Both peers work on all points at once. The loop over wires has computed before all that does not depend on the
pose, as `bind` does, for the points in reach alone.
"""

from pathlib import Path

import numpy as np
from record import Row
from scipy.integrate import solve_ivp
from timing import Work, alternate

import sinew_native

from . import Options, Task

SIZE, SMALL = 100_000, 5_000
WIRES, SAMPLES, RADIUS = 3, 61, 0.7
STEPS = 100
INNER, OUTER = 0.3, 1.0
MOVE, TURN = np.array((0.6, 0.2, 0.3)), np.array((0.3, -0.2, 0.6))
FRAME = np.concatenate((np.zeros((1, 3)), np.eye(3)))
SCRIPT = Path(__file__).resolve().parents[1] / "curves_frame.py"


def plan(options: Options) -> list[Task]:
    size = SMALL if options.smallest else SIZE
    tasks = [
        Task("curves", (work,), {"work": work, "size": size, "threads": options.threads})
        for work in ("wires_frame", "wires_bind", "field_frame")
    ]
    if options.smallest or not options.quick:
        keywords = {"work": "overhead", "size": size, "threads": [], "small": options.smallest}
        tasks.append(Task("curves", ("overhead_wires", "overhead_field"), keywords))
    return tasks


def measure(work: str, size: int, threads: list[int], small: bool = False) -> list[Row]:
    if work == "overhead":
        from .blender import run_in

        found = run_in("3.4", SCRIPT, ["--small"] if small else [])
        return [{**row, "size": size, "unit": "s"} for row in found]
    rows = {"wires_frame": _wires, "wires_bind": _bind, "field_frame": _field}[work](size, threads)
    common = {"work": work, "size": size, "case": f"{size // 1000}k points", "vertices": size, "unit": "s"}
    return [{**common, **row} for row in rows]


def scattered(size: int) -> np.ndarray:
    return np.random.default_rng(0).uniform(-1.0, 1.0, (size, 3))


def curves() -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Wires along x, not straight, at rest and posed."""
    x = np.linspace(-1.0, 1.0, SAMPLES)
    rest = [np.stack((x, y + 0.1 * np.sin(5.0 * x), 0.1 * np.cos(4.0 * x)), axis=1) for y in (-0.5, 0.0, 0.5)]
    posed = [
        wire + (0.1 * k, 0.2, 0.3) + np.outer(np.sin(3.0 * x + k), (0.0, 0.1, 0.2))
        for k, wire in enumerate(rest)
    ]
    return rest, posed


def tangents(wire: np.ndarray) -> np.ndarray:
    ends = np.concatenate((wire[:1], wire, wire[-1:]))
    sides = ends[2:] - ends[:-2]
    return sides / np.linalg.norm(sides, axis=1, keepdims=True)


class Loop:
    """Wires by NumPy, by the rule of the nearest place, and of the points in reach."""

    def __init__(self, points: np.ndarray, rest: list[np.ndarray]) -> None:
        self.points, self.rest = points, rest
        self.found = [self._nearest(wire) for wire in rest]
        self.before = [tangents(wire) for wire in rest]

    def _nearest(self, wire: np.ndarray) -> tuple[np.ndarray, ...]:
        sides = np.diff(wire, axis=0)
        least, near, share = np.full(len(self.points), np.inf), np.zeros(len(self.points), int), 0.0
        share = np.zeros(len(self.points))
        for number, side in enumerate(sides):
            t = np.clip((self.points - wire[number]) @ side / (side @ side), 0.0, 1.0)
            square = ((self.points - wire[number] - t[:, None] * side) ** 2).sum(1)
            nearer = square < least
            least[nearer], near[nearer], share[nearer] = square[nearer], number, t[nearer]
        inside = np.flatnonzero(least < RADIUS**2)
        near, t = near[inside], share[inside, None]
        foot = (1 - t) * wire[near] + t * wire[near + 1]
        falloff = (1 - least[inside, None] / RADIUS**2) ** 2
        return inside, near, t, self.points[inside] - foot, falloff

    def warp(self, posed: list[np.ndarray]) -> np.ndarray:
        total, weights = np.zeros_like(self.points), np.zeros((len(self.points), 1))
        for (inside, near, t, y, F), rest, now, before in zip(
            self.found, self.rest, posed, self.before, strict=True
        ):
            after = tangents(now)
            axes = np.cross(before, after)
            sine = np.linalg.norm(axes, axis=1, keepdims=True)
            angle = np.arctan2(sine, (before * after).sum(1, keepdims=True))
            turns = axes * np.divide(angle, sine, out=np.zeros_like(sine), where=sine > 0)
            move = now - rest
            turn = F * ((1 - t) * turns[near] + t * turns[near + 1])
            theta = np.sqrt(np.einsum("ij,ij->i", turn, turn))[:, None]
            axis = turn / np.maximum(theta, 1e-300)
            across = np.cross(axis, y)
            D = np.sin(theta) * across + (1 - np.cos(theta)) * np.cross(axis, across)
            D += F * ((1 - t) * move[near] + t * move[near + 1])
            length = np.sqrt(np.einsum("ij,ij->i", D, D))[:, None]
            total[inside] += length * D
            weights[inside] += length
        return self.points + total / np.maximum(weights, 1e-300)


def _wires(size: int, threads: list[int]) -> list[Row]:
    points, (rest, posed) = scattered(size), curves()
    wires = sinew_native.Wires(np.concatenate(rest), [SAMPLES] * WIRES, radius=RADIUS)
    exact = sinew_native.Wires(np.concatenate(rest), [SAMPLES] * WIRES, radius=RADIUS, smoothing=0.0)
    reports = [each.bind(points) for each in (exact, wires)]
    loop, now = Loop(points, rest), np.concatenate(posed)
    out = np.empty((size, 3), np.float32)
    if np.abs(exact.warp(now) - loop.warp(posed)).max() > 1e-10:
        raise SystemExit("the wires of Sinew and of NumPy differ")
    rows = []
    cases = ("the nearest place, as the peer", exact), ("smoothed, by default", wires)
    for (case, each), report in zip(cases, reports, strict=True):
        works = _by_threads(lambda each=each: each.warp(now, out=out), threads)
        works["peer"] = Work(lambda: loop.warp(posed))
        alternate(works)
        rows += [
            {
                "case": case,
                "threads": count,
                "ours": works[count].best,
                "peer": works["peer"].best,
                "bytes_per_point": report.weight_bytes / size,
            }
            for count in threads
        ]
    return rows


def _bind(size: int, threads: list[int]) -> list[Row]:
    points, (rest, _posed) = scattered(size), curves()
    wires = sinew_native.Wires(np.concatenate(rest), [SAMPLES] * WIRES, radius=RADIUS)
    works = _by_threads(lambda: wires.bind(points), threads)
    works["peer"] = Work(lambda: Loop(points, rest))
    alternate(works)
    return [{"threads": count, "ours": works[count].best, "peer": works["peer"].best} for count in threads]


def field(t: float, flat: np.ndarray) -> np.ndarray:
    """The velocities of a drag, for SciPy."""
    y = flat.reshape(3, -1) - (t * MOVE)[:, None]
    r = np.sqrt((y * y).sum(0))
    u = np.clip((r - INNER) / (OUTER - INNER), 0.0, 1.0)
    beta = 1.0 - u**3 * (4.0 - 3.0 * u)
    steep = beta * (-12.0 / (OUTER - INNER)) * u * u * (1.0 - u)
    back = steep * (MOVE @ y) / np.maximum(r, 1e-300)
    straight = beta * beta + steep * r
    turned = np.stack(
        (
            TURN[1] * y[2] - TURN[2] * y[1],
            TURN[2] * y[0] - TURN[0] * y[2],
            TURN[0] * y[1] - TURN[1] * y[0],
        )
    )
    return (np.multiply.outer(MOVE, straight) - back * y + beta * turned).ravel()


def _field(size: int, threads: list[int]) -> list[Row]:
    """Both take 100 even steps: Sinew by order 4, SciPy by its pair of order 5 and 4."""
    points = scattered(size)
    angle = np.linalg.norm(TURN)
    axis = TURN / angle
    K = np.array(((0, -axis[2], axis[1]), (axis[2], 0, -axis[0]), (-axis[1], axis[0], 0)))
    turn = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
    posed, out = FRAME @ turn.T + MOVE, np.empty((size, 3), np.float32)
    steps = sinew_native.VectorField(FRAME, inner=INNER, outer=OUTER, steps=STEPS)
    free = sinew_native.VectorField(FRAME, inner=INNER, outer=OUTER)
    steps.bind(points)
    free.bind(points)
    start = np.ascontiguousarray(points.T).ravel()

    def scipy() -> np.ndarray:
        found = solve_ivp(
            field,
            (0.0, 1.0),
            start,
            method="RK45",
            t_eval=(1.0,),
            first_step=1.0 / STEPS,
            max_step=1.0 / STEPS,
            rtol=1e3,
            atol=1e3,
        )
        if not 6 * STEPS <= found.nfev <= 6 * STEPS + 8:
            raise SystemExit(f"SciPy took {found.nfev} evaluations")
        return found.y[:, -1].reshape(3, -1).T

    if np.abs(steps.warp(posed) - scipy()).max() > 1e-5:
        raise SystemExit("the flows of Sinew and of SciPy differ")
    works = _by_threads(lambda: steps.warp(posed, out=out), threads)
    works["peer"] = Work(scipy)
    alternate(works, least=2)
    default = alternate(_by_threads(lambda: free.warp(posed, out=out), threads), budget=1.0)
    return [
        {
            "threads": count,
            "ours": works[count].best,
            "peer": works["peer"].best,
            "by_tolerance": default[count].best,
        }
        for count in threads
    ]


def _by_threads(run, threads: list[int]) -> dict:
    return {count: Work(run, lambda count=count: sinew_native.limit_threads(count)) for count in threads}
