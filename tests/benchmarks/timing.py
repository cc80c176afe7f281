# SPDX-License-Identifier: GPL-3.0-or-later
"""Timing several works by turns, so that whatever else the machine does falls on all of them alike."""

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, field

BURST = 0.02  # seconds: short works are timed several times in a row once it is their turn


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
        if done >= least and time.perf_counter() - begin > budget:
            break
        for work in works.values():
            work.turn()
    return works
