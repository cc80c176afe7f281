# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders that get other vertices than the bind saw: each is compared with a solve on Blender's own mesh.

That mesh is what a render shows of a copy without Sinew, with its faces and vertex groups.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from expected import Expected
from inside import notes_of, settle
from mathutils import Matrix
from probe import Probe, exported_points, render, render_points
from rigs import rig as scenes
from rigs.kinds import RIGS, point_objects
from second_blender import another_blender, by_command_line, is_executable

HEIGHT = 0.5
EXACT = 1e-5
CARRIED = 2e-3  # a rest shape that follows from another one of a bent surface


# --- what happens to what enters: made before the bind, and changed after it


def subdivision(obj: bpy.types.Object, levels: int = 2, render_levels: int = 2) -> bpy.types.Modifier:
    return scenes.subdivided(obj, levels, render_levels)


def multires(obj: bpy.types.Object) -> None:
    obj.modifiers.new("Multires", "MULTIRES")
    scenes.make_active(obj)
    for _ in range(3):
        bpy.ops.object.multires_subdivide(modifier="Multires", mode="CATMULL_CLARK")
    modifier = obj.modifiers["Multires"]
    modifier.levels = modifier.render_levels = 2


def screw(obj: bpy.types.Object) -> None:
    """A line is drawn out to a sheet."""
    obj.data.clear_geometry()
    obj.vertex_groups.clear()
    places = [(0.0, y, 0.0) for y in np.linspace(-1.0, 1.0, 9)]
    obj.data.from_pydata(places, [(i, i + 1) for i in range(8)], [])
    for name, members in (("Top", [8]), ("Base", [0])):
        obj.vertex_groups.new(name=name).add(members, 1.0, "REPLACE")
    modifier = obj.modifiers.new("Screw", "SCREW")
    modifier.axis, modifier.angle, modifier.screw_offset = "X", 0.0, 1.0
    modifier.steps = modifier.render_steps = 4


def copies(obj: bpy.types.Object) -> None:
    modifier = obj.modifiers.new("Array", "ARRAY")
    modifier.relative_offset_displace = (1.5, 0.0, 0.0)


def boolean(obj: bpy.types.Object) -> bpy.types.Modifier:
    """The level of another object, which a Boolean joins."""
    other = scenes.grid_object("Other", 3)
    other.location = (0.0, 0.0, 5.0)
    modifier = obj.modifiers.new("Boolean", "BOOLEAN")
    modifier.operation, modifier.object = "UNION", other
    scenes.make_active(obj)
    return subdivision(other, 1, 1)


def by_nodes(obj: bpy.types.Object) -> None:
    """Nodes that subdivide once more in renders, once a switch is on."""
    tree, start, end = scenes.new_nodes("Finer")
    finer = tree.nodes.new("GeometryNodeSubdivideMesh")
    asks, choice = tree.nodes.new("GeometryNodeIsViewport"), tree.nodes.new("GeometryNodeSwitch")
    choice.input_type = "INT"
    levels = [socket for socket in choice.inputs if socket.enabled][1:]
    levels[0].default_value = levels[1].default_value = 1
    tree.links.new(asks.outputs[0], next(socket for socket in choice.inputs if socket.enabled))
    tree.links.new(next(socket for socket in choice.outputs if socket.enabled), finer.inputs["Level"])
    tree.links.new(start, finer.inputs[0])
    tree.links.new(finer.outputs[0], end)
    modifier = obj.modifiers.new("Finer", "NODES")
    modifier.node_group = tree


def finer_by_nodes(obj: bpy.types.Object) -> None:
    choice = next(node for node in bpy.data.node_groups["Finer"].nodes if node.type == "SWITCH")
    [socket for socket in choice.inputs if socket.enabled][1].default_value = 2  # where no viewport asks


def driven(obj: bpy.types.Object) -> None:
    obj.modifiers[0].driver_add("levels").driver.expression = "2"


def setting(**values: object) -> Callable[[bpy.types.Object], None]:
    """Settings of the first modifier."""
    return lambda obj: put(obj.modifiers[0], values)


def simplify(viewport: int, rendered: int) -> Callable[[bpy.types.Object], None]:
    values = {"simplify_subdivision": viewport, "simplify_subdivision_render": rendered}
    return lambda _obj: put(bpy.context.scene.render, {"use_simplify": True, **values})


def put(owner: object, values: dict[str, object]) -> None:
    for name, value in values.items():
        setattr(owner, name, value)


def several(*changes: Callable[[bpy.types.Object], object]) -> Callable[[bpy.types.Object], object]:
    return lambda obj: [change(obj) for change in changes]


