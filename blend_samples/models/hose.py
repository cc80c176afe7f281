# SPDX-License-Identifier: GPL-3.0-or-later
"""A tube open at both ends, with its ends as vertex groups."""

import bpy
import numpy as np

from ..materials import region_material
from .objects import Sculpture, grid_faces, to_object

HEIGHT, RADIUS, RINGS, AROUND = 2.4, 0.26, 96, 48
HELD = 0.3  # of its height, at each end
PLAIN = (0.55, 0.40, 0.22)


def build(name: str = "Hose") -> bpy.types.Object:
    height, turn = np.linspace(0, HEIGHT, RINGS + 1), 2 * np.pi / AROUND * np.arange(AROUND)
    z, a = np.meshgrid(height, turn, indexing="ij")
    points = np.stack((RADIUS * np.cos(a), RADIUS * np.sin(a), z), -1).reshape(-1, 3)
    fields = {"handle": points[:, 2] - HEIGHT + HELD, "fixed": HELD - points[:, 2]}
    regions = {
        group: np.flatnonzero(values >= 0.0) for group, values in zip(("Head", "Foot"), fields.values())
    }
    plain, quads = np.tile(PLAIN, (len(points), 1)), grid_faces(RINGS + 1, AROUND, around=True)
    made = Sculpture(points, quads, plain, attributes=fields, regions=regions)
    return to_object(name, made, [region_material("Hose", PLAIN)])
