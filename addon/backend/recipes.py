# SPDX-License-Identifier: GPL-3.0-or-later
"""What a factor is made from. Arrays are held, and must not change."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

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
class Bound:
    """A native method, bound, with what its bind reported."""

    method: object
    report: object


@dataclass(frozen=True)
class Handles:
    """Regions of a surface: vertices, weights and continuity of each, as ``set_handles`` takes them."""

    vertices: Sequence[np.ndarray]
    weights: Sequence[object]
    continuity: Sequence[float] | None = None

    def make(self, native, recipe: "Recipe", mesh: object) -> object:
        """The native method, without handles yet."""
        return getattr(native, recipe.method.native)(mesh, **recipe.options)

    def can_reuse(self, _recipe: "Recipe", made: object, former: object) -> bool:
        """Whether something of a bound method serves a made one."""
        return made.can_reuse(former)

    def bind(
        self, _native, _recipe: "Recipe", made: object, former: Bound | None, progress: Progress | None
    ) -> object:
        """Give a made method its handles, out of a bound one if there is one; the report."""
        words = {"weights": self.weights, "continuity": self.continuity, "progress": progress}
        if former is None:
            return made.set_handles(self.vertices, **words)
        return made.rebind(former.method, self.vertices, **words)

    def solve(self, method: object, poses: np.ndarray, **options) -> tuple[np.ndarray, object]:
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

    def make(self, native, recipe: "Recipe", _mesh: object) -> object:
        """The native method, with no points bound yet."""
        cage = native.SurfaceMesh(self.points, self.faces)
        with _at_fault(native, cage):
            return getattr(native, recipe.method.native)(cage, **recipe.options)

    def can_reuse(self, recipe: "Recipe", made: object, former: object) -> bool:
        """Whether the weights of a bound method are those of a made one."""
        return made.can_reuse(former, recipe.target.points)

    def bind(
        self, native, recipe: "Recipe", made: object, former: Bound | None, progress: Progress | None
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
        method: object,
        vertices: np.ndarray,
        *,
        incoming: np.ndarray | None = None,
        out: np.ndarray | None = None,
        progress: Progress | None = None,
    ) -> tuple[np.ndarray, None]:
        """Positions (n, 3) for cage ``vertices`` (c, 3). A product: there is nothing to report."""
        return method.warp(vertices, out=out, incoming=incoming), None


@contextmanager
def _at_fault(native, cage: object) -> Iterator[None]:
    """Says of a refused mesh that it is the cage: of the target, points alone are refused."""
    try:
        yield
    except native.InvalidMesh as error:
        inside_out = 0 < len(native.diagnose_cage(cage).inverted_faces) == cage.face_count
        remedy = Remedy.FLIP_CAGE if inside_out else Remedy.CAGE_REST
        raise CageError(str(error), tuple(error.elements), f"cage {error.element_kind}", remedy) from error


@dataclass(frozen=True)
class Recipe:
    """``options`` of the native constructor; ``control`` is an array bundle that builds the native object."""

    method: Method
    target: Shape
    options: dict[str, object]
    control: Handles | Cage

    def preview(self) -> "Recipe | None":
        """Rough weights to pose by until exact ones are there, where those take long."""
        if not self.options.get("exact"):
            return None
        return replace(self, options={**self.options, "exact": False, "directions": _PREVIEW_RAYS})
