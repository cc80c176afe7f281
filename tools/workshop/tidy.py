# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs clang-tidy on each source of native/, and again only if the source or what it depends on has changed.

Kernels, which are compiled once for each set of instructions, are read as compiled for the baseline. Sources
that are compiled as one are also read as one, and others that have the same options some at a time, so that
the headers of others, which take most of the time, are read once.

For each source that passed, an empty file is kept for all clones of this user. Its name is a digest of the
compile command, the settings, and the source with all files of this repository that it includes.
"""

import json
import os
import re
import shlex
import subprocess
from collections.abc import Iterable, Mapping, Set
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import dropwhile
from pathlib import Path
from tempfile import TemporaryDirectory

from . import environments
from .dev import configure_tree
from .places import BUILD, NATIVE_TREE, ROOT
from .shell import fingerprint, git, jobs, must, said, say

AT_A_TIME = 5
PASSED = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "sinew" / "tidy"
SETTINGS = (ROOT / ".clang-tidy", environments.REQUIREMENTS / "dev.txt", Path(__file__))
Batch = tuple[tuple[str, ...], list[Path]]
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)


def tidy(only: Set[Path] | None = None) -> bool:
    """Whether all sources of native/ pass, or these. Prints the complaints about those that do not."""
    environments.dev().make()
    configure_tree("dev")
    # New sources may have to be listed
    must(["cmake", "--build", "--preset", "dev", "--target", "build.ninja"], quiet=True)
    PASSED.mkdir(parents=True, exist_ok=True)
    every = sorted(commands().items())
    chosen = {file: command for file, command in every if only is None or sources_in(file) & only}
    stamps = {file: PASSED / digest(file, command) for file, command in chosen.items()}
    changed = {file: chosen[file] for file, stamp in stamps.items() if not stamp.exists()}
    if changed:
        say(f"clang-tidy reads {len(changed)} of {len(stamps)} sources")
    with ThreadPoolExecutor(jobs()) as pool:
        for found in pool.map(complaints_about, batches(changed)):
            for file, complaints in found.items():
                if complaints:
                    say(complaints)
                else:
                    stamps[file].touch()
    return all(stamp.exists() for stamp in stamps.values())


def batches(changed: Mapping[Path, str]) -> list[Batch]:
    """Sources that are read as one, with the options of all. Those of one folder, whose unnamed namespaces
    are the likeliest to have the same names, are in different batches."""
    alike: dict[tuple[str, ...], list[Path]] = {}
    for file, command in changed.items():
        alike.setdefault(options_in(file, command), []).append(file)
    found = []
    for options, files in alike.items():
        count = -(-len(files) // AT_A_TIME)
        found += [(options, files[k::count]) for k in range(count)]
    return found


def options_in(file: Path, command: str) -> tuple[str, ...]:
    """The options of a compiler's command, without its source and what it writes."""
    words = shlex.split(re.sub(r" -o \S+", "", command))
    options = dropwhile(lambda word: not word.startswith("-"), words)
    return tuple(word for word in options if word not in ("-c", str(file)))


def commands() -> dict[Path, str]:
    """The commands by which the dev preset compiles native/; of the kernels, only their baseline. Sources
    that are compiled as one stand in a file of CMake, which includes them."""
    entries = json.loads((NATIVE_TREE / "compile_commands.json").read_text(encoding="utf-8"))
    found = {Path(entry["file"]): entry["command"] for entry in entries}
    native, kernels = ROOT / "native", NATIVE_TREE / "native"
    several = NATIVE_TREE / "CMakeFiles"

    def is_read(file: Path) -> bool:
        kernel = file.is_relative_to(kernels) and file.stem.endswith("_baseline")
        together = file.is_relative_to(several) and file.parent.name == "Unity"
        return kernel or together or file.is_relative_to(native)

    return {file: command for file, command in found.items() if is_read(file)}


def uncommitted() -> set[Path]:
    """The sources that differ from the last commit; none where git cannot tell."""
    found: set[Path] = set()
    for words in (["diff", "--name-only", "HEAD"], ["ls-files", "--others", "--exclude-standard"]):
        found |= {ROOT / name for name in git(*words, "--", "*.cpp", "*.inl").splitlines()}
    return found


def sources_in(file: Path) -> set[Path]:
    """A source; of one that CMake made for several sources, or for a set of instructions, those."""
    return {file, *(path for path in directly_included(file) if path.suffix in (".cpp", ".inl"))}


def digest(file: Path, command: str) -> str:
    here = command.replace(str(ROOT), "")
    return fingerprint([*SETTINGS, file, *included(file)], *shlex.split(here))


@cache
def included(file: Path) -> frozenset[Path]:
    """The files of this repository that a file includes, directly or not."""
    found: set[Path] = set()
    waiting = [file]
    while waiting:
        new = set(directly_included(waiting.pop())) - found
        found |= new
        waiting += new
    return frozenset(found)


@cache
def directly_included(file: Path) -> tuple[Path, ...]:
    named = (ROOT / name for name in INCLUDE.findall(file.read_text(encoding="utf-8")))
    return tuple(path for path in named if path.is_file())


def complaints_about(batch: Batch) -> dict[Path, str]:
    """What clang-tidy says about each source; empty if it passes. A batch with complaints is read again
    source by source, as they may come from names that are alike."""
    options, files = batch
    if len(files) > 1:
        with TemporaryDirectory(dir=BUILD) as folder:
            together = Path(folder) / "together.cpp"
            lines = (f'// NOLINTNEXTLINE(bugprone-suspicious-include)\n#include "{file}"\n' for file in files)
            together.write_text("".join(lines), encoding="utf-8")
            if not complaints_by(options, together):
                return dict.fromkeys(files, "")
    return {file: complaints_by(options, file) for file in files}


def complaints_by(options: Iterable[str], file: Path) -> str:
    clang_tidy = environments.dev().bin / "clang-tidy"
    command = [clang_tidy, "--quiet", *compiler_arguments(), file, "--", *options]
    done = subprocess.run(command, capture_output=True, text=True, errors="replace")
    lines = done.stdout.replace(f"{ROOT}/", "")
    return "" if done.returncode == 0 else lines or done.stderr


@cache
def compiler_arguments() -> tuple[str, ...]:
    """The arguments that Clang needs to read what GCC compiles. GCC's own headers come after all others, for
    headers that Clang does not have, such as OpenMP's. Templates that are never used are not checked, since
    some of CGAL's refer to members that do not exist."""
    headers = said(["g++", "-print-file-name=include"]).strip()
    return (f"--extra-arg=-idirafter{headers}", "--extra-arg=-fdelayed-template-parsing")
