# SPDX-License-Identifier: GPL-3.0-or-later
"""A cage moves the mesh: by object, by its vertices, by shape keys and bones, through save and load."""

from __future__ import annotations

import threading

import bmesh
import bpy
import numpy as np
import pytest
from cages import add_raising_key, ball, new_object
from inside import BINDING
from mathutils import Matrix
from probe import render_points
from rig import (
    FLOAT32,
    add_armature,
    apply_matrix,
    base_points,
    evaluated_points,
    make_active,
    move_world,
    update,
)


def box(name: str = "Cage", size: float = 2.0) -> bpy.types.Object:
    """A cube around it."""
    bpy.ops.mesh.primitive_cube_add(size=size)
    bpy.context.object.name = name
    return bpy.context.object


@pytest.fixture
def caged() -> tuple[str, str]:
    """A ball and its cage, bound by mean value coordinates; their names."""
    target, cage = ball(), box()
    make_active(target)
    assert bpy.ops.sinew.cage_add(source="OBJECT", cage=cage.name, method="mean_value") == {"FINISHED"}
    return target.name, cage.name


def target_and_cage(names: tuple[str, str]) -> list[bpy.types.Object]:
    return [bpy.data.objects[name] for name in names]


def shear() -> Matrix:
    return Matrix(((1.0, 0.4, 0.0, 0.2), (0.0, 1.2, 0.1, 0.0), (0.0, 0.0, 0.8, -0.3), (0.0, 0.0, 0.0, 1.0)))


def test_an_affine_cage_moves_the_mesh_affinely(caged):
    target, cage = target_and_cage(caged)
    cage.data.transform(shear())
    cage.data.update()
    expected = apply_matrix(shear(), base_points(target))
    assert np.abs(evaluated_points(target) - expected).max() < FLOAT32


def test_the_cage_object_moves_too(caged):
    target, cage = target_and_cage(caged)
    target.location, target.rotation_euler.z, target.scale.x = (0.3, 0.0, 0.1), 0.4, 1.5
    update()
    before = evaluated_points(target)
    motion = Matrix.Translation((0.2, 0.5, -0.1)) @ Matrix.Rotation(0.6, 4, (0.0, 0.6, 0.8))
    frame = target.matrix_world.copy()
    move_world(cage, motion)
    expected = apply_matrix(frame.inverted() @ motion @ frame, before)
    assert np.abs(evaluated_points(target) - expected).max() < 2 * FLOAT32


def test_edits_of_the_cage_show_in_edit_mode(caged):
    target, cage = target_and_cage(caged)
    before = evaluated_points(target)
    make_active(cage)
    bpy.ops.object.mode_set(mode="EDIT")
    edit = bmesh.from_edit_mesh(cage.data)
    for vertex in edit.verts:
        if vertex.co.z > 0:
            vertex.co.z += 0.5
    bmesh.update_edit_mesh(cage.data)
    shown = evaluated_points(target)
    expected = before.copy()
    expected[:, 2] = -1.0 + (before[:, 2] + 1.0) * 1.25
    assert np.abs(shown - expected).max() < FLOAT32
    bpy.ops.object.mode_set(mode="OBJECT")
    assert np.abs(evaluated_points(target) - expected).max() < FLOAT32


def test_shape_keys_bones_and_modifiers_of_the_cage_count(caged):
    target, cage = target_and_cage(caged)
    rest = evaluated_points(target)
    key = add_raising_key(cage, 0.5)
    key.value = 1.0
    assert np.abs(evaluated_points(target) - (rest + (0.0, 0.0, 0.5))).max() < FLOAT32
    key.value = 0.0
    armature = add_armature(cage)
    armature.pose.bones["high"].location.x = 0.7
    moved = evaluated_points(target)
    assert moved[:, 0].max() > rest[:, 0].max() + 0.1
    assert moved[moved[:, 1].argmax(), 0] > moved[moved[:, 1].argmin(), 0] + 0.1


