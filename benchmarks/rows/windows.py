# SPDX-License-Identifier: GPL-3.0-or-later
"""The module for Windows under Wine, next to the same binds, solves and warps on this machine, by turns.

Wine hands files, memory and threads on to Linux, so these figures tell of the compiler, of the BLAS and of
Wine, and say little about Windows itself. Both run by their wheels, in Python 3.11.
"""

import json
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import timing
from record import Row
from workshop import environments, shell, windows_tests, wine
from workshop.package import package
from workshop.places import BUILD
from workshop.windows_libraries import WINDOWS

SCRIPT = Path(__file__).resolve().parents[1] / "scripts" / "system_times.py"
ROUNDS = 3
LONGEST = 300.0  # seconds, for one process


def library(size: int, _threads: Sequence[int]) -> list[Row]:
    windows_tests.build_wheel(11)
    package()
    runs = {
        "ours": (wine.run_in_windows, wine.python(11), "Z:", WINDOWS.tree / "wheel-check" / "cp311"),
        "peer": (shell.run, environments.dev().make().python, "", BUILD / "wheel-check" / "cp311"),
    }
    count = 1 if timing.FEWEST_ROUNDS else ROUNDS
    rounds = [{side: _times(size, *run) for side, run in runs.items()} for _ in range(count)]
    least = lambda side, case: min(times[side][case] for times in rounds)  # noqa: E731
    return [{"case": case, **{side: least(side, case) for side in runs}} for case in rounds[0]["ours"]]


def _times(size: int, run: Callable, python: Path, drive: str, module: Path) -> dict[str, float]:
    """What a process writes into the file that it is given. Under Wine its status proves nothing."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "times.json"
        words = [python, SCRIPT, f"{drive}{out}", str(size)]
        status = run(words, env={"PYTHONPATH": f"{drive}{module}"}, timeout=LONGEST)
        if not out.is_file():
            raise SystemExit(f"no times were written (status {status})")
        return json.loads(out.read_text(encoding="utf-8"))
