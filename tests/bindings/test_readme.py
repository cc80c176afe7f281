# SPDX-License-Identifier: GPL-3.0-or-later
"""The script that the README shows works as it stands there."""

import re
from pathlib import Path

import numpy as np

README = Path(__file__).parents[2] / "README.md"


def test_the_readme_script_lifts_the_head() -> None:
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    (script,) = [block for block in blocks if "import numpy" in block]
    (more,) = [block for block in blocks if "SubdivisionSurface" in block]
    line = np.linspace(-1.0, 1.0, 11)
    points = np.array([(x, y, 0.0) for y in line for x in line])
    faces = np.array(
        [(j * 11 + i, j * 11 + i + 1, j * 11 + i + 12, j * 11 + i + 11) for j in range(10) for i in range(10)]
    )
    head, feet = np.flatnonzero(points[:, 1] > 0.7), np.flatnonzero(points[:, 1] < -0.7)
    names = {"points": points, "faces": faces, "head": head, "feet": feet}

    exec(compile(script, str(README), "exec"), names)

    # Handles are held exactly.
    assert np.allclose(names["positions"][head], points[head] + (0.0, 0.0, 0.5), atol=1e-12)
    assert np.allclose(names["positions"][feet], points[feet], atol=1e-12)
    assert names["report"].converged

    exec(compile(more, str(README), "exec"), names)
    assert names["problems"].clean
    assert np.abs(names["positions"] - points * (1.0, 1.0, 1.5)).max() < 1e-6 * np.abs(points).max()
