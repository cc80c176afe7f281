# SPDX-License-Identifier: GPL-3.0-or-later
"""Clang by way of zig, which brings headers, libc++ and a linker for other systems (PyPI's ``ziglang``)."""

from functools import partial
from pathlib import Path

from . import environments
from .cross_libraries import System
from .environments import Environment
from .places import BUILD, PYTHON311, ROOT
from .shell import fingerprint, one_at_a_time

ENVIRONMENT = Environment("zig", PYTHON311, ("zig",))
PACKAGE = ENVIRONMENT.folder / "lib" / "python3.11" / "site-packages" / "ziglang"
REQUIREMENTS = environments.REQUIREMENTS / "zig.txt"
PROGRAM = """#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
export ZIG_GLOBAL_CACHE_DIR={cache} ZIG_LOCAL_CACHE_DIR={cache}
exec {zig} {words} "$@"
"""


def system(name: str, title: str, target: str) -> System:
    """A system that zig compiles for; ``target`` is zig's word for it."""
    folder = BUILD / name / "zig"
    launcher = f"env;CCACHE_COMPILERCHECK=string:{fingerprint([REQUIREMENTS], options(target, '.'))};ccache"
    tools = {"C_COMPILER": "cc", "CXX_COMPILER": "c++", "AR": "ar", "RANLIB": "ranlib"}
    settings = (
        *(f"-DCMAKE_{language}_COMPILER_LAUNCHER={launcher}" for language in ("C", "CXX")),
        *(f"-DCMAKE_{variable}={folder / tool}" for variable, tool in tools.items()),
        "-DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY",
        "-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON",
        "-DCMAKE_SKIP_RPATH=ON",
        # What a module shows of its templates, another library in the process may replace.
        *(f"-DCMAKE_{language}_VISIBILITY_PRESET=hidden" for language in ("C", "CXX")),
        "-DCMAKE_VISIBILITY_INLINES_HIDDEN=ON",
        "-DCMAKE_POLICY_DEFAULT_CMP0063=NEW",  # in static libraries, too
        "-DTBB_ENABLE_IPO=OFF",  # objects of LLVM's own, which zig's linker for macOS does not read
    )
    return System(name, title, partial(make_tools, folder, target), settings, (REQUIREMENTS, Path(__file__)))


def options(target: str, root: str) -> str:
    """Those of the compilers. Binaries hold no names of this machine's folders, nor what debuggers read.

    Without -O, where CMake only tries the compiler, zig would compile another libc++, which takes minutes.
    """
    return f"-target {target} -O3 -s -ffile-prefix-map={root}=."


@one_at_a_time()
def make_tools(folder: Path, target: str) -> None:
    """Makes zig's compilers, ar and ranlib into programs of their own, as CMake wants them."""
    ENVIRONMENT.make()
    folder.mkdir(parents=True, exist_ok=True)
    compiles = options(target, str(ROOT))
    for tool, words in {"cc": compiles, "c++": compiles, "ar": "", "ranlib": ""}.items():
        words = f"{tool} {words}".strip()
        text = PROGRAM.format(cache=BUILD / "zig-cache", zig=PACKAGE / "zig", words=words)
        program = folder / tool
        if not program.is_file() or program.read_text(encoding="utf-8") != text:
            program.write_text(text, encoding="utf-8")
            program.chmod(0o755)


def licences() -> dict[str, Path]:
    """Those of what zig links into a module."""
    return {"libc++": PACKAGE / "lib" / "libcxx" / "LICENSE.TXT", "zig": PACKAGE / "LICENSE"}
