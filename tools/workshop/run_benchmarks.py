# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the library, its peers and their environment, then measures: benchmarks/suite.py."""

import sys

from . import debian, environments
from .dev import BENCHMARK_TARGETS, build_tree
from .environments import Environment
from .places import DEV_MODULE, PYTHON311, ROOT
from .shell import run

SUITE, TABLES = ROOT / "benchmarks" / "suite.py", ROOT / "benchmarks" / "tables.py"
PEERS = Environment("peers", PYTHON311, ("dev", "peers"))
ONLY_READS = {"-h", "--help", "--render"}


def main() -> None:
    words = sys.argv[1:]
    if not ONLY_READS & set(words):
        debian.install(debian.BENCHMARKS)
        build_tree("dev", *BENCHMARK_TARGETS)
    tables = words[:1] == ["--tables"]
    python = (PEERS if tables else environments.dev()).make().python
    program = [TABLES, *words[1:]] if tables else [SUITE, *words]
    sys.exit(run([python, *program], env={"PYTHONPATH": DEV_MODULE}))
