# SPDX-License-Identifier: GPL-3.0-or-later
"""Every row of the benchmarks, once and at its smallest size: whether it and its peer run, never how fast."""

import math
from pathlib import Path

import pytest
import suite
import works
from groups import Options, Task
from record import Row
from workshop import cross_wheels, windows_wheels

DERIVED = {"two_threads"}  # follows from rows of other works
MAY_BE_NONE = {"convergence", "primo_steps"}  # what is left to a minimum, and the steps that lead near it
WITHOUT_PEER = {"convergence": "excess_percent", "handler_cost": "handler_ms"}  # work -> its figure
OPTIONS = Options(
    sizes=suite.QUICK, own_sizes=(), threads=(1, 2), quick=True, meshes=Path("none"), smallest=True
)
TASKS = suite.every_task(OPTIONS)


def figures(row: Row) -> list[float]:
    if row["work"] not in WITHOUT_PEER:
        return [row["ours"], row["peer"]]
    found = row[WITHOUT_PEER[row["work"]]]
    return found if isinstance(found, list) else [found]


def test_every_work_of_the_table_is_planned() -> None:
    planned = {work for task in TASKS for work in task.works}
    assert planned == works.BY_ID.keys() - DERIVED | WITHOUT_PEER.keys()


@pytest.mark.parametrize("task", TASKS, ids=str)
def test_row_and_its_peer_give_a_figure(task: Task) -> None:
    if task.group == "windows" and not cross_wheels.are_built(windows_wheels.TARGET):
        pytest.skip("this code has no wheels for Windows yet; tests/run windows builds them")
    rows = suite.run_task(task, [], smallest=True)
    assert {row["work"] for row in rows} == set(task.works)
    for row in rows:
        assert all(math.isfinite(figure) for figure in figures(row)), row
        if row.get("unit") != "faces" and row["work"] not in MAY_BE_NONE:
            assert min(figures(row)) > 0.0, row
