# SPDX-License-Identifier: GPL-3.0-or-later
"""The small models of *Try It*, each written into the add-on as a file with one scene."""

from __future__ import annotations

from collections.abc import Sequence
from math import radians
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

from .. import materials, posing, studio
from ..models import mannequin, pillar, spot, yeti
from ..models.objects import keep_vertices, to_object
from ..studio import Shot
from . import wires

FOLDER = Path(__file__).parents[2] / "addon" / "rigs"
COLOURS = 6  # of a model at most, each a material, since a solid viewport shows these
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
    keep_vertices(body.data, _kept(body, lambda p: (p[:, 1] > 0.36) & (p[:, 2] > 0.92)))
    _paint(body)
    kept = ("upper_arm.L", "forearm.L", "hand.L")
    posing.make_active(bones)
    bpy.ops.object.mode_set(mode="EDIT")
    for bone in list(bones.data.edit_bones):
        if bone.name not in kept:
            bones.data.edit_bones.remove(bone)
    bpy.ops.object.mode_set(mode="OBJECT")
    for group in list(body.vertex_groups):
        if group.name not in kept:
            body.vertex_groups.remove(group)
    forearm = bones.pose.bones["forearm.L"]
    forearm.rotation_mode = "XYZ"
    for frame, angle in zip(FRAMES, (0.0, BENT)):
        forearm.rotation_euler.z = radians(angle)
        forearm.keyframe_insert("rotation_euler", frame=frame)
    bones.rotation_euler.z = radians(-90.0)
    return [body, bones]


def lines() -> list[bpy.types.Object]:
    """The head of the yeti, and curves along its brows and its mouth."""
    head = wires.bust(voxel=0.026)
    head.name = head.data.name = "Yeti Head"
    _paint(head)
    curves = [wires.draw(head, name, places) for name, places in wires.features().items()]
    for curve, name in zip(curves, wires.RADII):
        curve.name = curve.data.name = name
    head.rotation_euler.z = radians(-90.0)
    return [head, *curves]


def cage() -> list[bpy.types.Object]:
    """The cow, and a cage around it."""
    cow = spot.build("Cow")
    colours = np.tile((0.80, 0.74, 0.66), (len(cow.data.vertices), 1))
    for field, colour, _softness in spot.PATCHES:
        values = np.empty(len(colours), np.float32)
        cow.data.attributes[field].data.foreach_get("value", values)
        colours[values > 0.0] = colour
    eyes = [corner for face in cow.data.polygons if face.material_index == spot.EYE for corner in face.vertices]
    colours[eyes] = 0.005
    cow.vertex_groups.clear()
    _paint(cow, colours)
    cow.rotation_euler.z = radians(-38.0)
    made = posing.add_cage(cow, "mean_value", faces=160)
    around = made.copy()
    around.data = made.data.copy()
    bpy.context.scene.collection.objects.link(around)
    posing.expect(bpy.ops.sinew.deformer_remove(), "deformer_remove")  # it removes its own cage
    around.name = around.data.name = "Cow Cage"
    return [cow, around]


def figure() -> list[bpy.types.Object]:
    """The mannequin and its bones."""
    skin = mannequin.build("Mannequin", cell=0.034)
    rig = mannequin.rig_of(skin)
    rig.show_in_front = True
    _paint(skin, np.tile((0.46, 0.27, 0.13), (len(skin.data.vertices), 1)))
    return [skin, rig]


RIGS = {"limb": limb, "joint": joint, "lines": lines, "cage": cage, "figure": figure}


def make() -> bpy.types.Scene:
    """Write the files, and leave all models in one row."""
    overview = studio.empty_scene("Try It")
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


def _kept(body: bpy.types.Object, inside) -> np.ndarray:
    return inside(posing.vertices(body))


def _paint(obj: bpy.types.Object, colours: np.ndarray | None = None) -> None:
    """Let each face have the material of the colour that it has, of a few; and remove all other attributes.

    ``colours`` (n, 3) of the vertices; without, those that the mesh has.
    """
    mesh = obj.data
    if colours is None:
        rgba = np.empty(4 * len(mesh.vertices), np.float32)
        mesh.color_attributes["Colour"].data.foreach_get("color", rgba)
        colours = rgba.reshape(-1, 4)[:, :3]
    of_faces = np.array([np.mean(colours[list(face.vertices)], axis=0) for face in mesh.polygons])
    palette, slots = _palette(of_faces)
    mesh.materials.clear()
    for number, colour in enumerate(palette):
        mesh.materials.append(materials.plain_material(f"{obj.name} {number + 1}", colour.tolist()))
    mesh.polygons.foreach_set("material_index", slots.astype(np.int32))
    for name in [attribute.name for attribute in mesh.attributes if attribute.domain == "POINT"]:
        if name not in ("position", ".select_vert"):
            mesh.attributes.remove(mesh.attributes[name])
    mesh.update()


def _palette(colours: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A few colours (k, 3), and the number (m,) of the nearest for each of ``colours`` (m, 3).

    The first is the brightest; each next one is that which is farthest from all so far, then all settle.
    """
    chosen = colours[np.argmax(colours.sum(axis=1))][None]
    for _ in range(12):
        apart = np.linalg.norm(colours[:, None] - chosen[None], axis=2)
        if len(chosen) < COLOURS and apart.min(axis=1).max() > 0.05:
            chosen = np.vstack((chosen, colours[np.argmax(apart.min(axis=1))]))
            continue
        nearest = apart.argmin(axis=1)
        chosen = np.array([colours[nearest == number].mean(axis=0) for number in np.unique(nearest)])
    apart = np.linalg.norm(colours[:, None] - chosen[None], axis=2)
    return chosen, apart.argmin(axis=1)
