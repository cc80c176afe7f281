# SPDX-License-Identifier: GPL-3.0-or-later
"""The scripts that the README, the manual and the methods show for the library work as they stand there."""

import re
from pathlib import Path

import numpy as np
import pytest

from .meshes import quad_grid

ROOT = Path(__file__).parents[2]


def scripts(page: str) -> list[str]:
    """The Python blocks of a page that use the library alone, without Blender."""
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.DOTALL)
    return [block for block in blocks if "sn." in block]


@pytest.fixture
def names() -> dict:
    """What the scripts speak of: a plate with a head and feet."""
    points, faces = quad_grid(10, 10, 0.2)
    points -= (1.0, 1.0, 0.0)
    head, feet = np.flatnonzero(points[:, 1] > 0.7), np.flatnonzero(points[:, 1] < -0.7)
    return {"points": points, "faces": faces, "head": head, "feet": feet}


@pytest.mark.parametrize("page", ["README.md", "docs/manual/scripting.md"])
def test_the_first_script_lifts_the_head(page: str, names: dict) -> None:
    exec(scripts(page)[0], names)
    for part, lift in (("head", 0.5), ("feet", 0.0)):  # handles are held exactly
        held = names[part]
        assert np.allclose(names["positions"][held], names["points"][held] + (0.0, 0.0, lift), atol=1e-12)
    assert names["report"].converged


def test_the_manuals_cage_and_subdivision(names: dict) -> None:
    first, cage, subdivision = scripts("docs/manual/scripting.md")
    exec(first, names)
    exec(cage, names)
    points = names["points"]
    assert names["problems"].clean
    assert np.abs(names["positions"] - points * (1.0, 1.0, 1.5)).max() < 1e-6 * np.abs(points).max()
    exec(subdivision, names)
    # refine works in single precision: some bits of the largest coordinate.
    expected = names["smooth"].matrix @ names["positions"]
    assert np.abs(names["fine"] - expected).max() < 1e-6 * np.abs(expected).max()


def test_the_page_for_scripts_lifts_the_head_and_prints_an_error(capsys: pytest.CaptureFixture) -> None:
    exec(scripts("LLM.md")[0], names := {})
    lift = names["positions"] - names["points"]
    assert np.allclose(lift[names["feet"]], 0.0, atol=1e-12)
    assert np.allclose(lift[names["head"]], (0.0, 0.0, 0.5), atol=1e-12)
    assert np.ptp(names["warped"][:, 2]) > 1.5 * np.ptp(names["positions"][:, 2])
    assert "InvalidConstraint vertices 0, 1, 2" in capsys.readouterr().out


PROGRAMS = sorted(page for page in (ROOT / "docs/methods").glob("*.md") if scripts(page))


@pytest.mark.parametrize("page", PROGRAMS, ids=lambda page: page.stem)
def test_the_program_of_a_method_moves_its_mesh(page: Path) -> None:
    names: dict = {}
    exec(*scripts(page), names)
    moved = np.linalg.norm(names["positions"] - names["mesh"].points, axis=1)
    assert 0.3 < moved.max() < 5.0  # an egg 6.7 long, of which a part moves by up to 3.8
    assert np.isfinite(moved).all()
