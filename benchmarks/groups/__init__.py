# SPDX-License-Identifier: GPL-3.0-or-later
"""One module a group of rows. Each has ``plan`` (what to measure, under the options) and ``measure``."""

from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class Options:
    sizes: tuple[int, ...]
    own_sizes: tuple[int, ...]  # measured without peers
    threads: tuple[int, ...]
    quick: bool
    meshes: Path | None  # scanned meshes that the project does not carry
    smallest: bool = False  # each row once, for the tests: whether it runs, not how fast


@dataclass(frozen=True)
class Task:
    """What runs in a process of its own; the keywords go to the group's ``measure``."""

    group: str
    works: tuple[str, ...]  # what its rows may be called, for --only
    keywords: dict[str, object] = field(default_factory=dict)

    def __str__(self) -> str:
        return " ".join([self.group, *(f"{name}={value}" for name, value in self.keywords.items())])
