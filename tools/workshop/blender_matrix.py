# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs all of tests/blender in every release between the oldest and the newest, or in the given ones.

Each release takes 1 GB in ``.build/venv-bpy-<version>``, which can be deleted afterwards.
"""

import argparse
import sys

from . import environments
from .layers import blender_layer
from .run_tests import run_layers

BETWEEN = (*environments.LONG_TERM_BLENDERS, "4.3.0", "4.4.0", "5.0.1", "5.1.2")


def pinned() -> list[str]:
    """The releases that have a requirements file."""
    return sorted(file.stem.removeprefix("bpy-") for file in environments.REQUIREMENTS.glob("bpy-*.txt"))


def main() -> None:
    parser = argparse.ArgumentParser(prog="tools/blender_matrix", description=__doc__)
    known = ", ".join(pinned())
    without = f"one of {known}; without any, {', '.join(BETWEEN)}"
    parser.add_argument("versions", nargs="*", metavar="VERSION", help=without)
    chosen = parser.parse_args().versions or BETWEEN
    unknown = sorted(set(chosen) - set(pinned()))
    if unknown:
        parser.error(f"no requirements for {', '.join(unknown)}; there are {known}")
    missing = [version for version in chosen if environments.blender(version) is None]
    if missing:
        parser.error(f"{', '.join(missing)} needs a Python 3.13 with headers on PATH or in pyenv")
    sys.exit(1 if run_layers([blender_layer(version) for version in chosen]) else 0)
