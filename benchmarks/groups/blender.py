# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole frames and binds in Debian's Blender and in the newest one, next to Blender's own deformers.

blender_frame.py and handler_cost.py measure inside Blender, without this suite. Here their rows get the ids
of the table.
"""

import contextlib
import io
import json
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from record import Row

from . import Options, Task

HERE = Path(__file__).resolve().parents[1]
sys.path.append(str(HERE.parent / "tools"))

from workshop import blenders, debian, environments, shell  # noqa: E402

BLENDERS = ("3.4", "5.2")
# Row of blender_frame.py -> the id of the work, and the names of Sinew's time and of the peer's.
FRAMES = {
    "frame thin_shell": ("frame_thin_shell", "ours", "peer"),
    "frame laplacian_editing": ("frame_laplacian_editing", "ours", "peer"),
    "frame explicit laplacian_editing": ("frame_laplacian_explicit", "ours", "peer"),
    "frame arap": ("frame_arap", "ours", "peer"),
    "frame short arap": ("frame_arap_3", "ours", "peer"),
    "frame draft arap": ("frame_arap_draft", "ours", "peer"),
    "frame cage": ("frame_cage", "ours", "peer"),
    "frame lattice": ("ffd_frame", "native", "peer"),
    "overhead lattice": ("overhead_ffd", "around", "bare"),
    "drag arap": ("drag_arap", "ours", "peer"),
    "overhead thin_shell": ("overhead_thin_shell", "around", "bare"),
    "overhead drag arap": ("overhead_arap", "around", "bare"),
    "bind thin_shell": ("first_thin_shell", "ours", "peer"),
    "bind arap": ("first_arap", "ours", "peer"),
    "reading thin_shell": ("reading_thin_shell", "reading", "bind"),
    "reading arap": ("reading_arap", "reading", "bind"),
    "rebind handle": ("rebind_handle", "edit", "new"),
    "rebind stiffness": ("rebind_stiffness", "edit", "new"),
}
LONGEST = 120.0  # seconds, for one row


def plan(options: Options) -> list[Task]:
    if options.quick and not options.smallest:
        return []
    # Starting Blender takes most of the time of a small row, so these share one Blender.
    parts = [list(FRAMES)] if options.smallest else [[row] for row in FRAMES]
    tasks = []
    for version in BLENDERS:
        keywords = {"version": version, "small": options.smallest}
        for rows in parts:
            works = tuple(FRAMES[row][0] for row in rows)
            tasks.append(Task("blender", works, {**keywords, "rows": rows}))
        tasks.append(Task("blender", ("handler_cost",), {**keywords, "rows": []}))
    return tasks


def measure(version: str, rows: list[str], small: bool = False) -> list[Row]:
    """The rows of one Blender: those of blender_frame.py that are named, else the cost of a handler."""
    script, convert = ("blender_frame.py", table_row) if rows else ("handler_cost.py", handler_row)
    found = run_in(version, HERE / script, [*rows, *(["--small"] if small else [])])
    return [convert(entry, version) for entry in found]


def table_row(entry: Row, version: str) -> Row:
    """A row of blender_frame.py as a row of the table, with times in seconds."""
    work, ours, peer = FRAMES[entry["row"]]
    details = {key: value for key, value in entry.items() if key not in ("row", "ratio", "goal", "at_most")}
    size = round(entry["vertices"], -5) or entry["vertices"]
    times = {"ours": entry[f"{ours}_ms"] / 1000.0, "peer": entry[f"{peer}_ms"] / 1000.0}
    return {**details, "work": work, "size": size, "case": version, "unit": "s", **times}


def handler_row(entry: Row, version: str) -> Row:
    case = f"{version}, {entry['deformers']} deformers, {entry['vertices']} vertices"
    return {**entry, "work": "handler_cost", "size": entry["vertices"], "case": case}


def run_in(version: str, script: Path, words: list[str]) -> list[Row]:
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "rows.json"
        with contextlib.redirect_stdout(io.StringIO()):  # it prints the same lines for each row
            blender, env = _installed(version)
        status = shell.run([*blender(script), *words, "--json", out], env=env, timeout=LONGEST, quiet=True)
        if not out.is_file():
            raise SystemExit(f"{script.name} in Blender {version} wrote no rows (status {status})")
        return json.loads(out.read_text(encoding="utf-8"))["rows"]


def _installed(version: str) -> tuple[Callable[[Path], list], dict[str, object]]:
    """The command that runs a script in this Blender, and an environment with the installed add-on."""
    name = f"benchmarks-{version}"
    if version == "3.4":
        debian.install(debian.BLENDER)
        headless = ["blender", "--background", "--factory-startup", "--python"]
        return (lambda script: [*headless, script, "--"]), blenders.install_legacy(name)
    newest = environments.newest_blender().make()
    return (lambda script: [newest.python, script]), blenders.install_extension(newest, name)
