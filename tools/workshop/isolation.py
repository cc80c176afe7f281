# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps a wheel's own BLAS, CHOLMOD and TBB from being replaced by those of the program that loads it.

On Linux a name that the executable or one of its libraries defines wins over the same name in a library that
a module brings. Blender brings a BLAS and a TBB; with the wrong build of OpenBLAS, two binds at once give
wrong answers. So the names are changed, alike in the module and in its libraries. (RTLD_DEEPBIND would choose
ours too, but then the module frees by libc what Blender's allocator gave, and Blender aborts when it quits.)
"""

import re
import subprocess
import tempfile
from pathlib import Path

from .environments import Environment
from .shell import must

PREFIX = "sinew_"
OWNED = re.compile(r"lib(openblas|blas|lapack|cholmod|c?amd|c?colamd|metis|suitesparse|tbb)")
# C++ names of the standard library stay, and those of OpenSubdiv, which tell its version; so do the marks
# that every linker sets.
RENAMED = re.compile(r"(?!_Z)(?!_init$|_fini$|__bss_start$|_edata$|_end$)|_Z(?:T[ISVT]|GV)?NK?3tbb")


def isolated(files: dict[str, bytes], builder: Environment) -> dict[str, bytes]:
    """The wheel's files, with the names that its own libraries export changed wherever they occur."""
    binaries = [name for name in files if re.search(r"\.so(\.|$)", name)]
    with tempfile.TemporaryDirectory() as folder:
        paths = {name: Path(folder) / str(number) for number, name in enumerate(binaries)}
        for name, path in paths.items():
            path.write_bytes(files[name])
        owned = [path for name, path in paths.items() if OWNED.match(Path(name).name)]
        exported = {symbol for path in owned for symbol in symbols(path, "--defined-only")}
        changed = {symbol for symbol in exported if RENAMED.match(symbol)}
        names = Path(folder) / "names"
        names.write_text(
            "".join(f"{symbol} {PREFIX}{symbol}\n" for symbol in sorted(changed)), encoding="utf-8"
        )
        for path in paths.values():
            must([builder.bin / "patchelf", "--rename-dynamic-symbols", names, path], quiet=True)
        left = {symbol for path in paths.values() for symbol in symbols(path)} & changed
        if not changed or left:
            raise SystemExit(f"{len(left)} of {len(changed)} names could not be changed: {sorted(left)[:5]}")
        return files | {name: path.read_bytes() for name, path in paths.items()}


def symbols(binary: Path, *options: str) -> set[str]:
    """The dynamic symbols of a shared library, without their versions."""
    command = ["nm", "--dynamic", "--format=posix", *options, str(binary)]
    listing = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return {line.split()[0].split("@")[0] for line in listing.splitlines()}
