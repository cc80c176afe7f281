# SPDX-License-Identifier: GPL-3.0-or-later
"""LLM.md, the page for scripts: they run as they stand there, and it lists what this Blender has."""

import re
import sys
from itertools import zip_longest

import bpy
import numpy as np
import pytest
from inside import room
from pages import ROOT
from rigs.rig import base_points, evaluated_points

sys.path.append(str(ROOT / "tools" / "workshop" / "inside"))
import script_page

TEXT = script_page.PAGE.read_text(encoding="utf-8")
FLOAT32 = 1e-5  # poses went through the location and rotation of a control


def run(title: str) -> dict:
    """The script below this heading, run; its names."""
    (script,) = re.findall(rf"^### {title}\n[^#]*?```python\n(.*?)```", TEXT, re.MULTILINE | re.DOTALL)
    names: dict = {}
    exec(compile(script, title, "exec"), names)
    return names


def test_the_reference_is_what_this_blender_says() -> None:
    lines = zip_longest(TEXT.splitlines(), script_page.page_of(TEXT, room).splitlines())
    changed = [pair for pair in lines if pair[0] != pair[1]]
    assert not changed, f"run tools/describe_methods --scripts: {changed[:2]}"


def test_the_script_with_handles_turns_the_head_and_holds_the_feet(capfd: pytest.CaptureFixture) -> None:
    names = run("Handles on a mesh")
    rest, seen, sin = base_points(names["obj"]), names["positions"], 0.75**0.5
    turn, middle = np.array([(1, 0, 0), (0, 0.5, -sin), (0, sin, 0.5)]), (0.0, 0.95, 0.0)
    head, feet = rest[:, 1] > 0.85, rest[:, 1] < -0.85
    assert np.allclose(seen[head], (rest[head] - middle) @ turn.T + (0.0, 0.95, 1.0), atol=FLOAT32)
    assert np.allclose(seen[feet], rest[feet], atol=FLOAT32)
    assert "\nINFO 441 vertices" in capfd.readouterr().out


def test_the_script_with_a_cage_lengthens_the_upper_half(capfd: pytest.CaptureFixture) -> None:
    shape = evaluated_points(run("A cage around a mesh")["obj"])
    assert 1.5 < shape[:, 2].max() < 2.0  # Green coordinates widen what they lengthen
    assert shape[:, 2].min() == pytest.approx(-1.0, abs=0.1)
    assert f"height {shape[:, 2].max()}" in capfd.readouterr().out


def test_the_script_with_a_bake_leaves_a_file_that_plays(capfd: pytest.CaptureFixture) -> None:
    obj = run("A motion, baked to a file")["obj"]
    assert f"True {32 + 10 * 441 * 12}" in capfd.readouterr().out  # 32 bytes, and three floats for each point
    bpy.data.objects.remove(obj.sinew.active.handles[0].control)
    for frame, height in ((1, 0.0), (10, 1.0)):
        bpy.context.scene.frame_set(frame)
        assert evaluated_points(obj)[-1, 2] == pytest.approx(height, abs=FLOAT32)


def test_the_script_with_an_error_and_the_place_of_the_module(capfd, addon_name: str) -> None:
    run("Errors")
    assert "Nothing is held yet" in capfd.readouterr().out
    extension, legacy = re.search(r"Inside Blender the module is `(.*)` \(.*`(.*)` \(", TEXT).groups()
    exec(legacy if addon_name == "sinew" else extension, names := {})
    assert names["sinew_native"] is room("backend").availability().module
