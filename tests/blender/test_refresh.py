# SPDX-License-Identifier: GPL-3.0-or-later
"""After an edit of the mesh: painted weights take effect, lost and new vertices are noticed."""

import bmesh
import bpy
import numpy as np
import pytest
from inside import settle
from rig import Rig, add_armature, make_active, update


def edit_faces(obj: bpy.types.Object, change) -> None:
    """A change of the mesh in Edit Mode, as a user makes it."""
    make_active(obj)
    bpy.ops.object.mode_set(mode="EDIT")
    edit = bmesh.from_edit_mesh(obj.data)
    for part in (edit.verts, edit.edges, edit.faces):
        part.ensure_lookup_table()
    change(edit)
    bmesh.update_edit_mesh(obj.data)
    bpy.ops.object.mode_set(mode="OBJECT")


def as_made_anew(rig: Rig, method: str = "thin_shell") -> np.ndarray:
    """What a deformer made now, with these weights and this pose, shows."""
    copy = rig.obj.copy()
    copy.data = rig.obj.data.copy()
    bpy.context.scene.collection.objects.link(copy)
    copy.sinew.deformers.clear()
    for modifier in [modifier for modifier in copy.modifiers if modifier.type == "NODES"]:
        copy.modifiers.remove(modifier)
    other = object.__new__(Rig)
    other.name = copy.name
    other.bind(method)
    other.control.matrix_basis = rig.control.matrix_basis
    return other.points()


@pytest.mark.parametrize("mode", ["OBJECT", "WEIGHT_PAINT"])
def test_painted_weights_take_effect_without_a_rebind(plate: Rig, mode: str):
    plate.bind("thin_shell")
    plate.lift()
    before = plate.points()
    make_active(plate.obj)
    bpy.ops.object.mode_set(mode=mode)
    plate.obj.vertex_groups["Top"].add(plate.top.tolist(), 0.3, "REPLACE")
    plate.obj.data.update_tag()
    settle()
    after = plate.points()
    bpy.ops.object.mode_set(mode="OBJECT")
    assert np.abs(after - before)[plate.top].max() > 1e-3
    np.testing.assert_allclose(after, as_made_anew(plate), atol=1e-6)


def held(deformer) -> list[int]:
    """Which datablocks a deformer points to."""
    return [
        datablock.as_pointer()
        for shape in (deformer.proxy, deformer.proxy_render)
        for datablock in (shape, shape.data)
    ] + [deformer.rest.as_pointer(), deformer.rest_render.as_pointer()]


@pytest.mark.parametrize("change", ["weights", "topology", "renders"])
def test_what_a_pause_renews_keeps_its_datablocks(plate: Rig, change: str):
    """Undo leaves an object alone where its steps agree, also one that a pause has changed since."""
    if change == "renders":
        modifier = plate.obj.modifiers.new("Subdivision", "SUBSURF")
        modifier.levels = modifier.render_levels = 1
    plate.bind("thin_shell")
    plate.lift()
    plate.deformer.auto_rebind = True
    bpy.ops.ed.undo_push(message="bound")
    before, size = held(plate.deformer), len(plate.deformer.rest_in("RENDER").vertices)
    if change == "weights":
        plate.obj.vertex_groups["Top"].add(plate.top.tolist(), 0.3, "REPLACE")
        plate.obj.data.update_tag()
        bpy.ops.ed.undo_push(message="painted")
    elif change == "topology":
        edit_faces(plate.obj, lambda edit: bmesh.ops.subdivide_edges(edit, edges=edit.edges, cuts=1))
        bpy.ops.ed.undo_push(message="subdivided")
    else:
        modifier.render_levels = 2
        plate.obj.data.update_tag()
        bpy.ops.ed.undo_push(message="finer")
    settle()
    after = len(plate.deformer.rest_in("RENDER").vertices)
    assert after == size if change == "weights" else after > size
    assert held(plate.deformer) == before
    shown = plate.points()
    bpy.ops.ed.undo()
    settle()
    assert len(plate.deformer.rest_in("RENDER").vertices) == size
    bpy.ops.ed.redo()
    settle()
    np.testing.assert_allclose(plate.points(), shown, atol=1e-6)


def test_vertices_assigned_in_edit_mode_join_their_region(plate: Rig):
    plate.bind("thin_shell")
    plate.lift()
    make_active(plate.obj)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.object.mode_set(mode="OBJECT")
    middle = [index for index, point in enumerate(plate.rest()) if abs(point[1]) < 0.05]
    plate.obj.vertex_groups["Top"].add(middle, 1.0, "REPLACE")
    plate.obj.data.update_tag()
    settle()
    np.testing.assert_allclose(plate.points()[middle, 2], 1.0, atol=1e-6)


def test_painting_a_group_of_no_region_binds_nothing(plate: Rig, room):
    plate.bind("thin_shell")
    plate.obj.vertex_groups.new(name="Other")
    settle()
    session = room("session").find(plate.deformer.uid)
    bound = session.bound
    plate.obj.vertex_groups["Other"].add([0, 1], 1.0, "REPLACE")
    plate.obj.data.update_tag()
    settle()
    assert session.bound is bound


def test_weights_painted_on_a_posed_mesh_keep_the_rest_shape(plate: Rig, room):
    armature = add_armature(plate.obj)
    plate.bind("thin_shell")
    armature.pose.bones["high"].location = (0.0, 0.0, 0.4)
    update()
    rest = plate.deformer.rest
    token = rest[room("ids").Keys.REST_TOKEN]
    held = np.array([vertex.co for vertex in rest.vertices])
    plate.obj.vertex_groups["Top"].add(plate.top.tolist(), 0.5, "REPLACE")
    plate.obj.data.update_tag()
    settle()
    assert rest[room("ids").Keys.REST_TOKEN] != token
    np.testing.assert_array_equal(np.array([vertex.co for vertex in rest.vertices]), held)


def test_renamed_vertex_groups_stay_regions_masks_and_paint(plate: Rig):
    plate.bind("thin_shell")
    plate.deformer.mask_group = "Top"
    plate.deformer.parameters.bending_group = "Base"
    plate.lift()
    before = plate.points()
    for name in ("Top", "Base"):
        plate.obj.vertex_groups[name].name = f"{name} renamed"
    settle()
    plate.control.location.x += 0.0
    plate.obj.update_tag()
    np.testing.assert_allclose(plate.points(), before, atol=1e-6)
    assert plate.deformer.handles[0].vertex_group == "Top renamed"
    assert plate.deformer.mask_group == "Top renamed"
    assert plate.deformer.parameters.bending_group == "Base renamed"
    make_active(plate.obj)
    bpy.ops.sinew.bind()
    np.testing.assert_allclose(plate.points(), before, atol=1e-6)
