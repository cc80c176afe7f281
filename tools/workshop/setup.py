# SPDX-License-Identifier: GPL-3.0-or-later
"""Installs the Debian packages and virtual environments for a purpose."""

import argparse

from . import debian, environments
from .shell import say


def set_up(packages: tuple[tuple[str, ...], ...], *made: environments.Environment | None) -> None:
    debian.install(*packages)
    for environment in made:
        if environment:
            environment.make()


def set_up_tests() -> None:
    releases = map(environments.blender, environments.LONG_TERM_BLENDERS)
    newest = environments.newest_blender()
    packages = (debian.BUILD, debian.GUI, debian.BPY, debian.API, debian.BROWSER, debian.NODE)
    set_up(packages, *builders(), environments.dev(), environments.farm(), *releases, newest)
    if newest.name == "bpy-5.0.1":
        say("No Python 3.13 here: Blender 5.0.1 stands in, 5.2 is not run.")


def builders() -> tuple[environments.Environment | None, ...]:
    return environments.build(), environments.build_for(13), environments.site()


PURPOSES = {
    "build": lambda: set_up((debian.BUILD,), *builders()),
    "samples": lambda: set_up((debian.BUILD, debian.BLENDER), environments.build(), environments.farm()),
    "dev": lambda: environments.dev().make(),
    "tests": set_up_tests,
}


def main() -> None:
    parser = argparse.ArgumentParser(prog="tools/setup", description=__doc__)
    about = f"{', '.join(PURPOSES)}; without a name, all"
    parser.add_argument("what", nargs="*", choices=[[], *PURPOSES], default=[], metavar="WHAT", help=about)
    for purpose in parser.parse_args().what or PURPOSES:
        PURPOSES[purpose]()
