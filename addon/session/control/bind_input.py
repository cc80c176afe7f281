# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bind is asked for, whatever moves the mesh."""

from dataclasses import dataclass

import numpy as np

from ...backend import CageRecipe, Recipe
from ...core.errors import OptionError
from ...core.methods import METHODS, Curve, Method, Parameter, Pointer, group_property
from ...mesh_io import RestShape
from ...properties import SinewDeformer
from ..blocks import references

_Names = tuple[tuple[str, ...], tuple[Parameter, ...]]


def _names(method: Method, rebinds: bool) -> _Names:
    """The properties of a method with plain values, and its parameters that refer to other datablocks."""
    chosen = [parameter for parameter in method.parameters if parameter.rebinds == rebinds]
    referring = tuple(parameter for parameter in chosen if parameter in method.references)
    plain = [parameter.id for parameter in chosen if parameter not in referring]
    return (*plain, *(group_property(parameter) for parameter in chosen if parameter.paintable)), referring


_NAMES: dict[tuple[str, bool], _Names] = {
    (method.id, rebinds): _names(method, rebinds) for method in METHODS for rebinds in (True, False)
}


@dataclass(frozen=True)
class BindInput:
    """Everything a worker thread needs to build a factor.

    ``control`` says in words what moves the mesh. With handles: their keys and vertices, in bound order.
    """

    key: tuple
    recipe: Recipe | CageRecipe
    rest: RestShape
    on_base: bool  # the vertices that enter are those of the base mesh
    control: str
    handles: tuple[str, ...] = ()
    indices: tuple[np.ndarray, ...] = ()
    after: "BindInput | None" = None  # of a preview: what is bound next


def option_values(settings: SinewDeformer, rebinds: bool = True) -> tuple:
    """The settings that a factor depends on, or else a solve, to compare."""
    values = settings.parameters
    plain, referring = _NAMES[settings.definition.id, rebinds]
    found = tuple((name, getattr(values, name)) for name in plain)
    if not referring:
        return found
    return (*found, *((parameter.id, references.compared(settings, parameter)) for parameter in referring))


def _value(settings: SinewDeformer, parameter: Parameter) -> object:
    """As the native module takes it."""
    if isinstance(parameter, Curve | Pointer):
        return references.value(settings, parameter)
    return getattr(settings.parameters, parameter.id)


def options(settings: SinewDeformer, rest: RestShape) -> dict[str, object]:
    """The keywords of the native constructor; a painted one is (n,)."""
    values = settings.parameters
    found: dict[str, object] = {}
    for parameter in settings.definition.parameters:
        if not parameter.rebinds:
            continue
        value = _value(settings, parameter)
        group = getattr(values, group_property(parameter), "")
        if group:
            painted = rest.weights.get(group)
            if painted is None:
                raise OptionError(
                    f"{parameter.label}: vertex group '{group}' is not on the mesh - pick another"
                )
            value = np.maximum(value * painted.astype(np.float64), parameter.minimum)
        found[parameter.id] = value
    return found


def solve_options(settings: SinewDeformer) -> dict[str, object]:
    """The keywords of ``solve`` that the method takes."""
    return {
        parameter.id: _value(settings, parameter)
        for parameter in settings.definition.parameters
        if not parameter.rebinds
    }
