# SPDX-License-Identifier: GPL-3.0-or-later
"""As-rigid-as-possible next to libigl: one iteration, a bent bar, and a scanned model solved from rest.

An iteration of Sinew is a step of L-BFGS with a test of the energy; an iteration of libigl is a local and a
global step. Since these are not equally effective, two rows count the time until the energy is 1 % above its
least value.
"""

import time
from collections.abc import Callable
from pathlib import Path

import igl
import numpy as np
from cases import Case, armadillo, bar, own_model
from record import Row
from timing import Work, alternate, arrival, rounds

import sinew_native

from . import Options, Task

LARGEST_BOTH = 200_000  # above this size, libigl is measured with one of its energies only
SHORT, LONG, LONG_OF_LARGE = 2, 12, 7  # numbers of iterations; the difference of their times is measured
# Part -> id of the row -> options. The rows of a part run by turns.
ITERATIONS = {
    "rims": {"arap_iteration": {"smoothness": 0.0, "cells": "rims"}},
    "spokes": {"arap_spokes": {"smoothness": 0.0}, "arap_smooth": {}},
}
WITHIN = 1.01
LONG_RUN = {"max_iterations": 2000, "tolerance": 1e-7}  # gives the least energy to 1e-5
PATIENCE, MOST_PATIENCE = 55.0, 90.0  # the longest time for libigl: a multiple of Sinew's, and seconds


def plan(options: Options) -> list[Task]:
    tasks = []
    for size in (*options.sizes, *options.own_sizes):
        keywords = {"size": size, "threads": options.threads, "peers": size in options.sizes}
        tasks += [
            Task("arap", tuple(variants), {"part": part, **keywords}) for part, variants in ITERATIONS.items()
        ]
    bend = 10_000 if options.quick else 50_000
    tasks.append(Task("arap", ("arap_bend",), {"part": "bend", "size": bend, "threads": options.threads}))
    cold = {"part": "cold", "threads": options.threads}
    if options.smallest:
        tasks.append(Task("arap", ("arap_cold",), {**cold, "size": 3_000}))
    elif options.meshes is not None:
        keywords = {"size": 43_000, "meshes": str(options.meshes)}
        tasks.append(Task("arap", ("arap_cold",), {**cold, **keywords}))
    return tasks


def measure(
    part: str, size: int, threads: list[int], peers: bool = True, meshes: str | None = None
) -> list[Row]:
    if part in ITERATIONS:
        rows = _iteration(bar("bend 90", size), ITERATIONS[part], threads, peers)
    elif part == "bend":
        rows = _bend(bar("bend 90", size), threads)
    else:
        rows = _cold(armadillo(Path(meshes), turned=True) if meshes else own_model(), threads)
    return [{"size": size, "unit": "s", **row} for row in rows]


def bound(case: Case, **options: object) -> "sinew_native.Arap":
    arap = sinew_native.Arap(sinew_native.SurfaceMesh(case.points, case.faces), **options)
    arap.set_handles(case.handles)
    return arap


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


def set_threads(count: int) -> Callable[[], None]:
    return lambda: sinew_native.limit_threads(count)


def _iteration(case: Case, variants: dict[str, dict], threads: list[int], peers: bool) -> list[Row]:
    large = case.vertex_count > 1.1 * LARGEST_BOTH
    short, long = (SHORT, LONG) if not large else (SHORT, LONG_OF_LARGE)
    libigl = {"arap_iteration": igl.ARAP_ENERGY_TYPE_SPOKES_AND_RIMS}
    if not large:
        libigl["arap_spokes"] = igl.ARAP_ENERGY_TYPE_SPOKES
    works: dict[tuple, Work] = {}
    for variant, options in variants.items():
        arap = bound(case, **options)
        start = arap.solve(case.poses, max_iterations=0)[0]
        for budget in (short, long):

            def solve(arap=arap, start=start, budget=budget) -> None:
                arap.solve(case.poses, start=start, max_iterations=budget, tolerance=0.0)

            works |= {(variant, count, budget): Work(solve, set_threads(count)) for count in threads}
    for variant in variants if peers else ():
        if variant not in libigl:
            continue
        peer = Libigl(case, libigl[variant])
        for budget in (short, long):
            run = lambda peer=peer, start=start, budget=budget: peer.solve(start, budget)  # noqa: E731
            works[variant, "peer", budget] = Work(run)
    alternate(works, budget=8.0, least=rounds(case.vertex_count))

    def iteration(*key: object) -> float:
        return (works[*key, long].best - works[*key, short].best) / (long - short)

    rows = []
    for variant in variants:
        for count in threads:
            row = {"work": variant, "threads": count, "vertices": case.vertex_count}
            row["ours"] = iteration(variant, count)
            if variant == "arap_smooth":
                row["peer"] = iteration("arap_spokes", count)
            elif (variant, "peer", long) in works:
                row["peer"] = iteration(variant, "peer")
            rows.append(row)
    return rows


