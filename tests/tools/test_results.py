# SPDX-License-Identifier: GPL-3.0-or-later
from pathlib import Path

import pytest
from workshop.coverage import table
from workshop.places import ROOT
from workshop.results import Outcome, closing_line, outcome

PYTEST = """<testsuites><testsuite name="pytest" tests="4">
<testcase name="a"/><testcase name="b"><failure message="no"/></testcase>
<testcase name="c"><error message="set-up"/></testcase><testcase name="d"><skipped/></testcase>
</testsuite></testsuites>"""
CTEST = """<testsuite name="ctest" tests="4">
<testcase name="a" status="run"/><testcase name="b" status="fail"><failure message=""/></testcase>
<testcase name="c" status="notrun"><skipped message="SKIP"/></testcase><testcase name="d" status="disabled"/>
</testsuite>"""


@pytest.mark.parametrize(
    ("text", "status", "counts"),
    [
        (PYTEST, 1, (1, 2, 1)),
        (CTEST, 8, (1, 1, 2)),
        (PYTEST[:80], 124, (0, 1, 0)),  # half a file
        ("<testsuite/>", 0, (0, 1, 0)),  # no test at all
        ('<testsuite><testcase name="a"/></testsuite>', -6, (1, 1, 0)),  # a crash after the last test
    ],
)
def test_a_file_is_counted(text: str, status: int, counts: tuple[int, int, int], tmp_path: Path) -> None:
    file = tmp_path / "junit.xml"
    file.write_text(text)
    found = outcome(file, status)
    assert (found.passed, found.failed, found.skipped) == counts
    assert status != -6 or "-6" in found.note


def test_crash_without_a_file_is_a_failure(tmp_path: Path) -> None:
    assert outcome(tmp_path / "none.xml", -11).failed == 1


def test_closing_line_is_plain() -> None:
    assert closing_line(Outcome(7, 0) + Outcome(1, 2)) == "8 passed, 2 failed"
    assert closing_line(Outcome(7, 0, 3)) == "7 passed, 0 failed, 3 skipped"


ARAP, REGIONS = ROOT / "native/methods/surface/arap.cpp", ROOT / "native/mesh/regions.h"


def test_line_that_one_part_of_the_tests_reached_counts_as_reached() -> None:
    parts = [{ARAP: {1: True, 2: False}, REGIONS: {5: False}}, {ARAP: {2: True, 3: False}}]
    rows = [line.split() for line in table(parts)]
    assert rows[1:] == [
        ["native", "4", "50.0", "%"],
        ["native/mesh", "1", "0.0", "%"],
        ["native/methods/surface", "3", "66.7", "%"],
    ]
