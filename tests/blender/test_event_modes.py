# SPDX-License-Identifier: GPL-3.0-or-later
"""Edit, Sculpt, Weight Paint Mode on the target; topology changed in Edit Mode, with and without rebind."""

from collections.abc import Callable

import bmesh
import bpy
import numpy as np
import pytest
from expected import Expected
from inside import catch_up, settle
from rig import Rig, close, make_active, update
from rigs import RIGS, HandleRig


def enter(plate: Rig, mode: str) -> None:
    make_active(plate.obj)
    bpy.ops.object.mode_set(mode=mode)


def leave() -> None:
    """Back to Object Mode, and the pause after it in which a window's timer works."""
    bpy.ops.object.mode_set(mode="OBJECT")
    settle()


MODES = [("handles", mode) for mode in ("EDIT", "SCULPT", "WEIGHT_PAINT", "VERTEX_PAINT", "TEXTURE_PAINT")]
MODES += [("cage", "EDIT"), ("cage", "SCULPT"), ("curve in a cage", "EDIT")]


@pytest.fixture(params=MODES, ids=" ".join)
def rig_and_mode(request: pytest.FixtureRequest) -> tuple[HandleRig, str]:
    """A rig, and a mode that its target may be in."""
    kind, mode = request.param
    return RIGS[kind].new(), mode


def test_controls_move_the_target_in_every_mode(rig_and_mode: tuple[HandleRig, str]):
    """During the mode where Blender evaluates modifiers in it, and afterwards."""
    rig, mode = rig_and_mode
    expected = rig.start()
    rig.lift(0.5)
    enter(rig, mode)
    assert rig.obj.mode == mode
    rig.lift(0.25)
    if mode != "EDIT":
        assert rig.shows(expected.lifted(0.75))
    catch_up()
    leave()
    assert rig.shows(expected.lifted(0.75))
    assert rig.deformer.status_level == "INFO"
    enter(rig, mode)
    leave()
    assert rig.shows(expected.lifted(0.75))


def test_frames_change_in_every_mode(rig_and_mode: tuple[HandleRig, str]):
    rig, mode = rig_and_mode
    expected = rig.start()
    for frame, height in ((1, 0.0), (11, 1.0)):
        rig.control.location.z = height
        rig.control.keyframe_insert("location", frame=frame)
    enter(rig, mode)
    for frame in (11, 1, 11):
        bpy.context.scene.frame_set(frame)
    leave()
    assert rig.shows(expected.lifted(1.0))


def test_saved_in_a_mode_and_opened(rig_and_mode: tuple[HandleRig, str], tmp_path):
    rig, mode = rig_and_mode
    expected = rig.start()
    rig.lift(0.5)
    enter(rig, mode)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "rig.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "rig.blend"))
    if rig.obj.mode != "OBJECT":
        make_active(rig.obj)
        leave()
    assert rig.shows(expected.lifted(0.5))
    rig.lift(0.25)
    assert rig.shows(expected.lifted(0.75))


# --- Edit Mode


def edit_vertices(plate: Rig, change: Callable[[bmesh.types.BMVert], None]) -> None:
    edit = bmesh.from_edit_mesh(plate.obj.data)
    for vertex in edit.verts:
        change(vertex)
    bmesh.update_edit_mesh(plate.obj.data)


def test_vertices_moved_in_edit_mode_move_on_top_of_the_pose(posed_plate: tuple[Rig, Expected]):
    """The rest shape stays that of the bind; what enters is followed."""
    plate, expected = posed_plate
    bump = np.zeros_like(plate.rest())
    bump[60:64, 2] = 0.1

    def raise_some(vertex: bmesh.types.BMVert) -> None:
        vertex.co.z += bump[vertex.index, 2]

    enter(plate, "EDIT")
    edit_vertices(plate, raise_some)
    leave()
    incoming = plate.rest()
    assert np.abs(incoming[60:64, 2] - 0.1).max() < 1e-6
    shape = expected.lifted(0.5) + bump
    assert close(plate.points(), shape)
    plate.lift(0.25)
    assert close(plate.points(), expected.lifted(0.75) + bump)
    make_active(plate.obj)
    bpy.ops.sinew.bind()
    expected.rebind(plate.obj)
    assert close(plate.points(), expected.lifted(0.75))


