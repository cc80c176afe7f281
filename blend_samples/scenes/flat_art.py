# SPDX-License-Identifier: GPL-3.0-or-later
"""Flat art in a flat cage: with mean_value its dots become oval, with green they stay round."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from .. import posing
from ..lineup import POSE_FRAME, Lineup, share_pose
from ..materials import plain_material
from ..models.objects import mesh_object
from ..studio import Shot

LABELS = {"Mean Value": "mean_value", "Green": "green"}
PAINT = {
    "Body": (0.85, 0.30, 0.06),
    "Fin": (0.55, 0.10, 0.03),
    "White": (0.85, 0.85, 0.82),
    "Pupil": (0.02, 0.02, 0.03),
    "Dot": (0.95, 0.72, 0.25),
}
COLUMNS = 6  # of the cage, along the fish
BEND = {1: 0.0, POSE_FRAME: 1.0, 60: -0.6, 84: 0.0}
UPRIGHT = np.array([(1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)])  # x, y, layer -> world axes
LAYER = 0.012


def make() -> bpy.types.Scene:
    return Lineup(
        title="Flat Art",
        build=drawing,
        row=dict.fromkeys(("Rest", *LABELS)),
        spacing=3.1,
        finish=bend,
        shot=Shot((0.0, 0.0, 1.05), 9.8, 5.0, 26.0, lit=1.0, picture=(1440, 400), samples=24, text=0.2),
    ).make()


def bend(fish: Sequence[bpy.types.Object]) -> None:
    share_pose(outline(fish[0]), zip(fish[1:], LABELS.values()), "Bend", bent, BEND, 0.02)
    for obj, method in zip(fish[1:], LABELS.values()):
        print(f"> {method}: dots are {ovalness(obj):.3f} times as long as wide", flush=True)


def bent(points: np.ndarray) -> np.ndarray:
    """The cage along an arc upwards, its height over the arc as before."""
    x, z = points[:, 0], points[:, 2] - 1.05
    radius = 1.15
    angle = x / radius
    return np.column_stack(
        ((radius - z) * np.sin(angle), points[:, 1], 0.72 + radius - (radius - z) * np.cos(angle))
    )


def ring(x: float, y: float, width: float, height: float, count: int = 48) -> np.ndarray:
    angle = 2 * np.pi * np.arange(count) / count
    return np.column_stack((x + width * np.cos(angle), y + height * np.sin(angle)))


def drawing() -> bpy.types.Object:
    """A fish of layers, one a little before the other; each shape is one face of many corners."""
    s = np.linspace(0.0, 1.0, 40)
    back = np.column_stack((-1.0 + 1.5 * s, 0.5 * np.sin(np.pi * s) ** 0.8))
    tail = np.array([(0.5, 0.0), (0.7, 0.16), (1.0, 0.45), (0.92, 0.15), (0.9, 0.0)])
    shapes = [
        (np.concatenate((tail, tail[-2:0:-1] * (1, -1))), 1, 0),
        (np.concatenate((back, back[-2:0:-1] * (1, -1))), 0, 1),
        (ring(-0.68, 0.09, 0.1, 0.1), 2, 2),
        (ring(-0.7, 0.09, 0.05, 0.05), 3, 3),
    ]
    shapes += [(dot, 4, 2) for dot in dots()]
    points, faces, slots = [], [], []
    for corners, slot, layer in shapes:
        faces.append(tuple(range(len(points), len(points) + len(corners))))
        slots.append(slot)
        points += [tuple(UPRIGHT.T @ (x, y, LAYER * layer) + (0.0, 0.0, 1.05)) for x, y in corners]
    surfaces = [plain_material(name, colour, roughness=0.7) for name, colour in PAINT.items()]
    return mesh_object("Fish", points, faces, slots=slots, materials=surfaces)


def dots() -> list[np.ndarray]:
    places = [(x, y) for x in (-0.4, -0.15, 0.1) for y in (-0.2, 0.0, 0.2)] + [(0.32, 0.0)]
    return [ring(x, y, 0.075, 0.075) for x, y in places]


def outline(obj: bpy.types.Object) -> bpy.types.Object:
    """A rectangle around the fish with corners along its sides, as one face."""
    x = np.linspace(-1.12, 1.12, COLUMNS + 1)
    around = np.concatenate(
        (np.column_stack((x, np.full_like(x, -0.6))), np.column_stack((x[::-1], np.full_like(x, 0.6))))
    )
    points = [tuple(UPRIGHT.T @ (a, b, 0.0) + (0.0, 0.0, 1.05)) for a, b in around]
    return mesh_object("Outline", points, [tuple(range(len(points)))], parent=obj)


def ovalness(obj: bpy.types.Object) -> float:
    """The greatest ratio of the two axes of a dot."""
    bpy.context.scene.frame_set(POSE_FRAME)
    posed = posing.shape(obj).astype(np.float64)
    ratios = []
    for face in obj.data.polygons:
        if face.material_index == 4:
            corners = posed[list(face.vertices)][:, [0, 2]]
            lengths = np.linalg.svd(corners - corners.mean(0), compute_uv=False)
            ratios.append(lengths[0] / lengths[1])
    return float(max(ratios))
