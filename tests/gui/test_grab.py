# SPDX-License-Identifier: GPL-3.0-or-later
"""Grab Region in a real window, beside Blender's own Move, Rotate and Scale. Needs a display, as Xvfb's."""

import json
import os
import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).parent
TIMEOUT = 420.0  # a software renderer draws about two windows a second, fewer on a busy machine
SAME = (
    "free",
    "axis",
    "local",
    "plane",
    "sight",
    "typed",
    "turn",
    "turn x",
    "turn z",
    "size",
    "size plane",
    "switched",
    "slanted axis",
    "slanted plane",
    "slanted turn z",
    "perspective free",
    "perspective axis",
)


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What the session in ``drive_grab.py`` observed; screenshots stay in the output folder."""
    if "DISPLAY" not in os.environ:
        pytest.skip("no display: start it under xvfb-run")
    output = Path(os.environ.get("SINEW_TEST_OUTPUT") or tmp_path_factory.mktemp("gui")) / "grab"
    output.mkdir(parents=True, exist_ok=True)
    command = ["blender", "--factory-startup", "--enable-event-simulate", "-noaudio"]
    command += ["--window-geometry", "0", "0", "1280", "800"]
    if "PYTHONPATH" in os.environ:
        command.append("--python-use-system-env")
    command += ["--python", str(HERE / "drive_grab.py"), "--", str(output)]
    ended = subprocess.run(command, timeout=TIMEOUT, capture_output=True, text=True, check=False)
    said = ended.stdout + ended.stderr
    assert "Traceback" not in said, said
    found = json.loads((output / "seen.json").read_text(encoding="utf-8"))
    assert "error" not in found, found["error"]
    return found


def test_the_key_starts_it_and_the_surface_follows(seen: dict):
    assert seen["dragged"] > 0.5
    assert seen["followed"] > 500


def test_axis_number_and_enter_move_the_selection_by_just_that(seen: dict):
    assert seen["typed along x"] < 1e-6
    assert seen["last"] == ["SINEW_OT_grab_region", "TRANSLATE", [0.5, 0.0, 0.0]]


def test_one_undo_takes_it_back(seen: dict):
    assert seen["undone"] == 0.0


def test_esc_restores_every_bit(seen: dict):
    assert seen["restored"]
    assert seen["selection kept"]
    assert "not restored" not in seen


@pytest.mark.parametrize("name", SAME)
def test_the_same_events_move_the_selection_as_blender_does(seen: dict, name: str):
    blender, ours = seen[name]
    difference = max(
        abs(a - b) for row, other in zip(blender, ours, strict=True) for a, b in zip(row, other, strict=True)
    )
    assert difference < 1e-4  # float32 vertices, and Blender's float32 view
