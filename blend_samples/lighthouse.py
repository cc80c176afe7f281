# SPDX-License-Identifier: GPL-3.0-or-later
"""A subdivided lighthouse in a leaning cage: mean values shear it, Green coordinates turn its parts."""

from __future__ import annotations

import bpy

from . import markers, materials, posing, studio
from .models import lighthouse

POSE_FRAME = 40
SPACING = 2.1
LABELS = {None: "Rest", "mean_value": "Mean Value", "green": "Green"}
STOREYS = ((0.0, 0.60), (0.62, 0.52), (1.18, 0.47), (1.74, 0.47), (2.34, 0.47))  # height, half the width
LEAN = (0.0, 0.10, 0.42, 0.86, 1.22)  # how far each floor of the cage moves sideways
SWAY = {1: 0.0, POSE_FRAME: 1.0, 52: 1.0, 72: -0.8, 96: 0.0}


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Lighthouse")
    first = lighthouse.build()
    for material in surfaces():
        first.data.materials.append(material)
    smooth = first.modifiers.new("Subdivision", "SUBSURF")
    smooth.levels = smooth.render_levels = 3
    towers = dict(zip(LABELS, posing.line_up(first, LABELS.values(), SPACING)))

    rest = add_storeys(towers[None])
    cages = [posing.share_cage(rest, towers[method], method) for method in ("mean_value", "green")]
    rest.data = rest.data.copy()  # the others share their mesh, and its poses
    points = posing.vertices(rest)
    posing.add_pose(cages[0], "Lean", points + [(LEAN[k // 4], 0, 0) for k in range(len(points))], SWAY)
    for cage in (rest, *cages):
        markers.add_cage_edges(cage, 0.014)
    rest.hide_render = True
    for method in ("mean_value", "green"):
        posing.check_posed(towers[method], 1, POSE_FRAME)

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(0.35, 0.0, 1.06), distance=26.0, elevation=9.0, width=7.2)
    studio.add_lights(scene, target=(0.0, 0.0, 1.0), size=9.0)
    for method, tower in towers.items():
        studio.add_label(scene, LABELS[method], (tower.location.x, -1.5, 0.0), 0.19)
    studio.set_up_render(scene, samples=64, height=560)
    studio.open_at(scene, POSE_FRAME, towers["green"])
    return scene


def add_storeys(tower: bpy.types.Object) -> bpy.types.Object:
    """A square tower of boxes around the round one, closed at both ends."""
    points = [
        (x * half, y * half, z - 0.04) for z, half in STOREYS for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    faces = [(3, 2, 1, 0), tuple(4 * len(STOREYS) - 4 + k for k in range(4))]
    for k in range(len(STOREYS) - 1):
        faces += [(4 * k + s, 4 * k + (s + 1) % 4, 4 * k + 4 + (s + 1) % 4, 4 * k + 4 + s) for s in range(4)]
    mesh = bpy.data.meshes.new("Storeys")
    mesh.from_pydata(points, [], faces)
    cage = bpy.data.objects.new("Storeys", mesh)
    cage.parent = tower
    bpy.context.scene.collection.objects.link(cage)
    return cage


def surfaces() -> list[bpy.types.Material]:
    return [
        materials.plain_material("Wall", (0.80, 0.77, 0.71), roughness=0.6),
        materials.plain_material("Stripe", (0.42, 0.035, 0.025), roughness=0.5),
        materials.plain_material("Stone", (0.27, 0.25, 0.23), roughness=0.7),
        materials.plain_material("Glass", (0.85, 0.62, 0.20), roughness=0.1, specular=0.6),
        materials.plain_material("Opening", (0.02, 0.022, 0.03), roughness=0.3),
    ]
