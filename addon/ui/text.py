# SPDX-License-Identifier: GPL-3.0-or-later
"""Sentences in a narrow sidebar."""

from bpy.types import Context, UILayout

_CHARACTER = 5.8  # average width in pixels at scale 1
_MARGIN = 68  # pixels of a line that icon, box and edges take


def columns(context: Context, margin: int = _MARGIN) -> int:
    """How many characters fit a line of the region being drawn."""
    width = context.region.width / context.preferences.system.ui_scale
    return max(12, int((width - margin) / _CHARACTER))


def draw_text(context: Context, layout: UILayout, text: str, icon: str = "NONE", beside: int = 0) -> None:
    """A sentence, on as many lines as it needs; ``beside`` pixels of each line are taken by other things."""
    column = layout.column(align=True)
    width, line = columns(context, beside + (_MARGIN if icon != "NONE" else _MARGIN // 2)), ""
    for word in text.split():
        if line and len(line) + 1 + len(word) > width:
            column.label(text=line, icon=icon)
            icon, line = "BLANK1" if icon != "NONE" else "NONE", word
        else:
            line = f"{line} {word}".strip()
    column.label(text=line, icon=icon)
