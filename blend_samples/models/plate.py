# SPDX-License-Identifier: GPL-3.0-or-later
"""The plate of the tutorial's figure 9: flat and square, with a fixed frame and a round handle."""

from __future__ import annotations

from itertools import pairwise

import bpy
import numpy as np

from ..materials import FIXED_COLOUR, HANDLE_COLOUR
from .objects import Sculpture, to_object

HANDLE_RADIUS = 0.27
FRAME = 0.82  # half the width of the free square; the plate itself reaches to 1
CELLS = 36  # across the handle; the rings around it have 4 * CELLS corners
FREE_RINGS, FRAME_RINGS = 46, 8

PLAIN = (0.62, 0.56, 0.46)


def sculpture() -> Sculpture:
    """A grid bent to a disc, then rings from its circle to the square: edges follow both borders."""
    line = np.linspace(-1, 1, CELLS + 1)
    u, v = (w.ravel() for w in np.meshgrid(line, line, indexing="ij"))
    disc = HANDLE_RADIUS * np.stack((u * np.sqrt(1 - v * v / 2), v * np.sqrt(1 - u * u / 2)), 1)
    number = np.arange((CELLS + 1) ** 2).reshape(CELLS + 1, CELLS + 1)
    quads = [
        np.stack((number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]), -1).reshape(-1, 4)
    ]

    rim = np.concatenate((number[:-1, 0], number[-1, :-1], number[:0:-1, -1], number[0, :0:-1]))
    circle, square = disc[rim], np.stack((u, v), 1)[rim]
    t = np.linspace(0, 1, FREE_RINGS + 1)[1:, None, None]
    free = (1 - t) * circle + t * FRAME * square
    grow = np.linspace(FRAME, 1, FRAME_RINGS + 1)[1:, None, None]
    rings = np.concatenate((free, grow * square))
    flat = np.vstack((disc, rings.reshape(-1, 2)))
    ring_number = len(disc) + np.arange(len(rings) * len(rim)).reshape(len(rings), len(rim))
    ring_number = np.vstack((rim, ring_number))
    for inner, outer in pairwise(ring_number):
        quads.append(np.stack((inner, outer, np.roll(outer, -1), np.roll(inner, -1)), 1))

    points = np.column_stack((flat, np.zeros(len(flat))))
    handle = np.arange(len(disc))
    fixed = np.flatnonzero(np.abs(flat).max(1) > FRAME - 1e-6)
    colours = np.tile(PLAIN, (len(points), 1))
    colours[handle], colours[fixed] = HANDLE_COLOUR, FIXED_COLOUR
    all_quads = np.vstack(quads)
    fields = {
        "handle": HANDLE_RADIUS - np.linalg.norm(flat, axis=1),
        "fixed": np.abs(flat).max(1) - FRAME,
    }  # zero on the borders of the regions, so that the material can draw them sharply
    return Sculpture(
        points, all_quads, colours, np.zeros(len(all_quads)), fields, {"Handle": handle, "Frame": fixed}
    )


def build(name: str = "Plate") -> bpy.types.Object:
    return to_object(name, sculpture())
