# SPDX-License-Identifier: GPL-3.0-or-later
"""The window of a session, its areas, and screenshots of them."""

import sys
from collections.abc import Sequence
from pathlib import Path

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Vector

OUTPUT = Path(sys.argv[sys.argv.index("--") + 1])
FRONT = (0.7071068, 0.7071068, 0.0, 0.0)  # the rotation of a view

pictures = [OUTPUT]  # the folder of the screenshots of this part

Place = tuple[int, int]  # pixels of the window, from its lower left corner


def window() -> bpy.types.Window:
    return bpy.context.window_manager.windows[0]


def viewport() -> bpy.types.Area:
    """The largest 3D viewport."""
    areas = (area for area in window().screen.areas if area.type == "VIEW_3D")
    return max(areas, key=lambda area: area.width)


def view() -> bpy.types.RegionView3D:
    return viewport().spaces.active.region_3d


def region(kind: str = "WINDOW") -> bpy.types.Region:
    return next(region for region in viewport().regions if region.type == kind)


def in_view() -> object:
    """For operators that ask where the mouse is."""
    return bpy.context.temp_override(window=window(), area=viewport(), region=region())


def button(name: str, **options: object) -> set[str]:
    """Call an operator of Sinew as a button in the viewport does."""
    with in_view():
        return getattr(bpy.ops.sinew, name)("INVOKE_DEFAULT", **options)


def middle() -> Place:
    """The middle of what the sidebar leaves of the viewport."""
    whole, sidebar = region(), region("UI")
    covered = sidebar.width if viewport().spaces.active.show_region_ui else 0
    return whole.x + (whole.width - covered) // 2, whole.y + whole.height // 2


def look_from_front(distance: float = 9.0, height: float = 0.0) -> None:
    """Without perspective."""
    view().view_perspective, view().view_rotation = "ORTHO", FRONT
    view().view_location, view().view_distance = (0.0, 0.0, height), distance


def on_screen(point: Sequence[float]) -> Place:
    """Where a point of the world is in the window."""
    pixel = location_3d_to_region_2d(region(), view(), Vector(point))
    return int(region().x + pixel.x), int(region().y + pixel.y)


def units_per_pixel() -> float:
    """Of a view from the front."""
    return 1.0 / (on_screen((1.0, 0.0, 0.0))[0] - on_screen((0.0, 0.0, 0.0))[0])


def screenshot(name: str) -> None:
    with bpy.context.temp_override(window=window()):
        bpy.ops.screen.screenshot(filepath=str(pictures[0] / f"{name}.png"))


def pixels(name: str) -> np.ndarray:
    """A screenshot, (rows, columns, 3) in 0..1, from below."""
    image = bpy.data.images.load(str(pictures[0] / f"{name}.png"))
    width, height = image.size
    rows = np.array(image.pixels[:], dtype=np.float32).reshape(height, width, -1)[:, :, :3]
    bpy.data.images.remove(image)
    return rows


def view_pixels(name: str) -> np.ndarray:
    """The part of a screenshot that shows the mesh, left of the sidebar."""
    whole = region()
    return pixels(name)[whole.y : whole.y + whole.height, whole.x : whole.x + whole.width * 2 // 3]


def differing(one: str, other: str, limit: float = 0.05) -> float:
    """The share of the pixels that show the mesh in which two screenshots differ."""
    return float((np.abs(view_pixels(one) - view_pixels(other)).max(axis=2) > limit).mean())
