# SPDX-License-Identifier: GPL-3.0-or-later
"""Timing several works by turns, so that whatever else the machine does falls on all of them alike."""

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

BURST = 0.02  # seconds: short works are timed several times in a row once it is their turn
LEAST_ALONE = (
    False  # no more rounds than the least: for a test, which asks for any figure, not for a good one
)


@dataclass
class Work:
    run: Callable[[], object]
    prepare: Callable[[], object] = lambda: None  # before each turn, not timed
    repeatable: bool = True  # without `prepare` in between
    seconds: list[float] = field(default_factory=list)

    @property
    def best(self) -> float:
        """The run that the rest of the machine disturbed least."""
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
    """Turn after turn of all works, at least ``least`` rounds, until ``budget`` seconds are spent."""
    begin = time.perf_counter()
    for done in range(most):
        if done >= least and (LEAST_ALONE or time.perf_counter() - begin > budget):
            break
        for work in works.values():
            work.turn()
    return works


def rounds(vertices: int) -> int:
    """The least number of turns: fewer where one takes long, and what is long varies little."""
    return 3 if vertices < 150_000 else 2 if vertices < 700_000 else 1


def arrival(excess: np.ndarray, goal: float, seconds: np.ndarray, chunk: int) -> dict[str, object]:
    """When a peer's excess over the minimum falls to `goal`, from samples every `chunk` iterations.

    Past the last sample, the excess is taken to fall on as in the second half of the run, by a power of
    the time or exponentially, whichever arrives first.
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
