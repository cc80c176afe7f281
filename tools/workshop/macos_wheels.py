# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the wheels of sinew_native for Apple's processors by zig (cross_wheels.py). They are never run.

A wheel is only kept if its module says that macOS 11 can load it, needs nothing but Python and libSystem,
names no folder of this machine, and is signed, which Apple's processors ask for.
"""

import re
from pathlib import Path

from . import mach_o, zig
from .archives import read_zip
from .cross_wheels import Target
from .places import ROOT
from .shell import say

SYSTEM = zig.system("macos", "macOS", "aarch64-macos.11.0")
INPUTS = ("tools/workshop/macos", *(f"tools/workshop/{name}.py" for name in ("mach_o", "macos_wheels")))
# Operators new and delete, which C++ lets a program replace. All of them are malloc and free.
ALLOCATION = re.compile(r"__Z(?:n[aw]|d[al])")
LIB_SYSTEM = "/usr/lib/libSystem.B.dylib"  # every Mac has it; libc++ is linked statically


def check_module(module: Path, minor: int) -> None:
    """Ends the tool if a module could not be loaded by macOS 11, as far as the file shows it."""
    if found := flaws(module.read_bytes()):
        raise SystemExit(f"{module.name}: {'; '.join(found)}")


def flaws(content: bytes) -> list[str]:
    """What would keep a Mac with an Apple processor from loading a module, or tells of this machine."""
    module = mach_o.read(content)
    fits = (module.processor, module.kind) == (mach_o.ARM64, mach_o.LIBRARY)
    system = f"platform {module.platform} from {module.minimum} on"
    foreign = {*module.libraries, *module.run_paths} - {LIB_SYSTEM}
    lacking = {name for name, library in module.wanted.items() if not library}
    unknown = {name for name in lacking if not name.startswith(("_Py", "__Py"))}
    replaced = {name for name in module.shared if not ALLOCATION.match(name)}
    places = {str(place) for place in (ROOT, Path.home()) if f"{place}/".encode() in content}
    found = {
        "it is no library for Apple's processors": not fits,
        f"it is for {system}, not for macOS from 11.0 on": (module.platform, module.minimum)
        != (mach_o.MACOS, (11, 0)),
        f"it looks for {', '.join(sorted(foreign))}, which the wheel does not hold": foreign,
        f"nothing defines {', '.join(sorted(unknown))}": unknown,
        "Python cannot initialise it": "_PyInit_sinew_native" not in module.exported,
        f"other libraries may replace its {', '.join(sorted(replaced))}": replaced,
        f"it names {', '.join(sorted(places))}": places,
        "its signature is missing or wrong": not module.signed,
    }
    return [flaw for flaw, is_there in found.items() if is_there]


def check_wheel(wheel: Path, minor: int) -> None:
    """Ends the tool if the tags inside a wheel are not those of its name."""
    files = read_zip(wheel)
    about = next(content for name, content in files.items() if name.endswith(".dist-info/WHEEL"))
    tag = f"Tag: {wheel.stem.split('-', 2)[2]}"
    if about.decode().splitlines().count(tag) != 1 or "Root-Is-Purelib: false" not in about.decode():
        raise SystemExit(f"{wheel.name} does not say {tag}, but:\n{about.decode()}")
    say(f"{wheel.name} is built, never run: no Mac is here, and what its file tells macOS is right")


TARGET = Target(
    system=SYSTEM,
    platform="macosx_11_0_arm64",
    suffix=".cpython-3{minor}-darwin.so",
    inputs=INPUTS,
    check_module=check_module,
    check_wheel=check_wheel,
)
