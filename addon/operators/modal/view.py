# SPDX-License-Identifier: GPL-3.0-or-later
"""What a tool reads from the viewport and the scene: view, axes, pivot, and the units of lengths."""

import math
import re

import bpy
import numpy as np
from bpy.types import Context
from mathutils import Matrix

from ...core.transform.typed_motion import View

_UNITS = {  # the length of a unit in metres, and its symbol
    "KILOMETERS": (1000.0, " km"),
    "METERS": (1.0, " m"),
    "CENTIMETERS": (0.01, " cm"),
    "MILLIMETERS": (0.001, " mm"),
    "MICROMETERS": (1e-6, " µm"),
    "MILES": (1609.344, " mi"),
    "FEET": (0.3048, "'"),
    "INCHES": (0.0254, '"'),
    "THOU": (0.0000254, " thou"),
}


def view_of(context: Context, pivot: np.ndarray) -> View:
    """The view of a 3D Viewport at a point (3,) of the world. Pixels are those of the window."""
    region = context.region
    if region is None or region.type != "WINDOW":
        region = next(other for other in context.area.regions if other.type == "WINDOW")
    view = context.space_data.region_3d if context.region_data is None else context.region_data
    to_view = np.array(view.view_matrix, dtype=np.float64)
    right, up, toward = to_view[:3, :3] / np.linalg.norm(to_view[:3, :3], axis=1, keepdims=True)
    x, y, _z, w = np.array(view.perspective_matrix, dtype=np.float64) @ (*pivot, 1.0)
    depth = max(abs(w), 1e-6)
    eye = np.linalg.inv(to_view)[:3, 3] - pivot if view.is_perspective else None
    return View(
        right,
        up,
        toward,
        pixel=2.0 * depth / (abs(view.window_matrix[0][0]) * region.width),
        centre=(
            region.x + 0.5 * region.width * (1.0 + x / depth),
            region.y + 0.5 * region.height * (1.0 + y / depth),
        ),
        eye=eye,
    )


def length_text(settings: bpy.types.UnitSettings, value: float) -> str:
    """A length of the world in the scene's units; what is shown as nothing has no sign."""
    if settings.system == "NONE":
        return _plain(value)
    value *= settings.scale_length
    if settings.length_unit in _UNITS:
        size, symbol = _UNITS[settings.length_unit]
        return _plain(value / size) + symbol
    text = bpy.utils.units.to_string(
        settings.system, "LENGTH", value, precision=4, split_unit=settings.use_separate
    )
    return text if re.search("[1-9]", text) else text.removeprefix("-")


def _plain(value: float) -> str:
    """At most four decimals, and 0 instead of -0."""
    return f"{round(value, 4) + 0.0:.4f}".rstrip("0").rstrip(".")


def typed_units(settings: bpy.types.UnitSettings) -> tuple[float, float]:
    """The world units and the radians that a typed 1 means."""
    turn = 1.0 if settings.system_rotation == "RADIANS" else math.pi / 180.0
    if settings.system == "NONE":
        return 1.0, turn
    natural = "FEET" if settings.system == "IMPERIAL" else "METERS"
    size, _symbol = _UNITS.get(settings.length_unit, _UNITS[natural])
    return size / settings.scale_length, turn


def axes_of(matrix: Matrix) -> np.ndarray:
    """The axes of a frame in the world, such as that of an object, as orthonormal columns, (3, 3)."""
    q, r = np.linalg.qr(np.array(matrix, dtype=np.float64)[:3, :3])
    return q * np.where(np.diag(r) < 0.0, -1.0, 1.0)


def pivot_of(context: Context, selection: np.ndarray) -> np.ndarray:
    """The point (3,) about which points (s, 3) of the world turn, by the scene's pivot setting."""
    choice = context.scene.tool_settings.transform_pivot_point
    if choice == "CURSOR":
        return np.array(context.scene.cursor.location, dtype=np.float64)
    if choice == "BOUNDING_BOX_CENTER":
        return 0.5 * (selection.min(axis=0) + selection.max(axis=0))
    return selection.mean(axis=0)
