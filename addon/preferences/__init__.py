# SPDX-License-Identifier: GPL-3.0-or-later
"""The page of the add-on in Blender's Preferences."""

import bpy

from .page import (
    DEFAULTS as DEFAULTS,
    PACKAGE as PACKAGE,
    SinewPreferences,
    apply_limits,
    apply_names,
    preferences,
)
from .shortcuts import KEYMAP as KEYMAP, SHORTCUTS as SHORTCUTS, SPACE as SPACE, find_items as find_items


def register() -> None:
    bpy.utils.register_class(SinewPreferences)
    apply_limits(preferences(bpy.context))
    apply_names(preferences(bpy.context))


def unregister() -> None:
    bpy.utils.unregister_class(SinewPreferences)
