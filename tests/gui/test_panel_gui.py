# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel shows in a sidebar of the width that Blender gives it. Needs a display."""

import pytest
from blender_window import drive

TIMEOUT = 300.0


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What the session in ``drive_panel.py`` observed."""
    return drive("drive_panel.py", tmp_path_factory.mktemp("panel"), TIMEOUT)


def test_each_key_shows_its_frame(seen: dict):
    """The lines of pixels that change with the number are those of digits, and within one row."""
    assert seen["width"] == pytest.approx(220.0, abs=1.0)
    found = seen["rows that changed"]
    assert sorted(map(int, found)) == [13, 133, 1029]
    assert all(4 <= lines <= 20 for lines in found.values()), found
