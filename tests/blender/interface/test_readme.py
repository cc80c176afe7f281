# SPDX-License-Identifier: GPL-3.0-or-later
"""The scripts that the README and the manual show work as they stand there."""

import re
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import bpy
import numpy as np
import pytest
from rigs.rig import Rig, add_group, base_points, evaluated_points, grid_object, key_heights, make_active

ROOT, SCRIPTING = Path(__file__).parents[3], "docs/manual/scripting.md"
FLOAT32 = 1e-6  # both regions are held exactly; float32 keeps some 1e-7 of a unit


def blocks(page: str, word: str) -> list[str]:
    """The Python blocks of a page in which a word stands."""
    found = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.DOTALL)
    return [block for block in found if word in block]


def run(script: str, page: str) -> dict:
    names: dict = {"bpy": bpy}
    exec(compile(script, page, "exec"), names)
    return names


@pytest.fixture
def doll() -> tuple[bpy.types.Object, list[int], list[int]]:
    """An active mesh with the groups that the scripts speak of, and their vertices."""
    obj = grid_object()
    head = add_group(obj, "Head", lambda point: point[1] > 0.7)
    feet = add_group(obj, "Feet", lambda point: point[1] < -0.7)
    make_active(obj)
    return obj, head, feet


def test_the_readme_script_lifts_the_head(doll: tuple) -> None:
    obj, head, feet = doll
    (script,) = blocks("README.md", "bpy.ops.sinew")
    run(script, "README.md")
    moved = evaluated_points(obj) - base_points(obj)
    assert np.allclose(moved[head], (0.0, 0.0, 0.5), atol=FLOAT32)
    assert np.allclose(moved[feet], 0.0, atol=FLOAT32)


def test_the_manuals_script_poses_keys_and_bakes(doll: tuple, tmp_path: Path) -> None:
    obj, head, feet = doll
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "doll.blend"))
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 3
    script, *_ = blocks(SCRIPTING, "bpy.ops.sinew")
    before_factor, after_factor = script.split("deformer.factor = 0.0\n")
    names = run(before_factor, SCRIPTING)
    moved = evaluated_points(obj) - base_points(obj)
    assert np.allclose(moved[head], (0.0, 0.0, 0.5), atol=FLOAT32)
    assert np.allclose(moved[feet], 0.0, atol=FLOAT32)
    exec(compile("deformer.factor = 0.0\n" + after_factor, SCRIPTING, "exec"), names)
    assert (tmp_path / "cache" / "head.pc2").is_file()
    assert names["deformer"].bake.is_baked
    assert np.allclose(evaluated_points(obj), base_points(obj), atol=FLOAT32)  # Factor is 0 in all frames


def test_the_manuals_cage_moves_the_mesh(doll: tuple) -> None:
    obj, _head, _feet = doll
    _, script, *_ = blocks(SCRIPTING, "bpy.ops.sinew")
    names = run(script, SCRIPTING)
    assert names["cage"].parent == obj
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    moved = np.abs(evaluated_points(obj) - base_points(obj)).max()
    assert 0.01 < moved < 0.5


def test_the_manuals_handler_reads_the_shape_of_each_frame(plate: Rig) -> None:
    plate.bind()
    key_heights(plate.control, {1: 0.0, 11: 1.0}, linear=True)
    (script,) = blocks(SCRIPTING, "frame_change_post")
    names, printed = run(script, SCRIPTING), StringIO()
    try:
        with redirect_stdout(printed):
            for frame in (4, 9):
                bpy.context.scene.frame_set(frame)
    finally:
        bpy.app.handlers.frame_change_post.remove(names["write_heights"])
    seen = [tuple(map(float, line.split())) for line in printed.getvalue().splitlines()]
    assert np.allclose(seen, [(4.0, 0.3), (9.0, 0.8)], atol=FLOAT32)


def test_the_manual_speaks_of_operators_that_exist() -> None:
    """Each ``sinew.name`` in code, with the names of its arguments."""
    for page in sorted((ROOT / "docs" / "manual").glob("*.md")):
        text = page.read_text(encoding="utf-8")
        for name, arguments in re.findall(r"sinew\.(\w+)\(([^)\n]*)\)?", text):
            if not hasattr(bpy.types, f"SINEW_OT_{name}"):
                continue
            known = getattr(bpy.ops.sinew, name).get_rna_type().properties.keys()
            for argument in re.findall(r"(\w+)\s*=", re.sub(r"\"[^\"]*\"", "", arguments)):
                assert argument in known, (page.name, name, argument)
        for name in re.findall(r"bpy\.ops\.sinew\.(\w+)", text):
            assert hasattr(bpy.types, f"SINEW_OT_{name}"), (page.name, name)


def test_the_scripting_page_lists_every_operator() -> None:
    text = (ROOT / SCRIPTING).read_text(encoding="utf-8")
    table = text[text.index("| operator") : text.index("Operators work on")]
    listed = set(re.findall(r"[`. ](?:sinew\.)?(\w+)[`(]", table))
    for name in dir(bpy.ops.sinew):
        options = getattr(getattr(bpy.types, f"SINEW_OT_{name}"), "bl_options", ())
        assert name in listed or "INTERNAL" in options, name
