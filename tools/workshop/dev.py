# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the library, the native tests and the Python module for daily work."""

import argparse
from pathlib import Path

from . import debian, environments
from .places import BUILD, DEV_MODULE, ROOT
from .shell import Stamp, fingerprint, jobs, must, one_at_a_time

BENCHMARK_TARGETS = ("sinew_native", "sinew_peers", "sinew_frames")


def configure_tree(preset: str) -> None:
    """Configures the tree if the presets or the tools changed."""
    debian.install(debian.BUILD)
    environments.build().make()
    tree = BUILD / {"dev": "native"}.get(preset, preset)
    stamp = Stamp(tree / "configured-from", fingerprint([ROOT / "CMakePresets.json"], preset))
    if not stamp.is_fresh() or not (tree / "build.ninja").is_file():
        must(["cmake", "--preset", preset, "-Wno-dev"])
        stamp.write()


@one_at_a_time()
def build_tree(preset: str, *targets: str) -> None:
    """Configures the tree if needed, and builds what changed of these targets, or of all."""
    configure_tree(preset)
    must(["cmake", "--build", "--preset", preset, "-j", str(jobs()), "--target", *(targets or ["all"])])


def types() -> Path:
    """The types of the Python module, which its build writes for editors."""
    build_tree("dev", "sinew_native")
    return DEV_MODULE / "sinew_native.pyi"


def main() -> None:
    parser = argparse.ArgumentParser(prog="tools/dev", description=__doc__)
    about = "a preset of CMakePresets.json; without one, dev"
    parser.add_argument("preset", nargs="?", default="dev", help=about)
    build_tree(parser.parse_args().preset)
