# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the wheels of sinew_native for Windows (cross_wheels.py).

A wheel is only kept if its module needs nothing but Python and Windows' own libraries, moves no wide vector
in a way that Windows' stack is not aligned for, and works in Windows' Python under Wine.
"""

import re
from pathlib import Path

from . import wine
from .archives import unpack
from .cross_wheels import Target
from .notices import of_packages
from .shell import said, say
from .windows_libraries import WINDOWS, import_library, imported_libraries

INPUTS = (
    *(f"tools/requirements/windows{python}.txt" for python in ("", "-3.11", "-3.13")),
    "tools/workshop/windows",
    *(f"tools/workshop/{name}.py" for name in ("wine", "windows_libraries", "windows_wheels")),
)
CHECK = Path(__file__).parent / "inside" / "check_module.py"
# The packages of this machine that come from the sources of what is linked into the module.
LINKED = ("gcc-mingw-w64-base", "libosd-dev", "libsuitesparse-dev", "libtbb-dev", "mingw-w64-x86-64-dev")
# What every Windows has. Whatever else a module imports must be in the wheel, and nothing else is.
OF_WINDOWS = {"kernel32.dll", "msvcrt.dll"}
# Moves between a register of 32 or 64 bytes and the stack that fail where the stack is aligned to 16 bytes.
ALIGNED_MOVE = re.compile(
    r"\tvmov(?:ap[sd]|dqa\w*|ntp[sd]|ntdqa?)\s[^\n]*(?:\(%r[sb]p[^\n]*%[yz]mm|%[yz]mm[^\n]*\(%r[sb]p)"
)


def check_module(module: Path, minor: int) -> None:
    """Ends the tool if a module could not be loaded by every Windows, or might crash there."""
    foreign = imported_libraries(module) - OF_WINDOWS - {f"python3{minor}.dll"}
    if foreign:
        raise SystemExit(f"{module.name} needs {', '.join(sorted(foreign))}, which the wheel does not hold")
    aligned = ALIGNED_MOVE.findall(disassembled(module))
    if aligned:
        raise SystemExit(f"{module.name} has {len(aligned)} aligned moves of wide vectors on the stack")


def disassembled(module: Path) -> str:
    return said(["x86_64-w64-mingw32-objdump", "-d", "--no-show-raw-insn", module])


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
    licences=lambda: of_packages(LINKED),
    python=lambda minor: [f"-DPython_LIBRARY={import_library(minor)}"],
    check_module=check_module,
    check_wheel=check_wheel,
)
