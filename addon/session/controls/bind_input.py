# SPDX-License-Identifier: GPL-3.0-or-later
"""The input of a bind, for every kind of control."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from bpy.types import PropertyGroup

from ...backend import Base, BoxShare, Recipe
from ...core.elements import NO_ELEMENTS, Elements, Owner
from ...core.methods import (
    METHODS,
    Box,
    Curve,
    Float,
    GridPoints,
    MeshShape,
    Method,
    Parameter,
    Pointer,
    UvMap,
    group_property,
)
from ...core.status import Level, Status
from ...mesh_io import RestShape
from ...properties import BASE, SinewDeformer
from ..datablocks import references

_Names = tuple[tuple[str, ...], tuple[Parameter, ...]]


def _names(method: Method, rebinds: bool) -> _Names:
    """The properties of a method with plain values, and its parameters that refer to other datablocks.

    Grids are left out: they are poses, see ``grid_moves``.
    """
    chosen = [
        parameter
        for parameter in method.parameters
        if parameter.rebinds == rebinds and not isinstance(parameter, GridPoints)
    ]
    referring = tuple(parameter for parameter in chosen if parameter in method.references)
    plain = [parameter.id for parameter in chosen if parameter not in referring]
    if rebinds and method.wraps:
        plain.append(BASE)
    return (*plain, *(group_property(parameter) for parameter in chosen if parameter.paintable)), referring


_NAMES: dict[tuple[str, bool], _Names] = {
    (method.id, rebinds): _names(method, rebinds) for method in METHODS for rebinds in (True, False)
}


@dataclass(frozen=True)
class BindInput:
    """Everything that a thread needs to build a factor.

    ``control`` names what moves the mesh, as the panel says it. ``handles``, ``names`` and ``indices`` are
    the keys, names and vertices of the bound handles, in their order; a cage has none. ``unused`` has a line
    for the panel per region that holds no vertex, ``unpainted`` one per parameter whose group or map is gone.
    ``stiff`` says why nothing will bend, and is empty if something will.
    """

    key: tuple
    recipe: Recipe
    rest: RestShape
    on_base: bool  # whether the vertices that enter are those of the base mesh
    control: str
    handles: tuple[str, ...] = ()
    names: tuple[str, ...] = ()
    indices: tuple[np.ndarray, ...] = ()
    unused: tuple[str, ...] = ()
    stiff: str = ""
    unpainted: tuple[Status, ...] = ()
    after: "BindInput | None" = None  # if this is a preview: the exact bind that follows

    def outside(self, points: Sequence[int] | np.ndarray, control: str) -> tuple[str, Elements]:
        """The sentence about points outside the control, and those that Select shows."""
        one, several = self.rest.point_type.nouns
        text = f"1 {one} lies" if len(points) == 1 else f"{len(points):,} {several} lie"
        elements = Elements(Owner.TARGET, "vertex", points) if self.on_base else NO_ELEMENTS
        return f"{text} outside the {control}", elements


def option_values(settings: SinewDeformer, rebinds: bool = True) -> tuple:
    """The settings that a factor depends on, or those that a solve depends on, for comparison."""
    found: list = [("sizes", settings.sizes)]
    for method, values in settings.methods:
        plain, referring = _NAMES[method.id, rebinds]
        found += [(name, getattr(values, name)) for name in plain]
        found += [(parameter.id, references.compared(values, parameter)) for parameter in referring]
    return tuple(found)


def options(settings: SinewDeformer, rest: RestShape) -> dict[str, object]:
    """The keywords of the native constructor. A painted parameter is an array (n,).

    A parameter whose vertex group is gone has its plain value; ``unpainted`` says so.
    """
    own, *bases = settings.methods
    of_boxes = settings.sizes == "BOX"
    found = _options(*own, rest, of_boxes)
    for method, values in bases:
        found[BASE] = Base(method, _options(method, values, rest, of_boxes))
    return found


def _options(method: Method, values: PropertyGroup, rest: RestShape, of_boxes: bool) -> dict[str, object]:
    found: dict[str, object] = {}
    for parameter in method.parameters:
        if not parameter.rebinds:
            continue
        if isinstance(parameter, UvMap):
            found[parameter.id] = rest.uv_maps.get(getattr(values, parameter.id))
            continue
        if isinstance(parameter, Box):
            found[parameter.id] = references.box(values, parameter, rest, of_boxes)
            continue
        if isinstance(parameter, MeshShape):
            found[parameter.id] = references.mesh_shape(values, parameter, rest)
            continue
        value = _value(values, parameter)
        painted = rest.weights.get(getattr(values, group_property(parameter), ""))
        if isinstance(parameter, Float) and painted is not None:
            value = np.maximum(value * painted.astype(np.float64), parameter.span.minimum)
        size = parameter.size_in_use(values) if of_boxes and isinstance(parameter, Float) else None
        if size is not None:
            value = BoxShare(value, size)
        found[parameter.id] = value
    return found


def unpainted(settings: SinewDeformer, rest: RestShape) -> tuple[Status, ...]:
    """A line for the panel per parameter whose vertex group or UV map is not on the mesh."""
    unmapped = tuple(
        Status(
            Level.WARNING,
            f"{parameter.label} '{name}' is not on the mesh: a plane is used instead - pick another",
            left_out=True,
        )
        for name, parameter in references.uv_maps(settings).items()
        if name not in rest.uv_maps
    )
    return unmapped + tuple(
        Status(
            Level.WARNING,
            f"{parameter.label} is not painted: vertex group '{group}' is not on the mesh - pick another",
            left_out=True,
        )
        for method, values in settings.methods
        for parameter in method.paintable
        if (group := getattr(values, group_property(parameter))) and group not in rest.weights
    )


def solve_options(settings: SinewDeformer) -> dict[str, Any]:
    """The keywords that ``solve`` of the method takes, with those of the method that it is put around."""
    return {
        parameter.id: _value(values, parameter)
        for method, values in reversed(settings.methods)
        for parameter in method.parameters
        if not parameter.rebinds and not isinstance(parameter, GridPoints)
    }


def grid_moves(settings: SinewDeformer) -> dict[str, np.ndarray]:
    """The keywords of ``solve`` for the control grids that an artist moves, (g, 3) float64 each."""
    found = {
        parameter.id: _value(values, parameter)
        for method, values in settings.methods
        for parameter in method.parameters
        if isinstance(parameter, GridPoints)
    }
    return {name: moves for name, moves in found.items() if moves is not None}


def _value(values: PropertyGroup, parameter: Parameter) -> Any:
    """The value of a parameter in the form that the native module takes."""
    if isinstance(parameter, Curve | Pointer):
        return references.value(values, parameter)
    return getattr(values, parameter.id)
