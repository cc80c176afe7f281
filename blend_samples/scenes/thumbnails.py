# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of the browser: one for each method and task, in one light, written into the add-on."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from math import radians
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

from .. import denoise, markers, materials, posing, studio
from ..comparison import CASES, native_solve
from ..lineup import POSE_FRAME
from ..lineups import LINEUPS, cows
from ..models import spot
from ..models.objects import mesh_object
from ..models.shapes import smoothstep
from . import elbow, longship, mesh_sequence

PICTURES = Path(__file__).parents[2] / "addon" / "pictures"
SIZE = 128  # pixels
FINER = 2  # times as large is rendered
SAMPLES = 40
GREY = (0.30, 0.30, 0.31)
CLAY = (0.62, 0.60, 0.56)
BAND = (0.16, 0.20, 0.26)
HIP, SWING = 2.1, 62.0  # the height where legs begin; by which angle one of them swings
LEGS = (-0.72, -0.07, 0.07, 0.72)  # where their sides are
SIDES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))  # of a box
IN_A_ROW = 8  # on the sheet of all of them

Shown = Sequence[bpy.types.Object]  # what fills the picture


@dataclass(frozen=True)
class Subject:
    """What a picture shows: ``build`` fills the empty scene; the camera looks from above by ``elevation``.
    ``aim`` is what part of the height of the objects is seen, from 0 at their feet to 1."""

    build: Callable[[], Shown]
    elevation: float = 12.0
    frame: int = POSE_FRAME
    aim: tuple[float, float] = (0.0, 1.0)


def of_case(name: str, method: str, **options: object) -> Shown:
    """A case of the comparison, solved by a method: clay, with its handle and what holds still."""
    case = CASES[name]()
    shape = native_solve(posing.registry(), posing.native(), method, **options)(case)
    slots = np.zeros(len(case.triangles), int)
    for slot, handle in enumerate(case.handles, 1):
        slots[np.isin(case.triangles, handle).all(axis=1)] = slot
    obj = mesh_object(name, shape, case.triangles, smooth=name != "bar", slots=slots, materials=_clay())
    obj.rotation_euler.z = radians(case.heading)
    return [obj]


def of_row(sample: str, label: str, painted: bool = True) -> Shown:
    """One copy of a line-up. ``painted``: its regions get the colours of handles and of what holds still."""
    lineup = LINEUPS[sample]
    obj = lineup.build(label, 0.0) if lineup.anew else lineup.build()
    obj.rotation_euler.z += radians(lineup.heading)
    bpy.context.view_layer.update()
    lineup.row[label](obj)
    if painted:
        _paint(obj)
    if lineup.smooth:
        posing.subdivide(obj)
    return [obj]


def dragged() -> Shown:
    """The cow that is dragged far at its back and its head, with balls where it is held."""
    obj = _cow("inverse_ffd")
    cows.dragged(7, farther=2.2)(obj)
    posing.subdivide(obj)
    for ball in (obj for obj in bpy.data.objects if obj.name.endswith(" Pin")):
        for vertex in ball.data.vertices:
            vertex.co *= 2.2
    return [obj]


def _cow(sample: str) -> bpy.types.Object:
    """The cow as it stands in a line-up."""
    obj = spot.build()
    obj.rotation_euler.z = radians(LINEUPS[sample].heading)
    bpy.context.view_layer.update()
    return obj


def in_a_cage(method: str) -> Shown:
    """Two legs close to each other, of which the cage swings one: what does the other one do?"""
    points, faces = _trousers()
    bands = [_clay()[0], materials.plain_material("Band", BAND, roughness=0.6)]
    body = mesh_object("Legs", points, faces, smooth=True, materials=bands)
    posing.subdivide(body, levels=4)
    posing.make_active(body)
    bpy.ops.object.modifier_apply(modifier="Subdivision")
    for face in body.data.polygons:
        face.material_index = int(face.center.z / 0.25) % 2
    around = points * (1.1, 1.2, 1.04) - (0.0, 0.0, 0.05)
    around[(np.abs(points[:, 0]) < 0.2) & (points[:, 2] == HIP)] -= (0.0, 0.0, 0.2)  # the gap ends lower
    cage = mesh_object("Legs Cage", around, faces)
    points = posing.vertices(cage)
    posing.add_cage(body, method, source="OBJECT", cage=cage.name)
    swung = smoothstep(HIP, 0.67 * HIP, points[:, 2]) * (points[:, 0] > 0.0)
    swing = posing.Move(turn=(0.0, -SWING, 0.0), pivot=(0.4, 0.0, HIP))
    posing.add_pose(cage, "Swing", posing.blended(swing, points, swung), {1: 0.0, POSE_FRAME: 1.0})
    markers.add_cage_edges(cage, 0.03)
    posing.check_posed(body, 1, POSE_FRAME)
    return [body]


