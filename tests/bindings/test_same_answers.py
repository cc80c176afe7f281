# SPDX-License-Identifier: GPL-3.0-or-later
"""This system gives the answers that another gave for the same input (answers.py).

It writes a table of the differences beside the answers of the other system.
"""

import os
import sys
from pathlib import Path

import numpy as np
import pytest

from .oracles.answers import answers

FILE = os.environ.get("SINEW_ANSWERS", "")
# All else is a sum in a fixed order, with METIS's orderings as on Linux, and equal to the last bit. Solves in
# double precision, which all linear methods have, go through the BLAS of their system, whose sums have other
# orders. So harmonic weights in single precision may fall on the neighbouring number. The hill is 12 wide.
# The first that fits a name counts.
LARGEST = {"solve Arap": 0.0, "solve": 1e-12, "warp Harmonic": 2e-7, "warp MultiresolutionSpace": 1e-12}
if sys.platform == "win32":
    # Sines and arctangents of two C libraries differ in their last bits, and with them wires, and where
    # puppetry's search for a pose ends within its tolerance.
    LARGEST = {"solve MeshPuppetry": 1e-8, "warp Wires": 1e-15} | LARGEST


@pytest.mark.skipif(not FILE, reason="another system has to write its answers first")
def test_answers_are_those_of_the_other_system() -> None:
    with np.load(FILE) as stored:
        given = {name.removeprefix("given "): stored[name] for name in stored if name.startswith("given ")}
        expected = {name: stored[name] for name in stored if not name.startswith("given ")}
    found = answers(given)
    assert found.keys() == expected.keys()
    differences = {name: abs(found[name] - expected[name]).max() for name in expected}
    others = {name: np.count_nonzero(found[name] != expected[name]) for name in expected}
    told = [f"| {k} | {v:.1e} | {others[k]} of {expected[k].size} |\n" for k, v in differences.items()]
    head = "| answer | largest difference | numbers that differ |\n|---|---|---|\n"
    Path(FILE).with_suffix(".md").write_text(head + "".join(told), encoding="utf-8")

    def allowed(name: str) -> float:
        return next((most for prefix, most in LARGEST.items() if name.startswith(prefix)), 0.0)

    assert {name: far for name, far in differences.items() if far > allowed(name)} == {}
