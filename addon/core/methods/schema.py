# SPDX-License-Identifier: GPL-3.0-or-later
"""The fields of a row of the method registry, and the types of parameters."""

from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass, replace
from enum import Enum
from functools import cached_property
from typing import Any, ClassVar, TypeVar

import numpy as np


class Family(Enum):
    """The families of methods, which are the sections of the documents, in their order."""

    SURFACE_LINEAR = "Linear Surface"
    SURFACE_NONLINEAR = "Nonlinear Surface"
    MULTIRESOLUTION = "Multiresolution"
    SPACE_LINEAR = "Linear Space"
    SPACE_NONLINEAR = "Nonlinear Space"


_SPACE = frozenset({Family.SPACE_LINEAR, Family.SPACE_NONLINEAR})


class Control(Enum):
    """The kinds of control: what an artist moves to steer a method. The method menu has a heading each."""

    HANDLES = "Handles"
    CAGE = "Cages"
    LATTICE = "Lattices"
    POINTS = "Points"
    CURVES = "Curves"
    TOOLS = "Tools"


class Moved(Enum):
    """The targets that a method can move."""

    MESH = "meshes"
    POINTS = "curves, text, hair, point clouds and lattices"


class Posed(Enum):
    """What the poses of handles do to a space method: ``warp_poses`` of its native class takes them.

    POINTS: they move the handle points, which are all that counts. CONTROL: those of handles of several
    points act as affine maps, and single points only move. POSES: those of single points turn, too; such a
    class is made of the surface and the handle points.
    """

    POINTS = "points"
    CONTROL = "control points"
    POSES = "poses"


class Reproduced(Enum):
    """The maps of space that a method reproduces if all its controls move by one; each holds those before."""

    REST = "rest"  # nothing moves far from all controls, so the method reproduces no motion
    TRANSLATIONS = "translations"
    RIGID_MOTIONS = "rigid motions"
    SIMILARITIES = "similarities"
    AFFINE_MAPS = "affine maps"


class Size(Enum):
    """The sizes that parameters are shares of, as the native module measures them."""

    SURFACE = "of the surface"  # of each part of it, ``SurfaceMesh.sizes``
    HANDLES = "of all handles"  # the ``diameter`` of their points


_P = TypeVar("_P", bound="Parameter")
DEFAULTS = 2  # how often defaults have changed, see ``Parameter.earlier`` and ``SinewDeformer.defaults``


@dataclass(frozen=True)
class Parameter:
    """A value that the artist may set.

    ``rebinds``: the parameter is a keyword of the native constructor, so a change needs another bind.
    Otherwise it is a keyword of ``solve``. ``advanced``: it is seldom changed, so it comes last among the
    Settings. ``only_with``: a choice of the same method, and its values with which the method uses this
    parameter; the panel hides it with others. ``unit``: what a number counts or measures, in words. Blender
    shows a "length" and an "angle" in the units of the scene. ``earlier``: a former default, and from which
    ``SinewDeformer.defaults`` on the present one holds.
    """

    id: str
    label: str
    default: Any
    _: KW_ONLY
    description: str = ""
    unit: str = ""
    rebinds: bool = True
    advanced: bool = False
    only_with: tuple[str, tuple[str, ...]] | None = None
    earlier: tuple[Any, int] | None = None
    paintable: ClassVar[bool] = False

    @property
    def native_default(self) -> object:
        """The default in the form that the native module takes."""
        return self.default

    def described(self: _P, description: str) -> _P:
        """With this tooltip, which every row has."""
        return replace(self, description=description)

    def is_used(self, settings: object) -> bool:
        """Whether the method uses this parameter. ``settings`` has its parameters as attributes."""
        return self.only_with is None or getattr(settings, self.only_with[0]) in self.only_with[1]


@dataclass(frozen=True)
class Span:
    """The values of a number, and how its field shows them: a drag of it ends at ``soft``, and one click on
    an arrow of it adds ``step``."""

    minimum: float = 0.0
    maximum: float = 1e9
    _: KW_ONLY
    soft: float = 10.0
    digits: int = 3
    step: float = 0.01


