# SPDX-License-Identifier: GPL-3.0-or-later
"""The preferences of the add-on in a real window. Needs a display."""

from pathlib import Path

from blender_window import drive

TIMEOUT = 300.0


def test_the_button_checks_the_installation_and_tells_where_the_report_lies(tmp_path: Path):
    seen = drive("drive_preferences.py", tmp_path, TIMEOUT)
    asked, wrong, summary = seen["found"]
    assert asked > 100
    assert wrong == 0
    assert summary == f"All {asked} known answers are right"
    assert "with a window" in seen["report"]
    assert seen["report"].count("  right  ") == asked
