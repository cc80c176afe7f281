# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of the parameters of a method, kept by Blender's own system: one folder per method."""

import ast
import re
from pathlib import Path

import bpy
from bl_operators.presets import AddPresetBase
from bpy.props import EnumProperty, StringProperty
from bpy.types import Context, Operator

from ... import compat
from ...core.errors import SinewError
from ...core.labels import label_of
from ...core.methods import BY_ID
from ...core.templates import TEMPLATE_BY_ID, TEMPLATES, Template, values_of
from ...ids import Operators, Panels
from ...properties import SinewDeformer
from ..arguments import once
from ..offered import OnDeformer, OnLiveDeformer
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

    filepath: once(StringProperty, subtype="FILE_PATH").named("File Path", "Choose the file of the preset")

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


class SINEW_OT_use_template(OnLiveDeformer, Operator):
    """Give the method the settings of a template"""

    bl_idname = Operators.TEMPLATE_USE
    bl_label = "Use Template"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    template: once(EnumProperty, items=tuple((row.id, row.label, row.purpose) for row in TEMPLATES)).named(
        "Template", "Choose what the result looks like"
    )

    @classmethod
    def description(cls, context: Context, properties: "SINEW_OT_use_template") -> str:
        """The tooltip: why it is grey, and what it is for."""
        template = TEMPLATE_BY_ID[properties.template]
        reason = template_refusal(target_of(context).sinew.active, template)
        return ".\n".join(map(compat.told, filter(None, (reason, template.purpose))))

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        deformer, template = target_of(context).sinew.active, TEMPLATE_BY_ID[self.template]
        refusal = template_refusal(deformer, template)
        if refusal:
            raise SinewError(refusal)
        method, values = deformer.methods[-1]
        for name, value in values_of(template, method).items():
            setattr(values, name, value)
        context.view_layer.update()
        return {"FINISHED"}


def template_refusal(deformer: SinewDeformer, template: Template) -> str:
    """Why a template does not fit the method of a deformer; empty if it does."""
    method, _values = deformer.methods[-1]
    return "" if values_of(template, method) else f"{label_of(method)} has no settings like {template.label}"
