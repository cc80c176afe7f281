# SPDX-License-Identifier: GPL-3.0-or-later
"""Every row of the benchmarks, once and at its smallest size: whether it and its peer run, never how fast."""

import math

import pytest
import suite
from workshop import cross_wheels, windows_wheels


@pytest.mark.parametrize("task", suite.every_task(suite.SMALLEST), ids=str)
def test_row_and_its_peer_give_a_figure(task: suite.Task) -> None:
    if task.measure.startswith("windows") and not cross_wheels.are_built(windows_wheels.TARGET):
        pytest.skip("this code has no wheels for Windows yet; tests/run windows builds them")
    rows = suite.run_task(task, smallest=True)
    assert {row["work"] for row in rows} == set(task.works)
    for row in rows:
        assert all(map(math.isfinite, row.get("excess_percent", [row.get("ours", 0.0)]))), row
        if row["work"] not in ("convergence", "settled"):  # counts without a peer, which may be none
            assert all(0.0 < row[side] < math.inf for side in ("ours", "peer")), row
