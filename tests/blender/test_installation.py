# SPDX-License-Identifier: GPL-3.0-or-later
"""The button in the preferences that checks the installation."""

from __future__ import annotations

import tempfile
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from inside import native
from registry import METHODS
from rigs import HandleRig
from sheet import Sheet


def page(addon_name: str) -> Sheet:
    """The preferences of the add-on, as they are drawn now."""
    values = bpy.context.preferences.addons[addon_name].preferences
    sheet = Sheet()
    stand_in = SimpleNamespace(layout=sheet, section="GENERAL")
    for name in ("_draw_general", "_draw_overlays", "_draw_keymap"):
        setattr(stand_in, name, lambda *_arguments: None)
    type(values).draw(stand_in, bpy.context)
    return sheet


def blocks() -> dict[str, int]:
    """How many datablocks there are of each type."""
    names = [p.identifier for p in bpy.data.bl_rna.properties if p.type == "COLLECTION"]
    return {name: len(getattr(bpy.data, name)) for name in names}


def icon_of(sheet: Sheet, words: str) -> str:
    """The icon before a line."""
    lines = [keywords for name, _args, keywords, _settings in sheet.calls if name == "label"]
    return next(keywords["icon"] for keywords in lines if words in keywords["text"])


# The button


@pytest.fixture
def reports(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder that the reports of this test go to."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def test_the_button_writes_a_report_and_leaves_the_file_alone(
    posed_plate: HandleRig, addon_name: str, reports: Path
):
    before, shown = blocks(), posed_plate.points()
    assert bpy.ops.sinew.check_installation() == {"FINISHED"}
    assert blocks() == before
    assert np.array_equal(posed_plate.points(), shown)
    (report,) = reports.glob("sinew-check-*.txt")
    text = report.read_text(encoding="utf-8")
    assert bpy.app.version_string in text
    for method in METHODS:
        assert f"\n{method.id}: " in text
    assert "known answers are right" in text
    assert "WRONG" not in text
    sheet = page(addon_name)
    assert icon_of(sheet, "known answers are right") == "CHECKMARK"
    assert dict(sheet.operators())["wm.path_open"].filepath == str(report)


def test_wrong_answers_of_the_module_are_shown(
    addon_name: str, reports: Path, monkeypatch: pytest.MonkeyPatch
):
    right = native().SurfaceMethod.solve

    def wrong(self, *args: object, **options: object) -> tuple:
        shape, report = right(self, *args, **options)
        return 1.001 * shape, report

    monkeypatch.setattr(native().SurfaceMethod, "solve", wrong)
    with pytest.raises(RuntimeError, match="known answers are wrong"):
        bpy.ops.sinew.check_installation()
    (report,) = reports.glob("sinew-check-*.txt")
    assert "WRONG" in report.read_text(encoding="utf-8")
    assert icon_of(page(addon_name), "known answers are wrong") == "ERROR"


def test_no_place_for_the_report(reports: Path, monkeypatch: pytest.MonkeyPatch):
    with monkeypatch.context() as patch:
        patch.setattr(tempfile, "tempdir", str(reports / "nowhere"))
        with pytest.raises(RuntimeError, match="cannot be written"):
            bpy.ops.sinew.check_installation()
