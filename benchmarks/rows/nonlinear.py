# SPDX-License-Identifier: GPL-3.0-or-later
"""Iterations of the nonlinear surface methods, next to libigl or to those of `Arap`; and a bent bar.

An iteration of Sinew is a step of L-BFGS with a test of the energy; an iteration of libigl is a local and a
global step. Since these are not equally effective, the bent bar is timed until the energy is 1 % above its
least value.
"""

import time
from bisect import bisect_left
from collections.abc import Callable, Sequence

import igl
import numpy as np
from cases import Case, bar
from record import Row
from timing import Timed, alternate, compare_iterations
from works import WITH_PEERS

import sinew_native

WITHIN = 0.01  # above the least energy
LONG_RUN = {"max_iterations": 2000, "tolerance": 1e-7}  # gives the least energy to 1e-5
PATIENCE, MOST_PATIENCE = 55.0, 90.0  # the longest time for libigl: a multiple of Sinew's, and seconds
CHUNK = 20  # iterations of libigl between two looks at the energy


def bound(case: Case, kind: type = sinew_native.Arap, **options: object) -> sinew_native.SurfaceMethod:
    method = kind(sinew_native.SurfaceMesh(case.points, case.faces), **options)
    method.set_handles(case.handles)
    return method


def _from_its_start(method: sinew_native.SurfaceMethod, case: Case) -> Callable[[int], object]:
    start = method.solve(case.poses, max_iterations=0)[0]
    return lambda budget: method.solve(case.poses, start=start, max_iterations=budget, tolerance=0.0)


class Libigl:
    """libigl's solver on the same mesh and handles."""

    def __init__(self, case: Case, energy: "igl.ARAPEnergyType") -> None:
        self._data = igl.ARAPData()
        self._data.energy = energy
        held = np.concatenate(case.handles)
        faces = np.ascontiguousarray(case.faces, dtype=np.int64)
        igl.arap_precomputation(case.points, faces, 3, held.astype(np.int32), self._data)
        pairs = zip(case.handles, case.poses)
        self.held = np.vstack([case.points_posed(pose)[vertices] for vertices, pose in pairs])
        self._harmonic = lambda: igl.harmonic(case.points, faces, held.astype(np.int64), self.held, 1)

    def start(self) -> np.ndarray:
        """The harmonic surface through the handles."""
        return np.ascontiguousarray(self._harmonic())

    def solve(self, start: np.ndarray, iterations: int) -> np.ndarray:
        self._data.max_iter = iterations
        return igl.arap_solve(self.held, self._data, start)


def arap(size: int, threads: Sequence[int]) -> list[Row]:
    case = bar("bend 90", size)
    method = bound(case, smoothness=0.0, cells="rims")
    peer = None
    if size <= WITH_PEERS[-1]:
        libigl = Libigl(case, igl.ARAP_ENERGY_TYPE_SPOKES_AND_RIMS)
        start = method.solve(case.poses, max_iterations=0)[0]
        peer = lambda budget: libigl.solve(start, budget)  # noqa: E731
    rows = compare_iterations(_from_its_start(method, case), peer, threads, size)
    return [{"vertices": case.vertex_count, **row} for row in rows]


def _beside_arap(kind: type, size: int, threads: Sequence[int], **options: float) -> list[Row]:
    case = bar("bend 90", size)
    ours, peer = (_from_its_start(method, case) for method in (bound(case, kind), bound(case, **options)))
    return [{"vertices": case.vertex_count, **row} for row in compare_iterations(ours, peer, threads, size)]


def shell(size: int, threads: Sequence[int]) -> list[Row]:
    return _beside_arap(sinew_native.ThinShellNonlinear, size, threads, smoothness=0.0)


def pyramid(size: int, threads: Sequence[int]) -> list[Row]:
    return _beside_arap(sinew_native.PyramidCoordinates, size, threads, smoothness=0.0)


def primo(size: int, threads: Sequence[int]) -> list[Row]:
    return _beside_arap(sinew_native.Primo, size, threads)


def bend(size: int, threads: Sequence[int]) -> list[Row]:
    """Each solver runs to 1 % above the end of its own long run, since the energy has many minima."""
    case = bar("bend 90", size)
    method = bound(case, smoothness=0.0)
    least = method.solve(case.poses, **LONG_RUN)[1].energy
    iterations = _fewest(method, case, (1 + WITHIN) * least)

    def solve() -> None:
        method.solve(case.poses, max_iterations=iterations, tolerance=0.0)

    works = {count: Timed(solve, lambda count=count: sinew_native.limit_threads(count)) for count in threads}
    alternate(works)
    slowest = max(work.best for work in works.values())
    peer = _libigl_to_one_percent(case, method, min(PATIENCE * slowest, MOST_PATIENCE))
    about = {"vertices": case.vertex_count, "iterations": iterations, "energy": least, **peer}
    return [{"threads": count, "ours": works[count].best, **about} for count in threads]


def _fewest(method: "sinew_native.Arap", case: Case, energy: float) -> int:
    """The least number of iterations that reaches an energy, which no step raises."""

    def reaches(iterations: int) -> bool:
        report = method.solve(case.poses, max_iterations=iterations, tolerance=0.0)[1]
        return report.energy <= energy

    high = 1
    while not reaches(high):
        high *= 2
        if high > 2 * LONG_RUN["max_iterations"]:
            raise SystemExit("Sinew does not reach the energy")
    return bisect_left(range(high), True, lo=high // 2 + 1, key=reaches)


def _libigl_to_one_percent(case: Case, method: "sinew_native.Arap", patience: float) -> Row:
    """The seconds of libigl without its start. If it does not reach 1 %, "peer" is the time that it had."""
    libigl = Libigl(case, igl.ARAP_ENERGY_TYPE_SPOKES)
    shape = libigl.start()
    energies, seconds = [method.energy(shape)], [0.0]
    while seconds[-1] < patience:
        begin = time.perf_counter()
        shape = libigl.solve(shape, CHUNK)
        seconds.append(seconds[-1] + time.perf_counter() - begin)
        energies.append(method.energy(shape))
    end = method.solve(case.poses, start=shape, **LONG_RUN)[1].energy
    return arrival(np.array(energies) / end - 1.0, np.array(seconds))


def arrival(excess: np.ndarray, seconds: np.ndarray) -> Row:
    """When a peer's excess over the least energy falls to 1 %, from samples every ``CHUNK`` iterations. If it
    does not fall so far, the second half of the samples is extrapolated, by a power of the time and
    exponentially; the earlier of both times counts."""
    within = np.flatnonzero(excess <= WITHIN)
    if len(within):
        k = within[0]
        return {"peer": float(seconds[k]), "peer_iterations": int(k * CHUNK), "peer_arrived": True}
    half = slice(len(excess) // 2, None)
    log_excess = np.log(excess[half])
    guesses = []
    for time_of, back in ((np.log, np.exp), (lambda t: t, lambda t: t)):
        slope, offset = np.polyfit(time_of(seconds[half]), log_excess, 1)
        with np.errstate(over="ignore"):
            guesses.append(float(back((np.log(WITHIN) - offset) / slope)) if slope < 0 else np.inf)
    return {
        "peer": float(seconds[-1]),
        "peer_iterations": (len(seconds) - 1) * CHUNK,
        "peer_arrived": False,
        "peer_excess_percent": 100 * float(excess[-1]),
        "peer_extrapolated": float(min(guesses)) if np.isfinite(min(guesses)) else None,
    }