Change = Callable[[bpy.types.Object], None]
CASES: dict[str, tuple[Change, Change]] = {
    "a lower level": (subdivision, setting(render_levels=1)),
    "a higher level": (subdivision, setting(render_levels=3)),
    "no level": (subdivision, setting(render_levels=0)),
    "hidden in renders": (subdivision, setting(show_render=False)),
    "multires": (multires, setting(render_levels=3)),
    "screw": (screw, setting(render_steps=16)),
    "shown in renders": (
        several(copies, setting(show_viewport=False, show_render=False)),
        setting(show_render=True),
    ),
    "nodes": (by_nodes, finer_by_nodes),
    "another object": (boolean, lambda obj: put(obj.modifiers[0].object.modifiers[0], {"render_levels": 2})),
    "simplified in the viewport": (subdivision, simplify(0, 6)),
    "simplified in renders": (subdivision, simplify(6, 1)),
    "a driven level in the viewport": (several(subdivision, driven), setting(render_levels=3)),
    "another level in the viewport": (subdivision, setting(levels=1)),
    "other levels in both": (subdivision, setting(levels=1, render_levels=3)),
    "the same other level in both": (subdivision, setting(levels=1, render_levels=1)),
}


@pytest.fixture(params=CASES)
def changed(request: pytest.FixtureRequest) -> scenes.Rig:
    """A sheet, bound, with a lifted handle; after a change."""
    prepare, change = CASES[request.param]
    rig = bound(prepare)
    change(rig.obj)
    return rig


def bound(prepare: Change) -> scenes.Rig:
    rig = scenes.Rig.plate(5)
    prepare(rig.obj)
    rig.bind()
    rig.lift(HEIGHT)
    assert rig.deformer.status_level == "INFO"
    return rig


def plain_of(rig: scenes.Rig) -> bpy.types.Object:
    """What a render shows of a copy without Sinew, as a mesh object with its vertex groups."""
    copy = rig.obj.copy()
    copy.sinew.deformers.clear()
    for modifier in [each for each in copy.modifiers if each.name.startswith("Sinew")]:
        copy.modifiers.remove(modifier)
    bpy.context.scene.collection.objects.link(copy)
    found: dict[str, tuple] = {}

    def note(depsgraph: bpy.types.Depsgraph) -> None:
        mesh = next(each for each in depsgraph.objects if each.name == copy.name).data
        groups = [[(each.group, each.weight) for each in vertex.groups] for vertex in mesh.vertices]
        faces = [tuple(face.vertices) for face in mesh.polygons]
        found["mesh"] = [tuple(vertex.co) for vertex in mesh.vertices], faces, groups

    Probe.noting = note
    try:
        render()
    finally:
        Probe.noting = None
        bpy.data.objects.remove(copy)
    points, faces, groups = found["mesh"]
    plain = scenes.new_object("Plain", points, faces)
    for group in rig.obj.vertex_groups:
        made = plain.vertex_groups.new(name=group.name)
        for vertex, members in enumerate(groups):
            for index, weight in members:
                if index == group.index:
                    made.add([vertex], weight, "REPLACE")
    return plain


def expected(rig: scenes.Rig) -> np.ndarray:
    """What a render is to show: solved on what enters there."""
    plain = plain_of(rig)
    shape = Expected(plain, rig.control, method="thin_shell").lifted(HEIGHT)
    bpy.data.objects.remove(plain)
    return shape


def render_is_right(rig: scenes.Rig) -> bool:
    return off(render_points(rig.obj), expected(rig)) < EXACT


def off(seen: np.ndarray, wanted: np.ndarray) -> float:
    """The largest difference; infinite between other numbers of points."""
    return float(np.abs(seen - wanted).max()) if seen.shape == wanted.shape else np.inf


# --- the targets


def test_renders_and_exporters_are_bound_for_their_own_counts(changed: scenes.Rig, tmp_path: Path):
    """Nothing tells Sinew before an exporter begins."""
    seen, wanted = exported_points(changed.obj, tmp_path), expected(changed)
    assert wanted[:, 2].max() > 0.4
    assert off(seen, wanted) < EXACT
    assert off(render_points(changed.obj), wanted) < EXACT
    assert not [line for line in notes_of(changed.deformer) if "render" in line]


@pytest.mark.parametrize("changed", ["hidden in renders", "another level in the viewport"], indirect=True)
def test_another_process_renders_them(changed: scenes.Rig, tmp_path: Path, addon_name: str):
    """All frames of ``blender -b FILE -a``, of a file that was saved right after the change."""
    wanted, scene = expected(changed), bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 2
    scene.render.filepath = str(tmp_path / "picture")
    path = scenes.save(tmp_path / "counts.blend")
    for shape in frames_of(path, tmp_path, addon_name, changed.name):
        assert off(shape, wanted) < EXACT


