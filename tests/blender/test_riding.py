# SPDX-License-Identifier: GPL-3.0-or-later
"""Corrections of a shape that bones, shape keys or another rig pose: they ride on the surface that enters.

The far edge of a plate is carried by one bone alone, so a correction that was made at one frame must follow
that bone at every other: the oracle is the matrix of the bone.
"""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from probe import render_points
from registry import BY_ID, WITH_HANDLES
from rig import (
    FLOAT32,
    MATRIX,
    Rig,
    add_armature,
    apply_matrix,
    close,
    evaluated_points,
    key,
    make_active,
    move_world,
    push,
    reopen,
    update,
)

MADE, FRAMES = 20, (1, 7, 20, 30)
ITERATED = 1e-2  # where handles are not moved, an iteration may stop this far from what enters
LIFT = Matrix.Translation((0.05, -0.1, 0.2))
TURN = LIFT @ Matrix.Rotation(0.4, 4, "Z")


def go(frame: int) -> None:
    bpy.context.scene.frame_set(frame)


def posed(plate: Rig) -> bpy.types.Object:
    """Two bones carry the plate; the far one bends and moves over the frames. It is at the frame MADE."""
    armature = add_armature(plate.obj, split=-0.3)
    bone = armature.pose.bones["high"]
    poses = {1: (0.0, 0.0, 0.0), MADE: (1.4, 0.3, -0.5), 30: (-0.6, 0.0, 0.8)}
    key(bone, {frame: {"rotation_euler": turn} for frame, turn in poses.items()})
    key(bone, {1: {"location": (0.0, 0.0, 0.0)}, 30: {"location": (0.2, 0.1, -0.3)}})
    go(MADE)
    return armature


def bone_now() -> np.ndarray:
    """What the far bone does to the mesh in this frame, (4, 4)."""
    armature = bpy.data.objects["Rig"].evaluated_get(bpy.context.evaluated_depsgraph_get())
    bone = armature.pose.bones["high"]
    return np.array(bone.matrix @ bone.bone.matrix_local.inverted(), dtype=float)


def entering(plate: Rig) -> np.ndarray:
    """What the bones make of the plate in this frame, by their matrix: the far edge alone is asked for."""
    return apply_matrix(bone_now(), plate.rest())


def corrected(plate: Rig, motion: Matrix) -> None:
    """Move the control in the world of this frame."""
    move_world(plate.control, motion)


def expected(plate: Rig, made: np.ndarray, motion: Matrix) -> np.ndarray:
    """The far edge now, if ``motion`` of the world moved it when the bone was at ``made``."""
    carried = bone_now() @ np.linalg.inv(made)
    return apply_matrix(carried @ np.array(motion) @ made, plate.rest()[plate.top])


@pytest.mark.parametrize("method", WITH_HANDLES)
def test_a_correction_rides_on_the_surface(plate: Rig, method: str):
    posed(plate)
    plate.bind(method)
    assert plate.deformer.handles[0].stands_on == "SURFACE"
    made, motion = bone_now(), LIFT if BY_ID[method].is_space else TURN
    off = ITERATED if BY_ID[method].iterative else MATRIX
    for frame in FRAMES:
        go(frame)
        assert close(plate.points()[plate.top], entering(plate)[plate.top], off), frame
    go(MADE)
    corrected(plate, motion)
    for frame in FRAMES:
        go(frame)
        wanted = expected(plate, made, motion)
        assert close(plate.points()[plate.top], wanted, off), frame
        assert close(render_points(plate.obj)[plate.top], wanted, off), frame
