# SPDX-License-Identifier: GPL-3.0-or-later
"""The mark in the corner of the 3D viewports while a preview or a draft is shown, not the final shape."""

import bpy
from bpy.types import SpaceView3D

from ..session.datablocks import owners
from ..session.state import sessions
from .overlays import overlay_draw

_callbacks: list = []  # the drawing callback, as Blender identifies it


def marks() -> list[str]:
    """The lines of the mark: one per object whose shape is not final yet."""
    lines = []
    for obj in owners.owners():
        keys = [deformer.uid for deformer in obj.sinew.deformers]
        if any(map(sessions.is_draft, keys)):
            lines.append(f"Draft of {obj.name}")
        elif any(map(sessions.is_refining, keys)):
            lines.append(f"Refining {obj.name}")
    return lines


def _draw() -> None:
    lines = marks()
    if lines and bpy.context.space_data.overlay.show_overlays:
        overlay_draw.draw_lines(bpy.context, lines)


def register() -> None:
    if not bpy.app.background:
        _callbacks.append(SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_PIXEL"))


def unregister() -> None:
    while _callbacks:
        SpaceView3D.draw_handler_remove(_callbacks.pop(), "WINDOW")