def subdivide(_plate: Rig) -> None:
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()


def extrude(plate: Rig) -> None:
    """The far edge grows; new vertices inherit the groups."""
    edit = bmesh.from_edit_mesh(plate.obj.data)
    for vertex in edit.verts:
        vertex.select = vertex.co.y > 0.95
    edit.select_flush_mode()
    bmesh.update_edit_mesh(plate.obj.data)
    bpy.ops.mesh.extrude_region_move(TRANSFORM_OT_translate={"value": (0.0, 0.2, 0.0)})


def cut_a_hole(plate: Rig) -> None:
    edit = bmesh.from_edit_mesh(plate.obj.data)
    for vertex in edit.verts:
        vertex.select = abs(vertex.co.x) < 0.1 and abs(vertex.co.y) < 0.5
    edit.select_flush_mode()
    bmesh.update_edit_mesh(plate.obj.data)
    bpy.ops.mesh.delete(type="VERT")


def reverse(_plate: Rig) -> None:
    """The same number of vertices, all in another order."""
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.sort_elements(type="REVERSE", elements={"VERT"})


def triangulate(_plate: Rig) -> None:
    """The same vertices, other faces."""
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.quads_convert_to_tris()


def add_a_part(_plate: Rig) -> None:
    bpy.ops.mesh.primitive_cube_add(size=0.2, location=(0.0, 0.0, 2.0))


def delete_and_add_as_many(plate: Rig) -> None:
    edit = bmesh.from_edit_mesh(plate.obj.data)
    edit.verts.ensure_lookup_table()
    bmesh.ops.delete(edit, geom=[edit.verts[60]], context="VERTS")
    edit.verts.new((0.0, 0.0, 1.0))
    bmesh.update_edit_mesh(plate.obj.data)


EDITS = (subdivide, extrude, cut_a_hole, reverse, triangulate, add_a_part, delete_and_add_as_many)


@pytest.mark.parametrize("change", EDITS, ids=lambda change: change.__name__)
def test_topology_changed_in_edit_mode_and_rebound(posed_plate: tuple[Rig, Expected], change):
    plate, expected = posed_plate
    enter(plate, "EDIT")
    change(plate)
    leave()
    assert close(plate.points(), plate.rest())
    assert plate.deformer.status == "Topology changed - Rebind"
    make_active(plate.obj)
    bpy.ops.sinew.bind()
    expected.rebind(plate.obj)
    assert close(plate.points(), expected.lifted(0.5))
    plate.lift(0.25)
    assert close(plate.points(), expected.lifted(0.75))
    assert plate.deformer.status_level == "INFO"


@pytest.mark.parametrize("change", EDITS, ids=lambda change: change.__name__)
def test_topology_changed_in_edit_mode_and_rebound_by_itself(posed_plate: tuple[Rig, Expected], change):
    plate, expected = posed_plate
    plate.deformer.auto_rebind = True
    enter(plate, "EDIT")
    change(plate)
    leave()
    expected.rebind(plate.obj)
    assert close(plate.points(), expected.lifted(0.5))
    assert plate.deformer.status_level == "INFO"
    plate.lift(0.25)
    assert close(plate.points(), expected.lifted(0.75))


@pytest.mark.parametrize("automatic", [False, True])
def test_saving_right_after_a_topology_edit_stores_no_wrong_shape(
    posed_plate: tuple[Rig, Expected], tmp_path, automatic: bool
):
    """No timer had time to look: Blender in the background never has one."""
    plate, expected = posed_plate
    plate.deformer.auto_rebind = automatic
    enter(plate, "EDIT")
    reverse(plate)
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "rig.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "rig.blend"))
    expected.rebind(plate.obj)
    assert close(plate.points(), expected.lifted(0.5) if automatic else plate.rest())