def frames_of(path: str, folder: Path, addon_name: str, name: str) -> list[np.ndarray]:
    """What another Blender shows of an object in an animation: by its command line, if it has one."""
    if is_executable():
        return by_command_line(path, folder, addon_name, name)[1]
    found = another_blender(
        f"""
        import probe
        bpy.ops.wm.open_mainfile(filepath={path!r})
        seen["shapes"] = [shapes[{name!r}].tolist() for shapes in probe.render(animation=True)]
        """,
        folder,
        addon_name,
    )
    return [np.array(shape) for shape in found["shapes"]]


def test_a_level_of_renders_comes_back():
    rig = bound(subdivision)
    for level in (2, 3, 2, 1, 3, 2):
        rig.obj.modifiers[0].render_levels = level
        assert render_is_right(rig), level


def test_the_viewport_goes_on_after_its_level_comes_back():
    rig = bound(subdivision)
    shown = rig.points()
    rig.obj.modifiers[0].levels = 1
    settle()
    assert rig.deformer.status == "Topology changed - Rebind"
    assert off(render_points(rig.obj), shown) < EXACT
    rig.obj.modifiers[0].levels = 2
    settle()
    assert scenes.close(rig.points(), shown)
    assert off(render_points(rig.obj), shown) < EXACT


@pytest.mark.parametrize("render_levels", [2, 3])
def test_painted_weights_reach_renders_while_the_viewport_waits(render_levels: int):
    rig = bound(subdivision)
    rig.obj.modifiers[0].levels, rig.obj.modifiers[0].render_levels = 1, render_levels
    settle()
    assert rig.deformer.status == "Topology changed - Rebind"
    before = render_points(rig.obj)
    near = [vertex.index for vertex in rig.obj.data.vertices if vertex.co.y > 0.1]
    rig.obj.vertex_groups["Top"].add(near, 1.0, "REPLACE")
    for _ in range(2):
        assert off(render_points(rig.obj), before) > 0.01
        assert render_is_right(rig)


def posed_by_an_armature(late: bool) -> list[np.ndarray]:
    """At a frame where an armature before Sinew poses the mesh, and at rest."""
    rig = scenes.Rig(scenes.grid_object(f"Plate {late}", 5))
    bone = scenes.add_armature(rig.obj).pose.bones["high"]
    modifier = subdivision(rig.obj, 2, 2 if late else 3)
    rig.bind()
    scenes.key(bone, {1: {"rotation_euler": (0.0, 0.0, 0.0)}, 20: {"rotation_euler": (0.9, 0.0, 0.2)}})
    rig.lift(HEIGHT)
    bpy.context.scene.frame_set(20)
    modifier.render_levels, shapes = 3, []
    for frame in (20, 1):
        bpy.context.scene.frame_set(frame)
        shapes.append(render_points(rig.obj))
    return shapes


def by_two_deformers(late: bool) -> list[np.ndarray]:
    """The second one gets what the first one makes of the vertices of the render."""
    rig = scenes.Rig(scenes.grid_object(f"Plate {late}", 5))
    modifier = subdivision(rig.obj, 2, 2 if late else 3)
    first = rig.bind().control
    rig.bind("arap")
    for control, way in ((first, (0.0, 0.0, HEIGHT)), (rig.control, (0.3, 0.0, 0.0))):
        scenes.move_world(control, Matrix.Translation(way))
    modifier.render_levels = 3
    return [render_points(rig.obj)]


@pytest.mark.parametrize("shapes_of", [posed_by_an_armature, by_two_deformers])
def test_the_rest_for_renders_is_that_of_the_bind(shapes_of: Callable[[bool], list[np.ndarray]]):
    """Also where the level changes later."""
    for one, other in zip(shapes_of(False), shapes_of(True), strict=True):
        assert one[:, 2].max() > 0.3
        assert off(one, other) < CARRIED


def test_a_deformer_that_is_removed_leaves_no_rest_for_renders():
    plate = scenes.Rig.plate(5)
    subdivision(plate.obj, 0, 1)
    count = len(bpy.data.meshes)
    plate.bind()
    assert plate.deformer.rest_render is not None
    scenes.press(plate.obj, "deformer_remove")
    assert len(bpy.data.meshes) == count


# --- the controls


