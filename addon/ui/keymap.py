# SPDX-License-Identifier: GPL-3.0-or-later
"""Register the shortcuts in Blender's keyconfig for add-ons. Changes by the user are kept apart from it."""

import bpy

from ..preferences import KEYMAP, SHORTCUTS, SPACE, find_items


def register() -> None:
    keyconfig = bpy.context.window_manager.keyconfigs.addon
    if keyconfig is None:  # Blender has none without a window
        return
    keymap = keyconfig.keymaps.new(name=KEYMAP, space_type=SPACE)
    for shortcut in SHORTCUTS:
        item = keymap.keymap_items.new(
            shortcut.operator,
            shortcut.key,
            "PRESS",
            shift=shortcut.shift,
            ctrl=shortcut.ctrl,
            alt=shortcut.alt,
        )
        for name, value in shortcut.properties:
            setattr(item.properties, name, value)


def unregister() -> None:
    """Find the items again instead of keeping references, which dangle once another keyconfig is loaded."""
    for keymap, item in find_items(bpy.context.window_manager.keyconfigs.addon):
        keymap.keymap_items.remove(item)
