# SPDX-License-Identifier: GPL-3.0-or-later
"""The lists of deformers and of handles."""

from bpy.types import Context, UILayout, UIList
from bpy.utils import register_classes_factory

from ..core import status
from ..core.status import Level
from ..ids import Operators
from ..properties import HANDLE_KINDS, SinewDeformer, SinewHandle, SinewObject
from .text import columns

_ICONS = {identifier: icon for identifier, _label, _description, icon, _number in HANDLE_KINDS}


class SINEW_UL_deformers(UIList):
    """Deformers of the mesh, with whether they follow their controls"""

    def draw_item(
        self,
        _context: Context,
        layout: UILayout,
        _owner: SinewObject,
        deformer: SinewDeformer,
        _icon: int,
        _active_owner: SinewObject,
        _active_property: str,
    ) -> None:
        failing = status.of(deformer.uid).level is Level.ERROR
        layout.prop(deformer, "name", text="", emboss=False, icon="ERROR" if failing else "MOD_MESHDEFORM")
        icon = "RADIOBUT_ON" if deformer.live else "RADIOBUT_OFF"
        layout.prop(deformer, "live", text="", emboss=False, icon=icon)


class SINEW_UL_handles(UIList):
    """Regions of a deformer: name, control, weight, select, use"""

    def draw_item(
        self,
        context: Context,
        layout: UILayout,
        _owner: SinewDeformer,
        handle: SinewHandle,
        _icon: int,
        _active_owner: SinewDeformer,
        _active_property: str,
        index: int,
    ) -> None:
        row = layout.row(align=True)
        row.active = handle.enabled
        swatch = row.row()
        swatch.ui_units_x = 0.6
        swatch.prop(handle, "colour", text="")
        row.prop(handle, "name", text="", emboss=False, icon=_ICONS[handle.kind])
        if handle.control_missing:
            picker = row.row()
            picker.alert = True
            picker.prop(handle, "control", text="")
        elif columns(context) > 40:
            row.label(text=handle.control_label)
        if columns(context) > 28:
            weight = row.row()
            weight.ui_units_x = 2.2
            weight.prop(handle, "weight", text="", emboss=False)
            select = row.operator(Operators.SELECT_HANDLE, text="", icon="RESTRICT_SELECT_OFF", emboss=False)
            select.index = index
        row.prop(handle, "enabled", text="", emboss=False, icon="HIDE_OFF" if handle.enabled else "HIDE_ON")


register, unregister = register_classes_factory((SINEW_UL_deformers, SINEW_UL_handles))
