# SPDX-License-Identifier: GPL-3.0-or-later
"""Wires and a drag of a vector field in a real window, by mouse and keys. Needs a display."""

import pytest
from blender_window import drive

TIMEOUT = 400.0
FLOAT32 = 4e-6  # of a head 4 units wide


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What the session in ``drive_curves.py`` observed."""
    return drive("drive_curves.py", tmp_path_factory.mktemp("curves"), TIMEOUT)


def test_edges_become_a_wire_that_g_moves_and_undo_puts_back(seen: dict):
    splines, status = seen["wire"]
    assert splines == 1
    assert "1 wire" in status
    assert seen["wire moved"] > 0.1
    assert seen["wire undone"] < FLOAT32


def test_a_stroke_on_the_surface_becomes_a_wire_that_is_posed_in_its_edit_mode(seen: dict):
    rows, points = seen["stroke"]
    assert (rows, points) == (1, 6)
    assert 0.3 < seen["stroke reaches"] < 0.5  # of its length on the screen; on the surface it is longer
    assert seen["stroke rests"] < FLOAT32
    assert seen["stroke moved"] > 0.05


def test_a_drag_stores_its_path(seen: dict):
    stops, moved, status = seen["field"]
    assert stops >= 3
    assert seen["field reaches"] == pytest.approx(1.0 / 3.0 / 1.1, rel=0.03)  # a click of the wheel smaller
    assert moved > 0.5
    assert "1 tool" in status
    from_rest, from_end = seen["half way"]
    assert min(from_rest, from_end) > 0.1
    assert seen["whole way"] < FLOAT32


def test_undo_and_escape_leave_nothing_of_a_drag(seen: dict):
    assert seen["field undone"][0] == 0
    assert seen["field undone"][1] < FLOAT32
    assert seen["before escape"] > 0.05
    deformers, tools, off = seen["given up"]
    assert (deformers, tools) == (0, [])
    assert off < FLOAT32
