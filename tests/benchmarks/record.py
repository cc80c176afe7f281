# SPDX-License-Identifier: GPL-3.0-or-later
"""Storing what was measured, with what it ran on."""

import json
import os
import platform
from pathlib import Path

RESULTS = Path(__file__).resolve().parent / "results"
KEY = ("work", "size", "threads", "case", "blender")  # what makes a row the same row, measured again

Row = dict[str, object]


def machine() -> dict[str, object]:
    return {
        "system": f"{platform.system()} {platform.machine()}",
        "processor": _processor(),
        "cores": os.cpu_count(),
        "memory_gib": _memory_gib(),
        "python": platform.python_version(),
    }


def _processor() -> str:
    for line in _lines("/proc/cpuinfo"):
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def _memory_gib() -> int:
    return round(next((int(line.split()[1]) for line in _lines("/proc/meminfo")), 0) / 2**20)


def _lines(path: str) -> list[str]:
    file = Path(path)
    return file.read_text(encoding="utf-8").splitlines() if file.is_file() else []


def key(row: Row) -> tuple:
    return tuple(row.get(name) for name in KEY)


def merged(old: list[Row], new: list[Row]) -> list[Row]:
    """The old rows with those that were measured again replaced, and new ones at the end."""
    rows = {key(row): row for row in old} | {key(row): row for row in new}
    return list(rows.values())


def load(folder: Path = RESULTS) -> dict[str, dict[str, object]]:
    """Group -> what results/<group>.json holds: "machine", "rows"."""
    return {file.stem: json.loads(file.read_text(encoding="utf-8")) for file in sorted(folder.glob("*.json"))}


def store(group: str, rows: list[Row], about: dict[str, object], folder: Path = RESULTS) -> Path:
    """Writes results/<group>.json; rows of an earlier run stay unless measured again."""
    folder.mkdir(exist_ok=True)
    path = folder / f"{group}.json"
    old = json.loads(path.read_text(encoding="utf-8"))["rows"] if path.is_file() else []
    text = json.dumps({"machine": about, "rows": merged(old, rows)}, indent=1)
    path.write_text(text + "\n", encoding="utf-8")
    return path
