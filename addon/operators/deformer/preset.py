# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of the parameters of a method, kept by Blender's own system: one folder per method."""

import ast
import re
from pathlib import Path

import bpy
from bl_operators.presets import AddPresetBase
from bpy.props import StringProperty
from bpy.types import Context, Operator

from ...core.errors import SinewError
from ...core.methods import BY_ID
from ...ids import Operators, Panels
from ..arguments import once
from ..offered import OnDeformer
from ..reporting import reports_errors
from ..target import target_of

# A line of a preset. It is read, and never run as Blender runs its own presets.
_SETTING = re.compile(r"^deformer\.(\w+)\.(\w+) = (.+)$", re.MULTILINE)


def preset_folder(context: Context) -> str:
    """The folder with the presets of the method in use, below Blender's folder of presets."""
    return f"sinew/{target_of(context).sinew.active.definition.id}"


class SINEW_OT_preset_add(AddPresetBase, OnDeformer, Operator):
    """Keep the parameters of the method as a preset, or remove a preset"""

    bl_idname = Operators.PRESET_ADD
    bl_label = "Add Method Preset"

    preset_menu = Panels.PRESETS
    preset_defines = ("deformer = bpy.context.object.sinew.active",)

    @property
    def preset_subdir(self) -> str:
        """The folder that Blender writes the preset to."""
        return preset_folder(bpy.context)

    @property
    def preset_values(self) -> list[str]:
        """What the preset stores: all parameters with a plain value, also those of the base method."""
        parameters = bpy.context.object.sinew.active.plain_parameters
        return [f"deformer.{method}.{name}" for method, name in parameters]

    def execute(self, context: Context) -> set[str]:
        with context.temp_override(object=target_of(context)):  # where a control is active
            return super().execute(context)


class SINEW_OT_preset_apply(OnDeformer, Operator):
    """Give the method the parameters of this preset"""

    bl_idname = Operators.PRESET_APPLY
    bl_label = "Apply Method Preset"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    filepath: once(StringProperty, "File Path", "Choose the file of the preset", subtype="FILE_PATH")

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        deformer = target_of(context).sinew.active
        try:
            for method, name, value in _SETTING.findall(Path(self.filepath).read_text(encoding="utf-8")):
                values = getattr(deformer, method) if method in BY_ID else None
                if hasattr(values, name):  # another release may have other parameters
                    setattr(values, name, ast.literal_eval(value))
        except (OSError, SyntaxError, TypeError, ValueError) as error:
            raise SinewError(f"This preset cannot be used: {error}") from error
        return {"FINISHED"}
