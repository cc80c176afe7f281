# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad cages, and bad meshes in good ones: a status with its elements, no jump, and a way on."""

from __future__ import annotations

import bmesh
import bpy
import numpy as np
import pytest
from cages import ball, new_object
from mathutils import Matrix
from registry import WITH_CAGE
from rig import FLOAT32, apply_matrix, base_points, evaluated_points, make_active, update

NOWHERE = (float("nan"), float("inf"), -float("inf"))
CORNERS = [(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)]
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def box() -> bpy.types.Object:
    return new_object("Cage", CORNERS, SIDES)


def fine_box(cuts: int) -> bpy.types.Object:
    """The same box of (cuts + 1)^2 squares a side."""
    obj, edit = box(), bmesh.new()
    edit.from_mesh(obj.data)
    bmesh.ops.subdivide_edges(edit, edges=edit.edges[:], cuts=cuts, use_grid_fill=True)
    edit.to_mesh(obj.data)
    edit.free()
    return obj


def surround(target: bpy.types.Object, cage: bpy.types.Object, method: str = "mean_value"):
    """The deformer; a refusal is in its status."""
    make_active(target)
    assert bpy.ops.sinew.cage_add(source="OBJECT", cage=cage.name, method=method) == {"FINISHED"}
    return target.sinew.active


def place(cage: bpy.types.Object, points: list) -> None:
    cage.data.vertices.foreach_set("co", np.array(points, dtype=np.float32).ravel())
    cage.data.update()


def assert_at_rest(target: bpy.types.Object) -> None:
    assert np.array_equal(evaluated_points(target), base_points(target))


def assert_goes_on(target: bpy.types.Object, cage: bpy.types.Object) -> None:
    """The bind is well, and the cage moves the mesh."""
    deformer = target.sinew.active
    before = evaluated_points(target)
    assert deformer.status_level == "INFO", deformer.status
    cage.location.z += 0.25
    assert np.abs(evaluated_points(target) - before - (0.0, 0.0, 0.25)).max() < FLOAT32


def selected(target: bpy.types.Object, kind: str) -> tuple[bpy.types.Object, set[int]]:
    """What Select shows: of which object, and the indices of its vertices or faces."""
    make_active(target)
    assert bpy.ops.sinew.select_problems() == {"FINISHED"}
    shown = bpy.context.object
    bpy.ops.object.mode_set(mode="OBJECT")
    elements = shown.data.polygons if kind == "face" else shown.data.vertices
    return shown, {element.index for element in elements if element.select}


@pytest.mark.parametrize("value", NOWHERE)
def test_a_cage_that_is_nowhere_at_bind_is_named_and_can_be_mended(room, value: float) -> None:
    target, cage = ball(), box()
    cage.data.vertices[3].co.x = value
    deformer = surround(target, cage)
    said = room("core.status").current(deformer.uid)
    assert (said.level.name, said.remedy.name) == ("ERROR", "CAGE_REST")
    assert "nowhere" in said.text
    assert_at_rest(target)
    assert selected(target, "vertex") == (cage, {3})
    cage.data.vertices[3].co.x = CORNERS[3][0]
    make_active(target)
    assert bpy.ops.sinew.cage_set_rest() == {"FINISHED"}
    assert_goes_on(target, cage)


@pytest.mark.parametrize("value", NOWHERE)
def test_a_cage_that_is_nowhere_after_bind_leaves_the_rest_and_comes_back(room, value: float) -> None:
    target, cage = ball(), box()
    deformer = surround(target, cage)
    cage.location.z = 0.5
    posed = evaluated_points(target)
    cage.data.vertices[3].co.x = value
    cage.data.update()
    assert_at_rest(target)
    assert deformer.status_level == "ERROR"
    assert "nowhere" in deformer.status
    assert room("core.status").current(deformer.uid).elements.indices == (3,)
    assert selected(target, "vertex") == (cage, {3})
    cage.data.vertices[3].co.x = CORNERS[3][0]
    cage.data.update()
    assert np.abs(evaluated_points(target) - posed).max() < FLOAT32
    assert_goes_on(target, cage)


def test_a_cage_object_that_is_nowhere_is_the_cages_fault(room) -> None:
    target, cage = ball(), box()
    deformer = surround(target, cage)
    cage.location.y = 0.5
    posed = evaluated_points(target)
    cage.delta_location.y = float("nan")
    assert_at_rest(target)
    assert "nowhere" in deformer.status
    elements = room("core.status").current(deformer.uid).elements
    assert (elements.owner.name, elements.element) == ("CONTROL", "vertex")
    cage.delta_location.y = 0.0
    assert np.abs(evaluated_points(target) - posed).max() < FLOAT32
    assert_goes_on(target, cage)


