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
from .notices import of_packages
from .places import ROOT
from .shell import say

SYSTEM = zig.system("macos", "macOS", "aarch64-macos.11.0")
INPUTS = (
    "tools/requirements/zig.txt",
    "tools/workshop/macos",
    *(f"tools/workshop/{name}.py" for name in ("mach_o", "macos_wheels", "zig")),
)
# Operators new and delete, which C++ lets a program replace. All of them are malloc and free.
ALLOCATION = re.compile(r"__Z(?:n[aw]|d[al])")
LIB_SYSTEM = "/usr/lib/libSystem.B.dylib"  # every Mac has it; libc++ is linked statically


def check_module(module: Path, minor: int) -> None:
    """Ends the tool if a module could not be loaded by macOS 11, as far as the file shows it."""
    content = module.read_bytes()
    found = flaws(content)
    if found:
        raise SystemExit(f"{module.name}: {'; '.join(found)}")


def flaws(content: bytes) -> list[str]:
    """What would keep a Mac with an Apple processor from loading a module, or tells of this machine."""
    module = mach_o.read(content)
    found = []
    if (module.processor, module.kind) != (mach_o.ARM64, mach_o.LIBRARY):
        found.append("it is no library for Apple's processors")
    if (module.platform, module.minimum) != (mach_o.MACOS, (11, 0)):
        found.append(
            f"it is for platform {module.platform} from {module.minimum} on, not for macOS from 11.0 on"
        )
    foreign = sorted({*module.libraries, *module.run_paths} - {LIB_SYSTEM})
    if foreign:
        found.append(f"it looks for {', '.join(foreign)}, which the wheel does not hold")
    unknown = sorted(
        name
        for name, library in module.wanted.items()
        if not library and not name.startswith(("_Py", "__Py"))
    )
    if unknown:
        found.append(f"nothing defines {', '.join(unknown)}")
    if "_PyInit_sinew_native" not in module.exported:
        found.append("Python cannot initialise it")
    replaced = sorted(name for name in module.shared if not ALLOCATION.match(name))
    if replaced:
        found.append(f"other libraries may replace its {', '.join(replaced)}")
    places = [str(place) for place in (ROOT, Path.home()) if f"{place}/".encode() in content]
    if places:
        found.append(f"it names {', '.join(places)}")
    if not module.signed:
        found.append("its signature is missing or wrong")
    return found


def check_wheel(wheel: Path, minor: int) -> None:
    """Ends the tool if the tags inside a wheel are not those of its name."""
    files = read_zip(wheel)
    about = next(content for name, content in files.items() if name.endswith(".dist-info/WHEEL"))
    tag = f"Tag: {wheel.stem.split('-', 2)[2]}"
    if about.decode().splitlines().count(tag) != 1 or "Root-Is-Purelib: false" not in about.decode():
        wheel.unlink()
        raise SystemExit(f"{wheel.name} does not say {tag}, but:\n{about.decode()}")
    say(f"{wheel.name} is built, never run: no Mac is here, and what its file tells macOS is right")


def licences() -> dict[str, Path]:
    return of_packages(("libosd-dev", "libsuitesparse-dev", "libtbb-dev")) | zig.licences()


TARGET = Target(
    system=SYSTEM,
    platform="macosx_11_0_arm64",
    suffix=".cpython-3{minor}-darwin.so",
    inputs=INPUTS,
    licences=licences,
    python=lambda minor: [],
    check_module=check_module,
    check_wheel=check_wheel,
)
