# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of a mesh that no region touches: they ride on the surface they lie on or in, or they stay."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import bmesh
import bpy
import numpy as np
import pytest
from editing import edited, grab
from inside import inner
from mathutils import Matrix
from registry import ON_HANDLE_POINTS, ON_SURFACE
from rigs.rig import (
    Rig,
    add_armature,
    add_group,
    add_regions,
    apply_matrix,
    base_points,
    close,
    evaluated_points,
    in_pose_mode,
    make_active,
    move_world,
    new_file,
    new_object,
    press,
    push,
    reopen,
    update,
)

HEAD, EYES = 463, 44  # vertices of Suzanne: the head comes first, then two eyes
BEND = Matrix.Rotation(math.radians(40.0), 4, "Y") @ Matrix.Translation((0.3, 0.0, 0.4))


def parts_of(obj: bpy.types.Object) -> list[np.ndarray]:
    """The vertices of each connected part, the largest first."""
    label = np.arange(len(obj.data.vertices))
    for _ in range(len(label)):
        before = label.copy()
        for edge in obj.data.edges:
            a, b = edge.vertices
            label[a] = label[b] = min(label[a], label[b])
        if np.array_equal(label, before):
            break
    found = [np.flatnonzero(label == first) for first in np.unique(label)]
    return sorted(found, key=len, reverse=True)


