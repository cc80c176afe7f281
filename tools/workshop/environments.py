# SPDX-License-Identifier: GPL-3.0-or-later
"""The virtual environments in ``.build``. Each is made once, and again when its pinned versions change."""

import shutil
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

from . import debian
from .places import BUILD, PYTHON311, ROOT
from .shell import Stamp, fingerprint, must, one_at_a_time, say

REQUIREMENTS = ROOT / "tools" / "requirements"
OF_BLENDERS = (11, 13)  # the second numbers of the Pythons that Blenders come with
FOR_PROGRAMS = range(10, 15)
LONG_TERM_BLENDERS = ("4.2.23", "4.5.15")  # tested beside Debian's 3.4.1 and the newest


@dataclass(frozen=True)
class Environment:
    name: str
    interpreter: Path
    requirements: tuple[str, ...]
    packages: tuple[str, ...] = debian.PYTHON

    @property
    def folder(self) -> Path:
        return BUILD / f"venv-{self.name}"

    @property
    def bin(self) -> Path:
        return self.folder / "bin"

    @property
    def python(self) -> Path:
        return self.bin / "python"

    @property
    def site_packages(self) -> Path:
        return next((self.folder / "lib").glob("python3*")) / "site-packages"

    @one_at_a_time()
    def make(self) -> "Environment":
        """Sets the environment up unless this is done already."""
        debian.install(self.packages)
        files = [REQUIREMENTS / f"{name}.txt" for name in self.requirements]
        pins = fingerprint(included(files))
        stamp = Stamp(self.folder / "made-from", f"{self.folder} {self.interpreter} {pins}")
        if stamp.is_fresh() and _runs(self.python):
            return self
        say(f"Making {self.folder.relative_to(ROOT)} from {self.interpreter}")
        stamp.forget()
        if not _runs(self.python) or not _was_made_here(self.folder):
            shutil.rmtree(self.folder, ignore_errors=True)
            must([self.interpreter, "-m", "venv", self.folder])
        self.install(*files)
        stamp.write()
        return self

    def install(self, *files: Path, options: Iterable[str | Path] = (), quiet: bool = False) -> None:
        """What requirement files name, into the environment unless the options lead elsewhere."""
        chosen = [word for file in files for word in ("-r", file)]
        self.pip("install", *options, "--no-cache-dir", *chosen, files=files, quiet=quiet)

    def pip(self, *words: str | Path, files: Iterable[Path], quiet: bool) -> None:
        named = ", ".join(str(file.relative_to(ROOT)) for file in files)
        lacking = f"pip could not get what {named} names: that takes a network with a package index"
        command = [self.python, "-m", "pip", "--quiet", "--disable-pip-version-check", *words]
        must(command, lacking=lacking, quiet=quiet)


def included(files: list[Path]) -> list[Path]:
    """Requirement files, with those that they include by ``-r``."""
    lines = [(file, line) for file in files for line in file.read_text(encoding="utf-8").splitlines()]
    further = [file.parent / line.removeprefix("-r ") for file, line in lines if line.startswith("-r ")]
    return [*files, *included(further)] if further else files


def _runs(python: Path) -> bool:
    return python.exists() and subprocess.run([python, "-c", ""], capture_output=True).returncode == 0


def _was_made_here(folder: Path) -> bool:
    """Whether the environment was made at this path. The scripts of a moved one point to the old path."""
    return str(folder) in (folder / "pyvenv.cfg").read_text(encoding="utf-8")


def python313() -> Path | None:
    """The Python of Blender 5.1 and later, or None."""
    return python(13)


@cache
def python(minor: int) -> Path | None:
    """A Python 3.``minor`` with headers, from PATH or from pyenv, or None."""
    name = f"python3.{minor}"
    pyenv = sorted(Path.home().glob(f".pyenv/versions/3.{minor}*/bin/{name}"), reverse=True)
    on_path = shutil.which(name)
    check = (
        f"import os, sys, sysconfig, venv; assert sys.version_info[:2] == (3, {minor}); "
        "assert os.path.exists(os.path.join(sysconfig.get_path('include'), 'Python.h')); "
        "print(os.path.realpath(sys.executable))"
    )
    for candidate in ([Path(on_path)] if on_path else []) + pyenv:
        answer = subprocess.run([candidate, "-c", check], capture_output=True, text=True)
        if answer.returncode == 0:
            return Path(answer.stdout.strip())
    return None


build, dev, farm, site = (
    partial(Environment, name, PYTHON311, (name,)) for name in ("build", "dev", "farm", "site")
)


def build_for(minor: int) -> Environment | None:
    """What builds a wheel for Python 3.``minor``; None if it is not installed."""
    if minor == 11:
        return build()
    interpreter = python(minor)
    return Environment(f"build-3.{minor}", interpreter, ("build",)) if interpreter else None


def builders(for_programs: bool = False) -> dict[int, Environment]:
    """By the second numbers of the Pythons that are here: those of Blenders, or all that programs use."""
    found = {minor: build_for(minor) for minor in (FOR_PROGRAMS if for_programs else OF_BLENDERS)}
    return {minor: builder for minor, builder in found.items() if builder}


def blender(version: str) -> Environment | None:
    """Blender as a Python module; None if its Python (3.13 from Blender 5.1 on) is missing."""
    name, series = f"bpy-{version}", [int(part) for part in version.split(".")[:2]]
    interpreter = python313() if series >= [5, 1] else PYTHON311
    return Environment(name, interpreter, (name,), debian.BPY) if interpreter else None


def newest_blender() -> Environment:
    """Blender 5.2 if there is a Python 3.13 to run it, else 5.0."""
    return blender("5.2.3") or blender("5.0.1")