@dataclass(frozen=True)
class Float(Parameter):
    """A real number.

    If it is ``paintable``, a vertex group may scale it per vertex. ``share_of`` says which size it is a share
    of, if of any; ``share_with`` a choice of the same method, and its value with which it is one.
    """

    span: Span = Span()
    _: KW_ONLY
    paintable: bool = False  # type: ignore[misc]  # rows set it, while all other types share one value
    share_of: Size | None = None
    share_with: tuple[str, str] | None = None

    def size_in_use(self, settings: object) -> Size | None:
        """The size that it is a share of. ``settings`` has the parameters of the method as attributes."""
        chosen = self.share_with is None or getattr(settings, self.share_with[0]) == self.share_with[1]
        return self.share_of if chosen else None


@dataclass(frozen=True)
class Int(Parameter):
    """A whole number."""

    span: Span


@dataclass(frozen=True)
class Bool(Parameter):
    """A value that is on or off."""


@dataclass(frozen=True)
class Choice(Parameter):
    """One of ``items``: (identifier, label, description), in an order that never changes."""

    items: tuple[tuple[str, str, str], ...]


@dataclass(frozen=True, kw_only=True)
class Curve(Parameter):
    """A function on [0, 1] that the artist draws.

    ``default`` holds points that straight lines join. The native module gets the values at evenly spaced
    places, (samples,) float64.
    """

    samples: int = 257

    @property
    def native_default(self) -> np.ndarray:
        return np.interp(np.linspace(0.0, 1.0, self.samples), *np.transpose(self.default))


@dataclass(frozen=True, kw_only=True)
class Pointer(Parameter):
    """An object whose type is one of ``types``, by Blender's names; any type if this is empty.

    The native module gets the frame of the object in the space of the target, (3, 4) float64, or None if no
    object is chosen.
    """

    types: tuple[str, ...] = ()
    default: None = None


@dataclass(frozen=True, kw_only=True)
class Box(Pointer):
    """An object whose cube from -1 to 1 is the box that the method fills, around the shape if none is chosen.

    The native module gets the frame of the cube in the space of the target, (3, 4) float64, or the surface of
    the target, along whose own axes the box is then. See ``SinewDeformer.sizes`` for earlier builds.
    """


@dataclass(frozen=True, kw_only=True)
class GridPoints(Pointer):
    """A mesh object whose vertices are the points of the control grids of the method.

    The native module gets how far each of them is moved after the modifiers of the object, (g, 3) float64 in
    the space of the target, or None if no object is chosen. It is a keyword of ``solve``.
    """

    rebinds: bool = False
    types: tuple[str, ...] = ("MESH",)


@dataclass(frozen=True, kw_only=True)
class MeshObject(Pointer):
    """A mesh object whose mesh, without its modifiers, the method uses.

    The native module gets a ``SurfaceMesh`` in the space of the target, or None if no object is chosen.
    """

    types: tuple[str, ...] = ("MESH",)


@dataclass(frozen=True, kw_only=True)
class MeshShape(Pointer):
    """A mesh object with the same faces as the target.

    The native module gets a ``SurfaceMesh`` of its points at rest, in its own space, or None. A bind reads
    it: later edits of that mesh count at the next bind.
    """

    types: tuple[str, ...] = ("MESH",)


@dataclass(frozen=True, kw_only=True)
class UvMap(Parameter):
    """A UV map of the target, by its name.

    The native module gets u and v of each vertex, (n, 2) float64, NaN for a vertex in no face, or None if no
    map is chosen. A vertex of a seam has several places on the map and takes that of its first corner.
    """

    default: None = None


def items(**described: str | tuple[str, str]) -> tuple[tuple[str, str, str], ...]:
    """The items of a choice: what each of them does, behind its label if that is not its identifier."""
    return tuple(
        (name, name.replace("_", " ").title(), words) if isinstance(words, str) else (name, *words)
        for name, words in described.items()
    )


# Parameters that several methods have

LAPLACIANS = items(
    uniform="Treats all neighbours equally: for messy meshes, whose angles and areas mean nothing",
    cotan=("Cotangent", "Takes the angles of the faces into account, but not their sizes"),
    cotan_voronoi=(
        "Cotangent + Area",
        "Takes the angles and sizes of the faces into account: depends least on how the mesh is divided",
    ),
    robust="Takes the angles and sizes of better faces of the same surface: for messy meshes and slivers",
)

