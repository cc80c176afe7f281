# SPDX-License-Identifier: GPL-3.0-or-later
"""The remedies: broken meshes mended with counts, shared vertices parted, all bound again; Prepare."""

from collections import Counter

import bmesh
import bpy
import numpy as np
import pytest
from expected import faces_of as expected_faces
from inside import inner
from libraries import put_into_a_library, read
from mathutils import Matrix
from rigs import rig as scenes
from rigs.cages import selected

NAN = float("nan")


def mesh_object(points, faces, name: str = "Mesh") -> bpy.types.Object:
    obj = scenes.new_object(name, points, faces)
    scenes.make_active(obj)
    return obj


def faces_of(obj: bpy.types.Object) -> list[tuple[int, ...]]:
    return [tuple(sorted(face.vertices)) for face in obj.data.polygons]


def faults(obj: bpy.types.Object) -> dict[str, int]:
    """An independent count, by loops over Blender's mesh."""
    mesh, points = obj.data, scenes.base_points(obj)
    uses = Counter(edge for face in mesh.polygons for edge in face.edge_keys)
    used = {vertex for face in mesh.polygons for vertex in face.vertices}
    areas = [face.area for face in mesh.polygons]
    places = Counter(map(tuple, np.round(points, 7)[sorted(used)]))
    return {
        "not_finite": int((~np.isfinite(points).all(axis=1)).sum()),
        "coincident": sum(count - 1 for count in places.values()),
        "degenerate": sum(area < 1e-9 for area in areas),
        "duplicate": len(areas) - len(set(faces_of(obj))),
        "non_manifold": sum(count > 2 for count in uses.values()),
        "loose": len(points) - len(used),
    }


def broken_plate() -> scenes.Rig:
    """Every fault once: a NaN inside, an infinite corner of its own, a sliver, a duplicate face, a fin, a
    loose vertex, and the far row of quads cut off along a seam."""
    obj = scenes.grid_object()
    points = scenes.base_points(obj).tolist()
    faces = [tuple(face.vertices) for face in obj.data.polygons]
    bpy.data.objects.remove(obj)
    points[60] = (NAN, 0.0, 0.0)
    copies = {vertex: 121 + row for row, vertex in enumerate(range(99, 110))}  # of the seam
    points += [points[vertex] for vertex in copies]
    faces = [tuple(copies.get(v, v) for v in face) if max(face) >= 110 else face for face in faces]
    loose, lost, tip, middle = (5.0, 0.0, 0.0), (float("inf"), 0.0, 0.0), (0.1, 0.1, 0.5), (-0.1, -1.0, 0.0)
    points += [loose, lost, tip, middle]
    faces += [faces[7], (36, 37, len(points) - 2), (4, 5, len(points) - 1)]
    return scenes.Rig(mesh_object(points, faces, "Plate"))


def test_every_fault_is_mended_and_counted():
    obj = broken_plate().obj
    before = faults(obj)
    assert (before["not_finite"], before["coincident"]) == (2, 11)
    assert all(before.values()), before
    mended, left = inner.repair.repair(obj, inner.repair.RepairOptions())
    assert mended.items() >= {"not_finite": 2, "coincident": 11, "duplicate": 1, "degenerate": 1}.items()
    assert mended["loose"] >= 1
    assert not any(left.values()), left
    assert not any(faults(obj).values()), faults(obj)
    points = scenes.base_points(obj)
    assert np.abs(points[60] - points[[49, 59, 61, 71]].mean(axis=0)).max() < scenes.FLOAT32


def test_the_operator_says_what_it_did_and_binds_again(capfd):
    plate = broken_plate()
    obj = plate.obj
    scenes.add_regions(obj, "thin_shell", {"Top": "HANDLE", "Base": "FIXED"})
    assert bpy.ops.sinew.repair() == {"FINISHED"}
    said = capfd.readouterr().out
    assert "Mended 2 vertices without a finite position, 11 coincident vertices" in said
    assert plate.deformer.status_level == "INFO"
    plate.control.location.z += 0.5
    points, along = plate.points(), plate.rest()[:, 1]
    assert np.abs(points[along > 0.75, 2] - 0.5).max() < scenes.FLOAT32
    assert np.abs(points[np.abs(along) < 0.3, 2]).min() > 1e-3  # the seam passes the motion on


