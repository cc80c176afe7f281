# SPDX-License-Identifier: GPL-3.0-or-later
"""The rows of the registry that handles steer, their options as the native module takes them, and turns."""

from collections.abc import Iterator
from types import ModuleType

import numpy as np

from sinew.core.methods import BY_ID, Choice, Control, Curve, Float, Int, Method, Parameter, wrapped

WITH_HANDLES = [method.id for method in BY_ID.values() if method.control is Control.HANDLES]
ON_SURFACE = [method for method in WITH_HANDLES if not BY_ID[method].is_space]


def default_options(method: Method) -> dict[str, object]:
    """The keywords of the native constructor, without a base method."""
    return {parameter.id: _given(parameter) for parameter in method.parameters if parameter.rebinds}


def _given(parameter: Parameter) -> object:
    """The default; of a curve, its values at even steps."""
    if not isinstance(parameter, Curve):
        return parameter.default
    x, y = np.transpose(parameter.default)
    return np.interp(np.linspace(0.0, 1.0, parameter.samples), x, y)


def base_option(backend: ModuleType, method: Method) -> dict[str, object]:
    """The method that this one is put around until an artist picks another, as an option of a recipe."""
    if not method.wraps:
        return {}
    base = wrapped(method)[0]
    return {"base": backend.Base(base, default_options(base))}


def other_options(method: Method, count: int) -> Iterator[tuple[str, object]]:
    """Each parameter of the native constructor with another value than its default.

    A paintable one also painted on ``count`` vertices; none where the value lies in another datablock.
    """
    for parameter in method.parameters:
        if not parameter.rebinds:
            continue
        if isinstance(parameter, Choice):
            yield from ((parameter.id, item[0]) for item in parameter.items if item[0] != parameter.default)
        elif isinstance(parameter.default, bool):
            yield parameter.id, not parameter.default
        elif isinstance(parameter, Float | Int):
            most = parameter.span.soft
            yield parameter.id, type(most)(most if most != parameter.default else 0.5 * most)
        if parameter.paintable:
            yield parameter.id, np.linspace(0.5, 1.0, count)


def rotation(axis: tuple[float, float, float], angle: float) -> np.ndarray:
    """By Rodrigues, (3, 3)."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    cross = np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
