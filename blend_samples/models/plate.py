# SPDX-License-Identifier: GPL-3.0-or-later
"""The plate of the tutorial's figure 9: flat and square, with a fixed frame and a round handle."""

import bpy
import numpy as np

from ..materials import FIXED_COLOUR, HANDLE_COLOUR, patched_material, region_material, rule_lines
from .objects import Sculpture, disc, grid_faces, square, to_object

HANDLE_RADIUS = 0.27
FRAME = 0.82  # half the width of the free square; the plate itself reaches to 1
CELLS = 36  # across the handle; the rings around it have 4 * CELLS corners
FREE_RINGS, FRAME_RINGS = 46, 8

PLAIN = (0.62, 0.56, 0.46)


def sculpture() -> Sculpture:
    """A grid bent to a disc, then rings from its circle to the square: edges follow both borders."""
    points, inner, rim = disc(CELLS)
    round_part, border = HANDLE_RADIUS * points, square(CELLS)[rim]
    t = np.linspace(0, 1, FREE_RINGS + 1)[1:, None, None]
    free = (1 - t) * round_part[rim] + t * FRAME * border
    grow = np.linspace(FRAME, 1, FRAME_RINGS + 1)[1:, None, None]
    rings = np.concatenate((free, grow * border))
    flat = np.vstack((round_part, rings.reshape(-1, 2)))
    number = np.concatenate((rim, np.arange(len(round_part), len(flat))))
    outer = number[grid_faces(len(rings) + 1, len(rim), around=True)][:, [0, 3, 2, 1]]
    points = np.column_stack((flat, np.zeros(len(flat))))
    handle = np.arange(len(round_part))
    fixed = np.flatnonzero(np.abs(flat).max(1) > FRAME - 1e-6)
    colours = np.tile(PLAIN, (len(points), 1))
    colours[handle], colours[fixed] = HANDLE_COLOUR, FIXED_COLOUR
    quads = np.vstack((inner, outer))
    # zero on the borders of the regions, so that the material can draw them sharply
    fields = {"handle": HANDLE_RADIUS - np.linalg.norm(flat, axis=1), "fixed": np.abs(flat).max(1) - FRAME}
    return Sculpture(points, quads, colours, None, fields, {"Handle": handle, "Frame": fixed})


def build(name: str = "Plate") -> bpy.types.Object:
    """The plate just above the floor, with its regions painted."""
    return _lying(name, region_material("Plate", PLAIN, ruled=True))


def build_plain(name: str = "Plate") -> bpy.types.Object:
    """The same in one colour."""
    surface = patched_material("Plate", PLAIN, (), roughness=0.5)
    rule_lines(surface, cell=0.1, line=0.014)
    return _lying(name, surface)


def _lying(name: str, surface: bpy.types.Material) -> bpy.types.Object:
    plate = to_object(name, sculpture(), [surface])
    plate.location.z = 0.05
    return plate
