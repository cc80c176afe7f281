# SPDX-License-Identifier: GPL-3.0-or-later
"""What a factor is made from, one class a kind of control. Arrays are held, and must not change."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from ..core.elements import Elements, Owner
from ..core.errors import CageError, CancelledError
from ..core.methods import Method
from ..core.status import Remedy

_PREVIEW_RAYS = 128  # a point: a tenth of the time of exact weights, off by some hundredths

Progress = Callable[[float, str], bool]
Change = Callable[[object, Progress | None], object]  # binds a solver anew and gives the report


@dataclass(frozen=True)
class Base:
    """An option: the method that another one is put around, with ``options`` of its own."""

    method: Method
    options: dict[str, object]


def make(native, method: Method, target: object, options: dict[str, object]) -> object:
    """The native object of a method, and of the one inside it, for a native mesh."""
    made = {
        name: make(native, value.method, target, value.options) if isinstance(value, Base) else value
        for name, value in options.items()
    }
    return getattr(native, method.native)(target, **made)


@dataclass(frozen=True)
class Recipe:
    """Of a method with handles.

    ``points`` (n, 3) float64, ``faces`` (counts, corners); ``options`` of the native constructor. Of each
    handle its vertices, and its weights and ``handle_options`` as the native ``set_handles`` takes them.
    """

    method: Method
    points: np.ndarray
    faces: tuple[np.ndarray, np.ndarray]
    options: dict[str, object]
    handles: Sequence[np.ndarray]
    weights: Sequence[object]
    handle_options: dict[str, Sequence[object]] = field(default_factory=dict)

    def build(self, native, mesh, progress: Progress | None) -> tuple[object, object]:
        """A bound solver and its report."""
        solver = make(native, self.method, mesh, self.options)
        return solver, _set_handles(self, solver, progress)

    def change_to(self, other: object, solver: object, report: object) -> Change | None:
        """What binds the solver to another recipe; None where only a new solver does."""
        if type(other) is not Recipe or self.method is not other.method or not self.has_rest_of(other):
            return None
        others, same_regions = self.differs_in(other), self.has_regions_of(other)
        if not others:
            return partial(_keep, report) if same_regions else partial(_set_handles, other)
        painted = {parameter.id for parameter in other.method.paintable}
        if others <= painted and same_regions and hasattr(solver, "set_stiffness"):
            return partial(_set_stiffness, {name: other.options[name] for name in sorted(painted)})
        return None

    def preview(self) -> None:
        """Nothing quicker stands in for a factor."""

    def has_rest_of(self, other: "Recipe") -> bool:
        """The same shape and faces."""
        return _same((self.points, *self.faces), (other.points, *other.faces))

    def has_regions_of(self, other: "Recipe") -> bool:
        """The same handles."""
        return self.handle_options == other.handle_options and _same(
            (self.handles, self.weights), (other.handles, other.weights)
        )

    def differs_in(self, other: "Recipe") -> set[str]:
        """Names of the options that are others."""
        names = self.options.keys() | other.options.keys()
        return {name for name in names if not _same(self.options.get(name), other.options.get(name))}


@dataclass(frozen=True)
class CageReport:
    """What a bind to a cage found: vertices ``outside`` of it, its faces ``crossing`` others; indices."""

    outside: np.ndarray
    crossing: np.ndarray


@dataclass(frozen=True)
class CageRecipe:
    """Of a method with a cage.

    ``points`` (n, 3) float64, ``faces`` (counts, corners) of the mesh; ``options`` of the native constructor;
    ``cage_points`` (c, 3), ``cage_faces`` (counts, corners) of the rest cage, in the frame of the mesh.
    """

    method: Method
    points: np.ndarray
    faces: tuple[np.ndarray, np.ndarray]
    options: dict[str, object]
    cage_points: np.ndarray
    cage_faces: tuple[np.ndarray, np.ndarray]

    def build(self, native, _mesh, progress: Progress | None) -> tuple[object, object]:
        """Bound coordinates and their report."""
        cage = native.SurfaceMesh(self.cage_points, self.cage_faces)
        try:
            coordinates = getattr(native, self.method.native)(cage, **self.options)
            outside = coordinates.bind(self.points, progress).outside
        except native.InvalidMesh as error:  # of the mesh, a bind refuses points alone
            inside_out = 0 < len(native.diagnose_cage(cage).inverted_faces) == cage.face_count
            remedy = Remedy.FLIP_CAGE if inside_out else Remedy.CAGE_REST
            elements = Elements(Owner.CONTROL, error.element_kind, error.elements)
            raise CageError(str(error), elements, remedy) from error
        crossing = np.unique(native.diagnose_cage(cage).crossing_faces)
        return _Warp(coordinates, self.points), CageReport(outside, crossing)

    def preview(self) -> "CageRecipe | None":
        """Rough weights to pose by until exact ones are there, where those take long."""
        if not self.options.get("exact"):
            return None
        return replace(self, options={**self.options, "exact": False, "directions": _PREVIEW_RAYS})

    def change_to(self, other: object, _solver: object, report: object) -> Change | None:
        """What binds the coordinates to another recipe; None where only new ones do."""
        same = isinstance(other, CageRecipe) and _same(self._parts(), other._parts())
        return partial(_keep, report) if same else None

    def _parts(self) -> tuple:
        names = sorted(self.options)
        options = tuple((name, self.options[name]) for name in names)
        return (self.method.id, options, self.points, *self.faces, self.cage_points, *self.cage_faces)


class _Warp:
    """A posed cage in the place of poses: the warp of the rest points, as displacements of what enters."""

    def __init__(self, coordinates: Any, rest: np.ndarray) -> None:
        self._coordinates = coordinates
        self._rest = rest

    def solve(
        self,
        vertices: np.ndarray,
        *,
        incoming: np.ndarray | None = None,
        out: np.ndarray | None = None,
        progress: Progress | None = None,
    ) -> tuple[np.ndarray, None]:
        """Positions (n, 3) for cage ``vertices`` (c, 3). A product: there is nothing to report."""
        positions = self._coordinates.warp(vertices, out=out)
        if incoming is not None:
            np.add(positions, incoming - self._rest, out=positions, casting="same_kind")
        return positions, None

    def influence(self, vertices: Sequence[int]) -> np.ndarray:
        """(n,) how far each point goes with these vertices of the cage."""
        return self._coordinates.influence(vertices)


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, Base) and isinstance(b, Base):
        return a.method is b.method and _same(list(a.options.items()), list(b.options.items()))
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return a is b or np.array_equal(a, b)
    if isinstance(a, tuple | list) and isinstance(b, tuple | list):
        return len(a) == len(b) and all(map(_same, a, b))
    return a == b


def _keep(report, _solver, progress: Progress | None):
    if progress is not None and not progress(1.0, "bound"):
        raise CancelledError("Cancelled")
    return report


def _set_handles(recipe: Recipe, solver, progress: Progress | None):
    return solver.set_handles(
        recipe.handles, weights=recipe.weights, progress=progress, **recipe.handle_options
    )


def _set_stiffness(stiffness: dict[str, object], solver, progress: Progress | None):
    return solver.set_stiffness(**stiffness, progress=progress)
