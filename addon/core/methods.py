# SPDX-License-Identifier: GPL-3.0-or-later
"""The method registry: one row a method. Menus, properties, sessions and tests are made from these rows."""

from dataclasses import dataclass
from enum import Enum


class Family(Enum):
    """Sections of the method menu."""

    SURFACE_LINEAR = "Linear Surface"
    SURFACE_NONLINEAR = "Nonlinear Surface"
    SPACE_LINEAR = "Linear Space"
    SPACE_NONLINEAR = "Nonlinear Space"


class Control(Enum):
    """What an artist moves to steer a method."""

    HANDLES = "Handles"
    CAGE = "Cage"
    LATTICE = "Lattice"
    POINTS = "Points"
    CURVES = "Curves"


@dataclass(frozen=True)
class Parameter:
    """A value the artist may set.

    ``rebinds``: a keyword of the native constructor, a change makes a new factor; without it, a keyword of
    ``solve``. ``advanced``: seldom changed, so the panel shows it further down.
    """

    id: str
    default: object


@dataclass(frozen=True)
class Float(Parameter):
    """A real number; where ``paintable``, a vertex group may scale it per vertex."""

    minimum: float = 0.0
    maximum: float = 1e9
    soft_maximum: float = 10.0
    precision: int = 3
    paintable: bool = False
    rebinds: bool = False
    advanced: bool = False
    label: str = ""
    description: str = ""


@dataclass(frozen=True)
class Int(Parameter):
    """A whole number."""

    minimum: int = 0
    maximum: int = 1_000_000
    soft_maximum: int = 100
    rebinds: bool = False
    label: str = ""
    description: str = ""


@dataclass(frozen=True)
class Bool(Parameter):
    """A switch."""

    rebinds: bool = False
    label: str = ""
    description: str = ""


@dataclass(frozen=True)
class Choice(Parameter):
    """One of ``items``: (identifier, label, description), in an order that never changes."""

    items: tuple[tuple[str, str, str], ...] = ()
    rebinds: bool = False
    advanced: bool = False
    label: str = ""
    description: str = ""


@dataclass(frozen=True)
class Method:
    """One row. ``number`` is stored in files: never reuse or change it."""

    id: str
    number: int
    label: str
    family: Family
    control: Control
    native: str
    section: str
    paper: str
    summary: str
    parameters: tuple[Parameter, ...] = ()
    continuity: bool = False  # each handle has a boundary continuity of its own, C0 to C2

    @property
    def iterative(self) -> bool:
        """Solves by steps, so a drag can show an early one."""
        return self.family in (Family.SURFACE_NONLINEAR, Family.SPACE_NONLINEAR)

    @property
    def paintable(self) -> tuple[Parameter, ...]:
        """The parameters a vertex group may scale."""
        return tuple(parameter for parameter in self.parameters if getattr(parameter, "paintable", False))


def group_property(parameter: Parameter) -> str:
    """The property that names the vertex group of a paintable parameter."""
    return f"{parameter.id}_group"


LAPLACIANS = (
    ("uniform", "Uniform", "Counts neighbours only: for meshes so messy that angles and areas mean nothing"),
    ("cotan", "Cotangent", "Follows the shape of the faces, not their size"),
    (
        "cotan_voronoi",
        "Cotangent + Area",
        "Follows shape and size of the faces: the least dependent on the meshing",
    ),
)

CELLS = (
    ("spokes", "Spokes", "Each vertex keeps the edges that meet it rigid"),
    ("rims", "Spokes and Rims", "Also the edges opposite to it: firmer, and steadier on sharp triangles"),
)

PRECISIONS = (
    ("single", "Single", "Half the memory and time of a frame; exact to a ten-millionth of the cage's size"),
    ("double", "Double", "As exact as the coordinates themselves"),
)

CAGE_PARAMETERS = (
    Float(
        "threshold",
        0.0,
        maximum=0.1,
        soft_maximum=0.01,
        precision=5,
        rebinds=True,
        advanced=True,
        label="Sparse Threshold",
        description="Leave out smaller weights, so that each point follows the near part of the cage "
        "alone: faster, less exact. 0 keeps all",
    ),
    Choice(
        "precision",
        "single",
        PRECISIONS,
        rebinds=True,
        advanced=True,
        label="Precision",
        description="How exactly the weights are kept",
    ),
)

OUTSIDE_REFUSED = Choice(
    "outside",
    "error",
    (
        ("error", "Refuse", "Vertices outside the cage are named, and nothing moves until they are inside"),
        ("mean_value", "Mean Value", "Vertices outside the cage follow it by mean value coordinates"),
    ),
    rebinds=True,
    label="Outside",
    description="What becomes of vertices outside the cage",
)

QUALITIES = (
    ("fast", "Fast", "Some hundredths of a second for 150 faces; weights to a fiftieth"),
    ("medium", "Medium", "Some tenths of a second for 150 faces; weights to a two-hundredth"),
    ("fine", "Fine", "A second or two for 150 faces"),
    ("finest", "Finest", "A minute and a gigabyte; for references"),
)

