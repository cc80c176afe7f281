# SPDX-License-Identifier: GPL-3.0-or-later
"""Edit, Sculpt, Weight Paint Mode on the target; its topology and its weights changed there."""

from collections.abc import Callable

import bmesh
import bpy
import numpy as np
import pytest
from events import ALL, MESHES, REBIND, REGIONS, Event, Table, every, is_bound_again, is_over, lives_on
from inside import catch_up, inner, settle
from rigs import rig as scenes
from rigs.kinds import HandleRig

EDITS = Table()
EVENTS = Table()


def enter(rig: scenes.Rig, mode: str) -> None:
    scenes.make_active(rig.obj)
    bpy.ops.object.mode_set(mode=mode)


def leave() -> None:
    """Back to Object Mode, and the pause after it in which a window's timer works."""
    bpy.ops.object.mode_set(mode="OBJECT")
    settle()


# --- in every mode

MODES = [("handles", mode) for mode in ("EDIT", "SCULPT", "WEIGHT_PAINT", "VERTEX_PAINT", "TEXTURE_PAINT")]
MODES += [("cage", "EDIT"), ("cage", "SCULPT"), ("curve in a cage", "EDIT")]


@pytest.mark.parametrize(("rig", "mode"), MODES, ids=" ".join, indirect=["rig"])
def test_in_every_mode_controls_move_frames_change_and_files_are_saved(posed: HandleRig, mode: str):
    """During the mode where Blender evaluates modifiers in it, and afterwards."""
    enter(posed, mode)
    assert posed.obj.mode == mode
    posed.lift(0.25)
    assert mode == "EDIT" or posed.is_right()
    catch_up()
    leave()
    assert posed.is_right()
    assert posed.deformer.status_level == "INFO"
    scenes.key_heights(posed.control, {1: 0.0, 11: 1.0})
    enter(posed, mode)
    for frame in (11, 1, 11):
        bpy.context.scene.frame_set(frame)
    leave()
    assert posed.shows(posed.at(1.0))
    enter(posed, mode)
    scenes.reopen(posed.folder / "rig.blend")
    if posed.obj.mode != "OBJECT":
        scenes.make_active(posed.obj)
        leave()
    assert posed.shows(posed.at(1.0))
    posed.control.animation_data_clear()
    posed.lift(-0.25)
    assert posed.shows(posed.at(0.75))


# --- other vertices, other faces


@EDITS.on(ALL)
def subdivided(rig: HandleRig) -> None:
    rig.change_topology()


@EDITS.on(MESHES)
def reversed_in_order(rig: HandleRig) -> None:
    scenes.on_all(rig.obj, bpy.ops.mesh.sort_elements, type="REVERSE", elements={"VERT"})


@EDITS.on(REGIONS)
def triangulated(rig: HandleRig) -> None:
    """The same vertices, other faces. A ball has triangles already."""
    scenes.on_all(rig.obj, bpy.ops.mesh.quads_convert_to_tris)


@pytest.mark.parametrize("automatic", [False, True])
@pytest.mark.parametrize("rig", MESHES, indirect=True)
def test_saving_right_after_a_topology_edit_stores_no_wrong_shape(posed: HandleRig, automatic: bool):
    """No timer had time to look: Blender in the background never has one."""
    posed.deformer.auto_rebind = automatic
    reversed_in_order(posed)
    scenes.reopen(posed.folder / "rig.blend")
    posed.poses.rebind(posed.obj)
    assert posed.is_right() if automatic else posed.is_at_rest()


@EVENTS.on(ALL)
def its_topology_changed_and_changed_back(rig: HandleRig) -> None:
    """By undo of the edit, Blender's own way back; no rebind is needed."""
    count = len(rig.rest())
    scenes.push("posed")
    rig.change_topology()
    settle()
    scenes.push("changed")
    assert rig.deformer.status == REBIND
    for _ in range(5):  # steps in Edit Mode
        if len(rig.rest()) != count or rig.obj.mode != "OBJECT":
            bpy.ops.ed.undo()
    catch_up()


# --- Edit and Sculpt Mode


def turn_faces(obj: bpy.types.Object, where: Callable[[np.ndarray], bool]) -> None:

    def flip(edit: bmesh.types.BMesh) -> None:
        for face in edit.faces:
            face.select_set(bool(where(face.calc_center_median())))
        bmesh.update_edit_mesh(obj.data)
        assert bpy.ops.mesh.flip_normals() == {"FINISHED"}

    scenes.change_in_edit_mode(obj, flip)


@EVENTS.on([kind for kind in ALL if kind != "curve in a cage"], then=is_bound_again)
def its_faces_turned(rig: HandleRig) -> None:
    """Some of them, all, and in the file: they are the same faces. Rebind takes them as they are then."""
    for where in (lambda point: point.x > 0.1, lambda _point: True):
        turn_faces(rig.obj, where)
        settle()
        lives_on(rig)
    scenes.reopen(rig.folder / "turned.blend")
    lives_on(rig)


