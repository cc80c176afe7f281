# SPDX-License-Identifier: GPL-3.0-or-later
"""The lists of deformers, of handles, and of objects that control a deformer together."""

from bpy.types import Context, ShapeKey, UILayout, UIList
from bpy.utils import register_classes_factory

from ..core import status
from ..core.status import Level
from ..properties import HANDLE_ROLES, SinewControl, SinewDeformer, SinewHandle, SinewObject
from ..session.actions.controls import control_list as rows
from ..session.targets.kinds import kind_of
from .keys import SINEW_UL_keys
from .layouts import RowList
from .text import columns

_ICONS = {identifier: icon for identifier, _label, _description, icon, _number in HANDLE_ROLES}
_RENDER_FROM = 26  # characters that a region is wide, from which the eye for renders is shown, too


def draw_deformer(context: Context, layout: UILayout, owner: SinewObject, deformer: SinewDeformer) -> None:
    """Draw the name of a deformer, whether it is live, and where it is shown."""
    failing = status.current(deformer.uid).level is Level.ERROR
    layout.prop(deformer, "name", text="", emboss=False, icon="ERROR" if failing else "NONE")
    row = layout.row(align=True)
    row.prop(deformer, "live", text="", emboss=False, icon="PLAY" if deformer.live else "FREEZE")
    modifier = kind_of(owner.id_data).shown_by(owner.id_data, deformer)
    if isinstance(modifier, ShapeKey):
        icon = "HIDE_ON" if modifier.mute else "HIDE_OFF"
        row.prop(modifier, "mute", text="", emboss=False, icon=icon)
    elif modifier is not None:
        row.prop(modifier, "show_viewport", text="", emboss=False)
        if columns(context) > _RENDER_FROM:
            row.prop(modifier, "show_render", text="", emboss=False)


class SINEW_UL_deformers(RowList, UIList):
    """The deformers of an object: name, whether they are live, and where they are shown"""

    def draw_row(
        self, context: Context, layout: UILayout, owner: SinewObject, deformer: SinewDeformer, *_
    ) -> None:
        draw_deformer(context, layout, owner, deformer)


class SINEW_UL_handles(RowList, UIList):
    """The regions of a deformer: colour, name, and whether they are used. A click selects the control"""

    def draw_row(
        self, _context: Context, layout: UILayout, _owner: SinewDeformer, handle: SinewHandle, *_
    ) -> None:
        row = layout.row(align=True)
        row.active = handle.enabled
        swatch = row.row()
        swatch.ui_units_x = 0.6
        if handle.kind == "HANDLE":
            swatch.prop(handle, "colour", text="")
        else:  # overlays show all other regions in one colour, which the preferences set
            swatch.label(text="")
        row.prop(handle, "name", text="", emboss=False, icon=_ICONS[handle.kind])
        if handle.control_missing:
            picker = row.row()
            picker.alert = True
            picker.ui_units_x = 2.4
            picker.prop(handle, "control", text="")
        row.prop(handle, "enabled", text="", emboss=False, icon="HIDE_OFF" if handle.enabled else "HIDE_ON")


class SINEW_UL_controls(RowList, UIList):
    """The wires or tools of a deformer: the object, and whether it is used"""

    def draw_row(
        self,
        _context: Context,
        layout: UILayout,
        _owner: SinewDeformer,
        control: SinewControl,
        icon: int,
        _index: int,
    ) -> None:
        row = layout.row(align=True)
        row.active = control.enabled
        row.alert = control.missing
        if control.object is None:
            row.prop(control, "object", text="")
        else:
            row.prop(control.object, "name", text="", emboss=False, icon_value=icon)
        row.prop(control, "enabled", text="", emboss=False, icon="HIDE_OFF" if control.enabled else "HIDE_ON")

    def filter_items(
        self, _context: Context, deformer: SinewDeformer, _property: str
    ) -> tuple[list[int], list[int]]:
        """Only the rows of the kind that the method in use asks for."""
        shown = {row.as_pointer() for row in rows.rows_of(deformer)}
        return [self.bitflag_filter_item if row.as_pointer() in shown else 0 for row in deformer.controls], []


register, unregister = register_classes_factory(
    (SINEW_UL_deformers, SINEW_UL_handles, SINEW_UL_controls, SINEW_UL_keys)
)
