# SPDX-License-Identifier: GPL-3.0-or-later
"""A round pillar with grooves that wind around it and studs between them, which show how details turn."""

from __future__ import annotations

from itertools import pairwise

import bpy
import numpy as np

from ..materials import FIXED_COLOUR, HANDLE_COLOUR
from .objects import Sculpture, to_object

HEIGHT, RADIUS = 2.0, 0.22
FOOT, HEAD = 0.3, 1.7  # between these heights it is free
GROOVES, WINDINGS = 7, 0.5
CELLS = 40  # across the top; each ring has 4 * CELLS corners
RINGS = 360
PLAIN = (0.55, 0.50, 0.43)


def sculpture() -> Sculpture:
    """Rings from the floor upwards, then a grid bent to a disc as the top."""
    line = np.linspace(-1, 1, CELLS + 1)
    u, v = (w.ravel() for w in np.meshgrid(line, line, indexing="ij"))
    disc = np.stack((u * np.sqrt(1 - v * v / 2), v * np.sqrt(1 - u * u / 2)), 1)
    number = np.arange((CELLS + 1) ** 2).reshape(CELLS + 1, CELLS + 1)
    top = np.stack((number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]), -1).reshape(-1, 4)
    rim = np.concatenate((number[:-1, 0], number[-1, :-1], number[:0:-1, -1], number[0, :0:-1]))

    heights = np.linspace(HEIGHT, 0.0, RINGS + 1)[1:]
    angle = np.arctan2(disc[rim, 1], disc[rim, 0])
    rings = np.empty((len(heights), len(rim), 3))
    for ring, height in zip(rings, heights):
        radius = RADIUS * (1.0 + relief(angle, height))
        ring[:, 0], ring[:, 1], ring[:, 2] = radius * np.cos(angle), radius * np.sin(angle), height
    points = np.vstack((np.column_stack((RADIUS * disc, np.full(len(disc), HEIGHT))), rings.reshape(-1, 3)))
    below = len(disc) + np.arange(len(heights) * len(rim)).reshape(len(heights), len(rim))
    sides = [
        np.stack((outer, np.roll(outer, -1), np.roll(inner, -1), inner), 1)
        for inner, outer in pairwise(np.vstack((rim, below)))
    ]
    quads = np.vstack((top, *sides))
    head, foot = np.flatnonzero(points[:, 2] >= HEAD), np.flatnonzero(points[:, 2] <= FOOT)
    colours = np.tile(PLAIN, (len(points), 1))
    colours[head], colours[foot] = HANDLE_COLOUR, FIXED_COLOUR
    fields = {
        "handle": points[:, 2] - HEAD,
        "fixed": FOOT - points[:, 2],
    }  # zero on the borders of the regions
    return Sculpture(points, quads, colours, np.zeros(len(quads)), fields, {"Head": head, "Foot": foot})


def relief(angle: np.ndarray, height: float) -> np.ndarray:
    """How far the surface stands out at angles (k,), as a share of the radius; none near the top."""
    turns = GROOVES * (angle / (2 * np.pi) + WINDINGS * height / HEIGHT)
    across = turns - np.floor(turns)  # from groove to groove
    groove = -0.10 * np.exp(-(((across - 0.5) / 0.10) ** 2))
    along = height / 0.16
    stud = np.hypot((np.minimum(across, 1 - across)) / 0.22, (along - np.round(along)) / 0.32)
    ease = np.clip((HEIGHT - height) / 0.05, 0.0, 1.0)
    return ease * (groove + 0.16 * np.sqrt(np.clip(1.0 - stud**2, 0.0, 1.0)))


def build(name: str = "Pillar") -> bpy.types.Object:
    return to_object(name, sculpture())
