# SPDX-License-Identifier: GPL-3.0-or-later
"""A symmetric pose of a cage of quads: two triangles per quad lean to one side, green with quads does not."""

from __future__ import annotations

from collections.abc import Sequence

import bmesh
import bpy
import numpy as np

from .. import posing
from ..lineup import POSE_FRAME, Lineup, share_pose
from ..materials import plain_material
from ..models.objects import stack_of_boxes
from ..studio import Shot

FLOORS = (0.06, 1.0, 1.94)  # heights of the three rings of the cage
POSED = ((1.0, 1.0, 0.0), (0.45, 1.0, 0.0), (1.9, 1.0, -0.15))  # by ring: width, depth, lift
CELLS = 24
SQUEEZE = {1: 0.0, POSE_FRAME: 1.0, 60: 1.0, 84: 0.0}


def make() -> bpy.types.Scene:
    return Lineup(
        title="Quad Cages",
        build=block,
        row=dict.fromkeys(("Rest", "Triangles", "Quads")),
        spacing=2.9,
        finish=squeeze,
        shot=Shot(
            (0.0, 0.0, 0.92), 9.2, 7.0, 26.0, lit=1.0, picture=(1440, 460), samples=24, text=0.21, front=-1.6
        ),
    ).make()


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
    mesh.materials.append(plain_material("Light", (0.78, 0.72, 0.62)))
    mesh.materials.append(plain_material("Dark", (0.10, 0.17, 0.26)))
    return posing.add_object("Block", mesh)


def squeeze(blocks: Sequence[bpy.types.Object]) -> None:
    rest = stack_of_boxes("Boxes", [(0.56, z) for z in FLOORS], blocks[0])
    width, depth, lift = np.repeat(POSED, 4, axis=0).T

    def posed(points: np.ndarray) -> np.ndarray:
        x, y, z = points.T
        return np.column_stack((width * x, depth * y, z + lift))

    share_pose(rest, [(block, "green") for block in blocks[1:]], "Squeeze", posed, SQUEEZE, 0.016)
    for block, faces in zip(blocks[1:], ("triangles", "quads")):
        block.sinew.deformers[-1].parameters.faces = faces
        posing.make_active(block)
        posing.expect(bpy.ops.sinew.bind(), f"{faces}: bind")
        posing.check_posed(block, 1, POSE_FRAME)
        print(f"> {faces}: {lean(block):.4f} of the width from its mirror image", flush=True)


def lean(obj: bpy.types.Object) -> float:
    """How far the posed block is from its own mirror image, as a share of its width at rest."""
    bpy.context.scene.frame_set(1)
    rest = posing.shape(obj).astype(np.float64)
    bpy.context.scene.frame_set(POSE_FRAME)
    posed = posing.shape(obj).astype(np.float64)
    keys = {tuple(np.round(point, 4)): index for index, point in enumerate(rest)}
    image = [keys[tuple(np.round(point * (-1, 1, 1), 4) + 0.0)] for point in rest]
    return float(np.linalg.norm(posed[image] * (-1, 1, 1) - posed, axis=1).max() / np.ptp(rest[:, 0]))
