# SPDX-License-Identifier: GPL-3.0-or-later
"""Nothing is selected that Sinew can move."""

from bpy.types import Context, UILayout

from ...core.status import Remedy
from ...operators import explain_no_target, target_of
from ..status_box import draw_remedy
from ..text import draw_text
from ..try_it import draw_offer

SELECT = "Select a mesh, text, curve, hair or armature"


def is_there(context: Context) -> bool:
    """Whether there is no object to work on."""
    return target_of(context) is None


def page(_context: Context) -> str:
    """How to begin."""
    return "start"


def draw(context: Context, layout: UILayout) -> None:
    """Draw what to select, or how to make something of what is selected."""
    draw_offer(context, layout)
    text, convertible = explain_no_target(context)
    draw_text(context, layout, text if convertible else SELECT, "INFO")
    if convertible:
        draw_remedy(layout, Remedy.CONVERT)
