# SPDX-License-Identifier: GPL-3.0-or-later
"""The script that the README shows works as it stands there."""

import re
from pathlib import Path

import bpy
import numpy as np
from rig import add_group, base_points, evaluated_points, grid_object, make_active

README = Path(__file__).parents[2] / "README.md"


def test_the_readme_script_lifts_the_head() -> None:
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    (script,) = [block for block in blocks if "bpy.ops.sinew" in block]
    obj = grid_object()
    head = add_group(obj, "Head", lambda point: point[1] > 0.7)
    feet = add_group(obj, "Feet", lambda point: point[1] < -0.7)
    make_active(obj)

    exec(compile(script, str(README), "exec"), {"bpy": bpy})

    moved = evaluated_points(obj) - base_points(obj)
    # Both regions are held exactly; float32 keeps some 1e-7 of a unit.
    assert np.allclose(moved[head], (0.0, 0.0, 0.5), atol=1e-6)
    assert np.allclose(moved[feet], 0.0, atol=1e-6)
