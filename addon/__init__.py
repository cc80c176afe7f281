# SPDX-License-Identifier: GPL-3.0-or-later
"""Sinew: pose meshes by handles, live and without destroying anything."""

bl_info = {
    "name": "Sinew",
    "author": "The Sinew developers",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D Viewport > Sidebar > Sinew",
    "description": "Pose meshes by handles, live and without destroying anything",
    "category": "Rigging",
}

from . import farm, handlers, operators, preferences, properties, ui  # noqa: E402
from .compat import translation  # noqa: E402

_ROOMS = (translation, properties, preferences, operators, ui, handlers, farm)


def register() -> None:
    for room in _ROOMS:
        room.register()


def unregister() -> None:
    for room in reversed(_ROOMS):
        room.unregister()