def test_a_subdivided_cage_is_a_cage():
    target, cage = ball(), box(size=3.0)
    cage.modifiers.new("Subdivision", "SUBSURF").levels = 1
    make_active(target)
    bpy.ops.sinew.cage_add(source="OBJECT", cage=cage.name)
    assert "cage of 26" in target.sinew.active.status
    cage.data.transform(shear())
    cage.data.update()
    expected = apply_matrix(shear(), base_points(target))
    assert np.abs(evaluated_points(target) - expected).max() < FLOAT32


def test_the_subdivision_of_the_panel_is_the_cages_own_modifier(caged):
    target, cage = target_and_cage(caged)
    deformer = target.sinew.active
    assert deformer.cage_subdivision == 0
    deformer.cage_subdivision = 2
    (smoother,) = cage.modifiers
    assert (smoother.type, smoother.levels, smoother.render_levels) == ("SUBSURF", 2, 2)
    make_active(target)
    assert bpy.ops.sinew.cage_set_rest() == {"FINISHED"}
    assert "cage of 98" in deformer.status
    smoother.levels = 1
    assert deformer.cage_subdivision == 1
    deformer.cage_subdivision = 0
    assert not cage.modifiers
    cage.modifiers.new("Subdivision", "SUBSURF")
    deformer.cage = None
    deformer.cage_subdivision = 3
    assert deformer.cage_subdivision == 0


def test_a_hidden_cage_still_moves_it(caged):
    target, cage = target_and_cage(caged)
    cage.hide_viewport = True
    key = add_raising_key(cage, 0.5)
    key.value = 1.0
    assert evaluated_points(target)[:, 2].mean() == pytest.approx(0.5, abs=1e-4)


def test_a_cage_with_other_vertices_is_refused_and_can_rest_anew(caged):
    target, cage = target_and_cage(caged)
    make_active(cage)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    bpy.ops.object.mode_set(mode="OBJECT")
    assert np.abs(evaluated_points(target) - base_points(target)).max() < FLOAT32
    deformer = target.sinew.active
    assert deformer.status_level == "ERROR"
    assert "26 vertices, at bind it had 8" in deformer.status
    assert bpy.ops.sinew.cage_set_rest() == {"FINISHED"}
    assert deformer.status_level == "INFO", deformer.status
    cage.location.z = 0.4
    assert np.abs(evaluated_points(target) - base_points(target) - (0.0, 0.0, 0.4)).max() < FLOAT32


def test_automatic_rebind_takes_a_cage_with_other_vertices_for_its_rest(room, caged):
    target, cage = target_and_cage(caged)
    target.sinew.active.auto_rebind = True
    make_active(cage)
    cage.modifiers.new("Subdivision", "SUBSURF").levels = 1
    update()
    room("session").refresh()
    update()
    deformer = target.sinew.active
    assert deformer.status_level == "INFO", deformer.status
    assert "cage of 26" in deformer.status
    cage.location.z = 0.4
    assert np.abs(evaluated_points(target) - base_points(target) - (0.0, 0.0, 0.4)).max() < FLOAT32


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda mesh: mesh.faces.remove(mesh.faces[0]), "open"),
        (lambda mesh: bmesh.ops.reverse_faces(mesh, faces=mesh.faces[:]), "inside out"),
        (lambda mesh: mesh.clear(), "vertices"),
    ],
)
def test_a_cage_that_is_none_is_refused(spoil, said):
    target, cage = ball(), box()
    edit = bmesh.new()
    edit.from_mesh(cage.data)
    edit.faces.ensure_lookup_table()
    spoil(edit)
    edit.to_mesh(cage.data)
    edit.free()
    make_active(target)
    bpy.ops.sinew.cage_add(source="OBJECT", cage=cage.name)
    assert target.sinew.active.status_level == "ERROR"
    assert said in target.sinew.active.status
    assert np.array_equal(evaluated_points(target), base_points(target))


