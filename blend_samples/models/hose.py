# SPDX-License-Identifier: GPL-3.0-or-later
"""A tube open at both ends, with its ends as vertex groups."""

from __future__ import annotations

from math import pi

import bpy
import numpy as np

from ..materials import region_material
from .objects import Sculpture, grid_faces, to_object

HEIGHT, RADIUS, RINGS, AROUND = 2.4, 0.26, 96, 48
HELD = 0.3  # of its height, at each end
PLAIN = (0.55, 0.40, 0.22)


def build(name: str = "Hose") -> bpy.types.Object:
    z, a = np.meshgrid(np.linspace(0, HEIGHT, RINGS + 1), 2 * pi / AROUND * np.arange(AROUND), indexing="ij")
    points = np.stack((RADIUS * np.cos(a), RADIUS * np.sin(a), z), -1).reshape(-1, 3)
    quads = grid_faces(RINGS + 1, AROUND, around=True)
    fields = {"handle": points[:, 2] - HEIGHT + HELD, "fixed": HELD - points[:, 2]}
    regions = {
        "Head": np.flatnonzero(points[:, 2] >= HEIGHT - HELD),
        "Foot": np.flatnonzero(points[:, 2] <= HELD),
    }
    plain = np.tile(PLAIN, (len(points), 1))
    obj = to_object(name, Sculpture(points, quads, plain, np.zeros(len(quads)), fields, regions))
    obj.data.materials.append(region_material("Hose", PLAIN))
    return obj
