# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps a wheel's own BLAS, CHOLMOD and TBB from being replaced by those of the program that loads it.

On Linux, a symbol of the executable or of its libraries takes precedence over the same symbol in a library
that a module brings. Blender brings a BLAS and a TBB, and with the wrong build of OpenBLAS, two binds at once
give wrong results. So the symbols are renamed, both in the module and in its libraries. (RTLD_DEEPBIND would
choose ours, too, but then the module frees memory of Blender's allocator by libc, and Blender aborts when it
quits.)
"""

import re
import tempfile
from pathlib import Path

from .environments import Environment
from .shell import must, said

PREFIX = "sinew_"
OWNED = re.compile(r"lib(openblas|blas|lapack|cholmod|c?amd|c?colamd|metis|suitesparse|tbb)")
# Not renamed: C++ symbols of the standard library, those of OpenSubdiv, which contain its version, and the
# symbols that every linker sets.
RENAMED = re.compile(r"(?!_Z)(?!_init$|_fini$|__bss_start$|_edata$|_end$)|_Z(?:T[ISVT]|GV)?NK?3tbb")


def isolated(files: dict[str, bytes], builder: Environment) -> dict[str, bytes]:
    """The files of a wheel, with all symbols renamed that its own libraries export."""
    binaries = [name for name in files if re.search(r"\.so(\.|$)", name)]
    with tempfile.TemporaryDirectory() as folder:
        paths = {name: Path(folder) / str(number) for number, name in enumerate(binaries)}
        for name, path in paths.items():
            path.write_bytes(files[name])
        owned = [path for name, path in paths.items() if OWNED.match(Path(name).name)]
        exported = {symbol for path in owned for symbol in symbols(path, "--defined-only")}
        changed = {symbol for symbol in exported if RENAMED.match(symbol)}
        names = Path(folder) / "names"
        lines = [f"{symbol} {PREFIX}{symbol}\n" for symbol in sorted(changed)]
        names.write_text("".join(lines), encoding="utf-8")
        for path in paths.values():
            must([builder.bin / "patchelf", "--rename-dynamic-symbols", names, path], quiet=True)
        left = {symbol for path in paths.values() for symbol in symbols(path)} & changed
        if not changed or left:
            raise SystemExit(f"{len(left)} of {len(changed)} names could not be changed: {sorted(left)[:5]}")
        return files | {name: path.read_bytes() for name, path in paths.items()}


def symbols(binary: Path, *options: str) -> set[str]:
    """The dynamic symbols of a shared library, without their versions."""
    listing = said(["nm", "--dynamic", "--format=posix", *options, binary])
    return {line.split()[0].split("@")[0] for line in listing.splitlines()}
