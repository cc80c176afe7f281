# SPDX-License-Identifier: GPL-3.0-or-later
"""How much room a region has, and sentences that fit in it."""

from bpy.types import Context, UILayout

from .. import compat

_CHARACTER = 5.8  # average width of a letter, in pixels at scale 1
_EDGES = 40  # width of the margins of region and panel around a line without an icon
_BOX = 19  # and of a box
_ICON = 20
_TABS = 21  # width of the tabs, which are inside the region of the sidebar
_SCROLL = 12  # and of the scroll bar in other regions
_BUTTON, _PLAIN = 24, 8  # of a button, beside its text: its icon and its edges, or its edges
_WIDE = 44  # characters


def width_of(context: Context, boxed: bool = False) -> float:
    """The width of a line, including its icon, in the region that is being drawn; in pixels at scale 1.

    ``boxed``: it is in a box.
    """
    side = _TABS if context.region.type == "UI" else _SCROLL
    return context.region.width / context.preferences.system.ui_scale - _EDGES - side - _BOX * boxed


def columns(context: Context) -> int:
    """About how many characters fit in a line that begins with an icon, in a box."""
    return max(12, int((width_of(context, boxed=True) - _ICON) / _CHARACTER))


def is_wide(context: Context) -> bool:
    """Whether labels have room beside their fields, and buttons beside their line."""
    return columns(context) >= _WIDE


def fit_beside(context: Context, *buttons: tuple[str, str], boxed: bool = False) -> bool:
    """Whether buttons with these texts and icons have room beside each other."""
    share = width_of(context, boxed) / len(buttons)
    return all(width_of_button(context, *button) <= share for button in buttons)


def width_of_button(context: Context, text: str, icon: str) -> float:
    """The width that a button needs, in pixels at scale 1."""
    points = context.preferences.ui_styles[0].widget.points
    return compat.text_width(compat.told(text), points) + (_PLAIN if icon == "NONE" else _BUTTON)


def draw_text(
    context: Context, layout: UILayout, text: str, icon: str = "NONE", beside: float = 0, boxed: bool = True
) -> None:
    """Draw a sentence in the language of the interface, on as many lines as it needs.

    ``beside`` is the width of what is drawn beside it. ``boxed``: it may be in a box.
    """
    column = layout.column(align=True)
    room, line = width_of(context, boxed) - beside - (_BUTTON if icon != "NONE" else _PLAIN), ""
    points = context.preferences.ui_styles[0].widget.points
    for word in compat.told(text).split():
        longer = f"{line} {word}" if line else word
        if line and compat.text_width(longer, points) > room:
            column.label(text=line, icon=icon)
            icon, line = "BLANK1" if icon != "NONE" else "NONE", word
        else:
            line = longer
    column.label(text=line, icon=icon)
