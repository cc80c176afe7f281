# SPDX-License-Identifier: GPL-3.0-or-later
"""New triangles: everything that the mesh carries comes along, and what is bound goes on."""

import bpy
import numpy as np
import pytest
from inside import inner
from rigs import rig as scenes
from rigs.cages import box

OPERATORS = (
    ("remesh", {"share": 0.7}),
    ("remesh", {"by_curvature": True, "longest": 0.3}),
    ("decimate", {"share": 0.5}),
    ("remesh_semi_regular", {"levels": 2}),
)


def loaded_plate() -> bpy.types.Object:
    """A plate of squares whose every value is a function of its place, with a seam and two materials."""
    obj = scenes.grid_object("Loaded", 12)
    mesh, points = obj.data, scenes.base_points(obj)
    left = points[:, 0] < points[:, 0].mean() - 1e-6
    scenes.add_group(obj, "Whole", lambda point: point[1] > np.median(points[:, 1]))
    slope = obj.vertex_groups.new(name="Slope")
    for vertex, point in enumerate(points):
        slope.add([vertex], float(point[0] - points[:, 0].min()) / np.ptp(points[:, 0]), "REPLACE")
    for name in ("First", "Second"):
        mesh.materials.append(bpy.data.materials.new(name))
    middle = points[:, 0].mean()
    faces = np.array([[np.mean([points[v][0] for v in face.vertices])] for face in mesh.polygons]) < middle
    mesh.polygons.foreach_set("material_index", faces.ravel().astype(np.int32))
    mesh.polygons.foreach_set("use_smooth", faces.ravel())
    layer = mesh.uv_layers.new(name="Islands")
    for face, on_left in zip(mesh.polygons, faces.ravel(), strict=True):
        for loop in face.loop_indices:
            x, y, _z = points[mesh.loops[loop].vertex_index]
            layer.data[loop].uv = (x + (10 if on_left else 0), y)
    for edge in mesh.edges:
        x = points[list(edge.vertices), 0].mean()
        edge.use_seam = bool(abs(x - middle) < 1e-6)
        edge.use_edge_sharp = bool(abs(points[list(edge.vertices), 1] - np.median(points[:, 1])).max() < 1e-6)
    attribute = mesh.attributes.new("place", "FLOAT_VECTOR", "POINT")
    attribute.data.foreach_set("vector", points.astype(np.float32).ravel())
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="Lifted")
    key.data.foreach_set("co", (points + np.column_stack([0 * points[:, :2], points[:, 0]])).ravel())
    key.value = 0.25
    assert left.any()
    return obj


@pytest.mark.parametrize(("operator", "options"), OPERATORS)
def test_everything_is_carried_over(operator: str, options: dict):
    obj = loaded_plate()
    bpy.ops.sinew.deformer_add(method="thin_shell")
    bpy.ops.sinew.handle_add(kind="FIXED", vertex_group="Whole")
    mesh, before = obj.data, scenes.base_points(obj)
    middle, level = before[:, 0].mean(), np.median(before[:, 1])
    size = np.ptp(before[:, 0])
    with scenes.in_mode(obj):
        assert getattr(bpy.ops.sinew, operator)(**options) == {"FINISHED"}
    points = scenes.base_points(obj)
    assert len(points) != len(before)
    assert all(len(face.vertices) == 3 for face in mesh.polygons)
    assert np.isclose(sum(face.area for face in mesh.polygons), size**2, rtol=1e-5)
    tolerance = 1e-5 * size
    expected = (points[:, 0] - before[:, 0].min()) / size
    group = obj.vertex_groups["Slope"].index
    slope = [sum(g.weight for g in vertex.groups if g.group == group) for vertex in mesh.vertices]
    assert np.allclose(slope, expected, atol=1e-5)
    whole = scenes.members(obj, "Whole")
    assert {round(obj.vertex_groups["Whole"].weight(int(v)), 6) for v in whole} == {1.0}
    assert (points[whole, 1] > level - tolerance).all()
    assert set(np.flatnonzero(points[:, 1] > level + size / 12)) <= set(whole)
    place = np.empty(3 * len(points), dtype=np.float32)
    mesh.attributes["place"].data.foreach_get("vector", place)
    assert np.allclose(place.reshape(-1, 3), points, atol=tolerance)
    uvs = mesh.uv_layers["Islands"]
    for face in mesh.polygons:
        on_left = points[list(face.vertices), 0].mean() < middle
        assert face.material_index == on_left
        assert face.use_smooth == on_left
        for loop in face.loop_indices:
            x, y, _z = points[mesh.loops[loop].vertex_index]
            assert np.allclose(uvs.data[loop].uv, (x + (10 if on_left else 0), y), atol=1e-4 * size)
    for flag, axis, value in (("use_seam", 0, middle), ("use_edge_sharp", 1, level)):
        marked = [edge for edge in mesh.edges if getattr(edge, flag)]
        ends = [points[list(edge.vertices)] for edge in marked]
        assert np.isclose(sum(np.linalg.norm(a - b) for a, b in ends), size, rtol=1e-5)
        assert all(abs(pair[:, axis] - value).max() < tolerance for pair in ends)
    lifted = mesh.shape_keys.key_blocks["Lifted"]
    assert lifted.value == 0.25
    expected = points + np.column_stack([0 * points[:, :2], points[:, 0]])
    assert np.allclose(scenes.coordinates(lifted.data), expected, atol=tolerance)


