# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of a mesh that no region touches: they ride on the surface they lie on or in, or they stay.

How they ride is tested in ``tests/native/attachments`` and ``tests/bindings/surfaces/test_free_parts.py``.
"""

from __future__ import annotations

import math
from pathlib import Path

import bmesh
import bpy
import numpy as np
import pytest
from editing import edited, grab
from expected import Expected
from inside import inner, notes_of
from mathutils import Matrix
from registry import ON_HANDLE_POINTS, ON_SURFACE
from rigs import rig as scenes

BEND = Matrix.Rotation(math.radians(40.0), 4, "Y") @ Matrix.Translation((0.3, 0.0, 0.4))
ITERATED = 1e-3  # where a pose differs in its last digit, an iterative method may stop a step earlier
COUNTS = {0: 33, 1: 129, 2: 497}  # vertices of each of Suzanne's two eyes, by how often she is divided


class Suzanne(scenes.Rig):
    """Her ears move, her chin stays, nothing holds her eyes."""

    def __init__(self, levels: int = 0) -> None:
        bpy.ops.mesh.primitive_monkey_add()
        obj = bpy.context.object
        if levels:
            scenes.subdivided(obj, levels)
            bpy.ops.object.modifier_apply(modifier="Subdivision")
        self.name = obj.name
        self.eyes = parts_of(obj)[1:]
        self.head = np.setdiff1d(np.arange(len(obj.data.vertices)), np.concatenate(self.eyes))
        self.top, self.base = (self.add(name, where) for name, where in (("Top", 0.6), ("Base", -0.6)))

    def add(self, name: str, height: float) -> np.ndarray:
        """A group of the head above or below."""
        points = scenes.base_points(self.obj)
        up = np.sign(height) * (points[:, 2] - height) > 0.0
        up[np.concatenate(self.eyes)] = False
        return self.add_members(name, np.flatnonzero(up))

    def add_members(self, name: str, members: np.ndarray) -> np.ndarray:
        self.obj.vertex_groups.new(name=name).add(members.tolist(), 1.0, "REPLACE")
        return members


def parts_of(obj: bpy.types.Object) -> list[np.ndarray]:
    """The vertices of each connected part, the largest first."""
    label, before = np.arange(len(obj.data.vertices)), None
    ends = np.array([edge.vertices for edge in obj.data.edges])
    while before is None or not np.array_equal(label, before):
        before = label.copy()
        for side in (0, 1):
            np.minimum.at(label, ends[:, side], label[ends].min(axis=1))
    return sorted((np.flatnonzero(label == first) for first in np.unique(label)), key=len, reverse=True)


@pytest.fixture
def suzanne() -> Suzanne:
    return Suzanne()


@pytest.mark.parametrize("method", ON_SURFACE)
def test_eyes_follow_the_head_or_stay(suzanne: Suzanne, method: str):
    """As those of a native object."""
    rest = suzanne.rest()
    suzanne.bind(method)
    assert "2 loose parts follow the surface" in notes_of(suzanne.deformer)
    assert scenes.close(suzanne.points(), rest)
    expected = Expected.of_rig(suzanne, method)
    scenes.move_world(suzanne.control, BEND)
    followed = suzanne.points()
    assert scenes.close(followed, expected.now(suzanne.obj, suzanne.control), ITERATED)
    assert all(np.linalg.norm(followed[eye] - rest[eye], axis=1).min() > 0.05 for eye in suzanne.eyes)
    suzanne.deformer.loose_parts = "STAY"
    stayed = suzanne.points()
    assert "2 loose parts stay at rest" in notes_of(suzanne.deformer)
    assert scenes.close(stayed[suzanne.head], followed[suzanne.head], 1e-4)
    assert all(scenes.close(stayed[eye], rest[eye]) for eye in suzanne.eyes)
    suzanne.deformer.loose_parts = "FOLLOW"
    assert scenes.close(suzanne.points(), followed)
    suzanne.control.matrix_basis = Matrix.Identity(4)
    assert scenes.close(suzanne.points(), rest)
    suzanne.deformer.method = ON_HANDLE_POINTS[0]  # which moves all parts anyway
    scenes.update()
    assert not any("loose" in line for line in notes_of(suzanne.deformer))


def test_a_region_on_an_eye_takes_it_out_and_a_support_does_not_hold_the_other(
    suzanne: Suzanne, tmp_path: Path
):
    """What lies outside a support is fixed, but not the parts that it does not touch at all."""
    left, right = suzanne.eyes
    suzanne.add("Support", -0.5)
    suzanne.add_members("Eye", left)
    suzanne.bind(fixed=False)
    scenes.press(suzanne.obj, "handle_add", kind="SUPPORT", vertex_group="Support")
    scenes.press(suzanne.obj, "handle_add", kind="FIXED", vertex_group="Eye")
    scenes.move_world(suzanne.control, BEND)
    rest, shape = suzanne.rest(), suzanne.points()
    assert "1 loose part follows the surface" in notes_of(suzanne.deformer)
    assert scenes.close(shape[left], rest[left])
    assert np.abs(shape[right] - rest[right]).max() > 0.05
    scenes.push("follow")
    suzanne.deformer.loose_parts = "STAY"
    stayed = suzanne.points()
    assert scenes.close(stayed[right], rest[right])
    scenes.push("stay")
    for step, expected in ((bpy.ops.ed.undo, shape), (bpy.ops.ed.redo, stayed)):
        step()
        assert scenes.close(suzanne.points(), expected)
    scenes.reopen(tmp_path / "stay.blend")
    assert scenes.close(suzanne.points(), stayed)


def test_what_an_armature_below_poses_rides_too(suzanne: Suzanne):
    armature = scenes.add_armature(suzanne.obj)
    suzanne.bind()
    suzanne.deformer.handles[0].stands_on = "WORLD"  # as its pose is read there
    expected = Expected.of_rig(suzanne)
    armature.pose.bones["high"].rotation_euler.x = 0.5
    incoming = suzanne.points()
    assert not scenes.close(incoming, suzanne.rest(), 0.01)
    suzanne.obj.modifiers[1].show_viewport = False
    assert scenes.close(suzanne.points(), incoming, 1e-5)  # a control at rest leaves what enters as it is
    suzanne.obj.modifiers[1].show_viewport = True
    scenes.move_world(suzanne.control, BEND)
    shape = expected.now(suzanne.obj, suzanne.control, incoming)
    assert scenes.close(suzanne.points(), shape, 1e-5)


def test_grab_once_takes_along_what_lies_on_the_moved_surface_but_parts_that_are_hidden(suzanne: Suzanne):
    """A part that is hidden in part stays as a whole."""
    hidden, eye = suzanne.eyes
    scenes.make_active(suzanne.obj)
    bpy.ops.object.mode_set(mode="EDIT")
    edit = bmesh.from_edit_mesh(suzanne.obj.data)
    edit.verts.ensure_lookup_table()
    for index, vertex in enumerate(edit.verts):
        vertex.select_set(index in suzanne.head[:50])
    edit.select_flush_mode()
    edit.verts[hidden[0]].hide_set(True)
    bmesh.update_edit_mesh(suzanne.obj.data)
    before = edited(suzanne.obj)
    grab(mode="TRANSLATE", value=(0.0, 0.0, 0.1), unlimited=True)
    after = edited(suzanne.obj)
    assert np.array_equal(after[hidden], before[hidden])
    assert scenes.close(after[eye], before[eye] + np.float32((0.0, 0.0, 0.1)), 1e-6)
    bpy.ops.object.mode_set(mode="OBJECT")


def add_button(edit: bmesh.types.BMesh) -> None:
    """A ball before her brow."""
    bmesh.ops.create_icosphere(edit, subdivisions=2, radius=0.1, matrix=Matrix.Translation((0.0, -1.1, 0.5)))


def offered(rig: scenes.Rig) -> list[int]:
    """The vertices that the button would keep inside."""
    keep, lines = inner.status.Remedy.KEEP_INSIDE, inner.status.notes(rig.deformer.uid)
    return [index for line in lines if line.remedy is keep for index in line.elements.indices]


@pytest.mark.parametrize("way", ["FIXED", "ARMATURE", "BONE"])
def test_parts_inside_may_stay_with_a_bone(suzanne: Suzanne, way: str):
    """They are named at the first bind; the button keeps them, and what lies outside goes on to follow."""
    scenes.change_in_edit_mode(suzanne.obj, add_button)
    obj, rest, inside = suzanne.obj, suzanne.rest(), np.concatenate(suzanne.eyes)
    armature = None if way == "FIXED" else scenes.add_armature(obj)
    if way == "BONE":
        obj.modifiers.clear()
    suzanne.bind()
    assert set(offered(suzanne)) == set(inside.tolist())
    if way == "BONE":
        scenes.in_pose_mode(armature, "low", obj)
    assert bpy.ops.sinew.keep_inside() == {"FINISHED"}
    assert not offered(suzanne)
    assert bpy.ops.sinew.keep_inside() == {"CANCELLED"}
    incoming = rest
    if armature is not None:
        bone = armature.pose.bones["low"]
        bone.rotation_euler.x = 0.5
        scenes.update()
        incoming = scenes.apply_matrix(
            armature.matrix_world @ bone.matrix @ bone.bone.matrix_local.inverted(), rest
        )
    scenes.move_world(suzanne.control, BEND)
    shape = suzanne.points()
    assert scenes.close(shape[inside], incoming[inside], 1e-5)
    assert np.linalg.norm(shape[507:] - rest[507:], axis=1).min() > 0.05


@pytest.mark.parametrize("levels", COUNTS)
def test_eyes_in_open_sockets_lie_inside_however_finely_they_are_divided(levels: int):
    assert len(offered(Suzanne(levels).bind())) == 2 * COUNTS[levels]
