# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of tasks and methods, which are read when they are first shown."""

from pathlib import Path

import bpy
import bpy.utils.previews
from bpy.types import UILayout

_FOLDER = Path(__file__).parents[2] / "pictures"
_read: list = []  # the collection of Blender's previews, once there is one


def draw_picture(layout: UILayout, name: str, scale: float) -> None:
    """Draw a picture, ``scale`` times as high as a button; nothing where there is none, or no window."""
    icon = _icon(name)
    if icon:
        layout.template_icon(icon_value=icon, scale=scale)


def beside_picture(layout: UILayout, name: str, scale: float, factor: float) -> UILayout:
    """Draw a picture in its share of the width; the layout of what stands beside it."""
    if not _icon(name):
        return layout
    parts = layout.split(factor=factor)
    draw_picture(parts, name, scale)
    return parts


def _icon(name: str) -> int:
    if bpy.app.background:
        return 0
    if not _read:
        _read.append(bpy.utils.previews.new())
        for path in sorted(_FOLDER.glob("*.png")):
            _read[0].load(path.stem, str(path), "IMAGE")
    return _read[0][name].icon_id if name in _read[0] else 0


def register() -> None:
    """Nothing: the first popup reads the pictures."""


def unregister() -> None:
    """Forget the pictures."""
    while _read:
        bpy.utils.previews.remove(_read.pop())