PRECISIONS = items(
    single="Half the memory, and half the time per frame; errors of a ten-millionth of the cage's size",
    double="As exact as the coordinates themselves",
)


def solver(of_iterations: str) -> Choice:
    solvers = items(
        automatic="Iterates only where the factor needs more memory than the limit, or the computer, has",
        factor="Computes a factor at bind, after which frames are quick",
        multigrid=("Iterations", of_iterations),
    )
    return Choice("solver", "Solver", "automatic", solvers, advanced=True).described(
        "Set how millions of vertices are solved for, where memory or the time of a bind is short"
    )


def iterations(default: int, soft: int = 100, maximum: int = 1_000_000, **others: Any) -> Int:
    """The largest number of steps of a frame of an iterative method."""
    usual: dict[str, Any] = {
        "label": "Iterations",
        "description": "Limit the steps of a frame; while you drag fewer are computed, and the others "
        "follow when you stop",
        "unit": "iterations",
        "rebinds": False,
    }
    span = Span(1, maximum, soft=soft)
    return Int("max_iterations", default=default, span=span, advanced=True, **usual | others)


def tolerance(default: float = 1e-4, soft: float = 0.001, digits: int = 6, **others: Any) -> Float:
    """When the steps of a frame of an iterative method stop."""
    usual: dict[str, Any] = {
        "description": "Stop when two steps in a row lower the energy by less than this share of it",
        "unit": "share of the energy",
        "rebinds": False,
    }
    span = Span(0.0, 1.0, soft=soft, digits=digits)
    return Float("tolerance", "Tolerance", default, span, advanced=True, **usual | others)


def stored_precision(of: str) -> Choice:
    """With how many digits a space method stores its weights: ``of`` says which."""
    return Choice("precision", "Precision", "single", PRECISIONS, advanced=True).described(
        f"Save memory, or store {of} more exactly"
    )


def laplacian(default: str = "cotan_voronoi", choices: int = 4) -> Choice:
    """The weights of the Laplacian of a surface: the first of them, as many as the method can use."""
    return Choice("laplacian", "Laplacian", default, LAPLACIANS[:choices]).described(
        "Make the shape depend less on how the faces divide the surface, by looking at their angles and sizes"
    )


BindSeconds = Callable[[int, int, Mapping[str, Any]], float]


def factorising(seconds: float) -> BindSeconds:
    """The cost of a sparse factor: ``seconds`` for 10,000 points, and a little more than in proportion."""
    return lambda points, _size, _options: seconds * (points / 1e4) ** 1.3


def per_pair(seconds: float) -> BindSeconds:
    """The cost of a closed form for each point and each part of its control: ``seconds`` for one of each."""
    return lambda points, size, _options: seconds * points * size


def following(shells: int, vertices: int) -> float:
    """About how long a bind takes for loose parts that follow: ``vertices`` of them have no edge."""
    return 2e-4 * shells + 1e-5 * vertices


_NEEDED = {Control.CAGE: "a cage", Control.CURVES: "a curve"}
_USUAL_POINTS, _USUAL_SIZE = 20_000, 300  # of a mesh, and of what moves it
_SLOWER = (0.13, 0.4)  # seconds from which a bind is medium, and slow