def test_a_mesh_that_is_well_is_left_alone(plate: scenes.Rig, capfd):
    plate.bind().lift(0.5)
    before, faces = plate.points(), faces_of(plate.obj)
    scenes.press(plate.obj, "repair")
    assert "Nothing to mend" in capfd.readouterr().out
    assert faces_of(plate.obj) == faces
    assert np.array_equal(plate.points(), before)


def test_switched_off_cures_do_nothing():
    plate = broken_plate()
    before = faults(plate.obj)
    scenes.make_active(plate.obj)
    off = dict.fromkeys(("coincident", "degenerate", "duplicate", "non_manifold", "loose"), False)
    bpy.ops.sinew.repair(**off)
    after = faults(plate.obj)
    assert after.pop("not_finite") == 0
    before.pop("not_finite")
    assert after == {**before, "loose": before["loose"] - 1}  # the infinite one is gone


def test_groups_shape_keys_and_uvs_stay():
    plate = broken_plate()
    obj = plate.obj
    for loop, corner in zip(obj.data.uv_layers.new(name="Map").data, obj.data.loops, strict=True):
        loop.uv = obj.data.vertices[corner.vertex_index].co.xy
    wave = scenes.add_key(obj, "Wave", Matrix.Translation((0.0, 0.0, 0.25)))
    wave.data[30].co.x = NAN
    scenes.press(obj, "repair")
    mesh, points = obj.data, scenes.base_points(obj)
    assert {group.name for group in obj.vertex_groups} == {"Top", "Base"}
    assert {element.weight for vertex in mesh.vertices for element in vertex.groups} == {1.0}
    assert set(scenes.members(obj, "Top")) == set(np.flatnonzero(points[:, 1] > 0.75))
    basis, raised = (scenes.coordinates(mesh.shape_keys.key_blocks[name].data) for name in ("Basis", "Wave"))
    assert np.abs(basis - points).max() < scenes.FLOAT32
    assert np.isfinite(raised).all()
    lifts = [np.abs(raised - basis - (0.0, 0.0, height)).max(axis=1) for height in (0.25, 0.0)]
    assert (np.minimum(*lifts) < scenes.FLOAT32).all()
    across = np.array([loop.uv[0] for loop in mesh.uv_layers["Map"].data])
    off = np.abs(across - points[[corner.vertex_index for corner in mesh.loops], 0])
    assert off[np.isfinite(across)].max() <= 1e-5


def test_repair_in_edit_mode_stays_there():
    obj = broken_plate().obj
    with scenes.in_mode(obj):
        bpy.ops.sinew.repair()
        assert obj.mode == "EDIT"
        assert not [face for face in bmesh.from_edit_mesh(obj.data).faces if face.calc_area() < 1e-9]
    assert not any(faults(obj).values())


def test_each_shape_key_is_filled_from_its_own_neighbours():
    """In Edit Mode with another key than the first one active, the mesh shows that key."""
    obj = scenes.grid_object()
    scenes.add_key(obj, "Wave", Matrix.Translation((0.0, 0.0, 1.0)))
    keys = obj.data.shape_keys.key_blocks
    for points in (keys[0].data, keys[1].data, obj.data.vertices):
        points[60].co.y = NAN
    obj.active_shape_key_index = 1
    for mode in ("EDIT", "OBJECT"):
        with scenes.in_mode(obj, mode):
            bpy.ops.sinew.repair()
    keys = obj.data.shape_keys.key_blocks
    for points, height in ((keys[0].data, 0.0), (keys[1].data, 1.0), (obj.data.vertices, 0.0)):
        assert np.abs(np.array(points[60].co) - (0.0, 0.0, height)).max() < scenes.FLOAT32


CUBE = 0.5 * (np.array(scenes.CORNERS) + 1.0)
TOUCHING = (
    np.vstack((CUBE, CUBE + (1, 0, 0))),
    scenes.SIDES + [tuple(v + 8 for v in side) for side in scenes.SIDES],
)
TWO_ROOMS = (  # the last face is the wall between them
    [(x, y, z) for x in (0, 1, 2) for y in (0, 1) for z in (0, 1)],
    [(0, 1, 3, 2), (8, 10, 11, 9)]
    + [tuple(v + k for v in side) for k in (0, 4) for side in scenes.SIDES[2:]]
    + [(4, 5, 7, 6)],
)
ENDS = ((0.0, 0.0), (1.0, 0.0), (-1.0, 1.0), (-1.0, -1.0))
SHEETS = ([(x, y, z) for x, y in ENDS for z in (0.0, 1.0)], [(0, 1, 3, 2), (0, 1, 5, 4), (0, 1, 7, 6)])
WIRE = ([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)], [])