@pytest.mark.parametrize(("operator", "options"), OPERATORS)
def test_a_bound_deformer_goes_on(bound_plate: scenes.Rig, operator: str, options: dict):
    obj = bound_plate.obj
    bound_plate.control.location.z += 0.5
    scenes.update()
    before = scenes.evaluated_points(obj)
    scenes.press(obj, operator, **options)
    scenes.update()
    after, rest = scenes.evaluated_points(obj), scenes.base_points(obj)
    assert obj.sinew.active.is_bound
    assert len(after) != len(before)
    assert abs(after[:, 2].max() - 0.5) < 1e-5
    top, base = (np.flatnonzero(np.abs(rest[:, 1] - side) < 1e-5) for side in (1, -1))
    assert np.allclose(after[top] - rest[top], (0, 0, 0.5), atol=1e-5)
    assert np.allclose(after[base], rest[base], atol=1e-5)


def test_what_cannot_be_remeshed_is_refused():
    obj = loaded_plate()
    before = scenes.base_points(obj)
    scenes.refused("too short", "remesh", obj, length=1e-6)
    twin = scenes.new_object("Twin", before, [])
    twin.data = obj.data
    modifier = twin.modifiers.new("Levels", "MULTIRES")
    scenes.refused("Twin has a Multiresolution", "decimate", obj)
    twin.modifiers.remove(modifier)
    with scenes.in_mode(twin):
        scenes.refused("in Edit Mode", "decimate", obj)
    assert np.array_equal(before, scenes.base_points(obj))


def test_weights_of_bones_keep_their_sum():
    obj = scenes.grid_object("Skinned", 12)
    for k in range(8):
        scenes.add_group(obj, f"Bone {k}", lambda point, k=k: int(4 * (point[0] + point[1] + 2)) % 8 == k)
    scenes.press(obj, "remesh", share=0.7)
    sums = [sum(g.weight for g in vertex.groups) for vertex in obj.data.vertices]
    np.testing.assert_allclose(sums, 1.0, atol=1e-5)


def test_a_cage_and_an_object_with_the_same_mesh_go_on():
    cage, obj = box(size=6.0), scenes.grid_object("Plate", 12)
    twin = bpy.data.objects.new("Twin", obj.data)
    bpy.context.scene.collection.objects.link(twin)
    for each in (obj, twin):
        scenes.make_active(each)
        assert bpy.ops.sinew.cage_add(source="OBJECT", cage=cage.name) == {"FINISHED"}
    scenes.press(obj, "decimate", share=0.5)
    cage.location.z = 0.5
    scenes.update()
    for each in (obj, twin):
        assert each.sinew.active.is_bound
        assert np.allclose(scenes.evaluated_points(each) - scenes.base_points(each), (0, 0, 0.5), atol=1e-4)


@pytest.mark.parametrize("what", ["flipped", "pinched", "border", "slit", "duplicate", "loose"])
def test_each_line_is_mended_alone(what: str):
    points = [(x, y, z) for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)]
    cube = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    points += [(x + 1, y + 1, z + 1) for x, y, z in points[1:]] + [(9, 9, 9)]
    second = [tuple(7 if v == 0 else v + 7 for v in face) for face in cube]
    turned = [tuple(reversed(second[1])), *second[2:]]  # the second one is open below, and touches the first
    points += [(-1, 0, 0), (0, 0, 0), (0, 1, 0), (-1, 1, 0)]
    slit = [(-1, 0, 1), (0, 0, 1), (0, 1, 1), (-1, 1, 1), (-1, 0, 0), (-1, 1, 0)]
    points += slit
    faces = [*cube, cube[0], *turned, (16, 17, 18, 19), (20, 21, 22, 23), (24, 25, 23, 20)]
    obj = scenes.new_object("Broken", points, faces)
    obj.vertex_groups.new(name="All").add(list(range(len(points))), 0.5, "REPLACE")
    scenes.press(obj, "diagnose")
    before = dict(inner.surveying.last_counts(obj).found)
    assert before[what] > 0
    scenes.press(obj, "cure", what=what)
    after = inner.surveying.last_counts(obj).found
    assert after.get(what, 0) == (2 if what == "border" else 0)  # the rims of the two loose sheets
    assert {round(g.weight, 6) for vertex in obj.data.vertices for g in vertex.groups} == {0.5}
    changed = {name for name in before if after.get(name, 0) != before[name]} - {what}
    assert changed <= {"flipped", "coincident", "border", "slit", "crossing", "non_manifold"}


def test_what_is_told_is_in_the_scene(bound_plate: scenes.Rig, capfd):
    obj = scenes.grid_object("Scaled", 16)
    obj.scale = (3.0, 3.0, 3.0)
    scenes.update()
    scenes.refused("20,000,000 are the most", "remesh_semi_regular", obj, levels=8, base_faces=512)
    assert inner.remesh.user_of(inner.compat.session_key(obj.data), "Former Name") == obj
    scenes.press(obj, "remesh", length=3.0)
    assert f"{len(obj.data.polygons)} triangles instead of 512" in capfd.readouterr().out
    assert 8 < len(obj.data.polygons) < 30  # of an area of 36, with 3.9 for each
    bound_plate.deformer.bake.result = "PC2"
    scenes.refused("Unbake it first", "remesh", bound_plate.obj)
