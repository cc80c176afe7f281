# SPDX-License-Identifier: GPL-3.0-or-later
"""The object is linked from another file."""

import bpy
from bpy.types import Context, UILayout

from ...core.status import Level, Remedy, Status
from ...operators import target_of
from ..status_box import draw_message


def is_there(context: Context) -> bool:
    """Whether the object to work on cannot be edited here."""
    return target_of(context).library is not None


def page(_context: Context) -> str:
    """What linked rigs can do."""
    return "hand-over"


def draw(context: Context, layout: UILayout) -> None:
    """Draw where it comes from, and how to pose it here."""
    name = bpy.path.basename(target_of(context).library.filepath)
    text = f"Linked from {name}: it plays as it is there"
    draw_message(context, layout, Status(Level.INFO, text, remedy=Remedy.OVERRIDE))
