# SPDX-License-Identifier: GPL-3.0-or-later
"""The presets of the parameters of a method, in a popover like that of Blender's own presets."""

import bpy
from bl_ui.utils import PresetPanel
from bpy.types import Panel
from bpy.utils import register_classes_factory

from ..ids import Operators, Panels
from ..operators import preset_folder


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


register, unregister = register_classes_factory((SINEW_PT_presets,))
