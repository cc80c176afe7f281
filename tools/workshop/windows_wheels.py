# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the wheels of sinew_native for Windows (cross_wheels.py).

A wheel is only kept if its module needs nothing but Python and Windows' own libraries, and works in Windows'
Python under Wine.
"""

import re
from pathlib import Path

from . import wine, zig
from .archives import unpack
from .cross_wheels import Target
from .shell import say
from .windows_libraries import WINDOWS, has_python, import_library, imported_libraries, memory_functions

INPUTS = (
    "tools/requirements/windows.txt",
    *(f"tools/requirements/windows-3.{minor}.txt" for minor in (10, 11, 12, 13)),
    "tools/workshop/windows",
    *(f"tools/workshop/{name}.py" for name in ("wine", "windows_libraries", "windows_wheels")),
)
CHECK = Path(__file__).parent / "inside" / "check_module.py"
# What every Windows has. Whatever else a module imports must be in the wheel, and nothing else is.
OF_WINDOWS = re.compile(r"(kernel32|api-ms-win-crt-\w+-l1-1-0)\.dll")


def check_module(module: Path, minor: int) -> None:
    """Ends the tool if a module could not be loaded by every Windows."""
    needed = imported_libraries(module) - {f"python3{minor}.dll"}
    foreign = [name for name in needed if not OF_WINDOWS.fullmatch(name)]
    if foreign:
        raise SystemExit(f"{module.name} needs {', '.join(sorted(foreign))}, which the wheel does not hold")


def check_wheel(wheel: Path, minor: int) -> None:
    """Loads the wheel in Windows' Python under Wine, from a folder that holds nothing else."""
    unpacked = unpack(wheel, WINDOWS.tree / "wheel-check" / f"cp3{minor}")
    said = wine.said_in_windows([wine.python(minor), CHECK], {"PYTHONPATH": f"Z:{unpacked}"}, timeout=300)
    if f"works in Python 3.{minor}." not in said:
        raise SystemExit(f"{wheel.name} does not work in Windows' Python 3.{minor} under Wine:\n{said}")
    say(f"{wheel.name} works in Windows' Python 3.{minor} under Wine")


TARGET = Target(
    system=WINDOWS,
    platform="win_amd64",
    suffix=".cp3{minor}-win_amd64.pyd",
    inputs=INPUTS,
    check_module=check_module,
    check_wheel=check_wheel,
    python=lambda minor: [
        f"-DPython_LIBRARY={import_library(minor)}",
        f"-DCMAKE_MODULE_LINKER_FLAGS={' '.join(map(str, memory_functions()))}",
    ],
    has_python=has_python,
    licences={"mingw-w64": zig.PACKAGE / "lib" / "libc" / "mingw" / "COPYING"},
)