def test_faces_of_a_cage_that_cross_are_named_and_can_be_selected(room):
    target, cage = ball(), box()
    bpy.ops.object.select_all(action="DESELECT")
    cage.data.vertices[0].co = (1.5, 0.3, 0.2)  # through the opposite side
    make_active(target)
    assert bpy.ops.sinew.cage_add(source="OBJECT", cage=cage.name) == {"FINISHED"}
    lines = [line for line in room("core.status").notes(target.sinew.active.uid) if line.elements]
    (note,) = (line for line in lines if line.elements.owner.name == "CONTROL")
    assert "faces of the cage cross" in note.text
    assert bpy.ops.sinew.select_problems(line=lines.index(note)) == {"FINISHED"}
    assert bpy.context.object == cage
    bpy.ops.object.mode_set(mode="OBJECT")
    assert note.elements.element == "face"
    assert set(note.elements.indices) <= {polygon.index for polygon in cage.data.polygons if polygon.select}


def test_a_cage_inside_out_can_be_flipped():
    target, cage = ball(), box()
    cage.data.flip_normals()
    make_active(target)
    bpy.ops.sinew.cage_add(source="OBJECT", cage=cage.name)
    assert target.sinew.active.status_level == "ERROR"
    assert bpy.ops.sinew.select_problems() == {"FINISHED"}
    assert bpy.context.object == cage
    assert cage.mode == "EDIT"
    assert all(face.select for face in bmesh.from_edit_mesh(cage.data).faces)
    assert bpy.ops.sinew.cage_flip() == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    assert target.sinew.active.status_level == "INFO", target.sinew.active.status
    cage.location.z = 0.4
    assert np.abs(evaluated_points(target) - base_points(target) - (0.0, 0.0, 0.4)).max() < FLOAT32


def test_one_cage_moves_several_meshes_and_several_cages_one(caged):
    target, cage = target_and_cage(caged)
    second = ball("Second", 2)
    make_active(second)
    bpy.ops.sinew.cage_add(source="OBJECT", cage=cage.name)
    other = box("Other", 4.0)
    make_active(target)
    bpy.ops.sinew.cage_add(source="OBJECT", cage=other.name)
    target.sinew.active.factor = 0.5
    rest, second_rest = base_points(target), base_points(second)
    cage.location.x, other.location.z = 0.4, 1.0
    assert np.abs(evaluated_points(second) - second_rest - (0.4, 0.0, 0.0)).max() < FLOAT32
    assert np.abs(evaluated_points(target) - rest - (0.4, 0.0, 0.5)).max() < FLOAT32