def _trousers() -> tuple[np.ndarray, list[list[int]]]:
    """The surface of a few boxes: two legs with a narrow gap, and what they hang from."""
    grid = np.stack(np.meshgrid(LEGS, (-0.33, 0.33), (0.0, 0.7, 1.4, HIP, 2.5, 2.9), indexing="ij"), axis=-1)
    place = np.arange(grid[..., 0].size).reshape(grid.shape[:3])
    boxes = [place[i : i + 2, :, k : k + 2].ravel() for i in range(3) for k in range(5) if i != 1 or k > 2]
    faces = np.array([box[list(side)] for box in boxes for side in SIDES])
    _, first, counts = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return grid.reshape(-1, 3), faces[first[counts == 1]].tolist()  # what two boxes share lies inside


def pushed() -> Shown:
    """The pillar that a drag has pushed aside, with a ball on the tool."""
    (obj,) = of_row("vector_field", "Drag", painted=False)
    bpy.context.scene.frame_set(1)
    control = obj.sinew.active.controls[-1].object
    place = control.matrix_world.translation
    markers.add_pin(control, place + Vector((0.62, 0.0, 0.0)), 0.1, place)
    return [obj]


def ship() -> Shown:
    """The ship in its lattice, whose lines are drawn."""
    parts = longship.build("One Lattice", 0.0)
    longship.pose_by_lattice(parts)
    bpy.context.scene.frame_set(POSE_FRAME)
    shown = [obj for obj in bpy.data.objects if obj.type in ("MESH", "CURVE", "FONT", "CURVES")]
    return [*shown, _lines_of(parts[0].sinew.active.controls[0].object)]


def keyed() -> Shown:
    """The frame of the swaying pillar at whose key it was edited."""
    mesh_sequence.make()
    shown = bpy.data.objects[f"Frame {mesh_sequence.KEY} edited"]
    live = next(obj for obj in bpy.data.objects if obj.sinew.deformers)
    _paint(shown, live)
    return [shown]


def half_way() -> Shown:
    """The cow between itself and its twisted twin."""
    rest, target = _cow("pyramid_coordinates"), spot.build()
    target.data = cows.twisted(rest.data)
    cows.morph(rest, target)
    posing.subdivide(rest)
    return [rest]


def corrected() -> Shown:
    """The bent elbow with its correction, and the control that rides on it."""
    elbow.make()
    last = elbow.SHOWN[-1]
    control = bpy.data.objects[f"Control {last}"]
    for frame in elbow.SHOWN[:-1]:
        for pin in bpy.data.objects[f"Control {frame}"].children:
            pin.hide_render = True
    return [bpy.data.objects[f"Frame {last} with the correction"], *control.children]


def redrawn() -> Shown:
    """The cow that two strokes have redrawn, and the strokes."""
    LINEUPS["silhouette"].make()
    cow = next(obj for obj in bpy.data.objects if obj.type == "MESH" and obj.data.shape_keys)
    strokes = [bpy.data.objects[name] for name in ("Back", "Muzzle")]
    for stroke in strokes:
        stroke.hide_render, stroke.data.bevel_depth = False, 0.025
    return [cow, *strokes]


_case, _row, _cage = (partial(partial, show) for show in (of_case, of_row, in_a_cage))

