# SPDX-License-Identifier: GPL-3.0-or-later
"""Times several works by turns, so that other load on the machine affects all of them alike."""

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

BURST = 0.02  # seconds for which a short work is timed again and again in each of its turns
FEWEST_ROUNDS = False  # whether to run the least number of rounds only: for tests, which need no good figures


@dataclass
class Work:
    run: Callable[[], object]
    prepare: Callable[[], object] = lambda: None  # called before each turn, and not timed
    repeatable: bool = True  # whether it can run again without `prepare`
    seconds: list[float] = field(default_factory=list)

    @property
    def best(self) -> float:
        """The fastest run, which other load disturbed least."""
        return min(self.seconds)

    @property
    def median(self) -> float:
        return statistics.median(self.seconds)

    def _once(self) -> float:
        begin = time.perf_counter()
        self.run()
        return time.perf_counter() - begin

    def turn(self) -> None:
        self.prepare()
        first = self._once()
        self.seconds.append(first)
        if self.repeatable:
            self.seconds += [self._once() for _ in range(min(20, int(BURST / max(first, 1e-6))))]


def alternate(
    works: dict[str, Work], *, budget: float = 4.0, least: int = 3, most: int = 20
) -> dict[str, Work]:
    """Run all works by turns, for at least ``least`` rounds, until ``budget`` seconds are over."""
    begin = time.perf_counter()
    for done in range(most):
        if done >= least and (FEWEST_ROUNDS or time.perf_counter() - begin > budget):
            break
        for work in works.values():
            work.turn()
    return works


def rounds(vertices: int) -> int:
    """The least number of rounds. It is small for large meshes, whose times are long and vary little."""
    return 3 if vertices < 150_000 else 2 if vertices < 700_000 else 1


def arrival(excess: np.ndarray, goal: float, seconds: np.ndarray, chunk: int) -> dict[str, object]:
    """When a peer's excess over the least energy falls to `goal`, from samples every `chunk` iterations.

    If it does not fall so far, the second half of the samples is extrapolated, by a power of the time and
    exponentially; the earlier of both times counts.
    """
    within = np.flatnonzero(excess <= goal)
    if len(within):
        k = within[0]
        return {"peer": float(seconds[k]), "peer_iterations": int(k * chunk), "peer_arrived": True}
    half = slice(len(excess) // 2, None)
    log_excess = np.log(excess[half])
    guesses = []
    for time_of, back in ((np.log, np.exp), (lambda t: t, lambda t: t)):
        slope, offset = np.polyfit(time_of(seconds[half]), log_excess, 1)
        with np.errstate(over="ignore"):
            guesses.append(float(back((np.log(goal) - offset) / slope)) if slope < 0 else np.inf)
    return {
        "peer": float(seconds[-1]),
        "peer_iterations": (len(seconds) - 1) * chunk,
        "peer_arrived": False,
        "peer_excess_percent": 100 * float(excess[-1]),
        "peer_extrapolated": float(min(guesses)) if np.isfinite(min(guesses)) else None,
    }
