# SPDX-License-Identifier: GPL-3.0-or-later
"""Modifiers of an object that show the shape of another one."""

from bpy.types import Context, Object, UILayout

from ...core.status import Level, Status
from ...session.targets import modified
from ..status_box import draw_message

COPIED = (
    "The modifier {} was copied from another object and shows the shape of that one - remove it, then add "
    "handles or a cage here"
)


def draw_strays(context: Context, layout: UILayout, obj: Object) -> None:
    """Draw which modifiers these are."""
    for name in modified.stray_modifiers(obj):
        draw_message(context, layout, Status(Level.WARNING, COPIED.format(name)))
