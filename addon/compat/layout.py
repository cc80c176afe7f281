# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of the interface that some versions lack or have elsewhere."""

import blf
import bpy
import rna_keymap_ui
from bpy.types import Context, KeyConfig, KeyMap, KeyMapItem, UILayout, Window

from .translation import told


def draw_progress(layout: UILayout, fraction: float, text: str) -> None:
    """Draw a progress bar, with ``fraction`` from 0 to 1.

    Before 4.0, Blender has no bar: then it is a text.
    """
    if hasattr(layout, "progress"):
        layout.progress(factor=fraction, text=f"{fraction:.0%} {told(text)}")
    else:
        layout.label(text=f"{fraction:.0%} {told(text)}", icon="SORTTIME")


def text_width(text: str, points: float) -> float:
    """The width of a label in the interface font, in pixels at scale 1.

    ``points`` is the size of the font.
    """
    if bpy.app.version >= (4, 0, 0):
        blf.size(0, points)
    else:
        blf.size(0, points, 72)
    return blf.dimensions(0, text)[0]


def refresh_popup(context: Context) -> None:
    """Draw an open popup again while a text in it is typed. Before 4.2, Blender does so after Return only."""
    region = getattr(context, "region_popup", None)
    if region is not None:
        region.tag_refresh_ui()


def close_popups(window: Window) -> None:
    """Close the popups of a window as soon as the operator ends that is pressed in one of them.

    Blender does so when the screen of the window is changed, though it be to the same one.
    """
    window.screen = window.screen


def draw_keymap_item(layout: UILayout, keyconfig: KeyConfig, keymap: KeyMap, item: KeyMapItem) -> None:
    """Draw an item of the user's keymap, which can be edited as in Blender's own Keymap page."""
    column = layout.column()
    column.context_pointer_set("keymap", keymap)
    rna_keymap_ui.draw_kmi([], keyconfig, keymap, item, column, 0)
