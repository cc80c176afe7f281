# SPDX-License-Identifier: GPL-3.0-or-later
"""The small models of *Try It*, each written into the add-on as a file with one scene."""

from collections.abc import Sequence
from math import radians
from pathlib import Path

import bmesh
import bpy
import numpy as np

from .. import materials, posing, studio
from ..lineups import yetis
from ..models import mannequin, pillar, spot, yeti
from ..models.objects import keep_vertices, layered, to_object
from ..models.shapes import smoothstep
from ..studio import Shot

FOLDER = Path(__file__).parents[2] / "addon" / "rigs"
COLOUR = "Colour"
WHITE = (0.80, 0.77, 0.72)  # of eyes
KEPT = ("position", ".select_vert")  # the attributes that meshes need
BENT = 118.0  # degrees of the elbow, in the last frame
FRAMES = (1, 20)
SPACING = 2.0
SHOT = Shot((0.0, 0.0, 0.95), width=10.4, light=12.0, picture=(1440, 420), front=-1.2)


def limb() -> list[bpy.types.Object]:
    """The pillar, whose tip is pulled and whose foot holds still."""
    made = pillar.sculpture(cells=10, rings=84)
    made.regions = {"Tip": made.regions["Head"], "Foot": made.regions["Foot"]}
    body = to_object("Pillar", made)
    _paint(body, np.tile(pillar.PLAIN, (len(made.points), 1)))
    return [body]


def joint() -> list[bpy.types.Object]:
    """The left arm of the yeti, which its bones bend."""
    body, bones = yeti.build("Yeti Arm", voxel=0.028)
    points = posing.vertices(body)
    keep_vertices(body.data, (points[:, 1] > 0.5) & (points[:, 2] > 0.95))
    _tidy(body)
    _paint(body, _colours(body))
    kept = ("upper_arm.L", "forearm.L", "hand.L")
    posing.make_active(bones)
    bpy.ops.object.mode_set(mode="EDIT")
    for bone in [bone for bone in bones.data.edit_bones if bone.name not in kept]:
        bones.data.edit_bones.remove(bone)
    bpy.ops.object.mode_set(mode="OBJECT")
    for group in [group for group in body.vertex_groups if group.name not in kept]:
        body.vertex_groups.remove(group)
    angles = {frame: (0.0, 0.0, angle) for frame, angle in zip(FRAMES, (0.0, BENT))}
    posing.key_angles(bones.pose.bones["forearm.L"], angles)
    bones.rotation_euler.z = radians(-90.0)
    return [body, bones]


def lines() -> list[bpy.types.Object]:
    """The head of the yeti, and curves along its brows and its mouth."""
    head = yetis.bust(voxel=0.026)
    head.name = head.data.name = "Yeti Head"
    _tidy(head)
    angles, colours = _values(head, "gaze"), _colours(head)
    seen = np.flatnonzero(angles < np.pi)
    black = np.full((len(seen), 3), 0.004)
    iris, white = (smoothstep(at - 0.08, at + 0.08, angles[seen]) for at in (yeti.EYES.pupil, yeti.EYES.edge))
    ring = layered(np.tile(yeti.EYES.iris, (len(seen), 1)), [(white, WHITE)])
    colours[seen] = layered(black, [(iris, ring)])
    _paint(head, colours)
    curves = yetis.draw_wires(head)
    for curve, name in zip(curves, yetis.WIRES):
        curve.name = curve.data.name = name
    head.rotation_euler.z = radians(-90.0)
    return [head, *curves]


def cage() -> list[bpy.types.Object]:
    cow = spot.build("Cow")
    colours = np.tile((0.80, 0.74, 0.66), (len(cow.data.vertices), 1))
    for field, colour, _softness in spot.PATCHES:
        colours[_values(cow, field) > 0.0] = colour
    for face in cow.data.polygons:
        if face.material_index == spot.EYE:
            colours[list(face.vertices)] = 0.005
    cow.vertex_groups.clear()
    _paint(cow, colours)
    cow.rotation_euler.z = radians(-38.0)
    made = posing.add_cage(cow, "mean_value", faces=160)
    around = made.copy()
    around.data = made.data.copy()
    bpy.context.scene.collection.objects.link(around)
    posing.operate(cow, "deformer_remove")  # it removes its own cage
    around.name = around.data.name = "Cow Cage"
    return [cow, around]


