# SPDX-License-Identifier: GPL-3.0-or-later
"""Sentences in a narrow sidebar."""

from bpy.types import Context, UILayout

from .. import compat

_CHARACTER = 5.8  # average width of a letter, in pixels at scale 1
_EDGES = 59  # of a line without icon: margins of region, panel and box
_ICON = 20
_TABS = 21  # the sidebar has its tabs inside the region


def width_of(context: Context) -> float:
    """What a line of the region being drawn can hold, in pixels at scale 1; icons count."""
    tabs = _TABS if context.region.type == "UI" else 0
    return context.region.width / context.preferences.system.ui_scale - _EDGES - tabs


def columns(context: Context) -> int:
    """About how many characters fit a line that begins with an icon."""
    return max(12, int((width_of(context) - _ICON) / _CHARACTER))


def draw_text(context: Context, layout: UILayout, text: str, icon: str = "NONE", beside: int = 0) -> None:
    """A sentence, on as many lines as it needs; ``beside`` pixels of each line are taken by other things."""
    column = layout.column(align=True)
    room, line = width_of(context) - beside - (_ICON if icon != "NONE" else 0), ""
    points = context.preferences.ui_styles[0].widget.points
    for word in text.split():
        longer = f"{line} {word}" if line else word
        if line and compat.text_width(longer, points) > room:
            column.label(text=line, icon=icon)
            icon, line = "BLANK1" if icon != "NONE" else "NONE", word
        else:
            line = longer
    column.label(text=line, icon=icon)
