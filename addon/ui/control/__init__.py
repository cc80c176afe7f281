# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel shows of each kind of control. The module of a kind has the name of the kind."""

from importlib import import_module
from pathlib import Path
from typing import Protocol

from bpy.types import Context, Menu, Object, UILayout

from ...core.methods import Control, Method
from ...properties import SinewDeformer
from ..layouts import Button


class ControlDrawing(Protocol):
    """What each module of this folder implements."""

    MENUS: tuple[type[Menu], ...]
    REST: tuple[Button, ...]  # what can be done with the rest of the controls

    @staticmethod
    def draw(context: Context, layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
        """Draw the controls of the active deformer, and what poses them."""

    @staticmethod
    def row_name(deformer: SinewDeformer) -> str:
        """The name of the active row; empty if there is none."""

    @staticmethod
    def draw_row(context: Context, layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
        """Draw the settings of the active row."""

    @staticmethod
    def draw_settings(context: Context, layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
        """Draw which object is the control, and what is seldom changed about it."""


_DRAWINGS: dict[Control, ControlDrawing] = {
    control: import_module(f".{control.name.lower()}", __package__)
    for control in Control
    if (Path(__file__).parent / f"{control.name.lower()}.py").is_file()
}

MENUS = tuple(menu for drawing in _DRAWINGS.values() for menu in drawing.MENUS)


def drawing_of(method: Method) -> ControlDrawing:
    """The module that draws the controls of a method."""
    return _DRAWINGS[method.control]
