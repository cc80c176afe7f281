# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the wheels of sinew_native for Linux by zig (cross_wheels.py), for a C library as old as Blender's.

A wheel is only kept if its module needs nothing but Python and a C library of 2.28, shows no symbol but its
entry, and works in plain CPython and, if installed, in Debian's Blender.
"""

import re
import shutil
from pathlib import Path

from . import environments, zig
from .archives import unpack
from .cross_wheels import Target
from .places import PYTHON311
from .shell import must, said, say

GLIBC = (2, 28)
SYSTEM = zig.system("linux", "Linux", f"x86_64-linux-gnu.{GLIBC[0]}.{GLIBC[1]}")
INPUTS = ("tools/workshop/linux", "tools/workshop/linux_wheels.py")
OF_LINUX = re.compile(r"lib(c|m|dl|rt|pthread)\.so\.\d|ld-linux-x86-64\.so\.2")
CHECK = Path(__file__).parent / "inside" / "check_module.py"


def check_module(module: Path, minor: int) -> None:
    """Ends the tool if a module could not be loaded by every Linux of the last years."""
    found = flaws(said(["readelf", "--wide", "--dynamic", "--dyn-syms", module]))
    if found:
        raise SystemExit(f"{module.name}: {'; '.join(found)}")


def flaws(listing: str) -> list[str]:
    """What would keep a Linux with an old C library from loading a module, by readelf's listing of it."""
    needed = re.findall(r"\(NEEDED\).*\[(.*)\]", listing)
    foreign = [name for name in needed if not OF_LINUX.fullmatch(name)]
    found = [f"it needs {name}, which the wheel does not hold" for name in foreign]
    found += [f"it looks in {place}" for place in re.findall(r"\((?:RPATH|RUNPATH)\).*\[(.*)\]", listing)]
    versions = {tuple(map(int, each.split("."))) for each in re.findall(r"@GLIBC_([\d.]+)", listing)}
    found += [f"it needs glibc {'.'.join(map(str, each))}" for each in sorted(versions) if each > GLIBC]
    symbols = [line.split() for line in listing.splitlines() if re.match(r"\s*\d+: [0-9a-f]{16}", line)]
    shown = {fields[7] for fields in symbols if fields[6] != "UND" and fields[4] in ("GLOBAL", "WEAK")}
    if shown != {"PyInit_sinew_native"}:
        found.append(f"it shows {', '.join(sorted(shown)[:9])}")
    asked = [fields for fields in symbols if len(fields) > 7 and fields[4] == "GLOBAL"]
    wanted = {fields[7] for fields in asked if fields[6] == "UND"}
    unknown = sorted(name for name in wanted if "@" not in name and not name.startswith(("Py", "_Py")))
    if unknown:
        found.append(f"nothing defines {', '.join(unknown)}")
    # Else the linker took the object of zig's own runtime, whose functions are slower (linux/division.c).
    if not any(name.startswith("memcpy@") for name in wanted):
        found.append("it has a memcpy of its own")
    return found


def check_wheel(wheel: Path, minor: int) -> None:
    """Loads the wheel in plain CPython and, if installed, in Debian's Blender."""
    unpacked = unpack(wheel, SYSTEM.tree / "wheel-check" / f"cp3{minor}")
    builder = environments.build_for(minor)
    must([builder.python, "-I", CHECK, unpacked], timeout=120, quiet=True)
    say(f"{wheel.name} works in {builder.interpreter}")
    blender = shutil.which("blender", path="/usr/bin")
    if blender and builder.interpreter == PYTHON311:
        script = [blender, "--background", "--factory-startup", "--python-exit-code", "1", "--python", CHECK]
        must([*script, "--", unpacked], timeout=120, quiet=True)
        say(f"{wheel.name} works in {blender}")


TARGET = Target(
    system=SYSTEM,
    platform=f"manylinux_{GLIBC[0]}_{GLIBC[1]}_x86_64",
    suffix=".cpython-3{minor}-x86_64-linux-gnu.so",
    inputs=INPUTS,
    check_module=check_module,
    check_wheel=check_wheel,
)
