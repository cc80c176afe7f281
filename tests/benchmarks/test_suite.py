# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark suite's own code, on made-up results: nothing is measured here."""

import shutil
import time
from pathlib import Path

import count
import documents as pages
import numpy as np
import pytest
import record
import report
import works
from groups import Options, blender
from timing import Work, alternate, arrival


def row(work: str, size: int, ours: float, peer: float | None, threads: int | None = 1, **more) -> record.Row:
    found = {"work": work, "size": size, "vertices": size, "threads": threads, "unit": "s", **more}
    return {**found, "ours": ours, **({} if peer is None else {"peer": peer})}


ROWS = [
    row("bind", 10_000, 0.1, 0.2),
    row("bind", 10_000, 0.1, 0.2, threads=2),
    row("bind", 500_000, 10.0, 11.0),
    row("bind", 1_000_000, 25.0, None),
    row("solve_bound", 50_000, 0.02, 0.01, bytes=1e8),
    row("basis_bound", 50_000, 0.002, 0.0005, bytes=1e7),
    row("arap_smooth", 10_000, 0.002, 0.001),
    row("arap_bend", 50_000, 0.5, 40.0, iterations=60, peer_iterations=800, peer_arrived=False,
        peer_excess_percent=7.0, peer_extrapolated=90.0),
    row("memory", 500_000, 2e9, 1e9, threads=None, unit="bytes"),
    row("frame_arap", 100_000, 0.1, 1.0, threads=None, case="3.4", native_ms=80.0, around_ms=20.0),
    {"work": "convergence", "size": 2_000, "vertices": 2_092, "case": "bend 90", "over": [],
     "excess_percent": [1.0, 0.06, 0.01, 0.001, 0.0], "default_iterations": 15},
    {"work": "handler_cost", "size": 121, "vertices": 121, "case": "3.4, 1", "blender": "3.4.1",
     "deformers": 1, "handler_ms": 0.04, "update_ms": 0.3},
]  # fmt: skip


def row_of(work: str, rows: list[record.Row] = ROWS) -> record.Row:
    return next(found for found in rows if found["work"] == work)


def test_ratio_of_a_faster_work_is_above_one() -> None:
    assert works.BY_ID["bind"].ratio(row_of("bind")) == pytest.approx(2.0)
    assert works.BY_ID["bind"].met(row_of("bind")) is True


def test_size_of_its_own_has_a_goal_of_its_own() -> None:
    large = ROWS[2]
    assert works.BY_ID["bind"].goal(large) == 1.2
    assert works.BY_ID["bind"].met(large) is False


def test_at_most_divides_the_other_way() -> None:
    work = works.BY_ID["memory"]
    assert work.ratio(row_of("memory")) == pytest.approx(2.0)
    assert work.met(row_of("memory")) is False


def test_goal_of_one_thread_is_not_that_of_two() -> None:
    work = works.BY_ID["arap_iteration"]
    assert [work.goal(row("arap_iteration", 200_000, 1.0, 1.0, threads=t)) for t in (1, 2)] == [7.0, 11.0]


def test_no_goal_is_no_verdict() -> None:
    assert works.BY_ID["solve"].met(row("solve", 10_000, 1.0, 0.5)) is None


def test_every_work_names_its_goal_and_peer() -> None:
    assert len(works.BY_ID) == len(works.WORKS)
    for work in works.WORKS:
        assert work.peer
        assert report.wanted(work).startswith("at most" if work.at_most else "at least")


def test_wanted_is_written_by_size() -> None:
    assert report.wanted(works.BY_ID["bind"]) == "at least 1; 500k: 1.2"
    assert report.wanted(works.BY_ID["arap_iteration"]) == "at least 10k/50k: 8, 12; 200k: 7, 11"


def test_line_says_what_falls_short() -> None:
    assert "SHORT" not in report.line(row_of("bind"))
    assert "wanted >= 1.2  SHORT" in report.line(ROWS[2])
    assert "wanted <= 1.6  SHORT" in report.line(row_of("arap_smooth"))
    assert report.line(ROWS[3]).endswith("25 s")  # no peer, no ratio
    assert "ratio    >80" in report.line(row_of("arap_bend"))  # the peer was stopped on its way