@pytest.mark.parametrize("kind", ["cage", "points of an object"])
def test_a_control_with_other_points_in_renders_moves_it_alike(kind: str, tmp_path: Path, addon_name: str):
    """A control is not seen in renders: these show what the viewport shows."""
    rig = RIGS[kind].new()
    rig.bind_at_rest(rig.methods[0])
    modifier = subdivision(rig.control, 1, 1)
    rig.deformer.auto_rebind = True
    settle()
    rig.deformer.auto_rebind = False
    points = scenes.base_points(rig.control)
    points[:, 2] += 0.3 * points[:, 0] + 0.2 * points[:, 1] ** 2
    rig.control.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    rig.control.data.update()
    shown = rig.points()
    assert off(shown, rig.rest()) > 0.1
    modifier.render_levels = 2
    assert off(render_points(rig.obj), shown) < EXACT
    modifier.render_levels = 0
    assert off(exported_points(rig.obj, tmp_path), shown) < 0.05  # less is known of the shape of the control
    modifier.render_levels = 3
    assert off(exported_points(rig.obj, tmp_path), shown) < EXACT
    path = scenes.save(tmp_path / "control.blend")
    for shape in frames_of(path, tmp_path, addon_name, rig.name):
        assert off(shape, shown) < EXACT


@pytest.mark.parametrize("kind", ["lattice", "hair"])
def test_a_control_without_faces_may_have_modifiers_in_viewports_alone(kind: str, tmp_path: Path):
    obj, control = scenes.grid_object("Plate", 5), getattr(point_objects, kind)()
    modifier = control.modifiers.new("Nodes", "NODES" if kind == "hair" else "CAST")
    modifier.show_render = False
    scenes.make_active(obj, control)
    assert bpy.ops.sinew.point_add(source="POINTS", method="mls") == {"FINISHED"}
    scenes.move_world(control, Matrix.Translation((0.0, 0.0, HEIGHT)))
    shown = scenes.evaluated_points(obj)
    assert off(shown, scenes.base_points(obj)) > 0.4
    scenes.save(tmp_path / "control.blend")
    assert off(render_points(obj), shown) < EXACT


# --- counts that change by the frame


def opened(obj: bpy.types.Object) -> None:
    """Half of the sheet and its mirror image, which a key takes apart at frame 10."""
    points = scenes.base_points(obj)
    points[:, 0] = 0.5 * (points[:, 0] + 1.0)
    obj.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    modifier = obj.modifiers.new("Mirror", "MIRROR")
    modifier.use_mirror_merge, modifier.merge_threshold = True, 1e-3
    wide = scenes.add_key(obj, "Wide", Matrix.Translation((0.1, 0, 0)) @ Matrix.Diagonal((0.9, 1, 1, 1)))
    scenes.key(wide, {1: {"value": 0.0}, 10: {"value": 1.0}})
    bpy.context.scene.frame_set(1)


def test_automatic_rebind_where_the_count_changes_by_the_frame():
    rig = bound(opened)
    rig.deformer.auto_rebind = True
    counts = set()
    for frame in (1, 10, 1, 10):
        bpy.context.scene.frame_set(frame)
        wanted = expected(rig)
        counts.add(len(wanted))
        for shape in (rig.points(), render_points(rig.obj)):
            assert off(shape, wanted) < EXACT, frame
        assert rig.deformer.status_level == "INFO"
    assert len(counts) == 2


def keyed_level(obj: bpy.types.Object) -> None:
    levels = ((1, 2), (4, 3), (10, 1))
    modifier = subdivision(obj)
    scenes.key(modifier, {frame: {"render_levels": level} for frame, level in levels})
    bpy.context.scene.frame_set(1)


@pytest.mark.parametrize("prepare", [opened, keyed_level])
def test_renders_whose_count_changes_by_the_frame(prepare: Change):
    """Also without Automatic Rebind, which is about the viewport."""
    rig, scene = bound(prepare), bpy.context.scene
    scene.frame_start, scene.frame_end, scene.frame_step = 1, 10, 3
    for frame, shapes in zip((1, 4, 7, 10), render(animation=True), strict=True):
        scene.frame_set(frame)
        assert off(shapes[rig.name], expected(rig)) < EXACT, frame


# --- where it cannot be


def test_what_a_render_cannot_show_is_said(capfd: pytest.CaptureFixture, monkeypatch: pytest.MonkeyPatch):
    """The other object of a Boolean is in Edit Mode, where it cannot be looked at."""
    # Once a picture was drawn, a graphics card subdivides what is in Edit Mode, and a Boolean goes without.
    monkeypatch.setattr(bpy.context.preferences.system, "use_gpu_subdivision", False)
    rig = scenes.Rig.plate(5)
    level = boolean(rig.obj)
    rig.bind()
    rig.lift(HEIGHT)
    with scenes.in_mode(level.id_data):
        level.render_levels = 2
        capfd.readouterr()
        render_points(rig.obj)
        assert any(line.startswith("In the render: Topology changed") for line in notes_of(rig.deformer))
        assert f"{rig.deformer.name}: In the render: Topology changed" in capfd.readouterr().out
    render_points(rig.obj)
    assert not any("render" in line for line in notes_of(rig.deformer))