def rigid_motion(before: np.ndarray, after: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """The rotation and translation that fit best, and what is left of them (Kabsch 1976)."""
    a, b = before.mean(axis=0), after.mean(axis=0)
    u, _, v = np.linalg.svd((before - a).T @ (after - b))
    turn = (u @ np.diag((1.0, 1.0, np.sign(np.linalg.det(u @ v)))) @ v).T
    left = np.abs((before - a) @ turn.T + b - after).max()
    return turn, b - turn @ a, left


class Suzanne(Rig):
    """Her ears move, her chin stays, nothing holds her eyes."""

    def __init__(self) -> None:
        bpy.ops.mesh.primitive_monkey_add()
        obj = bpy.context.object
        self.name = obj.name
        self.head, *self.eyes = parts_of(obj)
        inside = np.isin(np.arange(len(obj.data.vertices)), self.head)
        for name, where in (("Top", lambda p: p[2] > 0.6), ("Base", lambda p: p[2] < -0.6)):
            members = [i for i, point in enumerate(base_points(obj)) if inside[i] and where(point)]
            obj.vertex_groups.new(name=name).add(members, 1.0, "REPLACE")

    def eyes_ride(self, shape: np.ndarray, before: np.ndarray) -> bool:
        """Each eye is rigid, and moves as the surface around it does, to 2 % of the head."""
        for eye in self.eyes:
            turn, shift, left = rigid_motion(before[eye], shape[eye])
            away = np.linalg.norm(before[self.head] - before[eye].mean(axis=0), axis=1)
            near = self.head[np.argsort(away)[:40]]
            expected = rigid_motion(before[near], shape[near])
            centre = before[eye].mean(axis=0)
            missed = turn @ centre + shift - (expected[0] @ centre + expected[1])
            if left > 1e-5 or np.linalg.norm(missed) > 0.04:
                return False
        return True


@pytest.fixture
def suzanne() -> Suzanne:
    new_file()
    return Suzanne()


def notes(plate: Rig) -> list[str]:
    return [line.text for line in inner.status.notes(plate.deformer.uid)]


@pytest.mark.parametrize("method", ON_SURFACE)
def test_eyes_follow_the_head(suzanne: Suzanne, method: str):
    rest = suzanne.rest()
    suzanne.bind(method)
    assert "2 loose parts follow the surface" in notes(suzanne)
    assert close(suzanne.points(), rest)
    move_world(suzanne.control, BEND)
    shape = suzanne.points()
    assert suzanne.eyes_ride(shape, rest)
    assert np.abs(shape[suzanne.eyes[0]] - rest[suzanne.eyes[0]]).max() > 0.1
    suzanne.control.matrix_basis = Matrix.Identity(4)
    assert close(suzanne.points(), rest)


@pytest.mark.parametrize("method", ON_SURFACE)
def test_with_stay_they_stay(suzanne: Suzanne, method: str):
    rest = suzanne.rest()
    suzanne.bind(method)
    move_world(suzanne.control, BEND)
    followed = suzanne.points()
    suzanne.deformer.loose_parts = "STAY"
    stayed = suzanne.points()
    assert "2 loose parts stay at rest" in notes(suzanne)
    assert close(stayed[suzanne.head], followed[suzanne.head], 1e-4)
    assert all(close(stayed[eye], rest[eye]) for eye in suzanne.eyes)
    suzanne.deformer.loose_parts = "FOLLOW"
    assert close(suzanne.points(), followed)


def test_a_region_on_an_eye_takes_it_out(suzanne: Suzanne):
    suzanne.bind()
    left, right = suzanne.eyes
    suzanne.obj.vertex_groups.new(name="Eye").add(left.tolist(), 1.0, "REPLACE")
    press(suzanne.obj, "handle_add", kind="FIXED", vertex_group="Eye")
    move_world(suzanne.control, BEND)
    rest, shape = suzanne.rest(), suzanne.points()
    assert "1 loose part follows the surface" in notes(suzanne)
    assert close(shape[left], rest[left])
    assert np.abs(shape[right] - rest[right]).max() > 0.1


def test_the_border_of_a_support_does_not_hold_them(suzanne: Suzanne):
    """What lies outside a support is fixed, but not the parts that it does not touch at all."""
    muzzle = [i for i in suzanne.head if suzanne.rest()[i, 2] > -0.5]
    suzanne.obj.vertex_groups.new(name="Support").add([int(i) for i in muzzle], 1.0, "REPLACE")
    suzanne.bind(fixed=False)
    press(suzanne.obj, "handle_add", kind="SUPPORT", vertex_group="Support")
    rest = suzanne.rest()
    move_world(suzanne.control, BEND)
    shape = suzanne.points()
    assert suzanne.eyes_ride(shape, rest)
    suzanne.deformer.loose_parts = "STAY"
    shape = suzanne.points()
    assert all(close(shape[eye], rest[eye]) for eye in suzanne.eyes)


def test_what_an_armature_below_poses_rides_too(suzanne: Suzanne):
    add_armature(suzanne.obj)
    rest = suzanne.rest()
    suzanne.bind()
    armature = bpy.data.objects["Rig"]
    armature.pose.bones["high"].rotation_euler.x = 0.5
    incoming = suzanne.points()
    assert not close(incoming, rest, 0.01)
    suzanne.obj.modifiers[1].show_viewport = False
    assert close(suzanne.points(), incoming, 1e-5)  # a control at rest leaves what enters as it is
    suzanne.obj.modifiers[1].show_viewport = True
    move_world(suzanne.control, BEND)
    assert suzanne.eyes_ride(suzanne.points(), incoming)


def test_they_ride_after_save_and_load_in_renders_and_through_undo(suzanne: Suzanne, tmp_path: Path):
    suzanne.bind()
    move_world(suzanne.control, BEND)
    push("posed")
    shape = suzanne.points()
    suzanne.deformer.loose_parts = "STAY"
    stayed = suzanne.points()
    push("stay")
    bpy.ops.ed.undo()
    assert suzanne.deformer.loose_parts == "FOLLOW"
    assert close(suzanne.points(), shape)
    bpy.ops.ed.redo()
    assert close(suzanne.points(), stayed)
    reopen(tmp_path / "stay.blend")
    assert suzanne.deformer.loose_parts == "STAY"
    assert close(suzanne.points(), stayed)


def test_letters_follow_the_letter_that_a_handle_moves():
    new_file()
    bpy.ops.object.text_add()
    text = bpy.context.object
    text.data.body = "oxo"
    text.data.extrude = 0.1
    bpy.ops.object.convert(target="MESH")
    obj = bpy.context.object
    plate = Rig.called(obj.name)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.remove_doubles(threshold=1e-5)
    bpy.ops.object.mode_set(mode="OBJECT")
    rest = plate.rest()
    first = min(parts_of(obj), key=lambda letter: rest[letter, 0].mean())
    obj.vertex_groups.new(name="Top").add(first.tolist(), 1.0, "REPLACE")
    plate.bind(fixed=False)
    move_world(plate.control, BEND)
    assert close(plate.points(), apply_matrix(BEND, rest), 1e-5)


def test_a_space_method_moves_all_parts_anyway(suzanne: Suzanne):
    if not ON_HANDLE_POINTS:
        pytest.skip("no method of this kind yet")
    suzanne.bind(ON_HANDLE_POINTS[0])
    assert not any("loose" in line for line in notes(suzanne))


def test_a_mesh_that_only_has_loose_parts_left_shows_them_where_they_enter(suzanne: Suzanne):
    """Handles on a part without faces give no surface to ride on."""
    obj = suzanne.obj
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.primitive_circle_add(vertices=8, radius=0.2, location=(3.0, 0.0, 0.0))
    bpy.ops.object.mode_set(mode="OBJECT")
    ring = add_group(obj, "Ring", lambda point: point[0] > 2.5)
    add_regions(obj, "thin_shell", {"Ring": "HANDLE"})
    rest = base_points(obj)
    move_world(obj.sinew.active.handles[0].control, Matrix.Translation((0.0, 0.0, 1.0)))
    shape = evaluated_points(obj)
    others = np.setdiff1d(np.arange(len(rest)), ring)
    assert close(shape[ring], rest[ring] + (0.0, 0.0, 1.0))
    assert close(shape[others], rest[others])


def test_grab_region_takes_along_what_lies_on_the_moved_surface(suzanne: Suzanne):
    """The brows lift by a tenth; whoever is near them follows, and far from them everything stays."""
    left = max(suzanne.eyes, key=lambda eye: suzanne.rest()[eye, 0].mean())
    right = min(suzanne.eyes, key=lambda eye: suzanne.rest()[eye, 0].mean())
    socket = suzanne.rest()[left].mean(axis=0)
    members = set(suzanne.head.tolist())
    near = [i for i in members if np.linalg.norm(suzanne.rest()[i] - socket) < 0.45]
    chosen = np.zeros(len(suzanne.rest()), dtype=bool)
    chosen[near] = True
    before = edited_selection(suzanne.obj, chosen)
    grab(mode="TRANSLATE", value=(0.0, 0.0, 0.1), radius=0.3)
    after = edited(suzanne.obj)
    _turn, _shift, left_over = rigid_motion(before[left].astype(float), after[left].astype(float))
    assert left_over < 1e-5
    assert (after[left] - before[left])[:, 2].mean() == pytest.approx(0.1, abs=0.02)
    assert np.array_equal(after[right], before[right])
    bpy.ops.object.mode_set(mode="OBJECT")


def test_grab_region_leaves_parts_that_are_hidden_in_part(suzanne: Suzanne):
    chosen = np.isin(np.arange(len(suzanne.rest())), suzanne.head[:50])
    before = edited_selection(suzanne.obj, chosen, hidden=int(suzanne.eyes[0][0]))
    grab(mode="TRANSLATE", value=(0.0, 0.0, 0.1), unlimited=True)
    after = edited(suzanne.obj)
    assert np.array_equal(after[suzanne.eyes[0]], before[suzanne.eyes[0]])
    assert np.allclose(after[suzanne.eyes[1]], before[suzanne.eyes[1]] + (0.0, 0.0, 0.1), atol=1e-6)
    bpy.ops.object.mode_set(mode="OBJECT")


def edited_selection(obj: bpy.types.Object, chosen: np.ndarray, hidden: int = -1) -> np.ndarray:
    """Enter Edit Mode with these vertices selected, and one hidden; what it shows (n, 3)."""
    make_active(obj)
    bpy.ops.object.mode_set(mode="EDIT")
    edit = bmesh.from_edit_mesh(obj.data)
    for vertex in edit.verts:
        vertex.select_set(bool(chosen[vertex.index]))
    edit.select_flush_mode()
    if hidden >= 0:
        edit.verts.ensure_lookup_table()
        edit.verts[hidden].hide_set(True)
    bmesh.update_edit_mesh(obj.data)
    return edited(obj)


def joined(name: str, *shapes: tuple[np.ndarray, list]) -> bpy.types.Object:
    """One mesh of several parts; each has a vertex group of its number."""
    starts = np.cumsum([0, *(len(points) for points, _faces in shapes)])
    faces = [
        [int(start) + v for v in face]
        for start, (_, own) in zip(starts, shapes, strict=False)
        for face in own
    ]
    obj = new_object(name, np.concatenate([points for points, _faces in shapes]).tolist(), faces)
    for number, (first, last) in enumerate(itertools.pairwise(starts)):
        obj.vertex_groups.new(name=str(number)).add(range(int(first), int(last)), 1.0, "REPLACE")
    return obj


def grid(cells: int, size: float, height: float) -> tuple[np.ndarray, list]:
    along = np.linspace(-0.5 * size, 0.5 * size, cells + 1)
    points = np.array([(x, y, height) for y in along for x in along])
    rows = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    corners = np.stack((rows[:-1, :-1], rows[:-1, 1:], rows[1:, 1:], rows[1:, :-1]), -1).reshape(-1, 4)
    return points, corners.tolist()


def sphere(radius: float, place: tuple, rings: int = 16) -> tuple[np.ndarray, list]:
    """A ball of triangles that is its own mirror image in x."""
    made = bmesh.new()
    bmesh.ops.create_uvsphere(made, u_segments=2 * rings, v_segments=rings, radius=radius)
    bmesh.ops.poke(made, faces=made.faces)  # as diagonals have no mirror image
    points = np.array([tuple(v.co) for v in made.verts]) + place
    faces = [[v.index for v in face.verts] for face in made.faces]
    made.free()
    return points, faces


@pytest.mark.parametrize("height", [0.01, 0.03])
@pytest.mark.parametrize("method", ["arap", "thin_shell"])
def test_a_sheet_on_another_follows_a_bump_that_is_smaller_than_its_frames(method: str, height: float):
    """What lies above goes as far as what is beneath, and none of it is poked through."""
    obj = joined("Sheets", grid(40, 2.0, 0.0), grid(40, 2.0, height))
    rest = base_points(obj)
    below, above = np.array_split(np.arange(len(rest)), 2)
    away = np.linalg.norm(rest[below, :2], axis=1)
    obj.vertex_groups.new(name="Top").add(below[away < 0.15].tolist(), 1.0, "REPLACE")
    obj.vertex_groups.new(name="Base").add(below[away > 0.7].tolist(), 1.0, "REPLACE")
    add_regions(obj, method, {"Top": "HANDLE", "Base": "FIXED"})
    move_world(obj.sinew.active.handles[0].control, Matrix.Translation((0.0, 0.0, 0.2)))
    moved = evaluated_points(obj) - rest
    assert moved[above, 2].max() > 0.98 * 0.2
    assert (evaluated_points(obj)[above, 2] > evaluated_points(obj)[below, 2]).all()


def tongue() -> tuple[np.ndarray, list]:
    points, faces = sphere(0.05, (0.0, 0.0, 0.0))
    return points * (1.0, 10.0, 1.0) - (0.0, 0.3, 0.0), faces


def teeth() -> tuple[np.ndarray, list]:
    """A row of balls that touch, across the plane x = 0, as one part for each."""
    balls = [sphere(0.06, (x, -0.5 + x * x, 0.0), 8) for x in (-0.22, -0.11, 0.0, 0.11, 0.22)]
    count = len(balls[0][0])
    faces = [[count * k + v for v in face] for k, (_, own) in enumerate(balls) for face in own]
    return np.concatenate([points for points, _faces in balls]), faces


ON_THE_PLANE = {
    "ball": lambda: sphere(0.15, (0.0, -0.4, 0.0), 8),
    "tongue": tongue,
    "teeth": teeth,
}


@pytest.mark.parametrize("part", ON_THE_PLANE)
def test_a_part_on_the_mirror_plane_stays_on_it(part: str):
    """What lies in a large ball whose cheeks are pulled alike: one frame, several, and parts that touch."""
    large = sphere(1.0, (0.0, 0.0, 0.0))
    obj = joined("Head", large, ON_THE_PLANE[part]())
    rest = base_points(obj)
    head, inside = np.split(np.arange(len(rest)), [len(large[0])])
    groups = {
        "L": lambda p: np.linalg.norm(p - (0.8, -0.6, 0.0), axis=1) < 0.3,
        "R": lambda p: np.linalg.norm(p - (-0.8, -0.6, 0.0), axis=1) < 0.3,
        "Base": lambda p: p[:, 1] > 0.7,
    }
    for name, where in groups.items():
        obj.vertex_groups.new(name=name).add(head[where(rest[head])].tolist(), 1.0, "REPLACE")
    add_regions(obj, "thin_shell", {"L": "HANDLE", "R": "HANDLE", "Base": "FIXED"})
    for handle, side in zip(obj.sinew.active.handles, (1.0, -1.0), strict=False):
        move_world(handle.control, Matrix.Translation((0.3 * side, -0.4, 0.1)))
    shape = evaluated_points(obj)
    assert np.linalg.norm((shape - rest)[inside].mean(axis=0)) > 0.02
    # Each vertex goes to the mirror image of where its own image goes; those of the plane stay on it.
    mirror, lopsided = np.array((-1.0, 1.0, 1.0)), {}
    for name, own in (("head", head), (part, inside)):
        away = np.linalg.norm(rest[own, None] * mirror - rest[None, own], axis=2)
        assert away.min(axis=1).max() < 1e-5
        lopsided[name] = np.abs(shape[own] * mirror - shape[own][away.argmin(axis=1)]).max()
    print(f"lopsided by {lopsided}")
    assert lopsided[part] < 4e-6


def head_with_teeth() -> Rig:
    """A ball with an eye and a row of teeth in it, and a button on it; its front moves, its back is fixed."""
    large, inside = sphere(1.0, (0.0, 0.0, 0.0)), (sphere(0.2, (0.3, -0.6, 0.3), 8), teeth())
    obj = joined("Head", large, *inside, sphere(0.06, (0.0, -1.06, 0.0), 8))
    for name, where in (("Top", lambda p: p[1] < -0.8), ("Base", lambda p: p[1] > 0.6)):
        members = [i for i, point in enumerate(base_points(obj)[: len(large[0])]) if where(point)]
        obj.vertex_groups.new(name=name).add(members, 1.0, "REPLACE")
    return Rig.called(obj.name)


@pytest.mark.parametrize("way", ["FIXED", "ARMATURE", "BONE"])
def test_parts_inside_may_stay_with_a_bone(way: str):
    """They are named at the first bind; the button keeps them, and what lies outside goes on to follow."""
    new_file()
    plate = head_with_teeth()
    obj, rest = plate.obj, plate.rest()
    inside = np.flatnonzero([any(group.group in (1, 2) for group in v.groups) for v in obj.data.vertices])
    button = np.flatnonzero([any(group.group == 3 for group in v.groups) for v in obj.data.vertices])
    if way != "FIXED":
        add_armature(obj)
        modifier = next(row for row in obj.modifiers if row.type == "ARMATURE")
        if way == "BONE":
            obj.modifiers.remove(modifier)
    plate.bind()
    status = inner.status
    (line,) = (row for row in status.notes(plate.deformer.uid) if row.remedy)
    assert line.remedy is status.Remedy.KEEP_INSIDE
    assert set(line.elements.indices) == set(inside.tolist())
    armature = bpy.data.objects.get("Rig")
    if way == "BONE":
        in_pose_mode(armature, "low", obj)
    assert bpy.ops.sinew.keep_inside() == {"FINISHED"}
    assert not any(row.remedy for row in status.notes(plate.deformer.uid))
    assert bpy.ops.sinew.keep_inside() == {"CANCELLED"}
    incoming = rest
    if armature is not None:
        bone = armature.pose.bones["low"]
        bone.rotation_mode, bone.rotation_euler.x = "XYZ", 0.5
        update()
        incoming = apply_matrix(armature.matrix_world @ bone.matrix @ bone.bone.matrix_local.inverted(), rest)
    move_world(plate.control, BEND)
    shape = plate.points()
    assert close(shape[inside], incoming[inside], 1e-5)
    assert np.linalg.norm(shape[button] - rest[button], axis=1).min() > 0.05


@pytest.mark.parametrize("levels", [0, 1, 2])
def test_eyes_in_open_sockets_lie_inside_however_finely_they_are_divided(levels: int):
    """Those of Blender's own head."""
    new_file()
    bpy.ops.mesh.primitive_monkey_add(size=2.0)
    obj = bpy.context.object
    if levels:
        obj.modifiers.new("Subdivision", "SUBSURF").levels = levels
        bpy.ops.object.modifier_apply(modifier="Subdivision")
    for name, where in (("Ears", lambda p: abs(p[0]) > 1.0), ("Chin", lambda p: p[2] < -0.7)):
        add_group(obj, name, where)
        bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group=name)
        make_active(obj)
    lines = inner.status.notes(obj.sinew.active.uid)
    (line,) = (row for row in lines if row.remedy is inner.status.Remedy.KEEP_INSIDE)
    assert len(line.elements.indices) == 2 * {0: 33, 1: 129, 2: 497}[levels]
