# SPDX-License-Identifier: GPL-3.0-or-later
"""Prints what the size and the connections of the code are, with the limits that the tests enforce."""

import argparse
import sys

from .places import ROOT
from .shell import say

sys.path.insert(0, str(ROOT / "tests"))  # the tests define the counts

from architecture.counts import COUNTS


def main() -> None:
    argparse.ArgumentParser(prog="tools/counts", description=__doc__).parse_args()
    say(f"{'':<62}{'now':>8}{'limit':>8}")
    for count in COUNTS:
        say(f"{count.name:<62}{count.find():>8.6g}{count.limit:>8.6g}")