METHODS: tuple[Method, ...] = (
    Method(
        id="thin_shell",
        number=1,
        label="Thin Shell",
        family=Family.SURFACE_LINEAR,
        control=Control.HANDLES,
        native="ThinShell",
        section="4.3",
        paper="Botsch & Kobbelt 2004",
        summary="Smooth and fair; best for translations and gentle bends",
        continuity=True,
        parameters=(
            Float(
                "stretching",
                0.0,
                soft_maximum=1.0,
                paintable=True,
                rebinds=True,
                label="Stretching",
                description="k_s: how much the surface resists being stretched, like a rubber skin. "
                "Raise it for a tauter, straighter transition",
            ),
            Float(
                "bending",
                1.0,
                soft_maximum=1.0,
                paintable=True,
                rebinds=True,
                label="Bending",
                description="k_b: how much the surface resists being bent, like a thin plate. "
                "Keeps the transition smooth at the edge of a handle",
            ),
            Float(
                "variation",
                0.0,
                soft_maximum=1.0,
                paintable=True,
                rebinds=True,
                label="Variation",
                description="How much the surface resists a change of its curvature. "
                "Gives the roundest, fairest shapes, and needs wider handles",
            ),
            Choice(
                "laplacian",
                "cotan_voronoi",
                LAPLACIANS,
                rebinds=True,
                label="Laplacian",
                description="How the mesh is measured",
            ),
        ),
    ),
    Method(
        id="arap",
        number=2,
        label="As-Rigid-As-Possible",
        family=Family.SURFACE_NONLINEAR,
        control=Control.HANDLES,
        native="Arap",
        section="6",
        paper="Sorkine & Alexa 2007, Levi & Gotsman 2015",
        summary="Keeps details through large turns; best for limbs",
        parameters=(
            Float(
                "smoothness",
                5e-4,
                maximum=10.0,
                soft_maximum=0.01,
                precision=5,
                rebinds=True,
                label="Smooth Rotations",
                description="How much neighbouring parts turn together, as a share of the surface's size. "
                "0 is the textbook energy, which buckles on fine meshes",
            ),
            Choice(
                "cells",
                "spokes",
                CELLS,
                rebinds=True,
                label="Cells",
                description="Which edges each vertex keeps rigid",
            ),
            Float(
                "rigidity",
                1.0,
                minimum=0.001,
                soft_maximum=1.0,
                paintable=True,
                rebinds=True,
                label="Rigidity",
                description="How firmly a region keeps its shape. "
                "Paint a vertex group to let soft parts give way before hard ones",
            ),
            Int(
                "max_iterations",
                40,
                minimum=1,
                soft_maximum=100,
                label="Iterations",
                description="The most steps a frame or a render may spend. "
                "While you drag, fewer are taken and the rest follow when you stop",
            ),
            Float(
                "tolerance",
                1e-5,
                maximum=1.0,
                soft_maximum=0.001,
                precision=6,
                label="Tolerance",
                description="Stop when two steps in a row lower the energy by less than this share of it",
            ),
        ),
    ),
    Method(
        id="mean_value",
        number=3,
        label="Mean Value Cage",
        family=Family.SPACE_LINEAR,
        control=Control.CAGE,
        native="MeanValue",
        section="5.4",
        paper="Ju, Schaefer & Warren 2005",
        summary="Any points, inside the cage or outside; limbs that lie side by side pull at each other",
        parameters=CAGE_PARAMETERS,
    ),
    Method(
        id="positive_mean_value",
        number=4,
        label="Positive Mean Value Cage",
        family=Family.SPACE_LINEAR,
        control=Control.CAGE,
        native="PositiveMeanValue",
        section="5.4",
        paper="Lipman, Kopf, Cohen-Or & Levin 2007",
        summary="Each point follows what it sees of the cage, so limbs do not pull at each other",
        parameters=(
            Bool(
                "exact",
                True,
                rebinds=True,
                label="Exact",
                description="Off, what is seen is guessed by rays: a quicker preview that is a little rough",
            ),
            Int(
                "directions",
                1024,
                minimum=8,
                maximum=65536,
                soft_maximum=4096,
                rebinds=True,
                label="Rays",
                description="How many rays a point has where the weights are not exact",
            ),
            OUTSIDE_REFUSED,
            *CAGE_PARAMETERS,
        ),
    ),
    Method(
        id="harmonic",
        number=5,
        label="Harmonic Cage",
        family=Family.SPACE_LINEAR,
        control=Control.CAGE,
        native="Harmonic",
        section="5.4",
        paper="Joshi, Meyer, DeRose, Green & Sanocki 2007",
        summary="Influence flows inside the cage, along limbs and never across gaps; smooth inside",
        parameters=(
            Choice(
                "quality",
                "medium",
                QUALITIES,
                rebinds=True,
                label="Quality",
                description="How exactly the weights are computed, once, at bind",
            ),
            OUTSIDE_REFUSED,
            *CAGE_PARAMETERS,
        ),
    ),
    Method(
        id="green",
        number=6,
        label="Green Cage",
        family=Family.SPACE_LINEAR,
        control=Control.CAGE,
        native="Green",
        section="5.4",
        paper="Lipman, Levin & Cohen-Or 2008",
        summary="Keeps shapes: parts turn instead of shearing, and bulge out of the cage a little",
        parameters=(
            Choice(
                "outside",
                "nearest",
                (
                    ("nearest", "Nearest Face", "Each vertex outside follows through the nearest face"),
                    (
                        "error",
                        "Refuse",
                        "Vertices outside are named, and nothing moves until they are inside",
                    ),
                ),
                rebinds=True,
                label="Outside",
                description="What becomes of vertices outside the cage",
            ),
            *CAGE_PARAMETERS,
        ),
    ),
)

DEFAULT_METHOD = "arap"  # what Add Handle makes on a mesh without a deformer
DEFAULT_CAGE_METHOD = "mean_value"  # what Add Cage makes

BY_ID: dict[str, Method] = {method.id: method for method in METHODS}
