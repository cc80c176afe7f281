# SPDX-License-Identifier: GPL-3.0-or-later
"""Our keys, in the keyconfig that Blender keeps for add-ons: the user's changes lie on top of it and stay."""

import bpy

from ..preferences import KEYMAP, SHORTCUTS, SPACE, find_items


def register() -> None:
    keyconfig = bpy.context.window_manager.keyconfigs.addon
    if keyconfig is None:  # without a window Blender has none
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
    """By what they are, not by kept references: those would dangle after another keyconfig was loaded."""
    for keymap, item in find_items(bpy.context.window_manager.keyconfigs.addon):
        keymap.keymap_items.remove(item)
