# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel shows of each kind of control. The module of a kind has the name of the kind."""

from importlib import import_module
from pathlib import Path
from typing import Protocol

from bpy.types import Context, Menu, Object, Panel, UILayout

from ...core.methods import Control, Method
from ...properties import SinewDeformer


class ControlDrawing(Protocol):
    """What each module of this folder implements."""

    MENUS: tuple[type[Menu], ...]
    PANELS: tuple[type[Panel], ...]
    ABOVE_PARAMETERS: bool  # whether the controls are drawn above the parameters of the method, or below them

    @staticmethod
    def draw_start(context: Context, layout: UILayout, obj: Object) -> None:
        """Draw the first step for an object that has no deformer."""

    @staticmethod
    def draw(context: Context, layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
        """Draw the controls of the active deformer."""


_DRAWINGS: dict[Control, ControlDrawing] = {
    control: import_module(f".{control.name.lower()}", __package__)
    for control in Control
    if (Path(__file__).parent / f"{control.name.lower()}.py").is_file()
}

MENUS = tuple(menu for drawing in _DRAWINGS.values() for menu in drawing.MENUS)
PANELS = tuple(panel for drawing in _DRAWINGS.values() for panel in drawing.PANELS)


def drawing_of(method: Method) -> ControlDrawing:
    """The module that draws the controls of a method."""
    return _DRAWINGS[method.control]


def draw_start(context: Context, layout: UILayout, obj: Object) -> None:
    """Draw the first steps for an object that has no deformer, for all kinds of control."""
    for drawing in _DRAWINGS.values():
        drawing.draw_start(context, layout, obj)
