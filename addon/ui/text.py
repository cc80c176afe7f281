# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw sentences in a narrow sidebar."""

from bpy.types import Context, UILayout

from .. import compat

_CHARACTER = 5.8  # average width of a letter, in pixels at scale 1
_EDGES = 59  # width of the margins of region, panel and box around a line without an icon
_ICON = 20
_TABS = 21  # width of the tabs, which are inside the region of the sidebar


def width_of(context: Context) -> float:
    """The width of a line, including its icon, in the region that is being drawn; in pixels at scale 1."""
    tabs = _TABS if context.region.type == "UI" else 0
    return context.region.width / context.preferences.system.ui_scale - _EDGES - tabs


def columns(context: Context) -> int:
    """About how many characters fit in a line that begins with an icon."""
    return max(12, int((width_of(context) - _ICON) / _CHARACTER))


def draw_text(context: Context, layout: UILayout, text: str, icon: str = "NONE", beside: int = 0) -> None:
    """Draw a sentence in the language of the interface, on as many lines as it needs.

    ``beside`` is the width of what is drawn beside it.
    """
    column = layout.column(align=True)
    room, line = width_of(context) - beside - (_ICON if icon != "NONE" else 0), ""
    points = context.preferences.ui_styles[0].widget.points
    for word in compat.told(text).split():
        longer = f"{line} {word}" if line else word
        if line and compat.text_width(longer, points) > room:
            column.label(text=line, icon=icon)
            icon, line = "BLANK1" if icon != "NONE" else "NONE", word
        else:
            line = longer
    column.label(text=line, icon=icon)
