# SPDX-License-Identifier: GPL-3.0-or-later
"""What a button refuses, it refuses in words, and all that was seen and listed stays as it was."""

import math
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from baking import stretch_time
from editing import centre
from mathutils import Matrix
from registry import BY_ID, GRABBING, ON_HANDLE_POINTS, WITH_HANDLES
from rigs.cages import ball, box
from rigs.point_objects import curve_object, text
from rigs.puppets import figure
from rigs.rig import (
    Rig,
    add_armature,
    add_regions,
    grid_object,
    linked,
    make_active,
    new_empty,
    new_object,
    press,
    refused,
    subdivided,
)
from rigs.rig_of_curves import polyline
from seen import assert_seen, seen
from test_undo_of_buttons import (
    BAKE,
    FILE,
    FRONT,
    LINE,
    add_left_side,
    draggable,
    in_an_automatic_cage,
    on,
    on_plate,
    posed,
    selected,
    two_of_one_topology,
    with_a_stroke,
    with_keys,
    with_nameless_sides,
)

NAN = math.nan
Spoil = Callable[[bpy.types.Object], object]  # what is done to the active object before the button is pressed
BOUND = posed()


def row(said: str, prepare: Callable, spoil: Spoil | None = None, **options: object):
    """The words that a button refuses with, the scene that it is pressed in, and its options."""
    return said, prepare, spoil, options


# The scenes. Each leaves active what the button is pressed on.


def with_an_empty() -> None:
    make_active(grid_object(), new_empty("Empty"))


def bound_for_surfaces() -> None:
    make_active(on_plate("deformer_add", method="arap").obj, new_empty("Empty"))


def with_points() -> None:
    make_active(grid_object(), new_object("Points", [(-1, -1, 0.2), (1, -1, 0), (1, 1, -0.3), (-1, 1, 0.4)]))


def no_vertices() -> None:
    obj = new_object("Nothing", [])
    obj.vertex_groups.new(name="Group")
    make_active(obj)


def bound_behind(modify: Spoil) -> Callable[[], None]:

    def prepare() -> None:
        plate = Rig.plate()
        modify(plate.obj)
        plate.bind().lift(0.5)
        make_active(plate.obj)

    return prepare


def dragged() -> None:
    plate = grid_object(cells=12)
    draggable()()
    make_active(plate)


def two_in_one_cage() -> None:
    body, suit = ball("Body"), ball("Suit")
    make_active(body, suit)
    assert bpy.ops.sinew.cage_add(faces=80) == {"FINISHED"}
    make_active(body)


def stroke(places: np.ndarray) -> Callable[[], object]:
    return lambda: (polyline(places, "Stroke"), ball())


def puppet() -> None:
    make_active(figure())


def with_an_object_without_vertices() -> None:
    make_active(grid_object(), new_object("Bare", []))


def edited_beside_the_active_one() -> None:
    selected(centre)()
    bpy.context.view_layer.objects.active = new_object("Other", [(9.0, 9.0, 9.0)])


def beside_a_wire() -> None:
    """Which moves a plate that is hidden."""
    plate = grid_object()
    wire = polyline(np.array([(-1.0, 0.9, 0.3), (1.0, 0.9, 0.3)]))
    press(plate, "wire_add", curve=wire.name, radius=0.5)
    plate.hide_set(True)


def nurbs_surface() -> None:
    bpy.ops.surface.primitive_nurbs_surface_sphere_add()


def without_bones() -> None:
    make_active(linked(bpy.data.objects.new("Bare", bpy.data.armatures.new("Bare"))))


def remeshed() -> None:
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.modifiers.new("Remesh", "REMESH").mode = "BLOCKS"


def with_crossed_faces() -> None:
    """Another mesh of the same points, whose faces have their corners in another order."""
    grid = grid_object()
    faces = [(a, c, b, d) for a, b, c, d in (face.vertices for face in grid.data.polygons)]
    make_active(grid, new_object("Crossed", [vertex.co[:] for vertex in grid.data.vertices], faces))


# What is in the way.


