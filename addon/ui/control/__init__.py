# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel shows of each kind of control: the module here with the name of the kind."""

from importlib import import_module
from pathlib import Path
from typing import Protocol

from bpy.types import Context, Menu, Object, Panel, UILayout

from ...core.methods import Control, Method
from ...properties import SinewDeformer


class ControlDrawing(Protocol):
    """A module of this folder."""

    MENUS: tuple[type[Menu], ...]
    PANELS: tuple[type[Panel], ...]
    ABOVE_PARAMETERS: bool  # drawn between the method and its parameters, else below them

    @staticmethod
    def draw_start(context: Context, layout: UILayout, obj: Object) -> None:
        """The first step on an object that has no deformer."""

    @staticmethod
    def draw(context: Context, layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
        """The controls of the active deformer."""


_DRAWINGS: dict[Control, ControlDrawing] = {
    control: import_module(f".{control.name.lower()}", __package__)
    for control in Control
    if (Path(__file__).parent / f"{control.name.lower()}.py").is_file()
}

MENUS = tuple(menu for drawing in _DRAWINGS.values() for menu in drawing.MENUS)
PANELS = tuple(panel for drawing in _DRAWINGS.values() for panel in drawing.PANELS)


def drawing_of(method: Method) -> ControlDrawing:
    """How the controls of a method are drawn."""
    return _DRAWINGS[method.control]


def draw_start(context: Context, layout: UILayout, obj: Object) -> None:
    """The first steps on an object that has no deformer, by each kind of control."""
    for drawing in _DRAWINGS.values():
        drawing.draw_start(context, layout, obj)
