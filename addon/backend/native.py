# SPDX-License-Identifier: GPL-3.0-or-later
"""Calls of the native module, whose errors become Sinew's own. No other room names a native class."""

import threading
from collections.abc import Callable, Iterator, Sequence
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
    FactorInUseError,
    MeshError,
    OptionError,
    OutOfMemoryError,
    OutsideError,
    SinewError,
    SolverError,
)
from ..core.geometry import frames
from ..core.methods import following
from ..core.status import Remedy
from .loader import Availability, load
from .recipes import Bound, HandlePoints, Progress, Recipe, Regions, Shape, SolveReport

_limits: dict[str, int] = {}  # the limits that are set, by the native function that sets each

_TRANSLATION = {
    "InvalidMesh": MeshError,
    "InvalidConstraint": ConstraintError,
    "PointsOutside": OutsideError,
    "InvalidOption": OptionError,
    "FactorizationFailed": SolverError,
    "OutOfMemory": OutOfMemoryError,
    "NotConverged": SolverError,
    "Cancelled": CancelledError,
    "ObjectInUse": FactorInUseError,
}
_REPAIRABLE = (MeshError, SolverError)  # if such an error names elements, Repair can mend the mesh


@lru_cache(maxsize=1)
def availability() -> Availability:
    """The native module, or why there is none. A loaded module stays loaded until Blender ends."""
    found = load()
    for function, value in _limits.items():
        _apply_limit(found, function, value)
    return found


def limit_threads(count: int) -> None:
    """Let native loops use at most ``count`` threads; 0 means no limit.

    It is applied when the module loads.
    """
    _limit("limit_threads", count)


def limit_memory(size: int) -> None:
    """Refuse binds that need more than ``size`` bytes; 0 means no limit.

    It is applied when the module loads.
    """
    _limit("limit_memory", size)


def limits() -> dict[str, int]:
    """The limits that are set, by the native function that sets each."""
    return dict(_limits)


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
        error_class = _TRANSLATION.get(type(error).__name__, SinewError)
        remedy = Remedy.REPAIR if error_class in _REPAIRABLE and error.elements else None
        if "choose the factor" in str(error):
            remedy = Remedy.USE_FACTOR
        elements = Elements(Owner.TARGET, error.element_kind, error.elements)
        raise error_class(str(error), elements, remedy) from error
    except MemoryError as error:
        raise OutOfMemoryError("Not enough memory to bind this mesh - use fewer vertices") from error


@dataclass(frozen=True)
class Diagnosis:
    """What is unusual about a mesh, as arrays of indices. Only ``not_finite`` prevents a bind."""

    not_finite: np.ndarray  # (k,) vertices with NaN or infinite coordinates
    degenerate_faces: np.ndarray  # (k,) faces without area
    duplicate_faces: np.ndarray  # (k,) faces with the same vertices as an earlier face
    coincident_vertices: np.ndarray  # (k,) vertices at exactly the place of an earlier vertex
    loose_vertices: np.ndarray  # (k,) vertices in no face
    non_manifold_edges: np.ndarray  # (k, 2) edges of three or more faces, as pairs of vertices


@dataclass(frozen=True)
class PreparedBind:
    """A native method that is not bound yet, and the bound method that it reuses the factor of, if any."""

    recipe: Recipe
    mesh: Any
    diagnosis: Diagnosis
    method: Any
    previous: Bound | None


