# SPDX-License-Identifier: GPL-3.0-or-later
"""Storing what a benchmark measured, with what it ran on."""

import json
import os
import platform
from pathlib import Path

import numpy as np

import sinew_native

RESULTS = Path(__file__).resolve().parent / "results"


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    if info.is_file():
        for line in info.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def store(name: str, rows: list[dict[str, object]]) -> Path:
    """Writes results/<name>.json."""
    RESULTS.mkdir(exist_ok=True)
    path = RESULTS / f"{name}.json"
    machine = {
        "system": f"{platform.system()} {platform.machine()}",
        "processor": _processor(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "sinew_native": sinew_native.__version__,
    }
    path.write_text(json.dumps({"machine": machine, "rows": rows}, indent=1) + "\n", encoding="utf-8")
    return path
