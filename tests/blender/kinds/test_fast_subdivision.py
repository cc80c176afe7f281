# SPDX-License-Identifier: GPL-3.0-or-later
"""Fast Subdivision shows in viewports what the Subdivision modifier makes of the deformed mesh."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from inside import catch_up, inner, notes_of
from mathutils import Matrix
from rigs import rig as scenes
from rigs.sheet import draw
from test_subdivision import LIMIT, TOLERANCE, crease, fin, prism, sheet, subdivide

WAYS = {
    "limit": LIMIT,
    "corners": {**LIMIT, "boundary_smooth": "PRESERVE_CORNERS"},
    "refined": {"use_limit_surface": False},
    "corners refined": {"use_limit_surface": False, "boundary_smooth": "PRESERVE_CORNERS"},
    "no creases": {"use_limit_surface": False, "use_creases": False},
    "simple": {"subdivision_type": "SIMPLE"},
}


def of_mesh(obj: bpy.types.Object) -> dict[str, np.ndarray]:
    """What Blender shows of a mesh: points, normals, UVs, weights and materials."""
    scenes.update()
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    uvs = mesh.uv_layers[0].data if mesh.uv_layers else ()
    shown = {
        "points": np.array([vertex.co for vertex in mesh.vertices]),
        "normals": np.array([vertex.normal for vertex in mesh.vertices]),
        "corners": np.array([list(face.vertices) for face in mesh.polygons]),
        "materials": np.array([face.material_index for face in mesh.polygons]),
        "uvs": np.array([uv.uv for uv in uvs]),
        "weights": np.array([sum(group.weight for group in vertex.groups) for vertex in mesh.vertices]),
    }
    obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh_clear()
    return shown


def assert_as_blender(obj: bpy.types.Object, tolerance: float = TOLERANCE) -> None:
    """What is shown is what the modifier shows without Fast Subdivision; at one vertex to this tolerance."""
    own, (by, ours) = of_mesh(obj), (obj.modifiers["Subdivision"], obj.modifiers["Fast Subdivision"])
    assert (by.show_viewport, by.show_render, ours.show_render) == (False, True, False)
    by.show_viewport, ours.show_viewport = True, False
    blenders = of_mesh(obj)
    by.show_viewport, ours.show_viewport = False, True
    size = np.linalg.norm(np.ptp(own["points"], axis=0))
    np.testing.assert_array_equal(own["corners"], blenders["corners"])
    *apart, farthest = np.sort(np.abs(own["points"] - blenders["points"]).max(axis=1))
    assert max(apart) < TOLERANCE * size
    assert farthest < tolerance * size
    assert np.abs(own["normals"] - blenders["normals"]).max() < 1e-4  # rounded corners of short edges
    for name in ("materials", "uvs", "weights"):
        assert np.array_equal(own[name], blenders[name])


def tokens() -> list[str]:
    """What tells refined meshes apart from those that are made anew, and their places."""
    name = "sinew_refined_token"
    return sorted(mesh[name] for mesh in bpy.data.meshes if name in mesh)


def plate(levels: int = 2, **settings: object) -> scenes.Rig:
    """A bent plate, refined by Sinew."""
    rig = scenes.Rig.plate(6).bind()
    subdivide(rig.obj, levels=levels, render_levels=3, **settings)
    rig.lift()
    scenes.press(rig.obj, "fast_subdivision")
    return rig


def in_a_box(obj: bpy.types.Object) -> bpy.types.Object:
    """The object, and the lattice around it that moves it."""
    scenes.press(obj, "lattice_add")
    return obj.sinew.active.controls[0].object


@pytest.mark.parametrize("level", [1, 3])
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("shape", [prism, sheet, fin])
def test_shapes_are_those_of_the_modifier(shape, way: str, level: int):
    obj = shape()
    crease(obj)
    obj.data.uv_layers.new(name="UV")
    obj.vertex_groups.new(name="Some").add([0, 2, 3], 0.7, "REPLACE")
    lattice = in_a_box(obj)
    subdivide(obj, levels=level, **WAYS[way])
    scenes.press(obj, "fast_subdivision")
    scenes.move_world(lattice, Matrix.Diagonal((1.0, 0.6, 1.4, 1.0)) @ scenes.some_motion())
    # The end of an endless crease, as in test_subdivision.
    is_off = shape is prism and WAYS[way].get("use_limit_surface", False)
    assert_as_blender(obj, TOLERANCE * (10.0 if is_off else 1.0))


def test_an_affine_motion_of_the_control_mesh_is_one_of_the_surface():
    obj = sheet()
    lattice = in_a_box(obj)
    subdivide(obj, levels=2, **LIMIT)
    scenes.press(obj, "fast_subdivision")
    before = of_mesh(obj)["points"]
    motion = scenes.some_motion() @ Matrix.Diagonal((1.3, 0.7, 1.2, 1.0))
    scenes.move_world(lattice, motion)
    expected = before @ np.array(motion)[:3, :3].T + np.array(motion)[:3, 3]
    assert np.abs(of_mesh(obj)["points"] - expected).max() < 1e-6 * np.linalg.norm(np.ptp(expected, axis=0))


def test_the_surface_follows_keyed_bones_settings_and_edits():
    """Bones before Sinew, frames, levels, other faces, and a file that is opened again."""
    rig = plate()
    armature = scenes.add_armature(rig.obj)
    bpy.ops.object.modifier_move_to_index(modifier="Armature", index=0)
    scenes.press(rig.obj, "bind")
    catch_up()
    bone = armature.pose.bones["high"]
    for frame, turn in ((1, 0.0), (11, 1.0)):
        bone.rotation_euler.x = turn
        bone.keyframe_insert("rotation_euler", frame=frame)
    seen = []
    for frame in (1, 6, 11):
        bpy.context.scene.frame_set(frame)
        assert_as_blender(rig.obj)
        seen.append(of_mesh(rig.obj)["points"])
    assert np.abs(seen[2] - seen[0]).max() > 0.3
    rig.obj.modifiers["Subdivision"].levels = 3
    assert_as_blender(rig.obj)
    scenes.change_in_edit_mode(rig.obj, lambda edit: edit.faces.remove(edit.faces[14]))
    scenes.press(rig.obj, "bind")
    catch_up()
    assert_as_blender(rig.obj)


def test_a_file_and_a_copy_and_an_undo_show_it_too(tmp_path):
    rig, made = plate(), tokens()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "refined.blend"))
    assert tokens() == made  # nothing was edited
    copy = scenes.duplicated(rig.obj)
    scenes.update()
    rig.lift(0.4)
    assert_as_blender(rig.obj)
    assert_as_blender(copy)
    bpy.ops.ed.undo_push(message="before")
    rig.lift(0.5)
    bpy.ops.ed.undo_push(message="after")
    bpy.ops.ed.undo()
    assert_as_blender(rig.obj)
    scenes.reopen(tmp_path / "refined.blend")
    rig.lift(0.3)
    assert_as_blender(rig.obj)


def test_what_it_cannot_follow_is_told_and_it_ends():
    rig = plate()
    rig.deformer.mask_group = "Top"
    scenes.update()
    assert "Fast Subdivision shows the control mesh: a mask" in " ".join(notes_of(rig.deformer))
    assert [line.remedy for line in inner.status.notes(rig.deformer.uid) if line.text.startswith("Fast")] == [
        inner.status.Remedy.STOP_REFINING
    ]
    assert len(of_mesh(rig.obj)["points"]) == len(rig.rest())
    rig.deformer.mask_group = ""
    scenes.update()
    assert "Fast Subdivision" not in " ".join(notes_of(rig.deformer))
    assert_as_blender(rig.obj)
    scenes.press(rig.obj, "unbind")
    assert_as_blender(rig.obj)
    scenes.press(rig.obj, "deformer_remove")  # ends it, as Stop does
    assert list(rig.obj.modifiers.keys()) == ["Subdivision"]
    assert rig.obj.modifiers["Subdivision"].show_viewport
    assert not [mesh for mesh in bpy.data.meshes if mesh.name.startswith(".Sinew Subdivision")]


def test_loose_edges_and_what_stands_between_are_refused():
    wire = scenes.new_object("Wire", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (2, 2, 1)], [(0, 1, 2)], [(2, 3)])
    in_a_box(wire)
    scenes.refused("in another way", "fast_subdivision", wire)
    assert [modifier.name for modifier in wire.modifiers] == ["Sinew"]
    rig = scenes.Rig.plate(4).bind()
    rig.obj.modifiers.new("Solidify", "SOLIDIFY")
    scenes.subdivided(rig.obj, 2)
    scenes.refused("Solidify stands between", "fast_subdivision", rig.obj)
    bpy.ops.object.modifier_move_to_index(modifier="Subdivision", index=0)
    scenes.refused("Subdivision stands before Sinew", "fast_subdivision", rig.obj)


def test_it_is_made_anew_for_another_simplify_or_look_and_not_for_points():
    rig, scene = plate(subdivision_type="SIMPLE"), bpy.context.scene
    other, scene.render.simplify_subdivision = scene.copy(), 1
    for simplified, shown, frame in ((1, scene, 0), (1, other, 0), (1, scene, 2), (0, scene, 3)):
        scene.render.use_simplify, bpy.context.window.scene = simplified, shown
        shown.frame_set(frame) if frame else scenes.update()
        rig.lift(0.1 * frame)
        assert_as_blender(rig.obj)
    for is_other, made in ((False, tokens()), (True, tokens())):
        rig.obj.data.vertices[3].co.z = 0.1
        rig.obj.data.polygons[3].use_smooth = is_other
        scenes.change_in_edit_mode(rig.obj, lambda edit: None)
        catch_up()
        assert (tokens() != made) == is_other
        assert_as_blender(rig.obj)


def test_it_ends_and_begins_whatever_was_moved_or_deleted():
    rig, tooltip = plate(), bpy.types.SINEW_OT_fast_subdivision.description
    stack, move = rig.obj.modifiers, bpy.ops.object.modifier_move_to_index
    by, cast = stack["Subdivision"], stack.new("Cast", "CAST")
    move(modifier="Cast", index=1)
    scenes.update()
    assert "Fast Subdivision shows the control mesh" in " ".join(notes_of(rig.deformer))
    for index, was_on in ((0, True), (1, False)):
        move(modifier="Subdivision", index=index)
        scenes.press(rig.obj, "fast_subdivision", stop=True)
        assert [by.show_viewport, *notes_of(rig.deformer)] == [was_on]
        cast.show_viewport, by.show_viewport = False, not was_on
        move(modifier="Subdivision", index=2)
        scenes.press(rig.obj, "fast_subdivision")
    stack.remove(stack["Fast Subdivision"])
    scenes.update()
    assert (catch_up(), by.show_viewport) == (False, True)
    scenes.press(rig.obj, "fast_subdivision")
    stack.remove(by)
    assert len({tooltip(bpy.context, type("", (), {"stop": stop})) for stop in (True, False)}) == 2
    for stop in (True, False, True):
        assert "sinew.fast_subdivision" in draw(bpy.types.SINEW_PT_order).operator_names()
        scenes.press(rig.obj, "fast_subdivision", stop=stop)  # begins with a new one
    stack.remove(stack["Sinew"])
    scenes.refused("Rebind", "fast_subdivision", rig.obj)