def test_topology_changed_and_changed_back(posed_plate: tuple[Rig, Expected]):
    """By undo of the edit, Blender's own way back; no rebind is needed."""
    plate, expected = posed_plate
    update()
    bpy.ops.ed.undo_push(message="posed")
    enter(plate, "EDIT")
    bpy.ops.ed.undo_push(message="Edit Mode")
    subdivide(plate)
    bpy.ops.ed.undo_push(message="subdivided")
    leave()
    bpy.ops.ed.undo_push(message="Object Mode")
    assert plate.deformer.status == "Topology changed - Rebind"
    for _ in range(3):
        bpy.ops.ed.undo()
    assert plate.obj.mode == "OBJECT"
    catch_up()
    assert close(plate.points(), expected.lifted(0.5))
    assert plate.deformer.status_level == "INFO"


def test_edit_mode_of_two_targets_at_once(posed_plate: tuple[Rig, Expected]):
    plate, expected = posed_plate
    make_active(plate.obj)
    plate.control.select_set(True)
    bpy.ops.object.duplicate()
    catch_up()
    other = next(obj for obj in bpy.data.objects if obj.sinew.deformers and obj != plate.obj)
    make_active(plate.obj)
    other.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    assert plate.obj.mode == other.mode == "EDIT"
    plate.lift(0.25)
    leave()
    assert close(plate.points(), expected.lifted(0.75))
    twin = Rig.__new__(Rig)
    twin.name = other.name
    assert close(twin.points(), expected.lifted(0.5))


# --- Sculpt Mode


def test_sculpt_mode_with_deforming_modifiers_only(posed_plate: tuple[Rig, Expected]):
    """Blender then leaves modifiers of nodes out: the pose comes back with Object Mode."""
    plate, expected = posed_plate
    enter(plate, "SCULPT")
    bpy.context.scene.tool_settings.sculpt.use_deform_only = True
    plate.obj.update_tag()
    update()
    plate.lift(0.25)
    catch_up()
    leave()
    assert close(plate.points(), expected.lifted(0.75))
    assert plate.deformer.status_level == "INFO"


def test_dynamic_topology(posed_plate: tuple[Rig, Expected]):
    """Blender switches modifiers off; what comes back is another mesh, or the old one."""
    plate, expected = posed_plate
    enter(plate, "SCULPT")
    if "FINISHED" not in bpy.ops.sculpt.dynamic_topology_toggle():
        pytest.skip("this Blender asks before it starts dynamic topology")
    update()
    plate.lift(0.25)
    catch_up()
    bpy.ops.sculpt.dynamic_topology_toggle()
    leave()
    if close(plate.points(), plate.rest()):  # its vertices are in another order
        assert plate.deformer.status == "Topology changed - Rebind"
        make_active(plate.obj)
        bpy.ops.sinew.bind()
        expected.rebind(plate.obj)
    assert close(plate.points(), expected.lifted(0.75))


def test_sculpted_vertices_move_on_top_of_the_pose(posed_plate: tuple[Rig, Expected]):
    """A stroke needs a window; it ends as this edit does, in the mesh."""
    plate, expected = posed_plate
    enter(plate, "SCULPT")
    bump = np.zeros_like(plate.rest())
    bump[60:64, 2] = 0.1
    flat = (plate.rest() + bump).astype(np.float32).ravel()
    plate.obj.data.vertices.foreach_set("co", flat)
    plate.obj.data.update()
    update()
    leave()
    assert close(plate.points(), expected.lifted(0.5) + bump)