def sets(path: str, value: object) -> Spoil:
    """A property of the active object."""
    owner, _dot, name = path.rpartition(".")
    return lambda obj: setattr(obj.path_resolve(owner) if owner else obj, name, value)


def of(name: str, spoil: Spoil) -> Spoil:
    """To another object."""
    return lambda _obj: spoil(bpy.data.objects[name])


def each(*spoils: Spoil) -> Spoil:
    return lambda obj: [spoil(obj) for spoil in spoils]


def beside(make: Callable, *arguments: object) -> Spoil:
    return lambda _obj: make(*arguments)


def has_a(method: str) -> Spoil:
    return lambda obj: press(obj, "deformer_add", method=method)


def has_an_empty_group(obj: bpy.types.Object) -> None:
    obj.vertex_groups.new(name="Empty")


def has_a_key(obj: bpy.types.Object) -> None:
    obj.shape_key_add(name="Basis")


def has_two_keys(obj: bpy.types.Object) -> None:
    has_a_key(obj)
    obj.shape_key_add(name="Bent")


def unbound(obj: bpy.types.Object) -> None:
    press(obj, "unbind")


def shares_its_mesh(obj: bpy.types.Object) -> None:
    linked(bpy.data.objects.new("Other", obj.data))


def baked(obj: bpy.types.Object) -> None:
    press(obj, "bake", **BAKE)


def baked_to_a_file(obj: bpy.types.Object) -> None:
    press(obj, "bake", **BAKE | {"target": "PC2", "filepath": str(Path(bpy.app.tempdir) / "baked.pc2")})


def shows_an_error(obj: bpy.types.Object) -> None:
    obj.sinew.active.auto_rebind = False
    obj.data.vertices.add(1)
    obj.data.update()


def has_an_edited_cage(obj: bpy.types.Object) -> None:
    cage = obj.sinew.active.cage
    cage.data.vertices[0].co.x += 0.1
    cage.data.update()
    press(obj, "cage_set_rest")


def has_its_cage_in_edit_mode(obj: bpy.types.Object) -> None:
    make_active(obj.sinew.active.cage)
    bpy.ops.object.mode_set(mode="EDIT")


def lift(obj: bpy.types.Object) -> None:
    obj.location.z += 0.5


def in_no_scene(obj: bpy.types.Object) -> None:
    bpy.context.scene.collection.objects.unlink(obj)


def has_no_selected_edges(obj: bpy.types.Object) -> None:
    for edge in obj.data.edges:
        edge.select = False


def on_two(obj: bpy.types.Object) -> None:
    press(obj, "deformer_add", method="arap")


def built_up(obj: bpy.types.Object) -> None:
    """Vertices come and go by the frame."""
    build = obj.modifiers.new("Build", "BUILD")
    build.frame_start, build.frame_duration = 1.0, 6.0
    bpy.ops.object.modifier_move_to_index(modifier="Build", index=0)


def lopsided(obj: bpy.types.Object) -> None:
    for vertex in obj.data.vertices:
        vertex.co.z += 3.0 * (vertex.co.x < -0.1)


def two_bound(obj: bpy.types.Object) -> None:
    add_regions(obj, "arap", {"Top": "HANDLE"})


TOP = {"vertex_group": "Top"}
STRETCHED = sets('pose.bones["lower.L"].scale', (1.0, 2.0, 1.0))
UPRIGHT = sets('data.bones["chest"].use_inherit_rotation', False)
FINE, HIDDEN = of("Other", subdivided), of("Other", lambda obj: obj.hide_set(True))
DRAG = {"origin": (0.0, 0.0, 5.0), "value": (0.0, 0.0, 0.5), "radius": 0.25}
ASIDE = DRAG | {"origin": (5.0, 5.0, 5.0)}
HAND = {"bone": "hand.L", "value": (0.0, 0.0, 0.1)}
UP = {"value": (0.0, 0.0, 1.0)}
SKETCH = {"stroke": "Stroke", "view": FRONT}
KEYS = {"target": "SHAPE_KEYS"}
BEYOND_NUMBERS = (
    {"value": (NAN, 0.0, 0.0)},
    {"value": (3e38, 3e38, 3e38)},
    {"mode": "ROTATE", "angle": 1.0, "axis": (NAN, 0.0, 0.0)},
    {"mode": "RESIZE", "scale": (NAN, 1.0, 1.0)},
)