@pytest.mark.parametrize(
    ("shape", "left"),
    [(TOUCHING, (16, 12)), (WIRE, (2, 0)), (SHEETS, (8, 3)), (TWO_ROOMS, (12, 10))],
    ids=["closed parts that touch", "a wire", "a junction of sheets", "all but an inner wall"],
)
def test_what_is_meant_stays(shape: tuple, left: tuple[int, int]):
    """Vertices and faces; merging the places that two parts have in common would change what they are."""
    obj = mesh_object(*shape)
    bpy.ops.sinew.repair()
    assert (len(obj.data.vertices), len(obj.data.polygons)) == left
    assert faults(obj)["non_manifold"] == (left == (8, 3))


def test_notes_name_each_fault_with_elements_and_remedy():
    plate = broken_plate()
    points, notes = scenes.base_points(plate.obj), inner.mesh_notes.notes
    found = inner.backend.diagnose(points, expected_faces(plate.obj.data))
    lines = notes(found)
    assert all(line.remedy is inner.status.Remedy.REPAIR and line.elements for line in lines)
    by_text = {line.text: line for line in lines}
    assert set(by_text) >= {
        "2 vertices without a finite position",
        "11 coincident vertices",
        "1 face without area",
        "1 duplicate face",
    }
    assert any("edges of three or more faces" in text for text in by_text)
    assert any("loose vert" in text for text in by_text)
    lost = np.flatnonzero(~np.isfinite(points).all(axis=1))
    assert set(by_text["2 vertices without a finite position"].elements.indices) == set(lost)
    assert by_text["1 duplicate face"].elements.element == "face"
    hidden = notes(found, selectable=False)
    assert [(line.text, not line.elements) for line in hidden] == [(line.text, True) for line in lines]


def overlapping(plate: scenes.Rig, name: str, where, weight: float = 1.0) -> set[int]:
    """A fixed region besides those of the plate; its vertices."""
    group = scenes.add_group(plate.obj, name, where).tolist()
    plate.obj.vertex_groups[name].add(group, weight, "REPLACE")
    scenes.press(plate.obj, "handle_add", kind="FIXED", vertex_group=name)
    return set(group)


def test_shared_vertices_stay_in_the_first_region(plate: scenes.Rig, capfd):
    plate.bind()
    shared = overlapping(plate, "Overlap", lambda point: point[1] > 0.55)
    line = inner.status.current(plate.deformer.uid)
    assert (line.level.name, line.remedy.name) == ("ERROR", "PART_REGIONS")
    assert "Top and Overlap share 22 vertices" in line.text
    assert np.array_equal(plate.points(), plate.rest())
    assert selected(plate.obj, "vertex")[1] == set(plate.top) & shared
    assert bpy.ops.sinew.part_regions() == {"FINISHED"}
    assert "22 vertices are now in Top alone, no longer in Overlap" in capfd.readouterr().out
    assert set(scenes.members(plate.obj, "Top")) == set(plate.top)
    assert set(scenes.members(plate.obj, "Overlap")) == shared - set(plate.top)
    assert plate.deformer.status_level == "INFO"
    plate.lift(0.5)
    assert np.abs(plate.points()[plate.top, 2] - 0.5).max() < scenes.FLOAT32
    scenes.make_active(plate.obj)
    assert bpy.ops.sinew.part_regions() == {"CANCELLED"}  # nothing is shared now


def test_a_handle_inside_a_fixed_part_keeps_its_vertices(plate: scenes.Rig):
    scenes.press(plate.obj, "deformer_add", method="thin_shell")
    everything = overlapping(plate, "All", lambda point: True)
    scenes.press(plate.obj, "handle_add", kind="HANDLE", vertex_group="Top")
    bpy.ops.sinew.part_regions()
    assert set(scenes.members(plate.obj, "Top")) == set(plate.top)
    assert set(scenes.members(plate.obj, "All")) == everything - set(plate.top)
    assert plate.deformer.status_level == "INFO"