def _fewest(arap: "sinew_native.Arap", case: Case, energy: float) -> int:
    """The least number of iterations that reaches an energy, which no step raises."""
    low, high = 0, 1
    while _energy_after(arap, case, high) > energy:
        low, high = high, 2 * high
        if high > 2 * LONG_RUN["max_iterations"]:
            raise SystemExit("Sinew does not reach the energy")
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if _energy_after(arap, case, middle) > energy else (low, middle)
    return high


def _energy_after(arap: "sinew_native.Arap", case: Case, iterations: int) -> float:
    return arap.solve(case.poses, max_iterations=iterations, tolerance=0.0)[1].energy


def _timed(arap: "sinew_native.Arap", case: Case, iterations: int, threads: list[int]) -> dict[object, Work]:
    def solve() -> None:
        arap.solve(case.poses, max_iterations=iterations, tolerance=0.0)

    return {count: Work(solve, set_threads(count)) for count in threads}


def _bend(case: Case, threads: list[int]) -> list[Row]:
    """Each solver runs to 1 % above the end of its own long run, since the energy has many minima."""
    arap = bound(case, smoothness=0.0)
    reference = arap.solve(case.poses, **LONG_RUN)[1].energy
    iterations = _fewest(arap, case, WITHIN * reference)
    works = alternate(_timed(arap, case, iterations, threads))
    slowest = max(work.best for work in works.values())
    peer = _libigl_to_one_percent(case, arap, min(PATIENCE * slowest, MOST_PATIENCE))
    return [
        {
            "work": "arap_bend",
            "threads": count,
            "vertices": case.vertex_count,
            "ours": works[count].best,
            "iterations": iterations,
            "energy": reference,
            **peer,
        }
        for count in threads
    ]


def _libigl_to_one_percent(case: Case, arap: "sinew_native.Arap", patience: float) -> dict[str, object]:
    """The seconds of libigl without its start. If it does not reach 1 %, "peer" is the time that it had."""
    libigl = Libigl(case, igl.ARAP_ENERGY_TYPE_SPOKES)
    shape = libigl.start()
    energies, seconds, chunk = [arap.energy(shape)], [0.0], 20
    while seconds[-1] < patience:
        begin = time.perf_counter()
        shape = libigl.solve(shape, chunk)
        seconds.append(seconds[-1] + time.perf_counter() - begin)
        energies.append(arap.energy(shape))
    end = arap.solve(case.poses, start=shape, **LONG_RUN)[1].energy
    return arrival(np.array(energies) / end - 1.0, WITHIN - 1.0, np.array(seconds), chunk) | {
        "peer_energy": end
    }


def _cold(case: Case, threads: list[int]) -> list[Row]:
    arap = bound(case)
    reference = arap.solve(case.poses, **LONG_RUN)[1].energy
    within = _energy_after(arap, case, 0) <= WITHIN * reference
    iterations = 0 if within else _fewest(arap, case, WITHIN * reference)
    works = _timed(arap, case, iterations, threads)
    libigl = Libigl(case, igl.ARAP_ENERGY_TYPE_SPOKES_AND_RIMS)
    works["peer"] = Work(lambda: libigl.solve(case.points, 4))
    alternate(works)
    return [
        {
            "work": "arap_cold",
            "threads": count,
            "vertices": case.vertex_count,
            "ours": works[count].best,
            "peer": works["peer"].best,
            "iterations": iterations,
            "excess_percent": 100 * (_energy_after(arap, case, iterations) / reference - 1),
        }
        for count in threads
    ]
