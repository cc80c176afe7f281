# SPDX-License-Identifier: GPL-3.0-or-later
"""One module per group of rows. ``plan`` returns its tasks under the options, ``measure`` runs a task."""

import sys
from dataclasses import dataclass, field
from pathlib import Path

# Some peers are oracles of the tests, too.
_BINDINGS = Path(__file__).resolve().parents[2] / "tests" / "bindings"
sys.path += [str(_BINDINGS), str(_BINDINGS / "oracles")]


@dataclass(frozen=True)
class Options:
    sizes: tuple[int, ...]
    own_sizes: tuple[int, ...]  # measured without peers
    threads: tuple[int, ...]
    quick: bool
    meshes: Path | None  # folder of scanned meshes that are not part of the project
    smallest: bool = False  # for tests: each row runs once, and its time does not matter


@dataclass(frozen=True)
class Task:
    """A measurement that runs in a process of its own. The keywords go to ``measure`` of its group."""

    group: str
    works: tuple[str, ...]  # the ids of its rows, for --only
    keywords: dict[str, object] = field(default_factory=dict)

    def __str__(self) -> str:
        return " ".join([self.group, *(f"{name}={value}" for name, value in self.keywords.items())])
