# SPDX-License-Identifier: GPL-3.0-or-later
"""Installs the Debian packages and virtual environments for a purpose."""

import argparse

from . import debian, environments
from .shell import say


def set_up_build() -> None:
    debian.install(debian.BUILD)
    environments.build().make()
    newer = environments.build313()
    if newer:
        newer.make()


def set_up_samples() -> None:
    debian.install(debian.BUILD, debian.BLENDER)
    environments.build().make()


def set_up_tests() -> None:
    debian.install(debian.BUILD, debian.GUI, debian.BPY)
    set_up_build()
    environments.dev().make()
    for version in environments.LONG_TERM_BLENDERS:
        environments.blender(version).make()
    newest = environments.newest_blender().make()
    if newest.name == "bpy-5.0.1":
        say("No Python 3.13 here: Blender 5.0.1 stands in, 5.2 is not run.")


PURPOSES = {
    "build": set_up_build,
    "samples": set_up_samples,
    "dev": lambda: environments.dev().make(),
    "tests": set_up_tests,
}


def main() -> None:
    parser = argparse.ArgumentParser(prog="tools/setup", description=__doc__)
    about = f"{', '.join(PURPOSES)}; without a name, all"
    parser.add_argument("what", nargs="*", choices=[[], *PURPOSES], default=[], metavar="WHAT", help=about)
    for purpose in parser.parse_args().what or PURPOSES:
        PURPOSES[purpose]()