def test_turned_faces_keep_the_pose_while_weights_are_painted_and_through_a_bind(plate: scenes.Rig):
    """This method makes a cage of the faces."""
    for vertex in plate.obj.data.vertices:
        vertex.co.z = 0.3 * np.sin(3.0 * vertex.co.x)
    plate.bind("subspace_laplacian")
    plate.lift(0.5)
    before = plate.points()
    turn_faces(plate.obj, lambda _point: True)
    settle()
    assert scenes.close(plate.points(), before)
    for weight in (0.5, 1.0):
        plate.obj.vertex_groups["Base"].add(plate.base.tolist(), weight, "REPLACE")
        plate.obj.data.update_tag()
        settle()
        assert scenes.close(plate.points(), before) == (weight == 1.0)
    scenes.press(plate.obj, "bind")
    assert scenes.close(plate.points(), before, 1e-4)


@EVENTS.on(["cage", "curve in a cage"])
def the_faces_of_its_control_turned(rig: HandleRig) -> None:
    for where in (lambda point: point.z > 0.1, lambda _point: True):
        turn_faces(rig.control, where)
        settle()
        lives_on(rig)


@EVENTS.on(ALL)
def taken_for_another_topology_in_an_older_file(rig: HandleRig) -> None:
    """As files were saved after faces were turned, before these counted as the same ones."""
    rig.deformer.topology_changed = True
    scenes.reopen(rig.folder / "turned.blend")


