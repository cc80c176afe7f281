# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark suite's own code, on made-up results: nothing is measured here."""

import shutil
from pathlib import Path

import count
import documents as pages
import numpy as np
import pytest
import record
import report
import works
from rows.nonlinear import arrival
from timing import Timed, alternate


def row(work: str, size: int, ours: float, peer: float | None, **more) -> record.Row:
    return {"work": work, "size": size, "vertices": size, "unit": "s", "ours": ours, "peer": peer, **more}


ROWS = [
    row("bind", 10_000, 0.1, 0.2, threads=1),
    row("bind", 10_000, 0.05, 0.2, threads=2),
    row("bind", 500_000, 10.0, 11.0),  # a size with a goal of its own
    row("bind", 1_000_000, 25.0, None),
    row("memory", 500_000, 2e9, 1e9, unit="bytes"),  # "at most" divides the other way
    row("wires_frame", 100_000, 1.0, 8.0, threads=2),  # more is wanted on two threads
    row("arap_iteration", 50_000, 1.0, 0.5),  # nothing is wanted
    row("arap_bend", 50_000, 0.5, 40.0, threads=1, iterations=60, peer_iterations=800, peer_arrived=False,
        peer_excess_percent=7.0, peer_extrapolated=90.0),
    row("frame_arap", 100_000, 0.1, 1.0, case="3.4", native_ms=80.0, around_ms=20.0),
    row("settled", 10_000, 7, None, case="Primo"),
    row("convergence", 2_000, 0, None, case="bend 90", default_iterations=15, excess_percent=[1.0, 0.06]),
]  # fmt: skip


@pytest.mark.parametrize(
    ("number", "ratio", "met"),
    [(0, 2.0, True), (2, 1.1, False), (4, 2.0, False), (5, 8.0, False), (6, 0.5, None)],
)
def test_ratio_is_judged_by_its_goal(number: int, ratio: float, met: bool | None) -> None:
    work = works.BY_ID[ROWS[number]["work"]]
    assert (work.ratio(ROWS[number]), work.met(ROWS[number])) == (pytest.approx(ratio), met)


def test_lines_and_cells_tell_what_is_wanted_and_missed() -> None:
    assert report.wanted(works.BY_ID["bind"]) == "at least 1; 500k: 1.2"
    assert report.wanted(works.BY_ID["wires_frame"]) == "at least 100k: 5, 10"
    assert report.wanted(works.BY_ID["arap_iteration"]) == ""
    assert "MISSED" not in report.line(ROWS[0])
    assert "wanted >= 1.2  MISSED" in report.line(ROWS[2])
    assert report.line(ROWS[3]).endswith("25 s")  # no peer, no ratio
    assert "ratio    >80" in report.line(ROWS[7])  # the peer was stopped on its way
    found = report.ratios(ROWS).splitlines()
    assert any("10k: 2.00, 4.00 · 500k: *1.10*" in text for text in found)
    assert all(text.count("|") == 5 for text in found)
    assert report.summary(ROWS) == "3 ratios as wanted, 3 missed"
    assert "factor of 2.00 (binding `ThinShell`, 10k)" in report.two_threads(ROWS)
    sizes = np.array([1e4, 5e4, 2e5])
    assert report.exponent(sizes, 3.0 * sizes**1.37) == pytest.approx(1.37)


def test_documents_are_renewed_between_their_marks_and_twice_is_once(tmp_path: Path) -> None:
    record.store("made_up", ROWS, record.machine(), tmp_path / "results")
    readme, page = (Path(shutil.copy(path, tmp_path)) for path in (pages.README, pages.PAGE))
    before = readme.read_text().partition("<!-- benchmarks -->")[0]
    pages.render(tmp_path / "results", readme, page)
    once = readme.read_text(), page.read_text()
    assert once[0].startswith(before)
    pages.render(tmp_path / "results", readme, page)
    assert once == (readme.read_text(), page.read_text())
    for figure in ("500k: *1.10*", "still 7 % above, extrapolated to 1 % after 90 s", "| `Primo` | 7 |"):
        assert figure in once[1]
    with pytest.raises(SystemExit, match="has no <!-- times -->"):
        pages.replaced("text", "times", "")


def test_documents_show_what_is_stored() -> None:
    for path, text in pages.renewed().items():
        assert text == path.read_text(encoding="utf-8"), f"benchmarks/run --render renews {path.name}"


def test_every_row_is_stored_and_few_miss_their_target() -> None:
    _, rows = record.load()
    assert {row["work"] for row in rows} == works.BY_ID.keys()
    assert len(works.WORKS) <= 30
    assert report.missed(rows) <= 5
    assert len(pages.known_peers(rows).splitlines()) == 2 + 6


def test_measuring_again_replaces_rows_and_runs(tmp_path: Path) -> None:
    record.store("2030-01-01-1200", ROWS[:3], {"cores": 4}, tmp_path)
    again = {**ROWS[1], "ours": 0.04}
    record.store("2030-01-02-1200", [again], {"cores": 2}, tmp_path)
    assert record.load(tmp_path) == ([{"cores": 4}, {"cores": 2}], [ROWS[0], again, ROWS[2]])
    assert [record.store("2030-01-03-1200", ROWS[:3], {}, tmp_path)] == list(tmp_path.iterdir())


def test_turns_alternate_and_short_works_come_in_bursts() -> None:
    called = []
    short = Timed(lambda: called.append("short"), lambda: called.append("turn"))
    once = Timed(lambda: called.append("once"), repeatable=False)
    alternate({"short": short, "once": once}, budget=0.0, least=3)
    assert called.count("turn") == called.count("once") == len(once.seconds) == 3
    assert called.count("short") == len(short.seconds) > 3
    assert [name for name in called if name != "short"] == 3 * ["turn", "once"]
    assert short.best <= short.median


def test_grown_loop_is_told_and_a_shrunk_one_is_not() -> None:
    lines, grown = count.compare({"a": 120, "b": 80, "c": 5}, {"a": 100, "b": 100})
    assert grown == ["a"]
    assert ["+20.00 %" in lines[0], "-20.00 %" in lines[1], "new" in lines[2]] == [True] * 3


def test_arrival_is_measured_or_extrapolated() -> None:
    """Excess 1 / t falls to 1 % at t = 100, whether or not the run goes on until then."""
    seconds = np.arange(1.0, 201.0)
    assert arrival(1 / seconds, seconds)["peer"] == pytest.approx(100.0, abs=1.0)
    stopped = arrival(1 / seconds[:40], seconds[:40])
    assert (stopped["peer"], stopped["peer_arrived"]) == (40.0, False)
    # A power fits exactly; an exponential through the same end arrives earlier, and the earlier one is taken.
    assert 40.0 < stopped["peer_extrapolated"] <= 100.5
