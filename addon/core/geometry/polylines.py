# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves as rows of samples at even steps of their parameter."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Lines:
    """How samples belong to lines, one line after the other: ``counts`` (k,), and which are ``closed`` (k,).

    ``length`` is that of all of them in their own space.
    """

    counts: tuple[int, ...]
    closed: tuple[bool, ...]
    length: float = 0.0

    @property
    def total(self) -> int:
        """How many samples there are."""
        return sum(self.counts)

    def to_text(self) -> str:
        """A text from which ``from_text`` makes it again."""
        each = zip(self.counts, self.closed, strict=True)
        lines = " ".join(f"{count}{'o' * bool(closed)}" for count, closed in each)
        return f"{self.length!r} {lines}"

    @classmethod
    def from_text(cls, text: str) -> "Lines":
        """The lines of a text that ``to_text`` made; no lines for an empty text."""
        if not text:
            return cls((), ())
        length, *lines = text.split()
        counts = tuple(int(line.rstrip("o")) for line in lines)
        return cls(counts, tuple(line.endswith("o") for line in lines), float(length))

    def split(self, samples: np.ndarray) -> list[np.ndarray]:
        """The samples (c, 3) of each line."""
        return np.split(samples, np.cumsum(self.counts)[:-1])


def lines_of(count: int, edges: np.ndarray) -> Lines | None:
    """How ``edges`` (e, 2) join ``count`` vertices in their order; None if they join any others."""
    low, high = np.sort(edges.reshape(-1, 2), axis=1).T
    steps = high - low == 1
    joined = np.zeros(max(count - 1, 0), dtype=bool)
    joined[low[steps]] = True
    ends = np.flatnonzero(~joined)
    begins = np.concatenate(([0], ends + 1)) if count else np.zeros(0, dtype=int)
    counts = np.diff(begins, append=count)
    closing = set(zip(low[~steps].tolist(), high[~steps].tolist(), strict=True))
    rings = [(int(first), int(first + number - 1)) for first, number in zip(begins, counts, strict=True)]
    if closing - set(rings):
        return None
    return Lines(tuple(counts.tolist()), tuple(ring in closing for ring in rings))


def lengths(samples: np.ndarray, lines: Lines) -> list[float]:
    """The length of each line of samples (c, 3)."""
    found = []
    for line, closed in zip(lines.split(samples), lines.closed, strict=True):
        sides = np.diff(np.concatenate((line, line[:1])) if closed else line, axis=0)
        found.append(float(np.linalg.norm(sides, axis=1).sum()))
    return found


def resampled(samples: np.ndarray, lines: Lines, wanted: Lines) -> np.ndarray:
    """Samples (c, 3) of ``wanted`` lines at even steps of the parameter of the lines of ``samples``.

    If there are fewer of these, the last one stands for those that are missing.
    """
    given, found = lines.split(samples), []
    for number, count in enumerate(wanted.counts):
        at = min(number, len(given) - 1)
        line, closed = given[at], lines.closed[at]
        end = len(line) if closed else len(line) - 1
        places = np.linspace(0.0, end, count, endpoint=not (closed and wanted.closed[number]))
        line = np.concatenate((line, line[:1]))
        low = np.minimum(places.astype(int), len(line) - 2)
        share = (places - low)[:, None]
        found.append((1.0 - share) * line[low] + share * line[low + 1])
    return np.concatenate(found)