class Factor:
    """A bound method.

    It can solve any number of times, from several threads, until another factor reuses it.
    """

    def __init__(self, native, prepared: PreparedBind, report: Any) -> None:
        self._native = native
        self._mesh = prepared.mesh
        self._method = prepared.method
        self._lock = threading.Lock()
        self._solves = 0  # how many solves are running
        self.report = report
        self.diagnosis = prepared.diagnosis
        self.recipe = prepared.recipe

    def solve(self, poses: np.ndarray, **options) -> tuple[np.ndarray, SolveReport | None]:
        """Positions (n, 3), in float64 or in the float32 array ``out``, and a report; a cage has none.

        ``poses`` are the poses (k, 3, 4) of handles, or the vertices (c, 3) of a cage.
        """
        with self._lock:
            method = self._bound_method()
            self._solves += 1
        try:
            with _translated(self._native):
                return self.recipe.control.solve(self._native, self.recipe, method, poses, **options)
        finally:
            with self._lock:
                self._solves -= 1

    def influence(self, vertices: Sequence[int]) -> np.ndarray:
        """How far each point follows some vertices of the cage, (n,) float64; 1 if it moves as far as they
        do.
        """
        with self._lock:
            method = self._bound_method()
        with _translated(self._native):
            return method.influence(vertices)

    def control_grids(self, poses: np.ndarray, **options) -> list[np.ndarray]:
        """The control grids (rows, columns, 3) as handles move them; none if the method has no grid."""
        with self._lock:
            method = self._bound_method()
        if self.recipe.method.draws != "GRID":
            return []
        with _translated(self._native):
            return method.control_grids(poses, **options)

    def network(self, poses: np.ndarray, **options) -> tuple[np.ndarray, np.ndarray] | None:
        """The nodes (m, 3) between the handles as they move, and pairs (l, 2) that hold together.

        None if the method has no nodes.
        """
        with self._lock:
            method = self._bound_method()
        control = self.recipe.control
        if not isinstance(control, HandlePoints) or self.recipe.method.draws != "GRAPH":
            return None
        with _translated(self._native):
            return control.network(self._native, self.recipe, method, poses, **options)

    @property
    def folded_rings(self) -> np.ndarray:
        """The vertices (f,) that a method takes as the plain mean of their rings, because these overlap."""
        found = getattr(self._method, "folded_rings", ())
        return np.asarray(found, dtype=int)

    def bands(self) -> np.ndarray | None:
        """The band of each point, (n,) int32, -1 for a point in none; None if the method has no bands."""
        with self._lock:
            method = self._bound_method()
        return method.bands() if self.recipe.method.draws == "BANDS" else None

    def edits(self, poses: np.ndarray, **options) -> np.ndarray:
        """The edits (k, 3, 4) of a frame in the moving frames of the handles, if the method has keys.

        ``options`` are the further keywords that its ``solve`` takes for a frame.
        """
        with self._lock:
            method = self._bound_method()
        with _translated(self._native):
            return method.edits(poses=poses, **options)

    def still_poses(self, **options) -> np.ndarray:
        """The poses (k, 3, 4) of controls that edit nothing in a frame, if the method has keys."""
        with self._lock:
            method = self._bound_method()
        with _translated(self._native):
            return method.still_poses(**options)

    def _bound_method(self) -> Any:
        if self._method is None:
            raise CancelledError("The mesh is being bound again")
        return self._method

    @property
    def is_released(self) -> bool:
        """Whether another factor reuses the native method, so that this one can solve no more."""
        return self._method is None

    def prepare_rebind(self, recipe: Recipe) -> PreparedBind | None:
        """Release the native method, so that ``build_factor`` can reuse it for another recipe.

        Returns None, and releases nothing, if the other recipe can reuse nothing or while a solve is running.
        """
        native, target = self._native, recipe.target
        with _translated(native):
            if not isinstance(self._method, recipe.native_class(native)):
                return None
            if not self._mesh.is_made_of(target.points, target.faces):
                return None
            method = recipe.control.make(native, recipe, self._mesh)
            with self._lock:
                if self._method is None or self._solves:
                    return None
                if not recipe.control.can_reuse(recipe, method, self._method):
                    return None
                previous, self._method = self._method, None
        return PreparedBind(recipe, self._mesh, self.diagnosis, method, Bound(previous, self.report))


def build_factor(
    recipe: Recipe, progress: Progress | None = None, prepared: PreparedBind | None = None
) -> Factor:
    """Assemble and factorise, or compute weights. It does not use bpy, so any thread may call it.

    ``prepared`` is what ``prepare_rebind`` of an earlier factor returned for this recipe.
    """
    native = _module()
    with _translated(native):
        if prepared is None:
            mesh = native.SurfaceMesh(recipe.target.points, recipe.target.faces)
            method = recipe.control.make(native, recipe, mesh)
            prepared = PreparedBind(recipe, mesh, _diagnosis(mesh), method, None)
        report = recipe.control.bind(native, recipe, prepared.method, prepared.previous, progress)
        return Factor(native, prepared, report)