CAGE = in_an_automatic_cage(80)
REFUSALS = {
    "handle_add": [
        row("Nothing is selected", selected(lambda point: False)),
        row("select vertices in Edit Mode", grid_object),
        row("no vertex group 'Nothing'", Rig.plate, vertex_group="Nothing"),
        row("cannot control itself", selected(lambda point: True), control_object="Plate"),
        row("no object 'Nobody'", Rig.plate, **TOP, control_object="Nobody"),
        row("no bone 'arm'", Rig.plate, beside(new_empty, "Arm"), **TOP, control_object="Arm", bone="arm"),
        row("'Empty' has no vertices", BOUND, has_an_empty_group, vertex_group="Empty"),
        *(
            row("The mesh has no vertices", no_vertices, has_a(method), vertex_group="Group")
            for method in WITH_HANDLES
        ),
    ],
    "handle_remove": [row("there is no number 7", BOUND, index=7)],
    "deformer_remove": [row("there is no number 7", BOUND, index=7)],
    "select_handle": [
        row("no bone 'hand'", BOUND, sets("sinew.deformers[0].handles[0].bone", "hand"), index=0),
    ],
    "handle_mirror": [
        row("no counterpart", posed(add_left_side), weights_only=True),
        row("not symmetrical", posed(add_left_side), lopsided),
        row("not symmetrical", with_nameless_sides, lopsided),
    ],
    "reset_pose": [
        row("no control that has a rest", grid_object, on_two),
        row("No control is selected", BOUND, selected=True),
    ],
    "key_pose": [row("no control to key", grid_object, on_two)],
    "bind": [row("Make Handle", grid_object, on_two)],
    "point_add": [
        row("Smooth Points", bound_for_surfaces, source="SELECTED", method="rbf"),
        row("no segments - choose Rigid Points", with_points, source="POINTS", method="rbf", segments=True),
        row("those whose points are handles", with_an_empty, source="POINTS"),
    ],
    "cage_add": [
        row("has no points", lambda: make_active(curve_object())),
        row("has no points", text, sets("data.body", "")),
    ],
    "cage_faces": [
        row("is posed", CAGE, lambda obj: lift(obj.sinew.active.cage), faces=30),
        row("was edited", CAGE, has_an_edited_cage, faces=30),
        row("was edited", CAGE, lambda obj: obj.sinew.active.cage.shape_key_add(), faces=30),
        row("shares its mesh", CAGE, lambda obj: shares_its_mesh(obj.sinew.active.cage), faces=30),
        row("is in Edit Mode", CAGE, has_its_cage_in_edit_mode, faces=30),
        row("was not made by Wrap in a Cage", on("cage"), faces=30),
        row("pose of Suit", two_in_one_cage, of("Suit", lift), faces=30),
        row("moves Suit as well", two_in_one_cage, of("Suit", in_no_scene), faces=30),
    ],
    "lattice_add": [
        row("has no points", no_vertices),
        row("is no lattice", with_an_empty, source="OBJECT", lattice="Empty"),
    ],
    "wire_add": [
        row("Select the curves", grid_object),
        row("Empty is no wire - a wire is a curve object", with_an_empty, curve="Empty"),
        row("Plate cannot be its own", grid_object, curve="Plate"),
        row("There is no object 'Nothing'", grid_object, curve="Nothing"),
    ],
    "morph": [
        row("was only reshaped", lambda: make_active(grid_object(), box())),
        row("other vertices", with_crossed_faces),
        row("not finite", two_of_one_topology, of("Other", sets("data.vertices[3].co", (NAN, 0, 0)))),
        row("There is no object", two_of_one_topology, target="Nobody"),
    ],
    "transfer_deformation": [
        row("empty", two_of_one_topology, **FILE | {"frame_start": 5}),
        row("faces of the target have other vertices", with_crossed_faces, **FILE),
        row("make .* vertices of its .* - switch", two_of_one_topology, FINE, **FILE),
        row("is hidden", two_of_one_topology, HIDDEN, **FILE, source="Other"),
        row("convert it to a mesh", with_an_empty, **FILE),
        row("no vertices", with_an_object_without_vertices, **FILE),
        row("There is no object Nobody", two_of_one_topology, **FILE, source="Nobody"),
        row("Save the file first", two_of_one_topology),
    ],
    "drag": [
        row("There is nothing to drag at this place", grid_object, **ASIDE),
        *(
            row("nothing to drag at this place", grid_object, **ASIDE, method=method)
            for method in ON_HANDLE_POINTS
            if not BY_ID[method].wraps
        ),
        row("no direction", grid_object, **DRAG, direction=(0.0, 0.0, 0.0)),
        row("not a finite number", grid_object, **DRAG | {"value": (NAN, 0.0, 0.0)}),
        row("convert it to a mesh|There is nothing to drag", nurbs_surface, **DRAG),
        row("Go to Object Mode", selected(centre), **DRAG),
        row("is hidden - show it", dragged, sets("modifiers[0].show_viewport", False), **DRAG),
        row("switch Live on", dragged, sets("sinew.deformers[0].live", False), **DRAG),
        row("New Control", dragged, of("Plate Handle", lambda obj: bpy.data.objects.remove(obj)), **DRAG),
        row("press Bind first", dragged, unbound, **DRAG),
        row("shows an error", dragged, shows_an_error, **DRAG),
        row("make a new mesh", remeshed, **DRAG),
        row("belongs to Base, which stays", BOUND, **DRAG | {"origin": (0.0, -0.9, 5.0)}),
        row("is in Edit Mode", edited_beside_the_active_one, **DRAG),
        row("nothing to drag", beside_a_wire, **DRAG | {"origin": (1.0, 0.9, 5.0)}, method="inverse_ffd"),
    ],
    "drag_press": [row("3D Viewport", grid_object)],
    "drag_start": [row("Object Mode or Pose Mode", selected(centre))],
    "control_drag": [
        row("there is no number 99", on("cage"), control="Cage", point=99),
        row("has shape keys", on("cage"), of("Cage", has_two_keys), control="Cage", point=1),
    ],
    "grab_region": [
        row("Go to Edit Mode", grid_object),
        row("Nothing is selected - select the vert", selected(lambda point: False), **UP),
        row("scaled to zero", selected(centre), sets("scale", (1.0, 1.0, 0.0)), **UP),
        *(
            row("finite", selected(centre), sets("scale", [1e-3] * 3), radius=0.4, method=method, **motion)
            for method in GRABBING
            for motion in BEYOND_NUMBERS
        ),
    ],
    "puppet_pose": [
        row("Figure has no bone 'tail'", puppet, **HAND | {"bone": "tail"}),
        row("There is no object 'Nobody'", puppet, **HAND, armature="Nobody"),
        row("not a finite number", puppet, **HAND | {"value": (NAN, 0.0, 0.0)}),
        row("Scaled bones cannot be posed: lower.L", puppet, STRETCHED, **HAND),
        row("do not inherit rotation cannot be posed: chest", puppet, UPRIGHT, **HAND),
        row("Balance needs something to stand on", puppet, **HAND, balance=True),
        row("Bare has no bones - add some in Edit Mode", without_bones, **UP),
        row("Select an armature", grid_object, **UP),
    ],
    "silhouette_sketch": [
        row("There is no silhouette near", stroke(LINE + (9.0, 0.0, 0.0)), **SKETCH),
        row("too short", stroke(0.0 * LINE), **SKETCH),
        row("stroke is too short", stroke(LINE[:1]), **SKETCH),
        row("not a finite number", stroke(NAN * LINE), **SKETCH),
        row("is a mesh object - choose a curve", lambda: (grid_object("Stroke"), ball()), **SKETCH),
        row("no camera", with_a_stroke, stroke="Stroke"),
        row("scaled to zero", with_a_stroke, **SKETCH | {"view": Matrix.Scale(0.0, 4)}),
        row("not a number", with_a_stroke, **SKETCH | {"view": Matrix.Diagonal((NAN, 1, 1, 1))}),
        row("There is no object Nothing", with_a_stroke, **SKETCH | {"stroke": "Nothing"}),
        row("There is no stroke", with_a_stroke, view=FRONT),
        row("No edges are selected", with_a_stroke, has_no_selected_edges, **SKETCH, line="EDGES"),
        row("invalid coordinates", with_a_stroke, sets("data.vertices[3].co", (NAN, 0.0, 0.0)), **SKETCH),
        row("poll", with_a_stroke, of("Stroke", make_active), **SKETCH),
        row("no shape key Nothing", with_a_stroke, **SKETCH, shape_key="Nothing"),
        row("no shape key Basis", with_a_stroke, has_a_key, **SKETCH, shape_key="Basis"),
        row(
            "has no faces",
            with_a_stroke,
            lambda obj: make_active(new_object("Point", [(0.0, 0.0, 0.0)])),
            **SKETCH,
        ),
    ],
    "apply": [
        row("single-user", BOUND, shares_its_mesh),
        row("single-user", BOUND, shares_its_mesh, as_shape_key=True),
        row("Subdivision made - apply those first", bound_behind(subdivided)),
        row("Subdivision made - apply those first", bound_behind(subdivided), as_shape_key=True),
        row("Unbake", BOUND, baked_to_a_file),
        row("switched off", BOUND, sets("modifiers[0].show_viewport", False)),
    ],
    "bake": [
        row("single-user", BOUND, shares_its_mesh, **KEYS),
        row("Solo", BOUND, each(has_a_key, sets("show_only_shape_key", True)), **KEYS),
        row("absolute", BOUND, each(has_a_key, sets("data.shape_keys.use_relative", False)), **KEYS),
        row("Armature comes before .* bake to PC2", bound_behind(add_armature), **KEYS),
        row("Subdivision.*PC2", bound_behind(subdivided), **KEYS),
        row("no room between keyframes", BOUND, lambda _obj: stretch_time(1, 200), **KEYS),
        row("empty", BOUND, **KEYS, frame_start=5, frame_end=3),
        row("hidden", BOUND, sets("hide_viewport", True), **KEYS),
        row("off in the viewport", BOUND, sets("modifiers[0].show_viewport", False), **KEYS),
        row("press Bind", BOUND, unbound, **KEYS),
        row("One file", BOUND, two_bound, target="PC2", **FILE, all_deformers=True),
        row(r"Frame \d: ", BOUND, built_up, target="PC2", **FILE),
        row("Save the file first", BOUND, target="PC2"),
        row("Save the file first", BOUND, target="PC2", filepath="//cache/plate.pc2"),
        row("Cannot write .*plate", BOUND, target="PC2", filepath=f"{__file__}/in-no-folder/plate.pc2"),
    ],
    "unbake": [row("single-user", BOUND, each(baked, shares_its_mesh))],
    "key_add": [
        row("is not bound - press Bind first", with_keys, unbound),
        row("is not live", with_keys, sets("sinew.deformers[0].live", False)),
    ],
    "key_remove": [row("has 2 keys, .* there is no number 5", with_keys, index=5)],
}


@pytest.mark.parametrize(
    ("operator", "said", "prepare", "spoil", "options"),
    [
        pytest.param(operator, *rest, id=f"{operator}: {rest[0]}")
        for operator, rows in REFUSALS.items()
        for rest in rows
    ],
)
def test_a_button_says_why_it_does_nothing_and_changes_nothing(
    operator: str, said: str, prepare: Callable[[], object], spoil: Spoil | None, options: dict
):
    prepare()
    if spoil is not None:
        spoil(bpy.context.object)
    before, frame, files = seen(), bpy.context.scene.frame_current, files_made()
    refused(said, operator, **options)
    assert_seen(before)
    assert (bpy.context.scene.frame_current, files_made()) == (frame, files)


def files_made() -> list[Path]:
    return sorted(Path(bpy.app.tempdir).rglob("*"))