def test_renders_and_frames_show_the_pose(caged):
    """The cage itself is hidden in renders."""
    target, cage = target_and_cage(caged)
    assert cage.hide_render
    rest = base_points(target)
    key = add_raising_key(cage, 1.0)
    for frame, value in ((1, 0.0), (11, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    cage.keyframe_insert("location", frame=1)
    cage.location.x = 1.0
    cage.keyframe_insert("location", frame=11)
    for frame in (11, 1, 6):
        bpy.context.scene.frame_set(frame)
        shown = evaluated_points(target)
        assert np.array_equal(render_points(target), shown)
        share = shown[0] - rest[0]
        assert np.abs(shown - rest - share).max() < FLOAT32
        assert {1: share.max() < FLOAT32, 6: 0.3 < share[0] < 0.7, 11: share[0] > 0.999}[frame]


def test_the_armature_before_it_still_counts(caged):
    target, cage = target_and_cage(caged)
    bpy.ops.sinew.deformer_remove()
    make_active(target)
    armature = add_armature(target)
    bpy.ops.sinew.cage_add(source="OBJECT", cage=cage.name)
    rest = evaluated_points(target)
    armature.pose.bones["high"].location.x = 0.7
    posed = evaluated_points(target)
    cage.location.z = 0.5
    assert np.abs(evaluated_points(target) - posed - (0.0, 0.0, 0.5)).max() < FLOAT32
    assert np.abs(posed - rest).max() > 0.1


def test_points_outside_are_said_or_refused(room, caged):
    target, cage = target_and_cage(caged)
    target.data.vertices[3].co.z = 5.0
    bpy.ops.sinew.bind()
    deformer = target.sinew.active
    (note,) = (line for line in room("core.status").notes(deformer.uid) if line.elements)
    assert note.elements.indices == (3,)
    deformer.method = "harmonic"
    update()
    assert deformer.status_level == "ERROR"
    assert "3 lie outside" in deformer.status
    deformer.harmonic.outside = "mean_value"
    cage.location.z = 0.4
    assert np.abs(evaluated_points(target) - base_points(target) - (0.0, 0.0, 0.4)).max() < FLOAT32


def test_an_automatic_cage_holds_the_mesh_and_moves_it(room):
    target = ball()
    target.location.x = 2.0
    make_active(target)
    assert bpy.ops.sinew.cage_add(faces=80) == {"FINISHED"}
    deformer = target.sinew.active
    cage = deformer.cage
    assert bpy.context.object == cage
    assert len(cage.data.polygons) <= 80
    assert cage.parent == target
    assert deformer.status_level == "INFO", deformer.status
    assert room("core.status").notes(deformer.uid) == ()
    rest = base_points(target)
    assert np.abs(evaluated_points(target) - rest).max() < FLOAT32
    target.location.y = 1.0
    assert np.abs(evaluated_points(target) - rest).max() < FLOAT32
    cage.location.z = 0.5
    assert np.abs(evaluated_points(target) - rest - (0.0, 0.0, 0.5)).max() < FLOAT32
    name = cage.name
    make_active(target)
    bpy.ops.sinew.deformer_remove()
    assert name not in bpy.data.objects


def test_harmonic_errs_a_tenth_of_mesh_deform():
    """In a cube, where both should be trilinear: each corner moved by 1, Mesh Deform at precision 5."""
    corners = np.array([(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    points = np.random.default_rng(0).uniform(0.02, 0.98, (1000, 3))

    cage = new_object("Cage", corners, faces)
    ours, theirs = (new_object(name, points, [(0, 1, 2)]) for name in ("Ours", "Theirs"))
    modifier = theirs.modifiers.new("Mesh Deform", "MESH_DEFORM")
    modifier.object, modifier.precision = cage, 5
    with bpy.context.temp_override(object=theirs, active_object=theirs):
        bpy.ops.object.meshdeform_bind(modifier=modifier.name)
    make_active(ours)
    assert bpy.ops.sinew.cage_add(source="OBJECT", cage="Cage", method="harmonic") == {"FINISHED"}

    exact = np.prod(np.where(corners > 0.5, points[:, None], 1.0 - points[:, None]), axis=2)
    worst = {obj.name: 0.0 for obj in (ours, theirs)}
    for corner, place in enumerate(corners):
        cage.data.vertices[corner].co.z = place[2] + 1.0
        cage.data.update()
        for obj in (ours, theirs):
            found = evaluated_points(obj)[:, 2] - points[:, 2]
            worst[obj.name] = max(worst[obj.name], np.abs(found - exact[:, corner]).max())
        cage.data.vertices[corner].co.z = place[2]
    assert 1e-4 < worst["Theirs"] < 0.1
    assert worst["Ours"] <= 0.1 * worst["Theirs"], worst


@pytest.mark.parametrize("first", ["Sinew", "Subdivision"])
def test_before_and_after_a_subdivision_of_the_mesh(room, caged, first: str):
    """Warped at control level and then subdivided, or subdivided and then warped: as the stack says."""
    target, cage = target_and_cage(caged)
    smoother = target.modifiers.new("Subdivision", "SUBSURF")
    smoother.levels = smoother.render_levels = 1
    if first == "Subdivision":
        make_active(target)
        bpy.ops.object.modifier_move_to_index(modifier="Subdivision", index=0)
        bpy.ops.sinew.bind()
    cage.data.vertices[0].co = (-1.6, -0.7, -1.3)
    cage.data.update()
    found = evaluated_points(target)

    native = room("backend").availability().module
    corners = np.array([tuple(polygon.vertices) for polygon in cage.data.polygons])
    rest = np.array([vertex.co[:] for vertex in target.sinew.active.cage_rest.vertices])
    coordinates = native.MeanValue(native.SurfaceMesh(rest, corners), precision="double")
    if first == "Subdivision":
        target.sinew.active.factor = 0.0
        smooth = evaluated_points(target)
        coordinates.bind(smooth.astype(float))
        expected = coordinates.warp(base_points(cage))
    else:
        coordinates.bind(base_points(target))
        plain = bpy.data.objects.new("Plain", target.data.copy())
        plain.data.vertices.foreach_set("co", coordinates.warp(base_points(cage)).astype(np.float32).ravel())
        bpy.context.scene.collection.objects.link(plain)
        plain.modifiers.new("Subdivision", "SUBSURF").levels = 1
        expected = evaluated_points(plain)
    assert np.abs(found - expected).max() < FLOAT32
    assert len(found) > 500


@pytest.mark.parametrize("sheared", [False, True])
def test_an_automatic_cage_rides_along_and_stays_where_it_is_under_another_parent(sheared: bool):
    target = ball()
    target.location, target.rotation_euler, target.scale = (3.0, -1.0, 0.5), (0.4, 0.2, 1.1), (1.5, 0.7, 1.0)
    if sheared:
        target.parent = bpy.data.objects.new("Above", None)
        target.parent.scale.x = 3.0
        bpy.context.scene.collection.objects.link(target.parent)
    update()
    make_active(target)
    assert bpy.ops.sinew.cage_add(source="AUTO", faces=60) == {"FINISHED"}
    cage = target.sinew.active.cage
    rest = base_points(target)
    target.location.x += 2.0
    update()
    assert np.abs(evaluated_points(target) - rest).max() < 4 * FLOAT32
    if sheared:
        return  # no location, rotation and scale of its own stand for where it is
    target.location.x -= 2.0
    update()
    place = np.array(cage.matrix_world)
    rig = bpy.data.objects.new("Rig", None)
    rig.location = (5.0, 6.0, 7.0)
    bpy.context.scene.collection.objects.link(rig)
    make_active(rig)
    cage.select_set(True)
    assert bpy.ops.object.parent_set(type="OBJECT") == {"FINISHED"}
    update()
    assert cage.parent == rig
    assert np.abs(np.array(cage.matrix_world) - place).max() < 1e-5


def test_rays_are_shown_until_the_exact_weights_are_there(room, caged, monkeypatch: pytest.MonkeyPatch):
    """As in a window, where heavy meshes bind in a thread."""
    target, cage = target_and_cage(caged)
    binding, deformer = room(BINDING), target.sinew.active
    monkeypatch.setattr(binding, "may_wait", lambda _count: True)
    may_begin, build = threading.Event(), binding.build_factor
    monkeypatch.setattr(binding, "build_factor", lambda *found: may_begin.wait(20.0) and build(*found))
    may_begin.set()
    cage.data.vertices[0].co = (-1.6, -0.7, -1.3)
    with room("session").suspended():
        deformer.method = "positive_mean_value"
    session = room("session").find(deformer.uid)
    assert binding.ensure(session, deformer, deformer, wait=False) is None
    shapes = []
    for is_preview in (True, False):
        binding.job(deformer.uid).thread.join(timeout=20.0)
        may_begin.clear()  # so that the exact weights are still under way below
        assert binding.collect() == [deformer.uid]
        assert session.bound.is_preview is is_preview
        target.update_tag(refresh={"OBJECT"})
        if is_preview:  # what came in between stopped the exact weights: they are asked for anew
            assert binding.ensure(session, deformer, deformer, wait=False) is session.bound
            binding.abandon(deformer.uid)
            may_begin.set()
            assert binding.ensure(session, deformer, deformer, wait=False) is None
            binding.job(deformer.uid).thread.join(timeout=20.0)
            assert binding.collect() == [deformer.uid]
        shapes.append(evaluated_points(target) if not is_preview else _shown_by(session, cage, target))
    assert binding.job(deformer.uid) is None
    monkeypatch.undo()
    assert 1e-6 < np.abs(shapes[0] - shapes[1]).max() < 0.1
    bpy.ops.sinew.bind()
    assert np.abs(evaluated_points(target) - shapes[1]).max() < FLOAT32


def _shown_by(session, cage: bpy.types.Object, target: bpy.types.Object) -> np.ndarray:
    """By the factor that is bound; in background an evaluation would wait for the exact one."""
    relative = target.matrix_world.inverted() @ cage.matrix_world
    return session.bound.factor.solve(apply_matrix(relative, base_points(cage)))[0]
