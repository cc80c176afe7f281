# SPDX-License-Identifier: GPL-3.0-or-later
"""The method registry: one row per method. Menus, properties, sessions and tests are made from these rows.

Every module of this folder that has ``ROWS`` is read, so no other file has to name a new row or module.
"""

from importlib import import_module
from pkgutil import iter_modules

from .schema import (
    DEFAULTS as DEFAULTS,
    Bool as Bool,
    Box as Box,
    Choice as Choice,
    Control as Control,
    Curve as Curve,
    Family,
    Float as Float,
    GridPoints as GridPoints,
    Int as Int,
    MeshObject as MeshObject,
    MeshShape as MeshShape,
    Method,
    Moved as Moved,
    Parameter,
    Pointer as Pointer,
    Posed as Posed,
    Reproduced as Reproduced,
    Size as Size,
    UvMap as UvMap,
    following as following,
    group_property as group_property,
)

DEFAULT_METHOD = "arap"  # the method of a deformer that Make Handle makes
DEFAULT_CAGE_METHOD = "mean_value"  # the method of a deformer that Wrap in a Cage makes
DEFAULT_PUPPET_METHOD = "mesh_puppetry"
DEFAULT_POINT_METHOD = "rbf"  # the method of a deformer that Add Points makes
DEFAULT_GRIP_METHOD = "inverse_ffd"  # the method that Sinew Drag gives to what is no mesh, such as text
DEFAULT_HOLD_METHOD = "mls"  # the method of a deformer that Sinew Drag: Points makes
DEFAULT_TOOL_METHOD = "vector_field"  # the method of a deformer that Add Tool and Sinew Drag: Clay make
DEFAULT_WIRE_METHOD = "wires"  # the method of a deformer that Add Wire makes
# The methods that a method is put around until the artist chooses another one.
DEFAULT_BASES = frozenset({"thin_shell", "rbf"})


def _menu_order(method: Method) -> tuple:
    """The order of the menu: by family, then by section of the tutorial."""
    section = tuple(map(int, method.section.split(".")))
    return list(Family).index(method.family), section, method.number


def _rows() -> list[Method]:
    modules = [import_module(f".{module.name}", __name__) for module in iter_modules(__path__)]
    return [row for module in modules for row in getattr(module, "ROWS", ())]


METHODS: tuple[Method, ...] = tuple(sorted(_rows(), key=_menu_order))
BY_ID: dict[str, Method] = {method.id: method for method in METHODS}
HANDLE_PARAMETERS: tuple[Parameter, ...] = tuple(
    {parameter.id: parameter for method in METHODS for parameter in method.handle_parameters}.values()
)
CONTROL_PARAMETERS: tuple[Parameter, ...] = tuple(
    {parameter.id: parameter for method in METHODS for parameter in method.control_parameters}.values()
)


def wrapped(method: Method) -> tuple[Method, ...]:
    """The methods that this one can be put around: the default first, the others in the menu's order."""
    bases = (
        base
        for base in METHODS
        if base.family in method.wraps
        and (base.control, base.posed) == (method.control, method.posed)
        and not (base.wraps or base.keyed)
    )
    return tuple(sorted(bases, key=lambda base: base.id not in DEFAULT_BASES))


def wrapper_of(method: Method) -> Method | None:
    """The method that keeps the details of a surface around this one; None if there is none."""
    return next((row for row in METHODS if row.wraps and method in wrapped(row)), None)
