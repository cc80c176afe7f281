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
from rows.nonlinear import CHUNK, arrival
from test_rows import MOST_MISSED
from timing import Timed, alternate


def row(work: str, size: int, ours: float, peer: float | None, threads: int | None = 1, **more) -> record.Row:
    found = {"work": work, "size": size, "vertices": size, "threads": threads, "unit": "s", **more}
    return {**found, "ours": ours, **({} if peer is None else {"peer": peer})}


ROWS = [
    row("bind", 10_000, 0.1, 0.2),
    row("bind", 10_000, 0.05, 0.2, threads=2),
    row("bind", 500_000, 10.0, 11.0),
    row("bind", 1_000_000, 25.0, None),
    row("memory", 500_000, 2e9, 1e9, threads=None, unit="bytes"),
    row("wires_frame", 100_000, 1.0, 8.0, threads=2, case="smoothed"),
    row("arap_iteration", 50_000, 1.0, 0.5),
    row("arap_bend", 50_000, 0.5, 40.0, iterations=60, peer_iterations=800, peer_arrived=False,
        peer_excess_percent=7.0, peer_extrapolated=90.0),
    row("frame_arap", 100_000, 0.1, 1.0, threads=None, case="3.4", native_ms=80.0, around_ms=20.0),
    row("settled", 10_000, 7, None, threads=None, case="Primo"),
    row("convergence", 2_000, 0, None, case="bend 90", default_iterations=15,
        excess_percent=[1.0, 0.06, 0.01, 0.001, 0.0]),
]  # fmt: skip


@pytest.mark.parametrize(
    ("number", "ratio", "met"),
    [
        (0, 2.0, True),
        (2, 1.1, False),  # this size has a goal of its own
        (4, 2.0, False),  # at most divides the other way
        (5, 8.0, False),  # on two threads more is wanted
        (6, 0.5, None),  # nothing is wanted
    ],
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


def test_exponent_is_that_of_a_power() -> None:
    sizes = np.array([1e4, 5e4, 2e5])
    assert report.exponent(sizes, 3.0 * sizes**1.37) == pytest.approx(1.37)


def test_documents_are_renewed_between_their_marks_and_twice_is_once(tmp_path: Path) -> None:
    record.store("made_up", ROWS, record.machine(), tmp_path / "results")
    readme, page = (Path(shutil.copy(path, tmp_path)) for path in (pages.README, pages.PAGE))
    before = readme.read_text()
    pages.render(tmp_path / "results", readme, page)
    once = readme.read_text(), page.read_text()
    pages.render(tmp_path / "results", readme, page)
    assert once == (readme.read_text(), page.read_text())
    mark = "<!-- benchmarks -->"
    assert once[0].partition(mark)[0] == before.partition(mark)[0]
    assert "libigl" not in once[0].partition(mark)[2].partition("<!-- end")[0]  # was not measured here
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
    assert report.missed(rows) <= MOST_MISSED
    assert len(pages.known_peers(rows).splitlines()) == 2 + 6


def test_measuring_again_replaces_rows_and_runs(tmp_path: Path) -> None:
    record.store("2030-01-01-1200", ROWS[:3], {"cores": 4}, tmp_path)
    again = {**ROWS[1], "ours": 0.04}
    record.store("2030-01-02-1200", [again], {"cores": 2}, tmp_path)
    assert record.load(tmp_path) == ([{"cores": 4}, {"cores": 2}], [ROWS[0], again, ROWS[2]])
    path = record.store("2030-01-03-1200", ROWS[:3], {}, tmp_path)
    assert list(tmp_path.iterdir()) == [path]


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
    assert stopped["peer_iterations"] == 39 * CHUNK
    # A power fits exactly; an exponential through the same end arrives earlier, and the earlier one is taken.
    assert 40.0 < stopped["peer_extrapolated"] <= 100.5