def automatic_cage(
    points: np.ndarray, polygons: tuple[np.ndarray, np.ndarray], progress: Progress | None = None, **options
) -> tuple[np.ndarray, np.ndarray, np.ndarray, str]:
    """Make a closed mesh around a mesh.

    Returns its points (c, 3), the counts and corners of its faces, and what else there is to say: why there
    are more faces than wanted, and by how much a mesh without symmetry misses it.
    ``polygons`` are the (counts, corners) of the mesh, ``options`` those of the native function. Any thread
    may call this.
    """
    native = _module()
    with _translated(native):
        mesh = native.SurfaceMesh(points, polygons)
        around, faces, report = native.automatic_cage(mesh, progress=progress, **options)
    more = [] if report.reached else [f"{report.faces} faces instead of {report.wanted}: {report.reason}"]
    if options.get("symmetry") == "automatic" and report.mirror_axis < 0:
        percent = 100.0 * report.asymmetry
        more.append(f"not symmetric: the sides differ by {percent:.1f} % of the size")
    told = "; ".join(more)
    if isinstance(faces, tuple):
        return around, *faces, told
    return around, np.full(len(faces), 3, dtype=np.int32), faces.ravel(), told


def mesh_transfer(source: Shape, target: Shape) -> Callable[[np.ndarray], np.ndarray]:
    """A function that deforms the target as the source: deformed source (n, 3) float64 -> target (n, 3).

    Both are at rest, with the same faces. Any thread may call this.
    """
    native = _module()
    with _translated(native):
        meshes = [native.SurfaceMesh(shape.points, shape.faces) for shape in (source, target)]
        made = native.MeshTransfer(*meshes)

    def transfer(deformed: np.ndarray) -> np.ndarray:
        with _translated(native):
            return made.transfer(deformed)

    return transfer


def sketched_part(
    shape: Shape,
    stroke: np.ndarray,
    axes: np.ndarray,
    eye: np.ndarray | None,
    edges: np.ndarray | None,
    hidden: bool,
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """The part of a silhouette that a stroke (s, 3) redraws, or None if there is none near it.

    Its points lie on ``edges`` (k, 2), at the shares (k,) between their ends, and go to targets (k, 3).
    ``axes`` (3, 3) are rows to the right, up and toward the viewer; ``eye`` (3,) is for a perspective view.
    With ``edges`` (e, 2), a line along these is taken instead of silhouettes. ``hidden``: silhouettes count
    that are behind the mesh.
    """
    native = _module()
    with _translated(native):
        mesh = native.SurfaceMesh(shape.points, shape.faces)
        return native.fit_stroke(mesh, stroke, axes, eye, edges, hidden=hidden)


def sketched(
    shape: Shape,
    line: tuple[np.ndarray, np.ndarray, np.ndarray],
    held: np.ndarray,
    sharpness: float,
) -> np.ndarray:
    """The shape (n, 3) with a line, as ``sketched_part`` gives it, at its targets.

    The vertices ``held`` (h,) stay.
    """
    edges, shares, targets = line
    native = _module()
    with _translated(native):
        mesh = native.SurfaceMesh(shape.points, shape.faces)
        return native.SilhouetteSketch(mesh, edges, shares, held, sharpness=sharpness).solve(targets)


def connected_parts(count: int, faces: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """The part (n,) that each of ``count`` vertices belongs to. ``faces`` are (counts, corners)."""
    native = _module()
    with _translated(native):
        return native.SurfaceMesh(np.zeros((count, 3)), faces).components


def bind_seconds(recipe: Recipe) -> float:
    """About how long a bind of this recipe takes, with that of the loose parts that follow."""
    control = recipe.control
    if not isinstance(control, Regions) or control.free_parts == "stay":
        return recipe.seconds
    parts = connected_parts(len(recipe.target.points), recipe.target.faces)
    sizes = np.bincount(parts)
    sizes[parts[np.concatenate(control.vertices)]] = 0
    return recipe.seconds + following(int((sizes > 1).sum()), int((sizes == 1).sum()))


def diagnose(points: np.ndarray, faces: tuple[np.ndarray, np.ndarray]) -> Diagnosis:
    """Find the defects that Repair can mend. ``points`` (n, 3) float64, ``faces`` (counts, corners).

    Points that are not finite are treated as points at the origin, but never counted as coincident.
    """
    bad = ~frames.are_valid(points)
    native = _module()
    with _translated(native):
        return _diagnosis(native.SurfaceMesh(np.where(bad[:, None], 0.0, points), faces), bad)


def _diagnosis(mesh, bad: np.ndarray | None = None) -> Diagnosis:
    """``bad`` (n,) is a mask of the points that are not finite; None means that all points are finite."""
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