def test_undo_of_what_sent_a_cage_nowhere_brings_the_pose_back() -> None:
    target, cage = ball(), box()
    surround(target, cage)
    cage.location.z = 0.5
    posed = evaluated_points(target)
    bpy.ops.ed.undo_push(message="Posed")
    place(cage, [(float("nan"),) * 3] * 8)
    assert_at_rest(target)
    bpy.ops.ed.undo_push(message="Lost")
    bpy.ops.ed.undo()
    target, cage = bpy.data.objects["Ball"], bpy.data.objects["Cage"]
    assert np.abs(evaluated_points(target) - posed).max() < FLOAT32
    assert_goes_on(target, cage)


@pytest.mark.parametrize("method", WITH_CAGE)
def test_a_mesh_without_vertices_is_said_and_waits_for_some(method: str) -> None:
    target, cage = new_object("Ball", []), box()
    make_active(target)
    with pytest.raises(RuntimeError, match=r"has no (vertices|points)"):
        bpy.ops.sinew.cage_add(source="AUTO", method=method)
    assert target.sinew.active is None
    deformer = surround(target, cage, method)
    assert deformer.status_level == "ERROR"
    assert "The mesh has no vertices" in deformer.status
    update()
    points = base_points(ball())
    target.data.from_pydata(points.tolist(), [], [])
    target.data.update()
    make_active(target)
    assert bpy.ops.sinew.bind() == {"FINISHED"}
    assert_goes_on(target, cage)


@pytest.mark.parametrize("after_bind", [False, True])
def test_a_mesh_that_a_modifier_empties_comes_back(after_bind: bool) -> None:
    """Before it is bound, Bind takes the vertices; afterwards they are still bound."""
    target, cage = ball(), box()
    target.vertex_groups.new(name="Nobody")
    if after_bind:
        surround(target, cage)
    mask = target.modifiers.new("Mask", "MASK")
    mask.vertex_group = "Nobody"
    make_active(target)
    bpy.ops.object.modifier_move_to_index(modifier="Mask", index=0)
    if not after_bind:
        deformer = surround(target, cage)
        assert deformer.status_level == "ERROR"
        assert "check the modifiers before Sinew" in deformer.status
    assert len(evaluated_points(target)) == 0
    cage.location.z = 0.5
    assert len(evaluated_points(target)) == 0
    mask.show_viewport = mask.show_render = False
    cage.location.z = 0.0
    assert_at_rest(target)
    if not after_bind:
        make_active(target)
        assert bpy.ops.sinew.bind() == {"FINISHED"}
    assert_goes_on(target, cage)


@pytest.mark.parametrize(
    ("points", "faces", "said"),
    [
        ([], [], "The cage has no vertices"),
        (CORNERS, [], "the cage has no faces"),
        (CORNERS[:4], [(0, 1, 3, 2), (2, 3, 1, 0)], "encloses no volume"),
        ([CORNERS[0]] * 8, SIDES, "encloses no volume"),
    ],
    ids=["empty", "loose", "flat", "point"],
)
def test_a_cage_that_holds_nothing_is_refused_until_it_does(room, points, faces, said: str) -> None:
    target, cage = ball(), new_object("Cage", points, faces)
    deformer = surround(target, cage)
    found = room("core.status").current(deformer.uid)
    assert found.level.name == "ERROR"
    assert said in found.text
    assert found.remedy.name == "CAGE_REST", "no other button helps"
    assert_at_rest(target)
    if found.elements:
        assert selected(target, "face") == (cage, set(range(len(faces))))
    cage.data = box().data
    make_active(target)
    assert bpy.ops.sinew.cage_set_rest() == {"FINISHED"}
    assert_goes_on(target, cage)


@pytest.mark.parametrize("method", WITH_CAGE)
def test_a_cage_in_one_place_takes_the_mesh_there_and_gives_it_back(method: str) -> None:
    target, cage = ball(), box()
    deformer = surround(target, cage, method)
    rest, spot = base_points(target), (0.1, 0.2, -0.3)
    place(cage, [spot] * 8)
    assert np.abs(evaluated_points(target) - spot).max() < FLOAT32
    place(cage, CORNERS)
    cage.scale, cage.location = (0.0, 0.0, 0.0), spot
    assert np.abs(evaluated_points(target) - spot).max() < FLOAT32
    assert deformer.status_level == "INFO", deformer.status
    cage.scale, cage.location = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
    assert np.abs(evaluated_points(target) - rest).max() < FLOAT32
    assert_goes_on(target, cage)


