# SPDX-License-Identifier: GPL-3.0-or-later
"""The module for Windows under Wine, next to the same binds, solves and frames on this machine, by turns.

Wine hands files, memory and threads on to Linux, so these figures tell of the compiler, of the BLAS and of
Wine, and say little about Windows itself.
"""

import json
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from record import Row

from . import Options, Task

HERE = Path(__file__).resolve().parents[1]
sys.path.append(str(HERE.parent / "tools"))

from workshop import blenders, environments, shell, windows_tests, wine  # noqa: E402
from workshop.package import package  # noqa: E402
from workshop.places import BUILD  # noqa: E402
from workshop.windows_libraries import WINDOWS  # noqa: E402

ROUNDS = 3
LONGEST = 300.0  # seconds, for one process
PARTS = {"library": ("windows_bind", "windows_solve"), "blender": ("windows_frame",)}
Times = dict[str, dict[str, float]]  # seconds by the id of the work and by method


def plan(options: Options) -> list[Task]:
    if options.quick and not options.smallest:
        return []
    size = 1_000 if options.smallest else 50_000
    return [Task("windows", works, {"part": part, "size": size}) for part, works in PARTS.items()]


def measure(part: str, size: int) -> list[Row]:
    small = size < 10_000
    systems = SYSTEMS[part](size, small)
    rounds = [{name: run() for name, run in systems.items()} for _ in range(1 if small else ROUNDS)]
    vertices = size if part == "library" else 1_600 if small else 99_856
    rows = []
    for work, methods in rounds[0]["wine"].items():
        for method in methods:
            ours, peer = (
                min(times[system][work][method] for times in rounds) for system in ("wine", "linux")
            )
            row = {"work": work, "size": vertices, "vertices": vertices, "case": method, "unit": "s"}
            rows.append({**row, "ours": ours, "peer": peer})
    return rows


def _library(size: int, _small: bool) -> dict[str, Callable[[], Times]]:
    """Both by their wheels, in Python 3.11."""
    script, here = HERE / "system_times.py", environments.dev().make().python
    windows_tests.build_wheel(11)

    def times(run: Callable, python: Path, drive: str, module: Path) -> Times:
        env = {"PYTHONPATH": f"{drive}{module}"}
        found = _written(
            lambda out: run([python, script, f"{drive}{out}", str(size)], env=env, timeout=LONGEST)
        )
        return {f"windows_{what}": methods for what, methods in found.items()}

    windows = WINDOWS.tree / "wheel-check" / "cp311"
    package()
    return {
        "wine": lambda: times(wine.run_in_windows, wine.python(11), "Z:", windows),
        "linux": lambda: times(shell.run, here, "", BUILD / "wheel-check" / "cp311"),
    }


def _blender(_size: int, small: bool) -> dict[str, Callable[[], Times]]:
    """Both in the same release of Blender, by the extension."""
    here = environments.blender(windows_tests.VERSION).make()
    installed = (
        windows_tests.install_extension(windows_tests.VERSION),
        blenders.install_extension(here, "benchmarks-system"),
    )
    words = ["--small"] if small else []

    def times(run: Callable, python: Path, drive: str, env: dict) -> Times:
        script = [python, HERE / "system_frame.py", *words, "--json"]
        return {
            "windows_frame": _written(lambda out: run([*script, f"{drive}{out}"], env=env, timeout=LONGEST))
        }

    windows = wine.python(11, f"bpy-{windows_tests.VERSION}")
    return {
        "wine": lambda: times(wine.run_in_windows, windows, "Z:", installed[0]),
        "linux": lambda: times(shell.run, here.python, "", installed[1]),
    }


SYSTEMS = {"library": _library, "blender": _blender}


def _written(run: Callable[[Path], int]) -> dict:
    """What a process writes into the file that it is given. Under Wine its status proves nothing."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "times.json"
        status = run(out)
        if not out.is_file():
            raise SystemExit(f"no times were written (status {status})")
        return json.loads(out.read_text(encoding="utf-8"))
