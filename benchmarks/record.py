# SPDX-License-Identifier: GPL-3.0-or-later
"""Stores measurements: one file per run, with a description of the machine."""

import json
import os
import platform
from pathlib import Path

RESULTS = Path(__file__).resolve().parent / "results"
KEY = ("work", "size", "threads", "case", "blender")  # rows that agree in these measure the same

Row = dict[str, object]


def machine() -> dict[str, object]:
    return {
        "system": f"{platform.system()} {platform.machine()}",
        "processor": _processor(),
        "cores": os.cpu_count(),
        "memory_gib": round(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30),
        "python": platform.python_version(),
    }


def _processor() -> str:
    lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def key(row: Row) -> tuple:
    return tuple(row.get(name) for name in KEY)


def load(folder: Path = RESULTS) -> tuple[list[dict[str, object]], list[Row]]:
    """The machines of all runs, and the latest measurement of each row."""
    runs = [json.loads(file.read_text(encoding="utf-8")) for file in sorted(folder.glob("*.json"))]
    rows = {key(row): row for run in runs for row in run["rows"]}
    machines = [run["machine"] for run in runs]
    return [one for k, one in enumerate(machines) if one not in machines[:k]], list(rows.values())


def store(run: str, rows: list[Row], about: dict[str, object], folder: Path = RESULTS) -> Path:
    """Write results/<run>.json, one line per row, and delete earlier runs whose rows are all replaced."""
    folder.mkdir(exist_ok=True)
    lines = ",\n".join(json.dumps(row) for row in rows)
    path = folder / f"{run}.json"
    path.write_text(f'{{"machine": {json.dumps(about)},\n"rows": [\n{lines}\n]}}\n', encoding="utf-8")
    replaced = {key(row) for row in rows}
    for older in folder.glob("*.json"):
        held = json.loads(older.read_text(encoding="utf-8"))["rows"]
        if older.stem < run and replaced.issuperset(map(key, held)):
            older.unlink()
    return path