def test_a_cage_of_zero_scale_is_no_rest(room) -> None:
    target, cage = ball(), box()
    deformer = surround(target, cage)
    cage.scale = (0.0, 1.0, 1.0)
    make_active(target)
    with pytest.raises(RuntimeError, match="encloses no volume"):
        bpy.ops.sinew.cage_set_rest()
    assert room("core.status").current(deformer.uid).remedy.name == "CAGE_REST"
    assert_at_rest(target)
    cage.scale = (1.0, 1.0, 1.0)
    make_active(target)
    assert bpy.ops.sinew.cage_set_rest() == {"FINISHED"}
    assert_goes_on(target, cage)


LOOSE = (CORNERS + [(9.0, 9.0, 9.0), (8.0, 8.0, 8.0), (7.0, 7.0, 7.0)], SIDES, [(8, 9)])
ELSEWHERE = [(x - 2.0, y - 2.0, z) for x, y, z in CORNERS]  # corners 6 and 7 are 0 and 1 of the other cube
SHARED = {6: 0, 7: 1}
TWO_CUBES = (
    CORNERS + ELSEWHERE,
    SIDES + [tuple(SHARED.get(corner, corner + 8) for corner in side) for side in SIDES],
    [],
)


@pytest.mark.parametrize("method", WITH_CAGE)
@pytest.mark.parametrize("cage", [LOOSE, TWO_CUBES], ids=["loose", "edge of four faces"])
def test_a_closed_cage_may_have_loose_vertices_and_edges_of_four_faces(cage, method: str) -> None:
    target, cage = ball(), new_object("Cage", *cage)
    surround(target, cage, method)
    assert np.abs(evaluated_points(target) - base_points(target)).max() < FLOAT32
    if len(cage.data.polygons) == len(SIDES):
        place(cage, CORNERS + [(50.0, 0.0, 0.0)] * 3)  # loose vertices carry nothing
        assert np.abs(evaluated_points(target) - base_points(target)).max() < FLOAT32
    assert_goes_on(target, cage)


FIN = (CORNERS + [(-2.0, -2.0, 0.0)], SIDES + [(0, 1, 8)], {0, 1, 8})
DOUBLED = (CORNERS + [CORNERS[0]], [(8, 1, 3, 2), *SIDES[1:]], {0, 1, 2, 8})


@pytest.mark.parametrize(("points", "faces", "bad"), [FIN, DOUBLED], ids=["fin", "doubled vertex"])
def test_edges_that_leave_a_cage_open_are_shown(points, faces, bad) -> None:
    target, cage = ball(), new_object("Cage", points, faces)
    deformer = surround(target, cage)
    assert deformer.status_level == "ERROR"
    assert "open" in deformer.status
    assert_at_rest(target)
    shown, vertices = selected(target, "vertex")
    assert (shown, vertices) == (cage, bad)
    cage.data = box().data
    make_active(target)
    assert bpy.ops.sinew.cage_set_rest() == {"FINISHED"}
    assert_goes_on(target, cage)


FLAT = (CORNERS + [(-1.0, -1.0, 0.0)], SIDES + [(0, 1, 8), (8, 1, 0)])  # along an edge, there and back


@pytest.mark.parametrize("method", WITH_CAGE)
def test_faces_without_area_do_no_harm_or_are_shown(room, method: str) -> None:
    target, cage = ball(), new_object("Cage", *FLAT)
    deformer = surround(target, cage, method)
    if method == "harmonic":  # an equation a face
        said = room("core.status").current(deformer.uid)
        assert "no area" in said.text
        assert said.remedy.name == "CAGE_REST", "Repair mends the mesh, which is well"
        assert_at_rest(target)
        shown, faces = selected(target, "face")
        assert shown == cage
        assert faces >= {6, 7}
        deformer.method = "mean_value"
        make_active(target)
        assert bpy.ops.sinew.bind() == {"FINISHED"}
    assert np.abs(evaluated_points(target) - base_points(target)).max() < FLOAT32
    assert_goes_on(target, cage)


