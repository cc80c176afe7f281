# SPDX-License-Identifier: GPL-3.0-or-later
"""Counts the results of a layer of tests, from the JUnit files of ctest and pytest."""

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Outcome:
    passed: int = 0
    failed: int = 0
    skipped: int = 0
    note: str = ""

    def __add__(self, other: "Outcome") -> "Outcome":
        passed, failed = self.passed + other.passed, self.failed + other.failed
        note = "; ".join(note for note in (self.note, other.note) if note)
        return Outcome(passed, failed, self.skipped + other.skipped, note)


def outcome(junit: Path, status: int) -> Outcome:
    """The counts of a file. A run that failed without a failed test, or without any test, is one failure."""
    try:
        root = ElementTree.parse(junit).getroot()
    except (OSError, ElementTree.ParseError):
        return Outcome(failed=1, note=f"no result was written (status {status})")
    cases = [{case.get("status"), *(child.tag for child in case)} for case in root.iter("testcase")]
    failed = sum(bool(said & {"failure", "error", "fail"}) for said in cases)
    skipped = sum(bool(said & {"skipped", "notrun", "disabled"}) for said in cases)
    passed = len(cases) - failed - skipped
    if passed + failed + skipped == 0:
        return Outcome(failed=1, note="no test was found")
    if status != 0 and failed == 0:
        return Outcome(passed, 1, skipped, f"all tests passed, but the run ended with status {status}")
    return Outcome(passed, failed, skipped)


def closing_line(total: Outcome) -> str:
    line = f"{total.passed} passed, {total.failed} failed"
    return line + (f", {total.skipped} skipped" if total.skipped else "")
