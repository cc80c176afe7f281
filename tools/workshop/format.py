# SPDX-License-Identifier: GPL-3.0-or-later
"""Formats C++ and Python with the pinned clang-format and Ruff."""

import argparse
from collections.abc import Iterator
from pathlib import Path

from . import environments
from .places import ROOT
from .shell import run

SOURCE_FOLDERS = ("benchmarks", "examples", "native", "tests")
PYTHON_FOLDERS = ("addon", "benchmarks", "blend_samples", "examples", "native", "tests", "tools")


def cpp_files() -> list[Path]:
    found: Iterator[Path] = (f for folder in SOURCE_FOLDERS for f in (ROOT / folder).rglob("*"))
    return sorted(f for f in found if f.suffix in (".h", ".cpp", ".inl"))


def checks(write: bool = False) -> dict[str, list[str | Path]]:
    """The command of each check, by name. With ``write`` the commands also mend what they can."""
    bin_folder = environments.dev().make().bin
    python = [folder for folder in PYTHON_FOLDERS if (ROOT / folder).is_dir()]
    mend = ["--fix"] if write else []
    only_look = ["--dry-run", "--Werror", "--ferror-limit=3"]
    clang_format = [bin_folder / "clang-format", *(["-i"] if write else only_look)]
    found = {
        "ruff check": [bin_folder / "ruff", "check", "--quiet", "--output-format=concise", *mend, *python],
        "ruff format": [bin_folder / "ruff", "format", "--quiet", *([] if write else ["--check"]), *python],
    }
    if cpp_files():
        found["clang-format"] = [*clang_format, *cpp_files()]
    return found


def main() -> None:
    parser = argparse.ArgumentParser(prog="tools/format", description=__doc__)
    about = "change nothing, and fail if something would change"
    parser.add_argument("--check", action="store_true", help=about)
    write = not parser.parse_args().check
    raise SystemExit(max(run(command) for command in checks(write).values()))