@pytest.mark.parametrize("method", WITH_CAGE)
def test_vertices_on_those_of_the_cage_go_with_them(method: str) -> None:
    """The mesh is a copy of its cage."""
    target, cage = ball(), ball()
    cage.data = cage.data.copy()
    surround(target, cage, method)
    assert np.abs(evaluated_points(target) - base_points(target)).max() < FLOAT32
    shear = Matrix(((1.0, 0.4, 0.0, 0.2), (0.0, 1.2, 0.1, 0.0), (0.0, 0.0, 0.8, -0.3), (0.0, 0.0, 0.0, 1.0)))
    cage.data.transform(shear)
    cage.data.update()
    if method != "green":  # its normals keep shapes
        assert np.abs(evaluated_points(target) - apply_matrix(shear, base_points(target))).max() < FLOAT32
    assert np.isfinite(evaluated_points(target)).all()
    assert_goes_on(target, cage)


@pytest.mark.parametrize("method", WITH_CAGE)
def test_vertices_on_edges_and_faces_of_the_cage_go_with_them(method: str) -> None:
    target, cage = fine_box(3), box()
    surround(target, cage, method)
    rest = base_points(target)
    assert np.abs(evaluated_points(target) - rest).max() < FLOAT32
    turn = Matrix.Translation((0.3, 0.0, 0.1)) @ Matrix.Rotation(0.7, 4, (0.0, 0.6, 0.8))
    cage.data.transform(turn)
    cage.data.update()
    assert np.abs(evaluated_points(target) - apply_matrix(turn, rest)).max() < FLOAT32
    assert_goes_on(target, cage)


def test_elements_that_a_modifier_of_the_cage_made_are_not_shown_wrongly(room) -> None:
    """A Subdivision at bind, and a face index of what it made is no index of the cage's own faces."""
    target, cage = ball(), box()
    cage.data.vertices[0].co = (1.5, 0.3, 0.2)  # through the opposite side
    cage.modifiers.new("Subdivision", "SUBSURF").subdivision_type = "SIMPLE"
    deformer = surround(target, cage)
    notes = [note for note in room("core.status").notes(deformer.uid) if note.elements]
    (line,) = (
        i
        for i, note in enumerate(notes)
        if (note.elements.owner.name, note.elements.element) == ("CONTROL", "face")
    )
    make_active(target)
    with pytest.raises(RuntimeError, match="turn off its modifiers"):
        bpy.ops.sinew.select_problems(line=line)
    cage.modifiers.clear()
    make_active(target)
    assert bpy.ops.sinew.cage_set_rest() == {"FINISHED"}
    make_active(target)
    assert bpy.ops.sinew.select_problems(line=line) == {"FINISHED"}
    assert bpy.context.object == cage


@pytest.mark.parametrize("method", WITH_CAGE)
def test_weights_above_the_memory_limit_are_refused_until_it_is_raised(
    room, preferences, method: str
) -> None:
    target, cage = ball(), fine_box(5)  # 162 by 218 weights of 4 bytes
    preferences.memory_limit = 0.00005
    deformer = surround(target, cage, method)
    said = room("core.status").current(deformer.uid)
    assert (said.level.name, said.remedy.name) == ("ERROR", "PREFERENCES")
    assert "needs" in said.text
    assert "the memory limit is 0.1 MB: raise the limit" in said.text
    assert_at_rest(target)
    assert deformer.cage == cage
    preferences.memory_limit = 1.0
    make_active(target)
    assert bpy.ops.sinew.bind() == {"FINISHED"}
    assert_goes_on(target, cage)


def test_a_lowered_memory_limit_keeps_what_is_bound_and_a_finer_cage_is_refused(room, preferences) -> None:
    target, cage = ball(), box()
    deformer = surround(target, cage)
    preferences.memory_limit = 0.00005
    assert_goes_on(target, cage)
    cage.location.z = 0.0
    smoother = cage.modifiers.new("Subdivision", "SUBSURF")
    smoother.levels = smoother.render_levels = 3
    smoother.subdivision_type = "SIMPLE"
    make_active(target)
    with pytest.raises(RuntimeError, match="memory limit"):
        bpy.ops.sinew.cage_set_rest()
    assert_at_rest(target)
    assert room("core.status").current(deformer.uid).remedy.name == "PREFERENCES"
    cage.modifiers.clear()
    make_active(target)
    assert bpy.ops.sinew.cage_set_rest() == {"FINISHED"}
    assert_goes_on(target, cage)
