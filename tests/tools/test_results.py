# SPDX-License-Identifier: GPL-3.0-or-later
from pathlib import Path

from workshop.results import Outcome, closing_line, outcome

PYTEST = """<testsuites><testsuite name="pytest" tests="4">
<testcase name="a"/><testcase name="b"><failure message="no"/></testcase>
<testcase name="c"><error message="set-up"/></testcase><testcase name="d"><skipped/></testcase>
</testsuite></testsuites>"""
CTEST = """<testsuite name="ctest" tests="4">
<testcase name="a" status="run"/><testcase name="b" status="fail"><failure message=""/></testcase>
<testcase name="c" status="notrun"><skipped message="SKIP"/></testcase><testcase name="d" status="disabled"/>
</testsuite>"""


def count(folder: Path, text: str, status: int) -> Outcome:
    file = folder / "junit.xml"
    file.write_text(text)
    return outcome(file, status)


def test_pytest_file_is_counted(tmp_path: Path) -> None:
    assert count(tmp_path, PYTEST, 1) == Outcome(passed=1, failed=2, skipped=1)


def test_ctest_file_is_counted(tmp_path: Path) -> None:
    assert count(tmp_path, CTEST, 8) == Outcome(passed=1, failed=1, skipped=2)


def test_crash_without_a_file_is_a_failure(tmp_path: Path) -> None:
    assert outcome(tmp_path / "none.xml", -11).failed == 1


def test_half_a_file_is_a_failure(tmp_path: Path) -> None:
    assert count(tmp_path, PYTEST[:80], 124).failed == 1


def test_no_test_at_all_is_a_failure(tmp_path: Path) -> None:
    assert count(tmp_path, "<testsuite/>", 0).failed == 1


def test_crash_after_the_last_test_is_a_failure(tmp_path: Path) -> None:
    found = count(tmp_path, '<testsuite><testcase name="a"/></testsuite>', -6)
    assert (found.passed, found.failed) == (1, 1)
    assert "-6" in found.note


def test_closing_line_is_plain() -> None:
    assert closing_line(Outcome(7, 0) + Outcome(1, 2)) == "8 passed, 2 failed"
    assert closing_line(Outcome(7, 0, 3)) == "7 passed, 0 failed, 3 skipped"
