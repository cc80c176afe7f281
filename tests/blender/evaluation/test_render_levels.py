# SPDX-License-Identifier: GPL-3.0-or-later
"""Modifiers before Sinew that give renders other vertices than the viewport."""

from pathlib import Path

import bpy
import numpy as np
import pytest
from probe import exported_points
from rigs.rig import (
    Rig,
    add_armature,
    press,
    reopen,
    update,
)


def subdivided(plate: Rig, levels: int, render_levels: int) -> None:
    modifier = plate.obj.modifiers.new("Subdivision", "SUBSURF")
    modifier.subdivision_type = "SIMPLE"
    modifier.levels, modifier.render_levels = levels, render_levels


def test_a_pose_of_an_armature_above_is_followed_in_renders_too(plate: Rig, tmp_path: Path):
    armature = add_armature(plate.obj)
    subdivided(plate, 0, 1)
    plate.bind("arap")
    armature.pose.bones["high"].location = (0.0, 0.0, 0.3)
    plate.lift(0.2)
    shown, seen = plate.points(), exported_points(plate.obj, tmp_path)
    assert len(seen) == 441
    assert seen[:, 2].max() == pytest.approx(shown[:, 2].max(), abs=1e-5)
    assert seen[:, 2].max() > 0.45
    assert seen[:, 2].min() == pytest.approx(0.0, abs=1e-5)


def test_save_and_load_keep_what_renders_show(plate: Rig, tmp_path: Path):
    subdivided(plate, 1, 2)
    plate.bind("thin_shell")
    plate.lift()
    before = exported_points(plate.obj, tmp_path)
    reopen(tmp_path / "levels.blend")
    np.testing.assert_allclose(exported_points(plate.obj, tmp_path), before, atol=1e-6)
    assert before[:, 2].max() == pytest.approx(1.0, abs=1e-3)  # weights fade where groups are subdivided


def test_simplify_counts(plate: Rig, tmp_path: Path):
    subdivided(plate, 2, 2)
    render = bpy.context.scene.render
    render.use_simplify, render.simplify_subdivision, render.simplify_subdivision_render = True, 0, 1
    update()
    plate.bind("thin_shell", fixed=False)
    plate.lift(0.5)
    seen = exported_points(plate.obj, tmp_path)
    assert (len(plate.points()), len(seen)) == (121, 441)
    np.testing.assert_allclose(seen[:, 2], 0.5, atol=1e-5)
    assert render.use_simplify


def test_unbinding_frees_both_rest_meshes(plate: Rig):
    subdivided(plate, 0, 1)
    count = len(bpy.data.meshes)
    plate.bind("thin_shell")
    assert plate.deformer.rest_render is not None
    press(plate.obj, "deformer_remove")
    assert len(bpy.data.meshes) == count
