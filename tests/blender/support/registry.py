# SPDX-License-Identifier: GPL-3.0-or-later
"""The rows of the add-on's registry, for tests that run on every row and name no method."""

import importlib
from collections.abc import Iterable

import installed
import numpy as np

_methods = importlib.import_module(f"{installed.name()}.core.methods")
METHODS, BY_ID = _methods.METHODS, _methods.BY_ID
Control, Moved, Posed, Reproduced = (_methods.Control, _methods.Moved, _methods.Posed, _methods.Reproduced)
TAKES_MINUTES = {"finest"}  # choices that are meant for references


def with_control(control: object) -> tuple[str, ...]:
    """The methods that such controls steer, the oldest first: a new row changes no rig."""
    rows = sorted(METHODS, key=lambda method: method.number)
    return tuple(method.id for method in rows if method.control is control)


WITH_HANDLES = with_control(Control.HANDLES)
WITH_CAGE = with_control(Control.CAGE)
ON_SURFACE = tuple(method for method in WITH_HANDLES if not BY_ID[method].is_space)
ON_HANDLE_POINTS = tuple(method for method in WITH_HANDLES if BY_ID[method].is_space)
RIGID_ON_HANDLE_POINTS = tuple(
    name for name in ON_HANDLE_POINTS if BY_ID[name].reproduces is not Reproduced.REST
)
GRABBING = tuple(method for method in ON_SURFACE if not BY_ID[method].wraps)  # those of Grab Once


def base_of(row: object) -> object | None:
    """The row of the method that this one is put around, until an artist picks another; None if alone."""
    return _methods.wrapped(row)[0] if row.wraps else None


def without_method(value: object) -> object:
    """A parameter of a test, with the kind of a method in place of the method: control, space, iterations."""
    if isinstance(value, tuple):
        return tuple(without_method(part) for part in value)
    row = BY_ID.get(value) if isinstance(value, str) else value
    return (row.control, row.is_space, row.iterative) if isinstance(row, _methods.Method) else value


def options_of(row: object, others: dict[str, object]) -> tuple[dict[str, object], dict[str, object]]:
    """Keywords of the native constructor and of its ``solve``: defaults of the row, but for ``others``."""
    constructor, solve = {}, {}
    for parameter in row.parameters:
        keywords = constructor if parameter.rebinds else solve
        keywords[parameter.id] = others.get(parameter.id, _given(parameter))
    return constructor, solve


def _given(parameter: object) -> object:
    """The default as the native module takes it: a curve by its values at even steps."""
    if not hasattr(parameter, "samples"):
        return parameter.default
    x, y = np.transpose(parameter.default)
    return np.interp(np.linspace(0.0, 1.0, parameter.samples), x, y)


def other_values(parameter: object) -> Iterable[object]:
    """What a test sets a parameter to: every choice, both ends of a switch, the end of a slider.

    Nothing for one whose value lies in another datablock: a test of its own draws or picks that.
    """
    if hasattr(parameter, "items"):
        return [item[0] for item in parameter.items if item[0] not in TAKES_MINUTES]
    if isinstance(parameter.default, bool):
        return [True, False]
    if not hasattr(parameter, "span"):
        return []
    least, most = parameter.span.minimum, parameter.span.soft
    return [most if most != parameter.default else type(parameter.default)(0.5 * (least + most))]
