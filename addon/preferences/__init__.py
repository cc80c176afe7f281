# SPDX-License-Identifier: GPL-3.0-or-later
"""The page of the add-on in Blender's Preferences."""

import bpy

from .page import DEFAULTS, PACKAGE, SinewPreferences, apply_limits, apply_names, preferences
from .shortcuts import KEYMAP, SHORTCUTS, SPACE, Shortcut, find_item, find_items


def register() -> None:
    bpy.utils.register_class(SinewPreferences)
    apply_limits(preferences(bpy.context))
    apply_names(preferences(bpy.context))


def unregister() -> None:
    bpy.utils.unregister_class(SinewPreferences)