@pytest.mark.parametrize("below", [False, True])
def test_multires(plate: Rig, below: bool):
    """Levels above the deformer smooth its result; below, the deformer works on the fine mesh."""
    obj = plate.obj
    make_active(obj)
    if below:
        obj.modifiers.new("Multires", "MULTIRES")
        bpy.ops.object.multires_subdivide(modifier="Multires", mode="SIMPLE")
        plate.bind()
        points, groups = plate.points(), len(plate.rest())
        plate.lift(0.5)
        lifted = plate.points()
        assert len(lifted) > groups
        far = points[:, 1] > 0.85
        assert np.abs(lifted[far] - points[far] - (0.0, 0.0, 0.5)).max() < 1e-5
    else:
        plate.bind()
        expected = Expected.of_rig(plate)
        obj.modifiers.new("Multires", "MULTIRES")
        plate.lift(0.5)
        assert close(plate.points(), expected.lifted(0.5))
    before = plate.points()
    enter(plate, "SCULPT")
    plate.lift(0.0)
    leave()
    assert close(plate.points(), before)


# --- Weight Paint Mode


def paint(plate: Rig, group: str, weight: float) -> None:
    """All vertices of the group, as one stroke."""
    members = [
        vertex.index
        for vertex in plate.obj.data.vertices
        for element in vertex.groups
        if element.group == plate.obj.vertex_groups[group].index
    ]
    plate.obj.vertex_groups[group].add(members, weight, "REPLACE")
    plate.obj.data.update()
    update()


def test_painted_weights_are_live(posed_plate: tuple[Rig, Expected]):
    """Each stroke takes effect when it ends; the mode need not be left."""
    plate, expected = posed_plate
    enter(plate, "WEIGHT_PAINT")
    for weight in (0.5, 0.1, 1.0):
        paint(plate, "Top", weight)
        catch_up()
        expected.rebind(plate.obj)
        assert close(plate.points(), expected.lifted(0.5))
    leave()
    assert close(plate.points(), expected.lifted(0.5))


def test_operators_of_weight_paint_are_live(posed_plate: tuple[Rig, Expected]):
    plate, expected = posed_plate
    plate.obj.vertex_groups.active = plate.obj.vertex_groups["Top"]
    enter(plate, "WEIGHT_PAINT")
    hard = plate.points()
    for operate in (
        lambda: bpy.ops.object.vertex_group_levels(group_select_mode="ACTIVE", gain=0.3),
        lambda: bpy.ops.object.vertex_group_invert(group_select_mode="ACTIVE"),
        lambda: bpy.ops.object.vertex_group_invert(group_select_mode="ACTIVE"),
        lambda: bpy.ops.object.vertex_group_smooth(group_select_mode="ACTIVE", factor=0.5, repeat=2),
    ):
        operate()
        update()
        catch_up()
        shown = plate.points()
        if plate.deformer.status_level == "INFO":
            expected.rebind(plate.obj)
            assert close(shown, expected.lifted(0.5))
        else:
            assert "share 22 vertices" in plate.deformer.status
            assert close(shown, plate.rest())
    assert np.abs(plate.points() - hard).max() > 1e-3
    leave()


def test_a_region_painted_wider_or_emptied(posed_plate: tuple[Rig, Expected]):
    plate, expected = posed_plate
    enter(plate, "WEIGHT_PAINT")
    plate.obj.vertex_groups["Top"].add([60], 1.0, "REPLACE")
    plate.obj.data.update()
    update()
    catch_up()
    expected.rebind(plate.obj)
    assert plate.points()[60, 2] == pytest.approx(0.5, abs=1e-6)
    assert close(plate.points(), expected.lifted(0.5))
    plate.obj.vertex_groups["Top"].remove(list(range(121)))
    plate.obj.data.update()
    update()
    catch_up()
    assert close(plate.points(), plate.rest())
    assert "has no vertices" in plate.deformer.status
    plate.obj.vertex_groups["Top"].add([int(index) for index in plate.top], 1.0, "REPLACE")
    plate.obj.data.update()
    update()
    catch_up()
    expected.rebind(plate.obj)
    assert close(plate.points(), expected.lifted(0.5))
