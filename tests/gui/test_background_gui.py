# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that stay in a real window while a thread works, and what the panel shows. Needs a display."""

import ast

import pytest
from blender_window import HERE, drive

TIMEOUT = 600.0  # a minute and a half on a quiet machine


def cases() -> list[str]:
    """The names in ``CASES`` of the script."""
    module = ast.parse((HERE / "drive_background.py").read_text(encoding="utf-8"))
    (table,) = (
        node.value
        for node in module.body
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "CASES"
    )
    return [ast.literal_eval(key) for key in table.keys]


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What the session in ``drive_background.py`` observed."""
    return drive("drive_background.py", tmp_path_factory.mktemp("background"), TIMEOUT, size=(800, 500))


@pytest.mark.parametrize("name", cases())
def test_an_operator_that_waits_for_threads_ends_once(seen: dict, name: str):
    found = seen[name]
    assert found["stays"] == ["RUNNING_MODAL"]
    assert all(found["bound"]), found
    assert found["bound"]
    assert found["level"] == "INFO", found["status"]


def test_objects_get_one_cage_at_a_time_and_the_panel_of_each_cancels_it(seen: dict):
    found = seen["one at a time"]
    assert found["offered while cancelled"] == [False, False]
    assert found["offered while made"] == [False, False]
    assert (found["cages when cancelled"], found["deformers when cancelled"]) == (0, [0, 0])
    assert (found["cages when made"], found["deformers when made"]) == (1, [1, 1])
    assert found["status"] == "INFO"
    assert found["offered afterwards"]


def test_another_file_ends_what_waits(seen: dict):
    assert seen["objects in the other file"] == 0