def test_exponent_is_that_of_a_power() -> None:
    sizes = np.array([1e4, 5e4, 2e5])
    assert report.exponent(sizes, 3.0 * sizes**1.37) == pytest.approx(1.37)


def test_two_threads_are_compared_with_one() -> None:
    (found,) = works.two_thread_rows(
        [row("bind", 10_000, 1.0, 2.0), row("bind", 10_000, 0.5, 2.0, threads=2)]
    )
    assert works.BY_ID["two_threads"].ratio(found) == pytest.approx(2.0)
    assert "least 2.00 (bind, 10k); 0 of 1 slower" in report.least_two_threads([found])


def test_tie_of_two_threads_is_no_loss_but_more_is() -> None:
    verdicts = [works.BY_ID["two_threads"].met(row("two_threads", 1, ours, 1.0)) for ours in (1.02, 1.05)]
    assert verdicts == [True, False]


def test_table_slants_what_falls_short() -> None:
    found = report.ratios(ROWS).splitlines()
    assert any("10k: 2.00, 2.00 · 500k: *1.10*" in text for text in found)
    assert all(text.count("|") == 5 for text in found)
    assert "| 3.4: 10 |" in report.ratios(ROWS)
    assert "1M" not in report.ratios(ROWS)  # without a peer


def test_summary_counts() -> None:
    assert report.summary(ROWS)[-1] == "6 ratios as wanted, 4 fall short"


@pytest.fixture
def documents(tmp_path: Path) -> tuple[Path, Path]:
    """Results and a page on performance, in a folder of their own."""
    record.store("made_up", ROWS, record.machine(), tmp_path / "results")
    (tmp_path / "images").mkdir()
    return (
        tmp_path / "results",
        Path(shutil.copy(pages.README, tmp_path / "README.md")),
        Path(shutil.copy(pages.PAGE, tmp_path / "performance.md")),
    )


def test_documents_are_renewed_between_their_marks_and_twice_is_once(
    documents: tuple[Path, Path],
) -> None:
    _, readme, page = documents
    before = readme.read_text()
    pages.render(*documents)
    once = [path.read_bytes() for path in (readme, page, *sorted(page.parent.glob("images/*")))]
    pages.render(*documents)
    assert once == [path.read_bytes() for path in (readme, page, *sorted(page.parent.glob("images/*")))]
    assert len(once) == 4
    mark = "<!-- benchmarks -->"
    after = readme.read_text()
    assert after.partition(mark)[0] == before.partition(mark)[0]
    assert "libigl" not in after.partition(mark)[2].partition("<!-- end")[0]  # was not measured here
    assert "500k: *1.10*" in page.read_text()
    assert "still 7 % above, extrapolated to 1 % after 90 s" in page.read_text()


def test_missing_mark_is_told() -> None:
    with pytest.raises(SystemExit, match="has no <!-- times -->"):
        pages.replaced("text", "times", "")


def test_documents_show_what_is_stored() -> None:
    for path, text in pages.renewed().items():
        assert text == path.read_text(encoding="utf-8"), f"benchmarks/run --render renews {path.name}"


def test_readme_has_its_six_rows() -> None:
    _, rows = record.load()
    assert len(pages.known_peers(rows).splitlines()) == 2 + 6


def test_every_shortfall_is_listed() -> None:
    found = report.shortfall_table(ROWS).splitlines()[2:]
    assert [line.split("|")[3:6] for line in found] == [
        [" 1.2 ", " 1.10 ", " 500k, one thread "],
        [" 1.5 ", " 2.00 ", " 500k "],
        [" 0.5 ", " *0.25* ".replace("*", ""), " 50k, one thread "],
        [" 1.6 ", " 2.00 ", " 10k, one thread "],
    ]


def test_measuring_again_replaces_a_row_and_keeps_the_others(tmp_path: Path) -> None:
    record.store("2030-01-01-1200", ROWS[:3], {"cores": 4}, tmp_path)
    again = {**ROWS[1], "ours": 0.05}
    record.store("2030-01-02-1200", [again], {"cores": 2}, tmp_path)
    assert record.load(tmp_path) == ([{"cores": 4}, {"cores": 2}], [ROWS[0], again, ROWS[2]])


