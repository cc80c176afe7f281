# SPDX-License-Identifier: GPL-3.0-or-later
"""A ring on a surface, drawn in a viewport."""

import numpy as np
from bpy.types import Region, RegionView3D
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Vector

from ...compat import smooth_colour_shader
from ...core.geometry import frames

_SIDES = 48

Colour = tuple[float, float, float, float]


def ring(place: np.ndarray, normal: np.ndarray, radius: float) -> np.ndarray:
    """Points (k, 3) on a circle around ``place`` (3,), across ``normal`` (3,); the first one is the last."""
    helper = np.eye(3)[np.argmin(np.abs(normal))]
    across = np.cross(normal, helper)
    across /= np.linalg.norm(across)
    circle = frames.circle(_SIDES) @ (across, np.cross(normal, across))
    return place + radius * np.concatenate((circle, circle[:1]))


def draw_line(
    region: Region,
    view: RegionView3D,
    points: np.ndarray,
    colour: Colour,
    corner: tuple[float, float] = (0.0, 0.0),
) -> None:
    """Draw a line through points (k, 3) of the world, in pixels, from ``corner`` of the region on."""
    import gpu
    from gpu_extras.batch import batch_for_shader

    seen = [location_3d_to_region_2d(region, view, Vector(point)) for point in points]
    if None in seen:  # behind the viewer
        return
    pixels = [(point.x + corner[0], point.y + corner[1], 0.0) for point in seen]
    gpu.state.blend_set("ALPHA")
    shader = smooth_colour_shader()
    batch_for_shader(shader, "LINE_STRIP", {"pos": pixels, "color": [colour] * len(pixels)}).draw(shader)
    gpu.state.blend_set("NONE")
