# SPDX-License-Identifier: GPL-3.0-or-later
"""Native calls with their errors translated. No other room names a native class."""

import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ..core.elements import Elements, Owner
from ..core.errors import (
    BackendMissingError,
    CancelledError,
    ConstraintError,
    MeshError,
    OptionError,
    OutOfMemoryError,
    SinewError,
    SolverError,
)
from ..core.geometry import frames
from ..core.status import Remedy
from .loader import Availability, load
from .recipes import Bound, Progress, Recipe

_limits: dict[str, int] = {}  # wanted, by the native function that sets it

_TRANSLATION = {
    "InvalidMesh": MeshError,
    "InvalidConstraint": ConstraintError,
    "InvalidOption": OptionError,
    "FactorizationFailed": SolverError,
    "OutOfMemory": OutOfMemoryError,
    "Cancelled": CancelledError,
}
_REPAIRABLE = (MeshError, SolverError)  # where elements are named, the mesh itself is at fault


@lru_cache(maxsize=1)
def availability() -> Availability:
    """The native module or its remedy. A loaded module stays until Blender ends."""
    found = load()
    for function, value in _limits.items():
        _apply_limit(found, function, value)
    return found


def limit_threads(count: int) -> None:
    """At most ``count`` threads in native loops; 0 lifts the limit. Takes effect when the module is there."""
    _limit("limit_threads", count)


def limit_memory(size: int) -> None:
    """Binds that need more than ``size`` bytes are refused; 0 lifts the limit. As with the threads."""
    _limit("limit_memory", size)


def _limit(function: str, value: int) -> None:
    _limits[function] = value
    if availability.cache_info().currsize:
        _apply_limit(availability(), function, value)


def _apply_limit(found: Availability, function: str, value: int) -> None:
    if found.module is not None:
        getattr(found.module, function)(value)


def _module():
    found = availability()
    if found.module is None:
        raise BackendMissingError(found.remedy)
    return found.module


@contextmanager
def _translated(native) -> Iterator[None]:
    try:
        yield
    except native.Error as error:
        kind = _TRANSLATION.get(type(error).__name__, SinewError)
        remedy = Remedy.REPAIR if kind in _REPAIRABLE and error.elements else None
        elements = Elements(Owner.TARGET, error.element_kind, error.elements)
        raise kind(str(error), elements, remedy) from error
    except MemoryError as error:
        raise OutOfMemoryError("Not enough memory to bind this mesh - use fewer vertices") from error


@dataclass(frozen=True)
class Diagnosis:
    """What is unusual about a mesh, as index arrays; nothing of it but ``not_finite`` prevents a bind."""

    not_finite: np.ndarray  # (k,) vertices with NaN or infinite coordinates
    degenerate_faces: np.ndarray  # (k,) faces without area
    duplicate_faces: np.ndarray  # (k,) faces with the vertices of an earlier one
    coincident_vertices: np.ndarray  # (k,) vertices exactly where an earlier one is
    loose_vertices: np.ndarray  # (k,) vertices in no face
    non_manifold_edges: np.ndarray  # (k, 2) edges of three or more faces, by their vertices


@dataclass(frozen=True)
class Inheritance:
    """A native method that waits to be bound, and the bound one that it takes over from."""

    recipe: Recipe
    mesh: Any
    diagnosis: Diagnosis
    made: Any
    former: Bound | None


