# SPDX-License-Identifier: GPL-3.0-or-later
"""A scanned dragon of 400 loose pieces, posed by embedded deformation; the graph that moves it beside it."""

from __future__ import annotations

import importlib
from types import ModuleType

import bpy
import numpy as np
from mathutils import Vector

from . import animals, creature, materials, posing, studio
from .models.sculpt import ball

POSE_FRAME = creature.POSE_FRAME
SPACING, HEADING = 2.75, -49.0
LABELS = ("Rest", "Its Graph of 250 Nodes", "Embedded Deformation")
PIECES, SHRUNK = 400, 0.9  # each piece to this share of its size, so that gaps show
BAR, BEAD = 0.006, 0.017  # radii of what is drawn of the graph


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Embedded Deformation")
    first = animals.dragon()
    shatter(first)
    dragons = posing.line_up(first, LABELS, SPACING, HEADING)
    for dragon in dragons:
        creature.pose(dragon, "embedded_deformation" if dragon is dragons[-1] else None)
    posed = dragons[-1]
    posed.sinew.active.parameters.nodes = 250
    bpy.context.view_layer.update()
    scene.frame_set(POSE_FRAME)
    show_graph(posed, dragons[1])
    dragons[1].hide_render = True

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(-0.06, 0.0, 0.90), distance=26.0, elevation=13.0, width=8.6)
    studio.add_lights(scene, target=(0.0, 0.0, 0.9), size=10.0)
    for dragon, label in zip(dragons, LABELS):
        studio.add_label(scene, label, (dragon.location.x + 0.12, -1.75, 0.0), 0.17)
    studio.set_up_render(scene, samples=24, height=540)
    studio.open_at(scene, POSE_FRAME, posed)
    return scene


def shatter(dragon: bpy.types.Object) -> None:
    """Cut the skin into pieces that share no vertex, as scans of many parts are, and shrink each a little."""
    mesh = dragon.data
    centres = np.empty(3 * len(mesh.polygons), np.float32)
    mesh.polygons.foreach_get("center", centres)
    centres = centres.reshape(-1, 3)
    seeds = centres[np.random.default_rng(5).choice(len(centres), PIECES, replace=False)]
    piece = np.concatenate(
        [((part[:, None] - seeds) ** 2).sum(-1).argmin(1) for part in np.array_split(centres, 64)]
    )
    counts, of_corner = np.empty(len(mesh.polygons), np.int32), np.empty(len(mesh.loops), np.int32)
    mesh.polygons.foreach_get("loop_total", counts)
    mesh.loops.foreach_get("edge_index", of_corner)
    lowest, highest = np.full(len(mesh.edges), PIECES), np.full(len(mesh.edges), -1)
    np.minimum.at(lowest, of_corner, np.repeat(piece, counts))
    np.maximum.at(highest, of_corner, np.repeat(piece, counts))
    for elements in (mesh.polygons, mesh.vertices):
        elements.foreach_set("select", np.zeros(len(elements), dtype=bool))
    mesh.edges.foreach_set("select", lowest != highest)
    posing.make_active(dragon)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.tool_settings.mesh_select_mode = (False, True, False)
    bpy.ops.mesh.edge_split(type="EDGE")
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.tool_settings.mesh_select_mode = (True, False, False)

    corners = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    owner = np.zeros(len(mesh.vertices), dtype=int)
    owner[corners] = np.repeat(piece, counts)
    points = posing.vertices(dragon)
    sums = np.stack([np.bincount(owner, points[:, axis], PIECES) for axis in range(3)], -1)
    middles = sums / np.maximum(np.bincount(owner, minlength=PIECES), 1)[:, None]
    points = middles[owner] + SHRUNK * (points - middles[owner])
    mesh.vertices.foreach_set("co", points.astype(np.float32).ravel())
    mesh.update()


def show_graph(posed: bpy.types.Object, place: bpy.types.Object) -> None:
    """The graph at rest, as bars and beads, in the place of another object."""
    points = posing.vertices(posed)
    held = [group_points(posed, points, name) for name in ("Head", "Tail", "Feet")]
    method = sinew_native().EmbeddedDeformation(
        native_mesh(posed, points),
        np.concatenate(held),
        [len(own) for own in held],
        nodes=posed.sinew.active.parameters.nodes,
    )
    method.bind(points)
    graph = method.graph()
    nodes, links = graph["nodes"], graph["edges"]
    corners, sides = [], []
    for a, b in links:
        start, end = Vector(nodes[a]), Vector(nodes[b])
        turn = (end - start).to_track_quat("Z", "Y").to_matrix()
        first = len(corners)
        for at in (start, end):
            ring = ((1, 0), (0, 1), (-1, 0), (0, -1))
            corners += [tuple(at + turn @ Vector((BAR * x, BAR * y, 0.0))) for x, y in ring]
        sides += [(first + k, first + (k + 1) % 4, first + 4 + (k + 1) % 4, first + 4 + k) for k in range(4)]
    bead, quads = ball((0.0, 0.0, 0.0), BEAD, 4)
    beads = (nodes[:, None] + bead).reshape(-1, 3)
    stacked = (quads + len(bead) * np.arange(len(nodes))[:, None, None]).reshape(-1, 4)
    add_mesh("Bars", corners, sides, (0.10, 0.23, 0.55), place)
    add_mesh("Beads", beads.tolist(), stacked.tolist(), materials.HANDLE_COLOUR, place)


def add_mesh(name: str, points: list, faces: list, colour: tuple, place: bpy.types.Object) -> None:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [], faces)
    mesh.materials.append(materials.plain_material(name, colour, roughness=0.4))
    obj = bpy.data.objects.new(name, mesh)
    obj.matrix_world = place.matrix_world.copy()
    bpy.context.scene.collection.objects.link(obj)


def sinew_native() -> ModuleType:
    """The compiled module that the add-on has loaded."""
    return importlib.import_module("sinew.backend").availability().module


def native_mesh(obj: bpy.types.Object, points: np.ndarray) -> object:
    faces = obj.data.polygons
    counts, corners = np.empty(len(faces), np.int32), np.empty(len(obj.data.loops), np.int32)
    faces.foreach_get("loop_total", counts)
    obj.data.loops.foreach_get("vertex_index", corners)
    return sinew_native().SurfaceMesh(points, (counts, corners))


def group_points(obj: bpy.types.Object, points: np.ndarray, name: str) -> np.ndarray:
    """The vertices of a vertex group, (h, 3)."""
    group = obj.vertex_groups[name].index
    return points[[v.index for v in obj.data.vertices if any(g.group == group for g in v.groups)]]
