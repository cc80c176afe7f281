# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's page in Blender's Preferences."""

import textwrap

import bpy
from bpy.props import EnumProperty
from bpy.types import AddonPreferences, Context

from .backend import availability
from .core.methods import DEFAULT_METHOD, METHODS


class SinewPreferences(AddonPreferences):
    """What new deformers start with, and whether the native module works"""

    bl_idname = __package__

    method: EnumProperty(
        name="Method of New Deformers",
        items=tuple((method.id, method.label, method.summary, "NONE", method.number) for method in METHODS),
        default=DEFAULT_METHOD,
    )

    def draw(self, _context: Context) -> None:
        found = availability()
        layout = self.layout
        layout.prop(self, "method")
        if found.module is None:
            for number, line in enumerate(textwrap.wrap(found.remedy, 90)):
                layout.label(text=line, icon="BLANK1" if number else "ERROR")
        else:
            layout.label(text=f"Native module {found.module.__version__} is ready", icon="CHECKMARK")


def preferences(context: Context) -> SinewPreferences:
    """Our preferences, also where Blender loaded us without a preferences entry."""
    entry = context.preferences.addons.get(__package__)
    return entry.preferences if entry is not None and entry.preferences is not None else _Defaults


class _Defaults:
    method = DEFAULT_METHOD


register, unregister = bpy.utils.register_classes_factory((SinewPreferences,))