class Factor:
    """A bound method: solve as often as you like, from several threads, until it is handed over."""

    def __init__(self, native, made: Inheritance, report: Any) -> None:
        self._native = native
        self._mesh = made.mesh
        self._method = made.made
        self._lock = threading.Lock()
        self._solves = 0  # under way
        self.report = report
        self.diagnosis = made.diagnosis
        self.recipe = made.recipe

    def solve(self, poses: np.ndarray, **options) -> tuple[np.ndarray, object]:
        """Positions (n, 3) float64, or the float32 ``out``, and a report.

        ``poses``: (k, 3, 4) of handles, (c, 3) of a cage.
        """
        with self._lock:
            method = self._owned()
            self._solves += 1
        try:
            with _translated(self._native):
                return self.recipe.control.solve(method, poses, **options)
        finally:
            with self._lock:
                self._solves -= 1

    def influence(self, vertices: Sequence[int]) -> np.ndarray:
        """(n,) float64: how far each point goes with some vertices of the cage, 1 where all the way."""
        with self._lock:
            method = self._owned()
        with _translated(self._native):
            return method.influence(vertices)

    def _owned(self) -> Any:
        if self._method is None:
            raise CancelledError("The mesh is bound anew")
        return self._method

    @property
    def is_spent(self) -> bool:
        """It was handed over."""
        return self._method is None

    def hand_over(self, recipe: Recipe) -> Inheritance | None:
        """What ``build_factor`` builds the factor of another recipe from; this one is spent then.

        None where nothing of this one would serve, or while somebody solves.
        """
        native, target = self._native, recipe.target
        with _translated(native):
            if not isinstance(self._method, recipe.native_class(native)):
                return None
            if not self._mesh.is_made_of(target.points, target.faces):
                return None
            made = recipe.control.make(native, recipe, self._mesh)
            with self._lock:
                if self._method is None or self._solves:
                    return None
                if not recipe.control.can_reuse(recipe, made, self._method):
                    return None
                former, self._method = self._method, None
        return Inheritance(recipe, self._mesh, self.diagnosis, made, Bound(former, self.report))


def build_factor(
    recipe: Recipe, progress: Progress | None = None, inherited: Inheritance | None = None
) -> Factor:
    """Assemble and factorise, or compute weights. Needs no bpy: any thread will do.

    ``inherited`` is what an earlier factor handed over for this recipe.
    """
    native = _module()
    with _translated(native):
        if inherited is None:
            mesh = native.SurfaceMesh(recipe.target.points, recipe.target.faces)
            made = recipe.control.make(native, recipe, mesh)
            inherited = Inheritance(recipe, mesh, _diagnosis(mesh), made, None)
        report = recipe.control.bind(native, recipe, inherited.made, inherited.former, progress)
        return Factor(native, inherited, report)


def automatic_cage(
    points: np.ndarray, polygons: tuple[np.ndarray, np.ndarray], progress: Progress | None = None, **options
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A closed mesh around a mesh: its points (c, 3), and (counts, corners) of its faces. Any thread will do.

    ``polygons`` (counts, corners); ``options`` as the native function takes them.
    """
    native = _module()
    with _translated(native):
        mesh = native.SurfaceMesh(points, polygons)
        around, faces, _report = native.automatic_cage(mesh, progress=progress, **options)
    if isinstance(faces, tuple):
        return around, *faces
    return around, np.full(len(faces), 3, dtype=np.int32), faces.ravel()


def diagnose(points: np.ndarray, faces: tuple[np.ndarray, np.ndarray]) -> Diagnosis:
    """Look for what Repair can mend. ``points`` (n, 3) float64, ``faces`` (counts, corners).

    Points that are not finite count as if they lay at the origin, and not as coincident.
    """
    bad = ~frames.is_place(points)
    native = _module()
    with _translated(native):
        return _diagnosis(native.SurfaceMesh(np.where(bad[:, None], 0.0, points), faces), bad)


def _diagnosis(mesh, bad: np.ndarray | None = None) -> Diagnosis:
    """``bad`` (n,): the points that are not finite, none where not given."""
    found = mesh.diagnose()
    coincident = found.coincident_vertices
    return Diagnosis(
        not_finite=np.zeros(0, dtype=int) if bad is None else np.flatnonzero(bad),
        degenerate_faces=found.degenerate_faces,
        duplicate_faces=found.duplicate_faces,
        coincident_vertices=coincident if bad is None else coincident[~bad[coincident]],
        loose_vertices=found.loose_vertices,
        non_manifold_edges=found.non_manifold_edges,
    )