SUBJECTS: dict[str, Subject] = {
    "arap": Subject(_case("branches", "arap")),
    "subspace_laplacian": Subject(_row("reduced", "Subspace Laplacian")),
    "laplacian_editing": Subject(_case("plane", "laplacian_editing"), elevation=24.0),
    "gradient_editing": Subject(_case("cylinder", "gradient_editing")),
    "rotation_invariant_coordinates": Subject(_case("bar", "rotation_invariant_coordinates")),
    "handle_aware_isolines": Subject(_row("reduced", "Handle-Aware Isolines")),
    "hierarchical_smoothing": Subject(_case("branches", "hierarchical_smoothing")),
    "volumetric_graph_laplacian": Subject(_row("volume", "Volumetric Graph Laplacian")),
    "thin_shell": Subject(_case("plane", "thin_shell"), elevation=24.0),
    "primo": Subject(_row("prisms", "PriMo   height 0.1"), elevation=24.0),
    "thin_shell_nonlinear": Subject(_row("sheets", "Thickness 0.5 %")),
    "spline_surface": Subject(_row("spline_surface", "Degree 3, 8 x 8 points"), elevation=24.0),
    "propagation": Subject(_case("branches", "propagation")),
    "subdivision_editing": Subject(_row("pillars", "Subdivision")),
    "ffd": Subject(ship),
    "inverse_ffd": Subject(dragged),
    "mean_value": Subject(_cage("mean_value")),
    "positive_mean_value": Subject(_cage("positive_mean_value")),
    "harmonic": Subject(_cage("harmonic")),
    "green": Subject(_cage("green")),
    "mls": Subject(_row("machine", "Moving Least Squares", painted=False)),
    "rbf": Subject(_case("branches", "rbf")),
    "embedded_deformation": Subject(
        _row("embedded_deformation", "Embedded Deformation", False), aim=(0.42, 1.0)
    ),
    "rigid_cells": Subject(_row("rigid_cells", "Rigid Cells", painted=False)),
    "space_propagation": Subject(_case("branches", "space_propagation")),
    "wires": Subject(_row("wires", "Angry", painted=False), elevation=4.0, aim=(0.3, 1.0)),
    "vector_field": Subject(pushed),
    "mesh_puppetry": Subject(_row("puppet", "Hand", painted=False)),
    "mesh_sequence": Subject(keyed, frame=mesh_sequence.KEY),
    "pyramid_coordinates": Subject(half_way, frame=cows.MIDDLE_FRAME),
    "multiresolution": Subject(_row("multiresolution", "Multiresolution, Thin Shell")),
    "multiresolution_space": Subject(_row("space_details", "Multiresolution in Space")),
    "joint": Subject(corrected, frame=elbow.MADE),
    "once": Subject(redrawn, elevation=4.0, frame=1),
}


def make() -> bpy.types.Scene:
    """A scene that holds the settings; each picture is built in it anew."""
    return studio.empty_scene()


def pictures(_scene: bpy.types.Scene) -> Iterator[tuple[str, np.ndarray]]:
    """Write all pictures, and give a sheet of them."""
    PICTURES.mkdir(exist_ok=True)
    lights = [render(name) for name in SUBJECTS]
    lights += [np.ones_like(lights[0])] * (-len(lights) % IN_A_ROW)
    rows = [np.concatenate(lights[k : k + IN_A_ROW], axis=1) for k in range(0, len(lights), IN_A_ROW)]
    yield "thumbnails", np.concatenate(rows[::-1], axis=0)


def render(name: str) -> np.ndarray:
    """Write one picture; its light (height, width, 3), from below."""
    subject = SUBJECTS[name]
    studio.progress(f"the picture {name}")
    studio.empty_scene()
    shown = subject.build()
    scene = bpy.context.scene  # some samples begin with a new one
    scene.frame_set(subject.frame)
    photograph(scene, shown, subject)
    light = denoise.render_clean(scene)
    light = light.reshape(SIZE, FINER, SIZE, FINER, 3).mean(axis=(1, 3))
    denoise.write_picture(scene, light, PICTURES / f"{name}.png")
    return light


