# SPDX-License-Identifier: GPL-3.0-or-later
"""A symmetric pose of a cage of quads: two triangles per quad lean to one side, green with quads does not."""

from __future__ import annotations

import bmesh
import bpy
import numpy as np

from . import markers, materials, posing, studio

POSE_FRAME = 40
SPACING = 2.9
LABELS = {None: "Rest", "triangles": "Triangles", "quads": "Quads"}
FLOORS = (0.06, 1.0, 1.94)  # heights of the three rings of the cage
POSED = ((1.0, 1.0, 0.0), (0.45, 1.0, 0.0), (1.9, 1.0, -0.15))  # by ring: width, depth, lift
CELLS = 24
SQUEEZE = {1: 0.0, POSE_FRAME: 1.0, 60: 1.0, 84: 0.0}


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Quad Cages")
    blocks = dict(zip(LABELS, posing.line_up(block(), LABELS.values(), SPACING)))
    rest = cage_of(blocks[None])
    cages = [posing.share_cage(rest, blocks[faces], "green") for faces in ("triangles", "quads")]
    rest.data = rest.data.copy()
    points = posing.vertices(rest)
    scale = np.array([POSED[k // 4] for k in range(len(points))])
    posed = points * np.column_stack((scale[:, 0], scale[:, 1], np.ones(len(points))))
    posed[:, 2] += scale[:, 2]
    posing.add_pose(cages[0], "Squeeze", posed, SQUEEZE)
    for cage in (rest, *cages):
        markers.add_cage_edges(cage, 0.016)
    rest.hide_render = True
    for faces in ("triangles", "quads"):
        deformer = blocks[faces].sinew.deformers[-1]
        deformer.parameters.faces = faces
        posing.make_active(blocks[faces])
        posing.expect(bpy.ops.sinew.bind(), f"{faces}: bind")
        posing.check_posed(blocks[faces], 1, POSE_FRAME)
        print(f"> {faces}: {lean(scene, blocks[faces]):.4f} of the width from its mirror image", flush=True)

    studio.add_backdrop(scene, behind=14.0)
    studio.add_camera(scene, target=(0.0, 0.0, 0.92), distance=26.0, elevation=7.0, width=9.2)
    studio.add_lights(scene, target=(0.0, 0.0, 1.0), size=9.0)
    for faces, obj in blocks.items():
        studio.add_label(scene, LABELS[faces], (obj.location.x, -1.6, 0.0), 0.21)
    studio.set_up_render(scene, samples=24, height=460)
    studio.open_at(scene, POSE_FRAME, blocks["quads"])
    return scene


def block() -> bpy.types.Object:
    """A chequered block, symmetric about x = 0."""
    mesh, edit = bpy.data.meshes.new("Block"), bmesh.new()
    bmesh.ops.create_cube(edit, size=1.0)
    bmesh.ops.subdivide_edges(edit, edges=edit.edges[:], cuts=CELLS - 1, use_grid_fill=True)
    for face in edit.faces:
        place = [int(np.floor((value + 0.5) * 6 - 1e-4)) for value in face.calc_center_median()]
        face.material_index = (abs(place[0] - 2.5) + place[1] + place[2]).__trunc__() % 2
    bmesh.ops.scale(edit, vec=(1.0, 1.0, 1.8), verts=edit.verts)
    bmesh.ops.translate(edit, vec=(0.0, 0.0, 1.0), verts=edit.verts)
    edit.to_mesh(mesh)
    edit.free()
    mesh.materials.append(materials.plain_material("Light", (0.78, 0.72, 0.62), roughness=0.5))
    mesh.materials.append(materials.plain_material("Dark", (0.10, 0.17, 0.26), roughness=0.5))
    obj = bpy.data.objects.new("Block", mesh)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def cage_of(obj: bpy.types.Object) -> bpy.types.Object:
    """Two boxes around the block, one on the other, all of quads."""
    half = 0.56
    points = [(x * half, y * half, z) for z in FLOORS for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    faces = [(3, 2, 1, 0), (8, 9, 10, 11)]
    faces += [
        (4 * k + s, 4 * k + (s + 1) % 4, 4 * k + 4 + (s + 1) % 4, 4 * k + 4 + s)
        for k in (0, 1)
        for s in range(4)
    ]
    mesh = bpy.data.meshes.new("Boxes")
    mesh.from_pydata(points, [], faces)
    cage = bpy.data.objects.new("Boxes", mesh)
    cage.parent = obj
    bpy.context.scene.collection.objects.link(cage)
    return cage


def lean(scene: bpy.types.Scene, obj: bpy.types.Object) -> float:
    """How far the posed block is from its own mirror image, as a share of its width at rest."""
    scene.frame_set(1)
    rest = posing.shape(obj).astype(np.float64)
    scene.frame_set(POSE_FRAME)
    posed = posing.shape(obj).astype(np.float64)
    keys = {tuple(np.round(point, 4)): index for index, point in enumerate(rest)}
    image = [keys[tuple(np.round(point * (-1, 1, 1), 4) + 0.0)] for point in rest]
    return float(np.linalg.norm(posed[image] * (-1, 1, 1) - posed, axis=1).max() / np.ptp(rest[:, 0]))
