# SPDX-License-Identifier: GPL-3.0-or-later
"""Every row of the benchmarks, once and at its smallest size: whether it and its peer run, never how fast."""

import math

import pytest
import suite
from works import BY_ID, WORKS
from workshop import cross_wheels, windows_wheels

MOST_ROWS, MOST_MISSED = 30, 5
TASKS = suite.every_task(suite.SMALLEST)


def test_table_is_short_and_each_function_is_planned_once() -> None:
    assert len(WORKS) <= MOST_ROWS
    assert [work for task in TASKS for work in task.works] == list(BY_ID)


@pytest.mark.parametrize("task", TASKS, ids=str)
def test_row_and_its_peer_give_a_figure(task: suite.Task) -> None:
    if task.measure.startswith("windows") and not cross_wheels.are_built(windows_wheels.TARGET):
        pytest.skip("this code has no wheels for Windows yet; tests/run windows builds them")
    rows = suite.run_task(task, smallest=True)
    assert {row["work"] for row in rows} == set(task.works)
    for row in rows:
        if row["work"] == "convergence":
            assert all(math.isfinite(excess) for excess in row["excess_percent"])
        elif row["work"] == "settled":
            assert row["ours"] >= 0
        else:
            assert all(0.0 < row[side] < math.inf for side in ("ours", "peer")), row
