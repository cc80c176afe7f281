# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs Windows' programs under Wine, whose drive C lies in ``.build``, and sets up Pythons for Windows."""

import shutil
import subprocess
from collections.abc import Iterable, Mapping
from pathlib import Path

from . import debian, environments
from .places import BUILD
from .shell import Stamp, environment, fingerprint, must, one_at_a_time, run, say
from .windows_libraries import PYTHONS, WINDOWS, windows_python

PREFIX = BUILD / "wine"
# The Python of Windows dies where a standard stream is a file, so both of its outputs are a pipe.
THROUGH_A_PIPE = ["bash", "-c", 'set -o pipefail; wine "$@" 2>&1 | cat', "wine"]
SETTINGS = {
    "WINEARCH": "win64",
    "WINEPREFIX": PREFIX,
    "WINEDEBUG": "-all",
    "LC_ALL": "C.UTF-8",  # how Wine reads the names of this machine's files
    # Neither entries in this machine's menus nor questions about Mono and Gecko. Without wbemprox, whose
    # answers crash Python 3.13 when it asks for the version of Windows, Python asks in its older way.
    "WINEDLLOVERRIDES": "winemenubuilder.exe,mscoree,mshtml,wbemprox=",
}


def run_in_windows(
    command: Iterable[str | Path], env: Mapping[str, str | Path] | None = None, **options
) -> int:
    """Does the same as run(), for a program of Windows. Its paths may be those of this machine. Of the status
    of a program Wine hands on the lowest byte, which is 0 after some crashes. So a status of 0 proves
    nothing: look at what the program wrote."""
    set_up()
    return run([*THROUGH_A_PIPE, *command], env=SETTINGS | dict(env or {}), **options)


def said_in_windows(command: Iterable[str | Path], env: Mapping[str, str | Path], timeout: float) -> str:
    """What a program of Windows prints, also where it fails."""
    set_up()
    words = [str(word) for word in (*THROUGH_A_PIPE, *command)]
    settings = {"env": environment(SETTINGS | dict(env)), "stdin": subprocess.DEVNULL, "timeout": timeout}
    return subprocess.run(words, capture_output=True, text=True, errors="replace", **settings).stdout


@one_at_a_time()
def set_up() -> None:
    debian.install(debian.WINE)
    stamp = Stamp(PREFIX / "made", "by wineboot\n")
    if not stamp.is_fresh():
        say(f"Making {PREFIX.relative_to(BUILD.parent)}")
        shutil.rmtree(PREFIX, ignore_errors=True)
        lacking = "Wine is installed, but could not make its drive C"
        must([*THROUGH_A_PIPE, "wineboot", "--init"], env=SETTINGS, timeout=300, lacking=lacking, quiet=True)
        stamp.write()


@one_at_a_time()
def python(minor: int, name: str = "") -> Path:
    """Python 3.``minor`` for Windows, with the packages that are pinned for it or for ``name``. It is
    python.org's embedded one without the file that would make it ignore PYTHONPATH."""
    embedded = windows_python(minor)
    requirements = [environments.REQUIREMENTS / f"windows-{name or f'3.{minor}'}.txt"]
    folder = WINDOWS.tree / f"environment-{name or f'3.{minor}'}"
    stamp = Stamp(folder / "made-from", fingerprint([*environments.included(requirements), PYTHONS]))
    if not stamp.is_fresh():
        say(f"Making {folder.relative_to(BUILD.parent)}")
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(embedded, folder)
        (folder / f"python3{minor}._pth").unlink()
        install_packages(folder / "Lib" / "site-packages", minor, *requirements)
        stamp.write()
    return folder / "python.exe"


def install_packages(folder: Path, minor: int, *requirements: Path) -> None:
    """Unpacks wheels for Windows into a folder."""
    # Whatever it installs for, pip asks whether a package allows the Python that runs it.
    builder = environments.build_for(minor)
    system = ["--platform", "win_amd64", "--python-version", f"3.{minor}", "--only-binary=:all:"]
    builder.make().install(*requirements, options=[*system, "--target", folder], quiet=True)
