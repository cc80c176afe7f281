# SPDX-License-Identifier: GPL-3.0-or-later
"""A dragon filled with rigid cells: the cells at rest, and the pose that they give."""

from __future__ import annotations

import bpy
import numpy as np

from . import animals, creature, materials, posing, studio
from .embedded_deformation import group_points, native_mesh, sinew_native

POSE_FRAME = creature.POSE_FRAME
SPACING, HEADING = 2.75, -49.0
LABELS = ("Rest", "Its 2,500 Cells", "Rigid Cells")
CUBE = np.array([(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)])
SIDES = np.array([(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)])


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Rigid Cells")
    dragons = posing.line_up(animals.dragon(), LABELS, SPACING, HEADING)
    for dragon in dragons:
        creature.pose(dragon, "rigid_cells" if dragon is dragons[-1] else None)
    posed = dragons[-1]
    posed.sinew.active.parameters.cells = 2500
    bpy.context.view_layer.update()
    posing.check_posed(posed, 1, POSE_FRAME)
    show_cells(posed, dragons[1])
    dragons[1].hide_render = True

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(-0.06, 0.0, 0.90), distance=26.0, elevation=13.0, width=8.6)
    studio.add_lights(scene, target=(0.0, 0.0, 0.9), size=10.0)
    for dragon, label in zip(dragons, LABELS):
        studio.add_label(scene, label, (dragon.location.x + 0.12, -1.75, 0.0), 0.2)
    studio.set_up_render(scene, samples=24, height=540)
    studio.open_at(scene, POSE_FRAME, posed)
    return scene


def show_cells(posed: bpy.types.Object, place: bpy.types.Object) -> None:
    """The cells at rest, a little smaller than they are, in the place of another object."""
    parameters, points = posed.sinew.active.parameters, posing.vertices(posed)
    held = [group_points(posed, points, name) for name in ("Head", "Tail", "Feet")]
    filled = sinew_native().RigidCells(
        native_mesh(posed, points),
        np.concatenate(held),
        [len(own) for own in held],
        cells=parameters.cells,
        levels=parameters.levels,
    )
    filled.bind(points)
    cells = filled.cells()
    cubes = cells["centres"][:, None] + 0.46 * cells["sides"][:, None, None] * CUBE
    mesh = bpy.data.meshes.new("Cells")
    faces = SIDES + 8 * np.arange(len(cubes))[:, None, None]
    mesh.from_pydata(cubes.reshape(-1, 3).tolist(), [], faces.reshape(-1, 4).tolist())
    for name, colour in (
        ("Free", (0.30, 0.42, 0.30)),
        ("Held", materials.HANDLE_COLOUR),
        ("Fixed", materials.FIXED_COLOUR),
    ):
        mesh.materials.append(materials.plain_material(f"{name} Cells", colour, roughness=0.5))
    which = np.where(cells["handles"] < 0, 0, np.where(cells["handles"] == 2, 2, 1))
    mesh.polygons.foreach_set("material_index", np.repeat(which, 6).astype(np.int32))
    obj = bpy.data.objects.new("Cells", mesh)
    obj.matrix_world = place.matrix_world.copy()
    bpy.context.scene.collection.objects.link(obj)
