# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the picture of the rooms in docs/developer from the ranks that the tests enforce."""

import argparse
import sys

from .places import ROOT
from .shell import say

sys.path.insert(0, str(ROOT / "tests"))  # the tests define the ranks

from architecture.picture import PICTURE, draw


def main() -> None:
    argparse.ArgumentParser(prog="tools/draw_architecture", description=__doc__).parse_args()
    (ROOT / PICTURE).write_text(draw(), encoding="utf-8")
    say(f"wrote {PICTURE}")
