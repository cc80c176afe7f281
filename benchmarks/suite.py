# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures every row of docs/developer/performance.md next to its peer.

Each measurement runs in a process of its own, in which Sinew and the peer run by turns. Nothing fails because
it is slow: every ratio is printed beside the ratio that is wanted. `--store` stores the results, draws the
plots and rewrites the figures in README.md and docs/developer/performance.md; `--render` only draws and
rewrites.
"""

import argparse
import importlib
import json
import os
import shlex
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import documents
import record
import report
import timing
from groups import Options, Task
from record import Row

GROUPS = (
    "thin_shell",
    "rebind",
    "linear",
    "multiresolution",
    "attachments",
    "puppetry",
    "memory",
    "arap",
    "pyramid",
    "reduced",
    "convergence",
    "primo",
    "space_nonlinear",
    "shell",
    "sequence",
    "subdivision",
    "cages",
    "lattices",
    "curves",
    "cages_harmonic",
    "points",
    "automatic_cage",
    "blender",
    "windows",
)
SIZES = (10_000, 50_000, 200_000, 500_000)
SCALE = (1_000_000, 2_000_000)
QUICK = (10_000,)
MESHES = os.environ.get("SINEW_BENCHMARK_MESHES")


def group(name: str):
    return importlib.import_module(f"groups.{name}")


def every_task(options: Options) -> list[Task]:
    return [task for name in GROUPS for task in group(name).plan(options)]


def plan(options: argparse.Namespace) -> list[Task]:
    """What to measure. ``--only`` takes groups, works, or both."""
    sizes = tuple(options.sizes or (QUICK if options.quick or options.smallest else SIZES))
    wanted = Options(
        sizes=sizes,
        own_sizes=SCALE if options.scale else (),
        threads=tuple(options.threads),
        quick=options.quick or options.smallest,
        meshes=options.meshes,
        smallest=options.smallest,
    )
    tasks = every_task(wanted)
    if not options.only:
        return tasks
    known = {name for task in tasks for name in (task.group, *task.works)} | {*GROUPS, "instructions"}
    unknown = sorted(set(options.only) - known)
    if unknown:
        raise SystemExit(
            f"there is no group or row {', '.join(unknown)}; there are {', '.join(sorted(known))}"
        )
    return [task for task in tasks if set(options.only) & {task.group, *task.works}]


def run_task(task: Task, through: list[str], smallest: bool = False) -> list[Row]:
    """Run a task in a process of its own. Returns its rows; none, with a message, if it failed."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "rows.json"
        words = ["--measure", task.group, json.dumps(task.keywords), str(out)]
        words += ["--smallest"] if smallest else []
        status = subprocess.run([*through, sys.executable, __file__, *words]).returncode
        if status != 0 or not out.is_file():
            print(f"{task}: not measured (status {status})", flush=True)
            return []
        return json.loads(out.read_text(encoding="utf-8"))


def measure_here(name: str, keywords: str, out: str) -> None:
    rows = group(name).measure(**json.loads(keywords))
    Path(out).write_text(json.dumps(rows), encoding="utf-8")


def count_instructions(store: bool) -> None:
    script = Path(__file__).parent / "instructions" / "count.py"
    subprocess.run([sys.executable, script, *(["--store"] if store else [])])


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="benchmarks/run",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    groups = ", ".join((*GROUPS, "instructions"))
    parser.add_argument("--only", action="append", metavar="NAME", help=f"a group ({groups}) or a row")
    parser.add_argument(
        "--quick", action="store_true", help="10,000 vertices and no Blender, which takes 3 minutes"
    )
    parser.add_argument(
        "--smallest", action="store_true", help="each row once, at its smallest size, as in the tests"
    )
    parser.add_argument("--scale", action="store_true", help="also Sinew alone at 1 and 2 million vertices")
    parser.add_argument(
        "--sizes", type=int, nargs="+", metavar="N", help="numbers of vertices, instead of the usual ones"
    )
    parser.add_argument("--threads", type=int, nargs="+", metavar="N", default=[1, 2])
    meshes_help = "holds armadillo.obj and decimated-knight.off; default: SINEW_BENCHMARK_MESHES"
    parser.add_argument("--meshes", type=Path, default=MESHES, metavar="FOLDER", help=meshes_help)
    parser.add_argument("--store", action="store_true", help="store the results and rewrite the documents")
    parser.add_argument("--render", action="store_true", help="measure nothing, rewrite the documents")
    parser.add_argument("--list", action="store_true", help="list what would be measured")
    parser.add_argument(
        "--through",
        default="",
        metavar="COMMAND",
        help='a command that runs each measurement, for example "nice"',
    )
    parser.add_argument("--measure", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.smallest and options.store:
        parser.error("--smallest measures too little for --store")
    return options


def main() -> None:
    options = arguments()
    timing.FEWEST_ROUNDS = options.smallest
    if options.measure:
        measure_here(*options.measure)
        return
    if options.render:
        documents.render()
        return
    tasks = plan(options)
    if options.list:
        print(*tasks, sep="\n")
        return
    if options.meshes is None:
        print("Without --meshes, the rows of the armadillo and of the knight are left out")
    about, begin = record.machine(), time.monotonic()
    run = time.strftime("%Y-%m-%d-%H%M", time.gmtime())
    rows: list[Row] = []
    for task in tasks:
        found = run_task(task, shlex.split(options.through), options.smallest)
        rows += found
        for row in found:
            print(report.line(row), flush=True)
        if options.store and found:
            record.store(run, rows, about)
    print(*report.summary(rows), sep="\n")
    if not options.only or "instructions" in options.only:
        count_instructions(options.store)
    if options.store:
        documents.render()
    print(f"{time.monotonic() - begin:.0f} s on {about['processor']}, {about['cores']} cores")


if __name__ == "__main__":
    main()
