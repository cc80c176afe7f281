# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the library, its peers and their environment, then measures: benchmarks/suite.py."""

import sys

from . import debian, environments
from .dev import BENCHMARK_TARGETS, build_tree
from .places import DEV_MODULE, ROOT
from .shell import run

SUITE = ROOT / "benchmarks" / "suite.py"
ONLY_READS = {"-h", "--help", "--render"}


def main() -> None:
    words = sys.argv[1:]
    if not ONLY_READS & set(words):
        debian.install(debian.BENCHMARKS)
        build_tree("dev", *BENCHMARK_TARGETS)
    python = environments.dev().make().python
    sys.exit(run([python, SUITE, *words], env={"PYTHONPATH": DEV_MODULE}))
