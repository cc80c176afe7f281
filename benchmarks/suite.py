# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures every row of docs/developer/performance.md next to its peer.

Each measurement runs in a process of its own, in which Sinew and the peer run by turns. Nothing fails because
it is slow: every ratio is printed beside the ratio that is wanted. `--store` stores the results and rewrites
the figures in README.md and docs/developer/performance.md; `--render` only rewrites.
"""

import argparse
import importlib
import json
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import documents
import record
import report
from record import Row
from works import BY_ID

HERE = Path(__file__).resolve().parent
# Some peers are oracles of the tests; rows that run in Blender or under Wine are set up by the tools.
sys.path += [str(HERE.parent / place) for place in ("tools", "tests/bindings", "tests/bindings/oracles")]

THREADS = (1, 2)
QUICK, SMALLEST = 10_000, 2_000  # the most vertices that `--quick` and `--smallest` measure
STARTS_BLENDER_OR_WINE = ("blender", "cages.harmonic", "windows")  # `--quick` leaves these out
INSTRUCTIONS = HERE / "instructions" / "count.py"


@dataclass(frozen=True)
class Task:
    """A measurement that runs in a process of its own, and the works whose rows it gives."""

    measure: str
    size: int
    works: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.measure} {self.size}"


def every_task(most: int | None = None) -> list[Task]:
    """All tasks; or one per function, at its least size or at ``most``, if that is less."""
    tasks: dict[tuple[str, int], list[str]] = {}
    for work in BY_ID.values():
        for size in work.sizes if most is None else [min(most, *work.sizes)]:
            tasks.setdefault((work.measure, size), []).append(work.id)
    return [Task(measure, size, tuple(ids)) for (measure, size), ids in tasks.items()]


def plan(options: argparse.Namespace) -> list[Task]:
    """What to measure. ``--only`` takes rows, and modules or functions of ``rows/``."""
    tasks = every_task(SMALLEST if options.smallest else QUICK if options.quick else None)
    if options.quick:
        tasks = [task for task in tasks if not task.measure.startswith(STARTS_BLENDER_OR_WINE)]
    if not options.only:
        return tasks
    names = {task: {task.measure, *task.measure.split("."), *task.works} for task in tasks}
    known = {"instructions"}.union(*names.values())
    if unknown := sorted(set(options.only) - known):
        raise SystemExit(f"there is no row {', '.join(unknown)}; there are {', '.join(sorted(known))}")
    return [task for task in tasks if names[task] & set(options.only)]


def run_task(task: Task, smallest: bool = False) -> list[Row]:
    """Run a task in a process of its own. Returns its rows; none, with a message, if it failed."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "rows.json"
        words = ["--measure", task.measure, str(task.size), str(out), *(["--smallest"] if smallest else [])]
        status = subprocess.run([sys.executable, __file__, *words]).returncode
        if status != 0 or not out.is_file():
            print(f"{task}: not measured (status {status})", flush=True)
            return []
        about = {"work": task.works[0], "size": task.size, "vertices": task.size, "unit": "s"}
        return [about | row for row in json.loads(out.read_text(encoding="utf-8"))]


def measure_here(measure: str, size: str, out: str, smallest: bool) -> None:
    import timing

    timing.FEWEST_ROUNDS = smallest
    module, _, function = measure.partition(".")
    rows = getattr(importlib.import_module(f"rows.{module}"), function)(int(size), THREADS)
    Path(out).write_text(json.dumps(rows), encoding="utf-8")


def arguments() -> argparse.Namespace:
    as_it_is = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="benchmarks/run", description=__doc__, formatter_class=as_it_is)
    only = "a row, a function that measures rows, or instructions; may be repeated"
    parser.add_argument("--only", action="append", metavar="NAME", help=only)
    parser.add_argument("--quick", action="store_true", help="10,000 vertices and no Blender: some minutes")
    parser.add_argument("--smallest", action="store_true", help="each row once, at its smallest size")
    parser.add_argument("--store", action="store_true", help="store the results and rewrite the documents")
    parser.add_argument("--render", action="store_true", help="measure nothing, rewrite the documents")
    parser.add_argument("--measure", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.smallest and options.store:
        parser.error("--smallest measures too little for --store")
    return options


def main() -> None:
    options = arguments()
    if options.measure:
        measure_here(*options.measure, options.smallest)
        return
    if options.render:
        documents.render()
        return
    about, begin = record.machine(), time.monotonic()
    run = time.strftime("%Y-%m-%d-%H%M", time.gmtime())
    rows: list[Row] = []
    for task in plan(options):
        found = run_task(task, options.smallest)
        rows += found
        for row in found:
            print(report.line(row), flush=True)
        if options.store and found:
            record.store(run, rows, about)
    print(report.summary(rows))
    if not options.only or "instructions" in options.only:
        subprocess.run([sys.executable, INSTRUCTIONS, *(["--store"] if options.store else [])])
    if options.store:
        documents.render()
    print(f"{time.monotonic() - begin:.0f} s on {about['processor']}, {about['cores']} cores")


if __name__ == "__main__":
    main()