def photograph(scene: bpy.types.Scene, shown: Shown, subject: Subject) -> None:
    """Put the objects before the camera, on a grey ground, and nothing else of the scene."""
    for obj in list(studio.studio_collection(scene).objects):
        bpy.data.objects.remove(obj)
    if "Backdrop" in bpy.data.materials:
        bpy.data.materials.remove(bpy.data.materials["Backdrop"])  # of another colour
    kept = _with_markers(shown)
    seen = [_in_the_world(obj) for obj in kept if not obj.name.endswith((" Edges", " Lines"))]
    points = np.concatenate(seen)
    for obj in scene.objects:
        obj.hide_render = obj.hide_render or obj not in kept
    floor, height = points[:, 2].min(), np.ptp(points[:, 2])
    depth = 0.5 * (points[:, 1].min() + points[:, 1].max())
    low, high = (floor + share * height for share in subject.aim)
    points = points[(points[:, 2] >= low) & (points[:, 2] <= high)]
    rise = radians(subject.elevation)
    up = np.array((0.0, np.sin(rise), np.cos(rise)))
    across, along = points[:, 0], points @ up
    middle = 0.5 * np.array((across.min() + across.max(), along.min() + along.max()))
    width = float(1.2 * max(np.ptp(across), np.ptp(along)))
    target = Vector((middle[0], depth, (middle[1] - depth * up[1]) / up[2]))
    studio.add_backdrop(scene, 5.0 * width, GREY)
    scene.objects["Backdrop"].location.z = floor
    studio.add_camera(scene, target, 6.0 * width, subject.elevation, width)
    studio.add_lights(scene, target, 1.5 * width)
    studio.set_up_render(scene, SAMPLES, FINER * SIZE, FINER * SIZE)
    scene.frame_set(subject.frame)


def _lines_of(lattice: bpy.types.Object) -> bpy.types.Object:
    """The outer lines of a lattice as it is posed, as thin tubes."""
    data = lattice.data
    places = _in_the_world(lattice).reshape(data.points_w, data.points_v, data.points_u, 3)
    lines = []
    for axis in range(3):
        grid = np.moveaxis(places, axis, 2)
        outside = np.ones(grid.shape[:2], bool)
        outside[1:-1, 1:-1] = False
        lines += list(grid[outside])
    obj = posing.add_lines("Lattice Lines", lines, bevel=0.012)
    obj.data.materials.append(_clay()[2])
    return obj


def _in_the_world(obj: bpy.types.Object) -> np.ndarray:
    matrix = np.array(obj.matrix_world)
    return posing.shape(obj) @ matrix[:3, :3].T + matrix[:3, 3]


def _with_markers(shown: Shown) -> set[bpy.types.Object]:
    """The objects, and what belongs to them: pins, pads, the edges of cages, tubes along wires."""
    marks = (" Pin", " Stem", " Edges", " Tube", " Drag", "Fixed")
    marked = {obj for obj in bpy.data.objects if any(mark in obj.name for mark in marks)}
    return {*shown, *(obj for obj in marked if not obj.hide_render and obj.type != "EMPTY")}


def _clay() -> list[bpy.types.Material]:
    return [
        materials.plain_material("Clay", CLAY, roughness=0.6),
        materials.plain_material("Still", materials.FIXED_COLOUR, roughness=0.5),
        materials.plain_material("Handle", materials.HANDLE_COLOUR, roughness=0.3),
    ]


def _paint(obj: bpy.types.Object, rigged: bpy.types.Object | None = None) -> None:
    """Give the faces of regions the colours of handles and of what holds still."""
    rigged = rigged or obj
    first = len(obj.data.materials)
    for material in _clay()[1:]:
        obj.data.materials.append(material)
    slots = {"FIXED": first, "HANDLE": first + 1}
    handles = [handle for handle in rigged.sinew.active.handles if handle.kind in slots]
    painted = {rigged.vertex_groups[handle.vertex_group].index: slots[handle.kind] for handle in handles}
    rows = [(vertex.index, row.group) for vertex in rigged.data.vertices for row in vertex.groups]
    held = {vertex: painted[group] for vertex, group in rows if group in painted}
    for face in obj.data.polygons:
        found = {held.get(vertex) for vertex in face.vertices}
        if len(found) == 1 and None not in found:
            face.material_index = found.pop()
