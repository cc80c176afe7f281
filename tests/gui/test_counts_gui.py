# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders beside a window get other vertices than the bind saw. Needs a display."""

import pytest
from blender_window import drive

TIMEOUT = 300.0
EXACT = 1e-5


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What the session in ``drive_counts.py`` observed."""
    return drive("drive_counts.py", tmp_path_factory.mktemp("counts"), TIMEOUT, keep=False)


@pytest.mark.parametrize("change", ["level 3", "level 1", "hidden", "other levels"])
def test_f12_is_bound_for_its_own_counts(seen: dict, change: str):
    assert seen[change] < EXACT


def test_the_viewport_waits_for_rebind_meanwhile(seen: dict):
    assert seen["viewport"] == "Topology changed - Rebind"


def test_playback_binds_no_renders(seen: dict):
    assert seen["counts in playback"] == 1


def test_a_render_that_nothing_was_bound_for_says_so_and_the_next_is_right(seen: dict):
    assert seen["at once"] > 0.1
    assert "In the render: Topology changed - Rebind" in seen["noted"]
    assert "Warning: Thin Shell: In the render: Topology changed - Rebind" in seen["said"]
    assert seen["the next"] < EXACT
    assert not any("render" in line for line in seen["noted next"])
