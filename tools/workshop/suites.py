# SPDX-License-Identifier: GPL-3.0-or-later
"""What several layers of the tests share: where results go, and the processes of GoogleTest."""

import os
import shlex
import shutil
from collections.abc import Mapping
from pathlib import Path

from .places import BUILD
from .results import Outcome, outcome
from .shell import jobs, run

RESULTS = BUILD / "results"
OPTIONS = ("-p", "no:cacheprovider", "-q")
# Processes of GoogleTest. One process per test would be slower: under sanitizers a process takes half a
# second to start, and most tests take less.
SHARDS = 8
IN_SHARDS = """seq 0 $((GTEST_TOTAL_SHARDS - 1)) |
    xargs -P "$1" -I{} env GTEST_SHARD_INDEX={} "${@:3}" --gtest_output="xml:$2-{}.xml" """


def files(words: str) -> tuple[str, ...]:
    """The names of files of tests, by what they test."""
    return tuple(f"test_{word}.py" for word in words.split())


def only_named(expression: str) -> None:
    """Lets pytest and GoogleTest, which read these variables, run the tests of this name alone."""
    os.environ["PYTEST_ADDOPTS"] = shlex.join(["-k", expression])
    os.environ["GTEST_FILTER"] = f"*{expression}*"


def only_some() -> bool:
    """Whether tests are chosen by their names."""
    return "GTEST_FILTER" in os.environ


def googletest(
    name: str,
    program: list[str | Path],
    timeout: float,
    env: Mapping[str, str | Path] | None = None,
    drive: str = "",
) -> Outcome:
    """Runs a program of GoogleTest, or one with a command before it, in several processes; some tests in one.
    ``drive`` is that of Windows on which the program finds this machine's files."""
    shards = 1 if only_some() else SHARDS
    files = [new_junit(f"{name}-{number}") for number in range(shards)]
    status = run(
        ["bash", "-c", IN_SHARDS, "shards", str(jobs()), f"{drive}{RESULTS / name}", *program],
        env={**(env or {}), "GTEST_TOTAL_SHARDS": str(shards), "GTEST_BRIEF": "1"},
        cwd=Path(program[-1]).parent,
        timeout=timeout,
    )
    found = sum((outcome(file, 0) for file in files), Outcome())
    if status != 0 and found.failed == 0:
        found += Outcome(failed=1, note=f"all tests passed, yet a process ended with status {status}")
    return found


def new_junit(name: str) -> Path:
    """Where a suite writes its results; what lies there is removed."""
    RESULTS.mkdir(parents=True, exist_ok=True)
    file = RESULTS / f"{name}.xml"
    file.unlink(missing_ok=True)
    return file


def emptied(folder: Path) -> Path:
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder
