# SPDX-License-Identifier: GPL-3.0-or-later
"""Undo and redo of every button: one step, which takes back and brings again all that was seen and listed.

What it has made is in the saved file, too.
"""

import math
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from baking import CACHES
from editing import centre, edit
from mathutils import Matrix, Vector
from registry import BY_ID, ON_HANDLE_POINTS
from rigs import rig as scenes
from rigs.cages import ball, box, place, surround
from rigs.kinds import RIGS
from rigs.point_objects import cage_around, lattice
from rigs.puppets import standing
from rigs.rig_of_curves import polyline, stroke_through
from seen import assert_seen, seen
from situations import cage_inside_out, lost_control

LINE = np.column_stack((np.linspace(-1.0, 1.0, 6), np.zeros((6, 2))))
UP = [(0.0, 0.0, 0.1 * k) for k in range(5)]


def run(operator: str, **options: object) -> None:
    """As a button does: with its own undo step."""
    assert getattr(bpy.ops.sinew, operator)("EXEC_DEFAULT", True, **options) == {"FINISHED"}


def button(operator: str, **options: object) -> Callable[[], None]:
    return lambda: run(operator, **options)


# The scenes. Each leaves active what the button is pressed on.


def on_plate(operator: str, **options: object) -> scenes.Rig:
    plate = scenes.Rig(scenes.grid_object())
    scenes.press(plate.obj, operator, **options)
    scenes.make_active(plate.obj)
    return plate


def posed(then: Callable[[scenes.Rig], object] = lambda plate: None) -> Callable[[], None]:
    """A bound plate that is lifted, after something else."""

    def prepare() -> None:
        plate = lifted("thin_shell")
        then(plate)
        scenes.make_active(plate.obj)
        plate.obj.sinew.active_deformer = 0

    return prepare


def after(operator: str, **options: object) -> Callable[[], None]:
    return posed(lambda plate: scenes.press(plate.obj, operator, **options))


def add_middle(plate: scenes.Rig) -> None:
    scenes.add_group(plate.obj, "Middle", lambda point: abs(point[1]) < 0.15)


def add_left_side(plate: scenes.Rig) -> None:
    scenes.add_group(plate.obj, "Side.L", lambda point: point[0] > 0.75 and abs(point[1]) < 0.3)
    scenes.press(plate.obj, "handle_add", kind="FIXED", vertex_group="Side.L")


def let_the_handle_give_way() -> None:
    bpy.data.objects["Plate"].sinew.active.handles[0].weight = 0.25
    scenes.push("softer")


def add_loose_vertex(plate: scenes.Rig) -> None:
    plate.obj.data.vertices.add(1)
    scenes.press(plate.obj, "bind")


def let_regions_overlap(plate: scenes.Rig) -> None:
    """Base takes a vertex of Top, which refuses the bind."""
    plate.obj.vertex_groups["Base"].add([int(plate.top[0])], 1.0, "REPLACE")
    scenes.refused("share 1 vertex", "bind", plate.obj)


def with_another_file() -> None:
    """A plate that plays a file, beside which there is one with other shapes."""
    after("bake", target="PC2", **FILE)()
    played = Path(bpy.path.abspath(bpy.context.object.sinew.active.bake.filepath)).read_bytes()
    points = np.frombuffer(played[32:], dtype="<f4") + np.float32(0.25)  # behind the header of a PC2
    Path(FOUND).write_bytes(played[:32] + points.tobytes())


def on(kind: str) -> Callable[[], None]:
    """A rig of this kind, posed."""

    def prepare() -> None:
        rig = RIGS[kind].new().start()
        rig.lift(0.2)
        scenes.make_active(rig.obj)

    return prepare


def in_an_automatic_cage(faces: int) -> Callable[[], None]:
    def prepare() -> None:
        target = ball()
        scenes.press(target, "cage_add", faces=faces)
        scenes.make_active(target)

    return prepare


def send_the_cage_nowhere() -> None:
    place(bpy.data.objects["Cage"], [(math.nan,) * 3] * 8)
    scenes.push("lost")


def a_lattice_in_a_box() -> None:
    """Its shape key shows what moves it."""
    obj = lattice()
    cage_around(obj)
    scenes.make_active(obj)


def a_caged_lattice() -> None:
    a_lattice_in_a_box()
    scenes.press(bpy.context.object, "cage_add", source="OBJECT", cage="Cage")
    bpy.data.objects["Cage"].location.z = 1.0
    scenes.make_active(bpy.data.objects["Lattice"])


def a_figure() -> None:
    scenes.make_active(standing())


def a_fine_grid() -> None:
    scenes.grid_object(cells=20)


def draw_a_wire() -> None:
    run("wire_draw", points=5, stroke=stroke_through(LINE[1:-1]))


def a_curve() -> None:
    polyline(LINE, "Wire")
    scenes.grid_object()


def lifted(method: str) -> scenes.Rig:
    plate = scenes.Rig.plate().bind(method)
    plate.lift(0.5)
    scenes.make_active(plate.obj)
    return plate


def with_grid() -> None:
    scenes.make_active(lifted("spline_surface").obj)
    run("grid_new")


def drag_a_point() -> None:
    def change(mesh) -> None:
        mesh.verts[40].co += Vector((0.1, -0.05, 0.8))

    scenes.change_in_edit_mode(bpy.data.objects["Plate"].sinew.active.spline_surface.grid, change)
    scenes.push("dragged")


def two_of_one_topology() -> None:
    other = scenes.grid_object("Other")
    other.data.transform(Matrix.Translation((0.3, 0.0, 0.8)))
    scenes.make_active(scenes.grid_object(), other)


def with_keys() -> None:
    plate = scenes.Rig.plate()
    sway = scenes.add_key(plate.obj, "Sway", scenes.slope(y=0.5))
    scenes.key(sway, {1: {"value": 0.0}, 20: {"value": 1.0}})
    plate.bind("mesh_sequence")
    for frame in (1, 10):
        bpy.context.scene.frame_set(frame)
        scenes.move_world(plate.control, Matrix.Translation((0.0, 0.0, 0.5)))
        scenes.press(plate.obj, "key_add")


def with_an_edit() -> None:
    with_keys()
    bpy.context.scene.frame_set(5)
    scenes.move_world(
        bpy.data.objects["Plate"].sinew.active.handles[0].control, Matrix.Translation((0.0, 0.2, 0.3))
    )


def with_a_preset() -> None:
    plate = lifted("thin_shell")
    for folder in bpy.utils.preset_paths("sinew/thin_shell"):
        (Path(folder) / "Undo.py").unlink(missing_ok=True)
    scenes.press(plate.obj, "preset_add", name="Undo")
    plate.deformer.parameters.stretching = 0.5


def apply_the_preset() -> None:
    (folder,) = bpy.utils.preset_paths("sinew/thin_shell")
    run("preset_apply", filepath=f"{folder}/Undo.py")


def refused_outside() -> None:
    """Two balls of which a vertex is outside of their common cage, which is posed."""
    cage = box()
    for name in ("Suit", "Body"):
        obj = ball(name)
        obj.data.vertices[3].co.z = 5.0
        surround(obj, cage, "harmonic")
    cage.location.z = 0.5
    scenes.make_active(obj)


def allowed_outside() -> None:
    refused_outside()
    run("cage_outside_follow")


def with_a_stroke() -> None:
    angles = np.linspace(-1.0, 1.0, 61)
    radii = 0.6 + 0.2 * np.cos(0.5 * math.pi * angles)
    polyline(np.column_stack((radii * np.cos(angles), np.full(61, -3.0), radii * np.sin(angles))), "Stroke")
    ball()


def selected(where: Callable) -> Callable[[], object]:
    return lambda: edit(scenes.grid_object(), where)


def selected_on_a_target() -> None:
    posed()()
    edit(bpy.context.object, centre)


def with_nameless_sides() -> None:
    """A handle on the left, whose name does not say so."""
    obj = scenes.grid_object()
    left = [vertex.index for vertex in obj.data.vertices if vertex.co.x > 0.7 and vertex.co.y < -0.7]
    obj.vertex_groups.new(name="Foot").add(left, 1.0, "REPLACE")
    scenes.add_regions(obj, "thin_shell", {"Foot": "HANDLE"})


def with_a_bent_bone() -> None:
    plate = scenes.Rig.plate()
    scenes.add_armature(plate.obj).pose.bones["high"].rotation_euler.x = 1.0
    plate.bind("thin_shell").lift()
    scenes.make_active(plate.obj)


def draggable(method: str = "") -> Callable[[], None]:
    options = {"method": method} if method else {}
    return button("drag", origin=(0.0, 0.0, 5.0), value=(0.0, 0.0, 0.5), radius=0.25, reach=2.0, **options)


FRAMES = {"frame_start": 1, "frame_end": 2}
BAKE = {"target": "SHAPE_KEYS", **FRAMES}
FOUND = f"{bpy.app.tempdir}found.pc2"
FILE = {"filepath": f"{bpy.app.tempdir}undone", **FRAMES}
GRAB = {"value": (0.0, 0.0, 0.5), "radius": 0.4}
FRONT = Matrix.Rotation(math.radians(90.0), 4, "X")  # a camera that looks along y
BUTTONS: dict[str, tuple[Callable[[], object], Callable[[], None]]] = {
    "start_task": (scenes.grid_object, button("start_task", task="sheet")),
    "use_method": (posed(), button("use_method", method="arap")),
    "deformer_add": (posed(), button("deformer_add", method="thin_shell")),
    "deformer_remove": (posed(), button("deformer_remove")),
    "deformer_move": (
        after("deformer_add", method="arap"),
        button("deformer_move", direction="DOWN", index=0),
    ),
    "cage_add": (posed(lambda _plate: box(size=6.0)), button("cage_add", source="OBJECT", cage="Cage")),
    "cage_set_rest": (on("cage"), button("cage_set_rest")),
    "cage_flip": (cage_inside_out, button("cage_flip")),
    "cage_faces": (in_an_automatic_cage(60), button("cage_faces", faces=30)),
    "a cage sent nowhere": (on("cage"), send_the_cage_nowhere),
    "cage_add around a lattice": (a_lattice_in_a_box, button("cage_add", source="OBJECT", cage="Cage")),
    "deformer_remove of a lattice": (a_caged_lattice, button("deformer_remove")),
    "handle_add": (posed(add_middle), button("handle_add", kind="FIXED", vertex_group="Middle")),
    "handle_remove": (posed(), button("handle_remove", index=1)),
    "weights of a handle": (posed(), let_the_handle_give_way),
    "handle_move": (posed(), button("handle_move", direction="DOWN", index=0)),
    "handle_mirror": (posed(add_left_side), button("handle_mirror", side="LEFT_TO_RIGHT")),
    "bind": (after("unbind"), button("bind")),
    "unbind": (posed(), button("unbind")),
    "apply": (posed(), button("apply")),
    "bake": (posed(), button("bake", **BAKE)),
    "unbake": (after("bake", **BAKE), button("unbake")),
    **{f"bake to {target}": (posed(), button("bake", target=target, **FILE)) for target in CACHES},
    "unbake of a file": (after("bake", target="PC2", **FILE), button("unbake")),
    "bake_find": (with_another_file, button("bake_find", filepath=FOUND)),
    "transfer_deformation": (two_of_one_topology, button("transfer_deformation", **FILE)),
    "repair": (posed(add_loose_vertex), button("repair")),
    "cure": (posed(add_loose_vertex), button("cure", what="loose")),
    "select_unusual": (posed(), button("select_unusual", what="border")),
    "measure_curvature": (posed(), button("measure_curvature")),
    "remesh": (posed(), button("remesh")),
    "decimate": (posed(), button("decimate")),
    "remesh_semi_regular": (posed(), button("remesh_semi_regular", levels=1)),
    "remove_needles": (posed(), button("remove_needles", ratio=1.3)),
    "fast_subdivision": (posed(), button("fast_subdivision")),
    "end of fast_subdivision": (after("fast_subdivision"), button("fast_subdivision", stop=True)),
    "part_regions": (posed(let_regions_overlap), button("part_regions")),
    "select_handle": (posed(), button("select_handle", index=0)),
    "select_problems": (posed(let_regions_overlap), button("select_problems")),
    "select_distorted": (posed(), button("select_distorted")),
    "drag of a handle": (posed(), button("drag", origin=(0.0, 0.9, 5.0), value=(0.0, 0.0, -0.5))),
    "lattice_add": (scenes.grid_object, button("lattice_add", resolution=(3, 3, 2))),
    "lattice_set_rest": (on("lattice"), button("lattice_set_rest")),
    "wire_add": (a_curve, button("wire_add", curve="Wire", radius=0.6)),
    "wire_draw": (scenes.grid_object, draw_a_wire),
    "control_remove": (on("curves"), button("control_remove", index=0)),
    "control_set_rest": (on("curves"), button("control_set_rest")),
    "tool_add": (scenes.grid_object, button("tool_add", tool="twist")),
    "reset_pose": (posed(), button("reset_pose")),
    "reset_pose of a cage": (on("cage"), button("reset_pose")),
    "reset_pose of a lattice": (on("lattice"), button("reset_pose")),
    "reset_pose of a wire": (on("curves"), button("reset_pose")),
    "reset_pose of a tool": (on("tools"), button("reset_pose")),
    "key_pose": (posed(), button("key_pose")),
    "drive_by_bone": (with_a_bent_bone, button("drive_by_bone", angle=2.0)),
    "control_drag": (on("cage"), button("control_drag", control="Cage", point=3, value=(0.2, 0.1, 0.3))),
    "reach_drag": (on("curves"), button("reach_drag", length="radius", value=0.9)),
    "drag of a place": (posed(), button("drag", origin=(0.0, 0.0, 5.0), value=(0.0, 0.0, 0.4), places=True)),
    "tool_stop": (on("tools"), button("tool_stop")),
    "tool_drag": (scenes.grid_object, lambda: run("tool_drag", radius=0.8, path=stroke_through(UP))),
    "point_add": (scenes.grid_object, button("point_add", source="CURSOR")),
    "grid_new": (lambda: lifted("spline_surface"), button("grid_new")),
    "a point of the grid": (with_grid, drag_a_point),
    "morph": (two_of_one_topology, button("morph")),
    "curve_edit": (lambda: lifted("propagation"), button("curve_edit", parameter="transfer")),
    "key_add": (with_an_edit, button("key_add")),
    "key_move": (with_keys, button("key_move", index=1, frame=5)),
    "key_remove": (with_keys, button("key_remove", index=1)),
    "preset_apply": (with_a_preset, apply_the_preset),
    "use_template": (posed(), button("use_template", template="rubber")),
    "try_it": (scenes.grid_object, button("try_it", rig="lines")),
    "try_it beside another rig": (button("try_it", rig="limb"), button("try_it", rig="joint")),
    "try_back": (button("try_it", rig="limb"), button("try_back")),
    "control_new": (lost_control, button("control_new")),
    "cage_outside_follow": (refused_outside, button("cage_outside_follow")),
    "settings_share": (allowed_outside, button("settings_share")),
    "puppet_pose": (a_figure, button("puppet_pose", bone="hip", value=(0.0, 0.0, -0.3))),
    "silhouette_sketch": (with_a_stroke, button("silhouette_sketch", stroke="Stroke", view=FRONT)),
    "handle_add in Edit Mode": (selected(lambda point: point.y > 0.75), button("handle_add", kind="HANDLE")),
    "grab_region": (selected(centre), button("grab_region", **GRAB)),
    "grab_region on a target": (selected_on_a_target, button("grab_region", **GRAB)),
    "handle_mirror that names both sides": (with_nameless_sides, button("handle_mirror")),
    "drag": (scenes.grid_object, draggable()),
    **{
        f"drag by {method}": (a_fine_grid, draggable(method))
        for method in ON_HANDLE_POINTS
        if not BY_ID[method].wraps
    },
}


@pytest.mark.parametrize("name", BUTTONS)
def test_undo_and_redo_of(name: str, tmp_path: Path):
    prepare, press_it = BUTTONS[name]
    prepare()
    scenes.push("prepared")
    before = seen()
    press_it()
    after = seen()
    with pytest.raises(AssertionError):  # it changes something
        assert_seen(before)
    for _ in range(2):
        bpy.ops.ed.undo()
        assert_seen(before)
        bpy.ops.ed.redo()
        assert_seen(after)
    if bpy.context.mode == "EDIT_MESH":
        bpy.ops.object.mode_set(mode="OBJECT")
        after = seen()
    scenes.reopen(tmp_path / "made.blend")
    assert_seen(after)