@dataclass(frozen=True, kw_only=True)
class Method:
    """One row of the registry, which says only what differs from most. Files store ``number``, so never reuse
    or change it.

    ``label``: what artists call it; ``known_as``: what the literature does (``core.names`` says which of them
    Sinew shows). ``search``: further words that find it. ``summary``: its tooltip, and ``fails``: where it is
    the wrong choice, each a sentence whose subject is the method. ``also_needs``: what it needs of its first
    requirement, or beside all that ``needs`` knows from the other fields. ``picture``: the sample, and after
    a colon which part of it, that shows the method. ``main``: the settings, at most two, that the panel shows
    before all others: parameters, control parameters, or properties of the deformer.

    ``iterative``: ``solve`` takes ``max_iterations`` and ``start``, so that a drag can show an early step.
    ``bind_seconds``: about how long a bind takes on two cores, without that of a base method, from the number
    of points, the size of the control and the options; its constants are measured. The size is that of a
    space method's control: the triangles of a cage, or the points of any other; 0 for a surface method.
    ``wraps``: the families of the methods that this method can be put around. Its native constructor gets
    such a method as ``base``. It is empty for a method that works alone. ``handle_parameters``: every handle
    has its own value of these. The native ``set_handles`` takes one keyword per parameter, with one value per
    handle. ``control_parameters``: likewise for methods that several objects control. Each object has its own
    value, and the native constructor takes one keyword per parameter. ``keyed``: the deformer has keys, which
    edit the handles in frames of an animation; ``solve`` takes the ``frame`` and the ``keys``.
    ``draft_iterations``: how many an iterative method takes for a draft of a frame in playback.
    ``reproduces``: the most that the method promises, on any shape. ``symmetric``: whether a mesh that is its
    own mirror image gets a shape that is; not where the order of the vertices decides something.
    ``takes_flat``: its cage may be a mesh in a plane, around art in that plane. ``posed``: for each space
    method that handles move, how they do. ``takes_segments``: the native constructor of such a method takes
    ``segments``, pairs of handle points between which the whole line is the handle. ``moves_incoming``: the
    poses of such a method move what enters, as those of surface methods do; those of the others move the rest
    shape, and the displacements are added to what enters. ``finer``: the whole number that is raised where
    two handles have no place beside each other. ``draws``: what an overlay shows of the bound method, GRID
    (control grids), GRAPH (nodes between the handles) or BANDS.
    """

    id: str
    number: int
    label: str
    known_as: str
    search: str
    family: Family
    control: Control = Control.HANDLES
    section: str
    paper: str
    summary: str
    fails: str
    also_needs: str = ""
    picture: str
    main: tuple[str, ...] = ()
    iterative: bool = False
    moves: frozenset[Moved] = frozenset({Moved.MESH})
    bind_seconds: BindSeconds
    reproduces: Reproduced = Reproduced.TRANSLATIONS
    symmetric: bool = True
    takes_flat: bool = False
    posed: Posed | None = None
    takes_segments: bool = False
    moves_incoming: bool = False
    finer: str = ""
    wraps: tuple[Family, ...] = ()
    keyed: bool = False
    draft_iterations: int = 1
    draws: str = ""
    parameters: tuple[Parameter, ...] = ()
    handle_parameters: tuple[Parameter, ...] = ()
    control_parameters: tuple[Parameter, ...] = ()

    @property
    def native(self) -> str:
        """Its class in the native module."""
        return "".join(word.capitalize() for word in self.id.split("_"))

    @property
    def is_space(self) -> bool:
        """It deforms the space around points, and knows of no surface."""
        return not _SPACE.isdisjoint((self.family, *self.wraps))

    @property
    def adds_displacements(self) -> bool:
        """Its poses move the rest shape, and the displacements are added to what enters."""
        return self.is_space and not self.moves_incoming

    @cached_property
    def needs(self) -> str:
        """What must be there before the method can work, in words; empty if it takes anything."""
        found = [
            "" if Moved.POINTS in self.moves else "a surface",
            _NEEDED.get(self.control, ""),
            "an animation" if self.keyed else "",
            self.also_needs,
        ]
        return ", ".join(filter(None, found))

    @cached_property
    def cost(self) -> int:
        """How long a bind of a usual mesh takes: 1 quick, 2 medium, 3 slow."""
        return 1 + sum(self.expected_seconds(_USUAL_POINTS) >= limit for limit in _SLOWER)

    def expected_seconds(self, points: int, settings: object = None, size: int = _USUAL_SIZE) -> float:
        """About how long a bind takes for so many points, with a control of this size, or a usual one.

        ``settings`` has its parameters as attributes; without it they have their defaults.
        """
        options = {
            parameter.id: getattr(settings, parameter.id, parameter.default) for parameter in self.parameters
        }
        return self.bind_seconds(points, size, options)

    @cached_property
    def references(self) -> tuple[Parameter, ...]:
        """The parameters whose value is stored in another datablock."""
        return tuple(
            parameter for parameter in self.parameters if isinstance(parameter, Curve | Pointer | UvMap)
        )

    @cached_property
    def paintable(self) -> tuple[Parameter, ...]:
        """The parameters that a vertex group may scale."""
        return tuple(parameter for parameter in self.parameters if parameter.paintable)


def group_property(parameter: Parameter) -> str:
    """The property that names the vertex group of a paintable parameter."""
    return f"{parameter.id}_group"