@EVENTS.on(MESHES, then=is_bound_again)
def its_vertices_moved_in_edit_or_sculpt_mode(rig: HandleRig) -> None:
    """On top of the pose: the rest shape stays that of the bind until the next, what enters is followed.

    A stroke needs a window; it ends as this edit does, in the mesh.
    """
    rest = rig.rest()
    some = range(len(rest) // 2, len(rest) // 2 + 4)

    def raise_some(edit: bmesh.types.BMesh) -> None:
        for vertex in some:
            edit.verts[vertex].co.z += 0.1

    scenes.change_in_edit_mode(rig.obj, raise_some)
    settle()
    for sculpted in (False, True):
        if sculpted:
            enter(rig, "SCULPT")
            for vertex in some:
                rig.obj.data.vertices[vertex].co.z += 0.1
            rig.obj.data.update()
            scenes.update()
            leave()
        bump = rig.rest() - rest
        assert np.abs(bump).max() > (0.19 if sculpted else 0.09)
        assert rig.shows(rig.at(rig.height) + bump)
        assert sculpted or rig.deformer.status_level == "INFO", rig.deformer.status
        rig.lift(0.25)
        assert rig.shows(rig.at(rig.height) + bump)


@EVENTS.on(MESHES)
def edited_beside_its_copy(rig: HandleRig) -> None:
    copy = scenes.duplicated(rig.obj, rig.control)
    catch_up()
    scenes.make_active(rig.obj, copy)
    bpy.ops.object.mode_set(mode="EDIT")
    assert rig.obj.mode == copy.mode == "EDIT"
    rig.lift(0.25)
    leave()
    assert rig.shows(rig.at(0.5), copy)


@EVENTS.on(MESHES)
def sculpted_with_deforming_modifiers_only(rig: HandleRig) -> None:
    """Blender then leaves modifiers of nodes out: the pose comes back with Object Mode."""
    enter(rig, "SCULPT")
    bpy.context.scene.tool_settings.sculpt.use_deform_only = True
    rig.obj.update_tag()
    scenes.update()
    rig.lift(0.25)
    catch_up()
    leave()


@EVENTS.on(MESHES)
def sculpted_with_dynamic_topology(rig: HandleRig) -> None:
    """Blender switches modifiers off; what comes back is another mesh, or the old one."""
    enter(rig, "SCULPT")
    if "FINISHED" not in bpy.ops.sculpt.dynamic_topology_toggle():
        pytest.skip("this Blender asks before it starts dynamic topology")
    scenes.update()
    rig.lift(0.25)
    catch_up()
    bpy.ops.sculpt.dynamic_topology_toggle()
    leave()
    if rig.is_at_rest():  # its vertices are in another order
        assert rig.deformer.status == REBIND
        rig.press("bind")
        rig.poses.rebind(rig.obj)


@EVENTS.on(REGIONS, then=is_over)
def given_levels_of_multires_above(rig: HandleRig) -> None:
    rig.obj.modifiers.new("Multires", "MULTIRES")
    assert rig.is_right()
    enter(rig, "SCULPT")
    rig.lift(0.0)
    leave()
    assert rig.is_right()


def test_multires_below(plate: scenes.Rig):
    scenes.make_active(plate.obj)
    plate.obj.modifiers.new("Multires", "MULTIRES")
    bpy.ops.object.multires_subdivide(modifier="Multires", mode="SIMPLE")
    points = plate.bind().points()
    plate.lift(0.5)
    lifted = plate.points()
    assert len(lifted) > len(plate.rest())
    far = points[:, 1] > 0.85
    assert scenes.close(lifted[far], points[far] + (0.0, 0.0, 0.5), 1e-5)
    enter(plate, "SCULPT")
    plate.lift(0.0)
    leave()
    assert scenes.close(plate.points(), lifted)


# --- weights, painted in Object or in Weight Paint Mode


def paint(rig: scenes.Rig, group: str, weight: float, chosen: list[int] | None = None) -> None:
    """As one stroke; all vertices of the group where none are named."""
    chosen = chosen or scenes.members(rig.obj, group).tolist()
    rig.obj.vertex_groups[group].add(chosen, weight, "REPLACE")
    rig.obj.data.update()
    rig.obj.data.update_tag()
    settle()


@EVENTS.on(REGIONS, then=is_over)
def its_weights_changed_by_operators(rig: HandleRig) -> None:
    rig.obj.vertex_groups.active = rig.obj.vertex_groups["Top"]
    enter(rig, "WEIGHT_PAINT")
    hard = rig.points()
    for operator, keywords in (
        (bpy.ops.object.vertex_group_levels, {"gain": 0.3}),
        (bpy.ops.object.vertex_group_invert, {}),
        (bpy.ops.object.vertex_group_invert, {}),
        (bpy.ops.object.vertex_group_smooth, {"factor": 0.5, "repeat": 2}),
    ):
        operator(group_select_mode="ACTIVE", **keywords)
        settle()
        if rig.deformer.status_level == "INFO":
            rig.poses.rebind(rig.obj)
            assert rig.is_right()
        else:
            assert "share 22 vertices" in rig.deformer.status
            assert rig.is_at_rest()
    assert np.abs(rig.points() - hard).max() > 1e-3
    leave()


@EVENTS.on(REGIONS)
def its_region_painted_wider_and_emptied(rig: HandleRig) -> None:
    """But a group of no region binds nothing."""
    for mode in ("OBJECT", "WEIGHT_PAINT"):
        enter(rig, mode)
        paint(rig, "Top", 1.0, [60, 61])
        rig.poses.rebind(rig.obj)
        assert rig.points()[[60, 61], 2] == pytest.approx(0.5, abs=1e-6)
        assert rig.is_right()
        rig.obj.vertex_groups["Top"].remove(list(range(121)))
        rig.obj.data.update()
        settle()
        assert rig.is_at_rest()
        assert "1 still, bound in" in rig.deformer.status
        paint(rig, "Top", 1.0, rig.top.tolist())
        rig.poses.rebind(rig.obj)
        assert rig.is_right()
    leave()
    bound = inner.sessions.find(rig.deformer.uid).bound
    rig.obj.vertex_groups.new(name="Other")
    paint(rig, "Other", 1.0, [0, 1])
    assert inner.sessions.find(rig.deformer.uid).bound is bound


def test_weights_painted_on_a_mesh_that_an_armature_poses_keep_the_rest_shape(plate: scenes.Rig):
    armature = scenes.add_armature(plate.obj)
    plate.bind("thin_shell")
    armature.pose.bones["high"].location = (0.0, 0.0, 0.4)
    scenes.update()
    rest, key = plate.deformer.rest, inner.ids.Keys.REST_TOKEN
    token, held = rest[key], [vertex.co[:] for vertex in rest.vertices]
    paint(plate, "Top", 0.5)
    assert rest[key] != token
    assert [vertex.co[:] for vertex in rest.vertices] == held


@pytest.mark.parametrize("change", ["weights", "topology", "renders"])
def test_what_a_pause_renews_keeps_its_datablocks(plate: scenes.Rig, change: str):
    """Undo leaves an object alone where its steps agree, also one that a pause has changed since."""
    modifier = scenes.subdivided(plate.obj) if change == "renders" else None
    plate.bind("thin_shell").lift()
    plate.deformer.auto_rebind = True
    scenes.push("bound")

    def datablocks() -> list[int]:
        row = plate.deformer
        shapes = [row.proxy, row.proxy_render]
        kept = [*shapes, *(shape.data for shape in shapes), row.rest, row.rest_render]
        return [datablock.as_pointer() for datablock in kept]

    def size() -> int:
        return len(plate.deformer.rest_in("RENDER").vertices)

    before, count = datablocks(), size()
    if change == "weights":
        plate.obj.vertex_groups["Top"].add(plate.top.tolist(), 0.3, "REPLACE")
    elif change == "topology":
        subdivide = bmesh.ops.subdivide_edges
        scenes.change_in_edit_mode(plate.obj, lambda edit: subdivide(edit, edges=edit.edges, cuts=1))
    else:
        modifier.render_levels = 2
    plate.obj.data.update_tag()
    bpy.ops.ed.undo_push(message="changed")
    settle()
    assert (size() > count) == (change != "weights")
    assert datablocks() == before
    shown = plate.points()
    bpy.ops.ed.undo()
    settle()
    assert size() == count
    bpy.ops.ed.redo()
    settle()
    assert scenes.close(plate.points(), shown, 1e-6)


# --- each of them


@every(EVENTS)
def test_a_rig_lives_through(posed: HandleRig, event: Event):
    event.run(posed)


@pytest.mark.parametrize("automatic", [False, True])
@every(EDITS)
def test_other_vertices_are_noticed(posed: HandleRig, event: Event, automatic: bool):
    event.edit(posed, automatic)
