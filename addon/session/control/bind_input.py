# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bind is asked for, whatever moves the mesh."""

from dataclasses import dataclass

import numpy as np

from ...backend import Recipe
from ...core.errors import OptionError
from ...core.methods import METHODS, group_property
from ...mesh_io import RestShape
from ...properties import SinewDeformer

_BINDING_NAMES = {  # the properties that a factor depends on, by method
    method.id: tuple(parameter.id for parameter in method.parameters if parameter.rebinds)
    + tuple(group_property(parameter) for parameter in method.paintable if parameter.rebinds)
    for method in METHODS
}


@dataclass(frozen=True)
class BindInput:
    """Everything a worker thread needs to build a factor.

    ``control`` says in words what moves the mesh. With handles: their keys and vertices, in bound order.
    """

    key: tuple
    recipe: Recipe
    rest: RestShape
    on_base: bool  # the vertices that enter are those of the base mesh
    control: str
    handles: tuple[str, ...] = ()
    indices: tuple[np.ndarray, ...] = ()
    after: "BindInput | None" = None  # of a preview: what is bound next


def option_values(settings: SinewDeformer) -> tuple:
    """The settings that a factor depends on, to compare."""
    values = settings.parameters
    return tuple((name, getattr(values, name)) for name in _BINDING_NAMES[settings.definition.id])


def options(settings: SinewDeformer, rest: RestShape) -> dict[str, object]:
    """The keywords of the native constructor; a painted one is (n,)."""
    values = settings.parameters
    found: dict[str, object] = {}
    for parameter in settings.definition.parameters:
        if not parameter.rebinds:
            continue
        value = getattr(values, parameter.id)
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
        parameter.id: getattr(settings.parameters, parameter.id)
        for parameter in settings.definition.parameters
        if not parameter.rebinds
    }