def test_run_of_which_every_row_was_measured_again_goes(tmp_path: Path) -> None:
    record.store("2030-01-01-1200", ROWS[:2], {}, tmp_path)
    path = record.store("2030-01-02-1200", ROWS[:3], {}, tmp_path)
    assert list(tmp_path.iterdir()) == [path]


def test_turns_alternate_and_short_works_come_in_bursts() -> None:
    called = []
    short = Work(lambda: called.append("short"), lambda: called.append("turn"))
    once = Work(lambda: called.append("once"), repeatable=False)
    alternate({"short": short, "once": once}, budget=0.0, least=3)
    assert called.count("turn") == called.count("once") == len(once.seconds) == 3
    assert called.count("short") == len(short.seconds) > 3
    assert called.index("once") < len(called) - 1 - called[::-1].index(
        "turn"
    )  # by turns, not one after the other


def test_best_and_median() -> None:
    work = Work(lambda: time.sleep(0), seconds=[3.0, 1.0, 2.0])
    assert (work.best, work.median) == (1.0, 2.0)


def test_grown_loop_is_told_and_a_shrunk_one_is_not() -> None:
    lines, grown = count.compare({"a": 120, "b": 80, "c": 5}, {"a": 100, "b": 100})
    assert grown == ["a"]
    assert ["+20.00 %" in lines[0], "-20.00 %" in lines[1], "new" in lines[2]] == [True] * 3


def test_arrival_is_measured_or_extrapolated() -> None:
    """Excess 1 / t falls to 1 % at t = 100, whether or not the run goes on until then."""
    seconds = np.arange(1.0, 201.0)
    assert arrival(1 / seconds, 0.01, seconds, 20)["peer"] == pytest.approx(100.0, abs=1.0)
    stopped = arrival(1 / seconds[:40], 0.01, seconds[:40], 20)
    assert stopped["peer"] == 40.0
    assert not stopped["peer_arrived"]
    # A power fits exactly; an exponential through the same end arrives earlier, and the earlier one is taken.
    assert 40.0 < stopped["peer_extrapolated"] <= 100.5


def test_rows_of_blender_get_the_names_of_the_table() -> None:
    entry = {
        "row": "overhead drag arap",
        "vertices": 99_856,
        "around_ms": 12.0,
        "bare_ms": 10.0,
        "ours_ms": 90.0,
    }
    found = blender.table_row({**entry, "ratio": 1.2, "goal": 1.2, "at_most": True}, "5.2")
    assert (found["work"], found["size"], found["case"]) == ("overhead_arap", 100_000, "5.2")
    assert works.BY_ID["overhead_arap"].ratio(found) == pytest.approx(1.2)
    assert "overhead_arap" in report.line(found)


def test_blender_is_planned_in_full_or_not_at_all() -> None:
    options = {"sizes": (), "own_sizes": (), "threads": (1,), "meshes": None}
    names = {work for task in blender.plan(Options(quick=False, **options)) for work in task.works}
    assert names - {"handler_cost"} <= set(works.BY_ID)
    assert blender.plan(Options(quick=True, **options)) == []


@pytest.mark.parametrize(
    ("function", "file", "name"),
    [
        (
            "sinew::ThinShell::respond(Eigen::Matrix<double> const&) const",
            "sinew_frames",
            "ThinShell::respond",
        ),
        ("(anonymous namespace)::triangle(double const*, int)", "sinew_frames", "triangle"),
        (
            "sinew::SupernodalSolve::Impl::sweep(sinew::W&) const::{lambda(int)#1}",
            "",
            "SupernodalSolve::sweep",
        ),
        ("Eigen::internal::gebp_kernel<double>::operator()(long)", "sinew_frames", "Eigen"),
        ("0x00000000000348a0", "/usr/lib/libcholmod.so.3.0.14", "CHOLMOD"),
        ("__memset_avx2_unaligned_erms", "/usr/lib/libc.so.6", "C library: clearing, copying, allocating"),
    ],
)
def test_profile_names_places_a_reader_knows(function: str, file: str, name: str) -> None:
    assert count.place(function, file) == name
