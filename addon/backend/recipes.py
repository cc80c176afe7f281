# SPDX-License-Identifier: GPL-3.0-or-later
"""What a factor is made from. Arrays are held, and must not change."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..core.elements import Elements, Owner
from ..core.errors import CageError
from ..core.methods import Method
from ..core.status import Remedy

_PREVIEW_RAYS = 128  # per point: a tenth of the time of exact weights, off by some hundredths

Progress = Callable[[float, str], bool]


@dataclass(frozen=True)
class Shape:
    """``points`` (n, 3) float64; ``faces`` (counts, corners)."""

    points: np.ndarray
    faces: tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Base:
    """An option: the method that another one is put around, with ``options`` of its own."""

    method: Method
    options: dict[str, object]


def make(native, method: Method, target: object, options: dict[str, object]) -> Any:
    """The native object of a method, and of the one inside it, for a native mesh."""
    made = {
        name: make(native, value.method, target, value.options) if isinstance(value, Base) else value
        for name, value in options.items()
    }
    return getattr(native, method.native)(target, **made)


@dataclass(frozen=True)
class Bound:
    """A native method, bound, with what its bind reported."""

    method: Any
    report: object


@dataclass(frozen=True)
class Handles:
    """Regions of a surface: vertices, weights and ``options`` of each, as ``set_handles`` takes them."""

    vertices: Sequence[np.ndarray]
    weights: Sequence[object]
    options: dict[str, Sequence[object]] = field(default_factory=dict)

    def make(self, native, recipe: "Recipe", mesh: object) -> Any:
        """The native method, without handles yet."""
        return make(native, recipe.method, mesh, recipe.options)

    def can_reuse(self, _recipe: "Recipe", made: Any, former: object) -> bool:
        """Whether something of a bound method serves a made one."""
        return made.can_reuse(former)

    def bind(
        self, _native, _recipe: "Recipe", made: Any, former: Bound | None, progress: Progress | None
    ) -> object:
        """Give a made method its handles, out of a bound one if there is one; the report."""
        words = {"weights": self.weights, "progress": progress, **self.options}
        if former is None:
            return made.set_handles(self.vertices, **words)
        return made.rebind(former.method, self.vertices, **words)

    def solve(self, method: Any, poses: np.ndarray, **options) -> tuple[np.ndarray, object]:
        """Positions (n, 3) and a report; ``poses`` (k, 3, 4)."""
        return method.solve(poses, **options)


@dataclass(frozen=True)
class CageReport:
    """What a bind to a cage found: vertices ``outside`` of it, its faces ``crossing`` others; indices."""

    outside: np.ndarray
    crossing: np.ndarray


@dataclass(frozen=True)
class Cage(Shape):
    """The rest cage around a target, in the frame of the target."""

    def make(self, native, recipe: "Recipe", _mesh: object) -> Any:
        """The native method, with no points bound yet."""
        cage = native.SurfaceMesh(self.points, self.faces)
        with _at_fault(native, cage):
            return make(native, recipe.method, cage, recipe.options)

    def can_reuse(self, recipe: "Recipe", made: Any, former: object) -> bool:
        """Whether the weights of a bound method are those of a made one."""
        return made.can_reuse(former, recipe.target.points)

    def bind(
        self, native, recipe: "Recipe", made: Any, former: Bound | None, progress: Progress | None
    ) -> object:
        """Compute the weights of the target's points, or take over those of a bound method; the report."""
        points = recipe.target.points
        if former is not None:
            made.rebind(former.method, points, progress)
            return former.report
        cage = native.SurfaceMesh(self.points, self.faces)
        with _at_fault(native, cage):
            outside = made.bind(points, progress).outside
        return CageReport(outside, np.unique(native.diagnose_cage(cage).crossing_faces))

    def solve(
        self,
        method: Any,
        vertices: np.ndarray,
        *,
        incoming: np.ndarray | None = None,
        out: np.ndarray | None = None,
        progress: Progress | None = None,
    ) -> tuple[np.ndarray, None]:
        """Positions (n, 3) for cage ``vertices`` (c, 3). A product: there is nothing to report."""
        return method.warp(vertices, out=out, incoming=incoming), None


@contextmanager
def _at_fault(native, cage: Any) -> Iterator[None]:
    """Says of a refused mesh that it is the cage: of the target, points alone are refused."""
    try:
        yield
    except native.InvalidMesh as error:
        inside_out = 0 < len(native.diagnose_cage(cage).inverted_faces) == cage.face_count
        remedy = Remedy.FLIP_CAGE if inside_out else Remedy.CAGE_REST
        elements = Elements(Owner.CONTROL, error.element_kind, error.elements)
        raise CageError(str(error), elements, remedy) from error


@dataclass(frozen=True)
class Recipe:
    """``options`` of the native constructor; ``control`` is an array bundle that builds the native object."""

    method: Method
    target: Shape
    options: dict[str, object]
    control: Handles | Cage

    def native_class(self, native) -> type:
        """Of the method, in the native module."""
        return getattr(native, self.method.native)

    def preview(self) -> "Recipe | None":
        """Rough weights to pose by until exact ones are there, where those take long."""
        if not self.options.get("exact"):
            return None
        return replace(self, options={**self.options, "exact": False, "directions": _PREVIEW_RAYS})
