# SPDX-License-Identifier: GPL-3.0-or-later
"""What a row of the method registry says, and which kinds of parameter there are."""

from dataclasses import KW_ONLY, dataclass
from enum import Enum
from functools import cached_property
from typing import Any, ClassVar


class Family(Enum):
    """Sections of the method menu, in its order."""

    SURFACE_LINEAR = "Linear Surface"
    SURFACE_NONLINEAR = "Nonlinear Surface"
    MULTIRESOLUTION = "Multiresolution"
    SPACE_LINEAR = "Linear Space"
    SPACE_NONLINEAR = "Nonlinear Space"


class Control(Enum):
    """What an artist moves to steer a method."""

    HANDLES = "Handles"
    CAGE = "Cage"
    LATTICE = "Lattice"
    POINTS = "Points"
    CURVES = "Curves"


class Moved(Enum):
    """What a method can move."""

    MESH = "meshes"
    POINTS = "curves, text, hair and point clouds"


@dataclass(frozen=True)
class Parameter:
    """A value that the artist may set.

    ``rebinds``: a keyword of the native constructor, so a change makes a new factor; else a keyword of
    ``solve``. ``advanced``: seldom changed, so the panel shows it further down. ``unit``: what a number
    counts or measures, in words; Blender shows a "length" and an "angle" in the units of the scene.
    """

    id: str
    default: Any
    _: KW_ONLY
    label: str
    description: str
    unit: str = ""
    rebinds: bool = False
    advanced: bool = False
    paintable: ClassVar[bool] = False


@dataclass(frozen=True, kw_only=True)
class Float(Parameter):
    """A real number. ``step``: what one step of its arrows adds.

    Where it is ``paintable``, a vertex group may scale it per vertex.
    """

    minimum: float = 0.0
    maximum: float = 1e9
    soft_maximum: float = 10.0
    precision: int = 3
    step: float = 0.01
    paintable: bool = False  # type: ignore[misc]  # of a row here, of the class elsewhere


@dataclass(frozen=True, kw_only=True)
class Int(Parameter):
    """A whole number."""

    minimum: int = 0
    maximum: int = 1_000_000
    soft_maximum: int = 100


@dataclass(frozen=True, kw_only=True)
class Bool(Parameter):
    """A switch."""


@dataclass(frozen=True)
class Choice(Parameter):
    """One of ``items``: (identifier, label, description), in an order that never changes."""

    items: tuple[tuple[str, str, str], ...]


@dataclass(frozen=True, kw_only=True)
class Curve(Parameter):
    """A function on [0, 1] that the artist draws. ``default``: points that straight lines join.

    The native module gets its values at so many even steps, (samples,) float64.
    """

    samples: int = 257


@dataclass(frozen=True, kw_only=True)
class Pointer(Parameter):
    """An object, of one of ``types`` as Blender calls them, or of any.

    The native module gets its frame in the space of the target, (3, 4) float64; None where none is chosen.
    """

    types: tuple[str, ...] = ()
    default: None = None


@dataclass(frozen=True)
class Method:
    """One row. ``number`` is stored in files: never reuse or change it.

    ``iterative``: ``solve`` takes ``max_iterations`` and ``start``, so that a drag can show an early step.
    ``wraps``: the families of the methods that this one can be put around, which its native constructor gets
    as ``base``; none for a method of its own.
    ``handle_parameters``: every handle has its own value, and the native ``set_handles`` takes one keyword
    for each of them, with one value per handle.
    """

    id: str
    number: int
    label: str
    family: Family
    control: Control
    native: str
    section: str
    paper: str
    summary: str
    iterative: bool
    moves: frozenset[Moved]
    wraps: tuple[Family, ...] = ()
    parameters: tuple[Parameter, ...] = ()
    handle_parameters: tuple[Parameter, ...] = ()

    @property
    def is_space(self) -> bool:
        """It deforms the space around points, and knows of no surface."""
        return self.family in (Family.SPACE_LINEAR, Family.SPACE_NONLINEAR)

    @cached_property
    def references(self) -> tuple[Parameter, ...]:
        """The parameters whose value lies in another datablock."""
        return tuple(parameter for parameter in self.parameters if isinstance(parameter, Curve | Pointer))

    @cached_property
    def paintable(self) -> tuple[Parameter, ...]:
        """The parameters a vertex group may scale."""
        return tuple(parameter for parameter in self.parameters if parameter.paintable)


def group_property(parameter: Parameter) -> str:
    """The property that names the vertex group of a paintable parameter."""
    return f"{parameter.id}_group"
