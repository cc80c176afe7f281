# SPDX-License-Identifier: GPL-3.0-or-later
"""A round pillar with grooves that wind around it and studs between them, which show how details turn."""

import bpy
import numpy as np

from ..materials import FIXED_COLOUR, HANDLE_COLOUR, patched_material, region_material
from .objects import Sculpture, disc, grid_faces, to_object

HEIGHT, RADIUS = 2.0, 0.22
FOOT, HEAD = 0.3, 1.7  # between these heights it is free
GROOVES, WINDINGS = 7, 0.5
CELLS = 40  # across the top; each ring has 4 * CELLS corners
RINGS = 360
PLAIN = (0.55, 0.50, 0.43)
LONG, WIDE, TURNS, AROUND = 2.4, 0.26, 96, 48  # of the hose: height, radius, rings, corners of each
HELD, RUBBER = 0.3, (0.55, 0.40, 0.22)  # of its height, at each end; its colour
STRIPES, STRIPE = 3, (0.30, 0.035, 0.02)  # how many, and their colour


def sculpture(cells: int = CELLS, rings: int = RINGS) -> Sculpture:
    """Rings from the floor upwards, then a grid bent to a disc as the top."""
    top, quads, rim = disc(cells)
    heights = np.linspace(HEIGHT, 0.0, rings + 1)[1:]
    angle = np.arctan2(top[rim, 1], top[rim, 0])
    z, angle = np.meshgrid(heights, angle, indexing="ij")
    radius = RADIUS * (1.0 + relief(angle, z))
    sides = np.stack((radius * np.cos(angle), radius * np.sin(angle), z), -1).reshape(-1, 3)
    points = np.vstack((np.column_stack((RADIUS * top, np.full(len(top), HEIGHT))), sides))
    number = np.concatenate((rim, np.arange(len(top), len(points))))
    around = number[grid_faces(len(heights) + 1, len(rim), around=True)][:, [3, 2, 1, 0]]
    quads = np.vstack((quads, around))
    head, foot = np.flatnonzero(points[:, 2] >= HEAD), np.flatnonzero(points[:, 2] <= FOOT)
    colours = np.tile(PLAIN, (len(points), 1))
    colours[head], colours[foot] = HANDLE_COLOUR, FIXED_COLOUR
    fields = {"handle": points[:, 2] - HEAD, "fixed": FOOT - points[:, 2]}  # zero on their borders
    return Sculpture(points, quads, colours, None, fields, {"Head": head, "Foot": foot})


def relief(angle: np.ndarray, height: np.ndarray) -> np.ndarray:
    """How far the surface stands out, as a share of the radius; none near the top."""
    turns = GROOVES * (angle / (2 * np.pi) + WINDINGS * height / HEIGHT)
    across = turns - np.floor(turns)  # from groove to groove
    groove = -0.10 * np.exp(-(((across - 0.5) / 0.10) ** 2))
    along = height / 0.16
    stud = np.hypot((np.minimum(across, 1 - across)) / 0.22, (along - np.round(along)) / 0.32)
    ease = np.clip((HEIGHT - height) / 0.05, 0.0, 1.0)
    return ease * (groove + 0.16 * np.sqrt(np.clip(1.0 - stud**2, 0.0, 1.0)))


def build(name: str = "Pillar") -> bpy.types.Object:
    return to_object(name, sculpture(), [region_material("Pillar", PLAIN)])


def build_striped(name: str = "Pillar") -> bpy.types.Object:
    """The pillar with upright stripes, which show how it turns."""
    made = sculpture()
    x, y, _z = made.points.T
    made.attributes["stripe"] = np.hypot(x, y) * np.cos(STRIPES * np.arctan2(y, x))
    striped = patched_material("Pillar", PLAIN, (("stripe", STRIPE, 0.006),), roughness=0.5)
    return to_object(name, made, [striped])


def build_hose(name: str = "Hose") -> bpy.types.Object:
    """A tube open at both ends, which are its regions."""
    height, turn = np.linspace(0, LONG, TURNS + 1), 2 * np.pi / AROUND * np.arange(AROUND)
    z, a = np.meshgrid(height, turn, indexing="ij")
    points = np.stack((WIDE * np.cos(a), WIDE * np.sin(a), z), -1).reshape(-1, 3)
    fields = {"handle": points[:, 2] - LONG + HELD, "fixed": HELD - points[:, 2]}
    regions = {
        group: np.flatnonzero(values >= 0.0) for group, values in zip(("Head", "Foot"), fields.values())
    }
    plain, quads = np.tile(RUBBER, (len(points), 1)), grid_faces(TURNS + 1, AROUND, around=True)
    made = Sculpture(points, quads, plain, attributes=fields, regions=regions)
    return to_object(name, made, [region_material("Hose", RUBBER)])
