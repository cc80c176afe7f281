# SPDX-License-Identifier: GPL-3.0-or-later
"""The templates and presets of the parameters of a method, in a popover like those of Blender."""

import bpy
from bl_ui.utils import PresetPanel
from bpy.types import Context, Menu, Panel
from bpy.utils import register_classes_factory

from ..core.templates import TEMPLATES
from ..ids import Operators, Panels
from ..operators import preset_folder, target_of, template_refusal


class SINEW_PT_presets(PresetPanel, Panel):
    """Presets of the parameters of the method in use"""

    bl_idname = Panels.PRESETS
    bl_label = "Method Presets"
    preset_operator = Operators.PRESET_APPLY
    preset_add_operator = Operators.PRESET_ADD

    @property
    def preset_subdir(self) -> str:
        """The folder with the presets of the method in use, below Blender's folder of presets."""
        return preset_folder(bpy.context)

    def path_menu(self, folders: list[str], operator: str, **looks: object) -> None:
        """Draw one's own presets. Where none was made yet, Blender would say that their folder is missing."""
        Menu.path_menu(self, folders or [bpy.app.tempdir], operator, **looks)

    def draw(self, context: Context) -> None:
        """Draw the templates, grey where they do not fit the method, and below them one's own presets."""
        deformer = target_of(context).sinew.active
        column = self.layout.column(align=True)
        column.emboss = "PULLDOWN_MENU"
        for template in TEMPLATES:
            row = column.row()
            row.enabled = not template_refusal(deformer, template)
            row.operator(Operators.TEMPLATE_USE, text=template.label).template = template.id
        self.layout.separator()
        super().draw(context)


register, unregister = register_classes_factory((SINEW_PT_presets,))
