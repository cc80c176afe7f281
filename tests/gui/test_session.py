# SPDX-License-Identifier: GPL-3.0-or-later
"""An artist's first pose in a real window: menu, drag, turn, undo. Needs a display, such as Xvfb's."""

import json
import os
import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).parent
TIMEOUT = 240.0  # a software renderer draws about two windows a second


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What the session in ``drive.py`` observed; screenshots stay in the output folder."""
    if "DISPLAY" not in os.environ:
        pytest.skip("no display: start it under xvfb-run")
    output = Path(os.environ.get("SINEW_TEST_OUTPUT") or tmp_path_factory.mktemp("gui"))
    output.mkdir(parents=True, exist_ok=True)
    command = ["blender", "--factory-startup", "--enable-event-simulate", "-noaudio"]
    command += ["--window-geometry", "0", "0", "1280", "800"]
    if "PYTHONPATH" in os.environ:
        command.append("--python-use-system-env")
    command += ["--python", str(HERE / "drive.py"), "--", str(output)]
    ended = subprocess.run(command, timeout=TIMEOUT, capture_output=True, text=True, check=False)
    said = ended.stdout + ended.stderr
    assert "Traceback" not in said, said
    assert "Dependency cycle" not in said, said
    found = json.loads((output / "seen.json").read_text(encoding="utf-8"))
    assert "error" not in found, found["error"]
    return found


def test_the_menu_makes_a_handle_of_the_selection(seen: dict):
    assert seen["handles_after_menu"] == ["Handle"]


def test_back_in_object_mode_the_control_alone_is_selected(seen: dict):
    assert seen["mode"] == "OBJECT"
    assert seen["selected"] == ["Statue Handle"]
    assert "vertices, 2 handles, bound in" in seen["status"]


def test_the_surface_follows_the_drag(seen: dict):
    assert seen["during"] > 0.5
    assert seen["moved"] > 0.5
    assert seen["base_moved"] == 0.0


def test_the_final_answer_follows_the_preview(seen: dict):
    assert seen["settled"]


def test_undo_takes_turn_and_drag_back(seen: dict):
    assert seen["turned"] > 0.2
    assert seen["first_undo"] < 1e-5
    assert seen["second_undo"] < 1e-5


def test_the_picture_changed_and_came_back(seen: dict):
    assert seen["pixels_moved"] > 0.03
    assert seen["pixels_not_undone"] < 0.002


def test_a_heavy_mesh_binds_in_a_thread_and_esc_cancels(seen: dict):
    assert seen["heavy_in_thread"]
    assert "160,801 vertices, 2 handles, bound in" in seen["heavy_status"]
    assert "cancelled" in seen["cancelled"]
    assert "bound in" in seen["bound_again"]
