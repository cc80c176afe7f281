# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds self-contained wheels of sinew_native, with one static module each, for Linux, Windows or macOS.

One for Python 3.11 (Blender 3.4.1 of Debian 12 and 4.2 to 5.0) and, where a Python 3.13 exists, one for 3.13
(Blender 5.1 and later). For programs without Blender, also for the other Pythons whose headers are here.
"""

import argparse

from . import cross_wheels, linux_wheels, macos_wheels, windows_wheels
from .environments import FOR_PROGRAMS, build_for
from .places import ROOT
from .shell import say

TARGETS = {"linux": linux_wheels.TARGET, "windows": windows_wheels.TARGET, "macos": macos_wheels.TARGET}


def name_what_is_missing() -> None:
    """Tells for which Pythons of programs no wheel could be built."""
    missing = [f"3.{minor}" for minor in FOR_PROGRAMS if not build_for(minor)]
    if missing:
        say(f"No wheels for Python {', '.join(missing)}, as this machine has no headers of these")


def main() -> None:
    parser = argparse.ArgumentParser(prog="tools/build_wheels", description=__doc__)
    parser.add_argument("system", nargs="?", default="linux", choices=TARGETS, help="without one, linux")
    oldest, *_, newest = FOR_PROGRAMS
    every = f"of all systems, for each of Python 3.{oldest} to 3.{newest} that is here with its headers"
    parser.add_argument("--all", action="store_true", help=every)
    options = parser.parse_args()
    targets = TARGETS.values() if options.all else [TARGETS[options.system]]
    for target in targets:
        for wheel in cross_wheels.build_wheels(target, options.all):
            say(str(wheel.relative_to(ROOT)))
    if options.all:
        name_what_is_missing()