def figure() -> list[bpy.types.Object]:
    skin = mannequin.build("Mannequin", cell=0.034)
    rig = mannequin.rig_of(skin)
    rig.show_in_front = True
    _paint(skin, np.tile((0.46, 0.27, 0.13), (len(skin.data.vertices), 1)))
    return [skin, rig]


RIGS = {"limb": limb, "joint": joint, "lines": lines, "cage": cage, "figure": figure}


def make() -> bpy.types.Scene:
    """Write the files, and leave all models in one row."""
    overview = studio.empty_scene()
    FOLDER.mkdir(exist_ok=True)
    labels = []
    for (name, build), x in zip(RIGS.items(), posing.places(len(RIGS), SPACING)):
        objects = _written(name, build)
        for obj in objects:
            overview.collection.objects.link(obj)
            if obj.parent is None:
                obj.location.x += x
        labels.append((objects[0].name, x))
    bpy.context.window.scene = overview
    overview.frame_set(FRAMES[-1])
    SHOT.set_up(overview, labels)
    return overview


def _written(name: str, build) -> Sequence[bpy.types.Object]:
    """Build a model in a scene of its own, and write that into a file, which 3.4 and later open."""
    studio.progress(f"the model {name}")
    scene = bpy.data.scenes.new(name)
    bpy.context.window.scene = scene
    scene.frame_start, scene.frame_end = FRAMES
    objects = build()
    scene.frame_set(FRAMES[-1] if name == "joint" else FRAMES[0])
    for obj in objects:
        obj.select_set(obj == objects[0])
    bpy.context.view_layer.objects.active = objects[0]
    bpy.data.libraries.write(str(FOLDER / f"{name}.blend"), {scene}, compress=True)
    return objects


def _tidy(obj: bpy.types.Object) -> None:
    """Remove what is left of faces that were cut: vertices in none, and edges of three faces and more."""
    edit = bmesh.new()
    edit.from_mesh(obj.data)
    for _ in range(3):
        shared = [face for edge in edit.edges if len(edge.link_faces) > 2 for face in edge.link_faces[2:]]
        bmesh.ops.delete(edit, geom=list(set(shared)), context="FACES")
    bmesh.ops.delete(edit, geom=[v for v in edit.verts if not v.link_faces], context="VERTS")
    edit.to_mesh(obj.data)
    edit.free()


def _values(obj: bpy.types.Object, name: str) -> np.ndarray:
    return np.array([row.value for row in obj.data.attributes[name].data])


def _colours(obj: bpy.types.Object) -> np.ndarray:
    return np.array([row.color[:3] for row in obj.data.color_attributes[COLOUR].data])


def _paint(obj: bpy.types.Object, colours: np.ndarray) -> None:
    """Store the ``colours`` (n, 3) of the vertices as bytes, and remove other attributes and materials."""
    mesh = obj.data
    for attribute in [row for row in mesh.attributes if row.domain == "POINT" and row.name not in KEPT]:
        mesh.attributes.remove(attribute)
    rgba = np.column_stack((colours, np.ones(len(colours)))).astype(np.float32)
    mesh.color_attributes.new(COLOUR, "BYTE_COLOR", "POINT").data.foreach_set("color", rgba.ravel())
    material, shader = materials.principled(obj.name)
    material.node_tree.links.new(materials.attribute(material, COLOUR, "Color"), shader.inputs["Base Color"])
    mesh.polygons.foreach_set("material_index", np.zeros(len(mesh.polygons), np.int32))
    mesh.materials.clear()
    mesh.materials.append(material)