def test_two_regions_of_the_same_vertices_are_refused_unless_one_is_soft(plate: scenes.Rig):
    plate.bind()
    overlapping(plate, "Soft", lambda point: point[1] > 0.75, weight=0.5)
    assert bpy.ops.sinew.part_regions() == {"CANCELLED"}
    assert plate.deformer.status_level == "INFO"
    overlapping(plate, "Twin", lambda point: point[1] > 0.75)
    scenes.refused("Top and Twin are the same vertices", "part_regions")
    assert set(scenes.members(plate.obj, "Twin")) == set(plate.top)


def test_what_is_unusual_is_counted_and_selected(capfd):
    obj = broken_plate().obj
    obj.data.polygons[3].flip()
    scenes.press(obj, "diagnose")
    said = capfd.readouterr().out
    expected = faults(obj)
    found = inner.surveying.last_counts(obj).found
    assert {what: found[what] for what in expected if what != "coincident"}.items() <= expected.items()
    assert "1 flipped face" in said
    assert f"{found['slit']} edges of slits" in said
    assert (found["slit"], found["flipped"]) == (20, 1)
    for what, count in found.items():
        assert bpy.ops.sinew.select_unusual(what=what) == {"FINISHED"}
        edit = bmesh.from_edit_mesh(obj.data)
        chosen = sum(face.select for face in edit.faces), sum(vertex.select for vertex in edit.verts)
        if what in ("flipped", "degenerate", "duplicate"):
            assert chosen[0] >= count, what  # of faces with the same vertices both are selected
        assert chosen[1] > 0, what
    bpy.ops.object.mode_set(mode="OBJECT")
    obj.data.vertices.add(1)
    assert inner.surveying.last_counts(obj) is None


def test_curvature_is_stored_and_shown():
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4, radius=2.0)
    obj = bpy.context.object
    with scenes.in_mode(obj):
        assert bpy.ops.sinew.measure_curvature(shown="largest", vectors=True) == {"FINISHED"}
    mesh, count = obj.data, len(obj.data.vertices)
    for name, expected in (("mean", 0.5), ("gaussian", 0.25), ("largest", 0.5), ("smallest", 0.5)):
        values = np.empty(count, dtype=np.float32)
        mesh.attributes[f"curvature_{name}"].data.foreach_get("value", values)
        assert np.abs(values / expected - 1).max() < 0.03, name  # the fit of edges of a tenth
    across = np.empty(3 * count, dtype=np.float32)
    mesh.attributes["curvature_largest_direction"].data.foreach_get("vector", across)
    assert np.abs((across.reshape(-1, 3) * scenes.base_points(obj)).sum(axis=1)).max() < 0.01
    colours = np.empty(4 * count, dtype=np.float32)
    mesh.color_attributes.active_color.data.foreach_get("color", colours)
    assert np.ptp(colours.reshape(-1, 4), axis=0).max() < 0.1
    assert colours[0] > 2 * colours[2]  # red is convex
    names = {attribute.name for attribute in mesh.attributes}
    scenes.press(obj, "measure_curvature", shown="none", rings=3)
    assert {attribute.name for attribute in mesh.attributes} == names


def test_what_prepare_refuses(tmp_path):
    obj = scenes.grid_object()
    obj.vertex_groups.new(name="curvature_mean")
    obj.data.uv_layers.new(name="curvature")
    scenes.refused("a vertex group called curvature_mean", "measure_curvature", obj)
    obj.vertex_groups.clear()
    scenes.refused("a UV map called curvature", "measure_curvature", obj)
    path = put_into_a_library(tmp_path / "library.blend", scenes.grid_object("Linked"))
    obj = read(path, link=True, kind="objects", name="Linked").override_create()
    bpy.context.scene.collection.objects.link(obj)
    scenes.refused("local first", "select_unusual", obj, what="border")


def test_counts_stay_until_they_may_be_wrong():
    points = [(-1, -1, 0), (1, -1, 0), (0, 1, 0), (0, 0, -1), (0, 0, 1), (0, 3, 0)]
    obj, other = (mesh_object(points, [(0, 1, 2), (3, 4, 5)], name) for name in ("Mesh", "Other"))
    scenes.press(obj, "diagnose")
    inner.surveying.survey(obj, crossings=False)
    assert inner.surveying.last_counts(obj).found["crossing"] == 2
    name, obj.data.name = obj.data.name, "Renamed"
    other.data.name = name
    assert inner.surveying.last_counts(other) is None
    inner.history.on_undo()
    assert not inner.surveying._last
