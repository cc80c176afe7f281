# SPDX-License-Identifier: GPL-3.0-or-later
"""Times several works by turns, so that other load on the machine affects all of them alike."""

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from timeit import repeat, timeit

import numpy as np
from record import Row

import sinew_native

BURST = 0.02  # seconds for which a short work is timed again and again in each of its turns
FEWEST_ROUNDS = False  # whether to run the least number of rounds only: for tests, which need no good figures
SHORT, LONG = 2, 12  # numbers of iterations; the difference of their times is measured

Run = Callable[[], object]


@dataclass
class Timed:
    run: Run
    prepare: Run = lambda: None  # called before each turn, and not timed
    repeatable: bool = True  # whether it can run again without `prepare`
    seconds: list[float] = field(default_factory=list)

    @property
    def best(self) -> float:
        """The fastest run, which other load disturbed least."""
        return min(self.seconds)

    @property
    def median(self) -> float:
        return statistics.median(self.seconds)

    def turn(self) -> None:
        self.prepare()
        first = timeit(self.run, number=1)
        again = min(20, int(BURST / max(first, 1e-6))) if self.repeatable else 0
        self.seconds += [first, *repeat(self.run, repeat=again, number=1)]


def alternate(
    works: dict[object, Timed], *, budget: float = 4.0, least: int = 3, most: int = 20
) -> dict[object, Timed]:
    """Run all works by turns, for at least ``least`` rounds, until ``budget`` seconds are over."""
    budget, least = (0.0, 1) if FEWEST_ROUNDS else (budget, least)
    begin = time.perf_counter()
    for done in range(most):
        if done >= least and time.perf_counter() - begin > budget:
            break
        for work in works.values():
            work.turn()
    return works


def rounds(vertices: int) -> int:
    """The least number of rounds. It is small for large meshes, whose times are long and vary little."""
    return 3 if vertices < 150_000 else 2 if vertices < 700_000 else 1


def compare(
    ours: Run, peer: Run | None, threads: Sequence[int], *, before: Run | None = None, **limits: float
) -> list[Row]:
    """A row for each number of threads that Sinew may use. Works with a ``before`` run once in a turn."""
    works: dict[object, Timed] = {}
    for count in threads:

        def prepare(count: int = count) -> None:
            sinew_native.limit_threads(count)
            if before:
                before()

        for name, run in {"ours": ours, "peer": peer}.items():
            if run:
                works[name, count] = Timed(run, prepare, before is None)
    alternate(works, **limits)
    return [
        {"threads": count, "ours_median": works["ours", count].median}
        | {name: works[name, count].best for name in ("ours", "peer") if (name, count) in works}
        for count in threads
    ]


def compare_iterations(
    ours: Callable[[int], object], peer: Callable[[int], object] | None, threads: Sequence[int], size: int
) -> list[Row]:
    """The time of one iteration, from functions that run as many as they are given."""
    runs = {name: run for name, run in {"ours": ours, "peer": peer}.items() if run}
    works: dict[object, Timed] = {
        (name, count, budget): Timed(partial(run, budget), partial(sinew_native.limit_threads, count))
        for count in threads
        for name, run in runs.items()
        for budget in (SHORT, LONG)
    }
    alternate(works, budget=8.0, least=rounds(size))

    def iteration(name: str, count: int) -> float:
        return (works[name, count, LONG].best - works[name, count, SHORT].best) / (LONG - SHORT)

    return [{"threads": count} | {name: iteration(name, count) for name in runs} for count in threads]


def require_equal(ours: np.ndarray, peers: np.ndarray, most: float) -> None:
    """Stop if the results differ, since a wrong result must not be timed."""
    worst = np.abs(ours - peers).max()
    if not worst < most:
        raise SystemExit(f"the results of Sinew and of its peer differ by {worst:.1e}")
