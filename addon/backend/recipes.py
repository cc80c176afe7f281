# SPDX-License-Identifier: GPL-3.0-or-later
"""What a factor is made from. Recipes keep the arrays that they are given, so these must not change."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar, Protocol

import numpy as np

from ..core.elements import Elements, Owner
from ..core.errors import CageError, ConstraintError
from ..core.geometry.frames import transformed
from ..core.geometry.turns import turned_poses
from ..core.methods import MeshShape, Method, Posed, Size
from ..core.status import Remedy

_PREVIEW_RAYS = 128  # per point: weights in a tenth of the time, with errors of some hundredths

Progress = Callable[[float, str], bool]


@dataclass(frozen=True)
class Shape:
    """A mesh: ``points`` (n, 3) float64 and ``faces`` (counts, corners)."""

    points: np.ndarray
    faces: tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Base:
    """The value of an option: the method that another method is put around, with its own ``options``."""

    method: Method
    options: dict[str, object]


@dataclass(frozen=True)
class BoxShare:
    """The value of an option that is a share of the box along the axes, which earlier builds took for the
    ``size``: the diagonal of that around the surface, or the longest side of that around all handles.
    """

    value: float | np.ndarray
    size: Size

    def of(self, native, target: Any) -> float | np.ndarray:
        """The share of the size that the native module measures, of a native mesh or of handle points."""
        points = target if isinstance(target, np.ndarray) else target.points
        sides = np.ptp(points, axis=0)
        if not sides.any():
            return self.value
        if self.size is Size.HANDLES:
            return self.value * sides.max() / native.diameter(points)
        return self.value * np.linalg.norm(sides) / target.sizes


@dataclass(frozen=True)
class AxisBox:
    """The value of an option: the box along the axes around ``points`` (n, 3) and the handles, as earlier
    builds took it. The ``frame`` (4, 4) leads here from the space of these axes.
    """

    points: np.ndarray
    frame: np.ndarray

    def around(self, handles: np.ndarray) -> np.ndarray:
        """The frame (3, 4) of the cube from -1 to 1; a side without length gets that of the longest one."""
        stored = transformed(np.linalg.inv(self.frame), np.concatenate((self.points, handles)))
        low, high = stored.min(axis=0), stored.max(axis=0)
        longest = (high - low).max() or 1.0
        sides = np.where(high - low > 1e-6 * longest, high - low, longest) + 0.1 * longest
        cube = np.column_stack((np.diag(0.5 * sides), 0.5 * (low + high)))
        return (self.frame @ np.vstack((cube, (0.0, 0.0, 0.0, 1.0))))[:3]


def make(native, method: Method, target: object, options: dict[str, object], mesh: Any = None) -> Any:
    """The native object of a method, and of the method that it is put around.

    ``target``: what the method is made of, a native mesh or points. ``mesh``: the native mesh that it moves,
    for options that may be the same one.
    """
    made = {name: _made(native, target, value, mesh) for name, value in options.items()}
    return getattr(native, method.native)(target, **made)


def _made(native, target: Any, value: object, mesh: Any) -> object:
    """The value of an option as the native constructor takes it."""
    if isinstance(value, Base):
        return make(native, value.method, target, value.options)
    if isinstance(value, Shape):
        is_same = mesh is not None and mesh.is_made_of(value.points, value.faces)
        return mesh if is_same else native.SurfaceMesh(value.points, value.faces)
    if isinstance(value, BoxShare):
        return value.of(native, target)
    if isinstance(value, AxisBox):
        return value.around(target)
    return value


class SolveReport(Protocol):
    """Result of a solve: iterations and convergence."""

    iterations: int
    converged: bool


@dataclass(frozen=True)
class Bound:
    """A native method that is bound, and the report of its bind."""

    method: Any
    report: object


@dataclass(frozen=True)
class Handles:
    """The regions of a surface: vertices, weights and ``options`` of each, as ``set_handles`` takes them.

    ``free_parts`` says what the parts do that no region touches: 'stay' or 'follow'.
    """

    size: ClassVar[int] = 0  # for the registry: a surface method pays for its surface alone

    vertices: Sequence[np.ndarray]
    weights: Sequence[object]
    options: dict[str, Sequence[object]] = field(default_factory=dict)
    free_parts: str = "stay"

    def make(self, native, recipe: "Recipe", mesh: object) -> Any:
        """The native method, still without handles."""
        return make(native, recipe.method, mesh, recipe.options)

    def can_reuse(self, _recipe: "Recipe", made: Any, former: object) -> bool:
        """Whether the method ``made`` can reuse anything of the bound method ``former``."""
        return made.can_reuse(former)

    def bind(
        self, _native, _recipe: "Recipe", made: Any, former: Bound | None, progress: Progress | None
    ) -> object:
        """Give the method ``made`` its handles, and return the report.

        It reuses what it can of ``former``.
        """
        words = {"weights": self.weights, "free_parts": self.free_parts, "progress": progress, **self.options}
        if former is None:
            return made.set_handles(self.vertices, **words)
        return made.rebind(former.method, self.vertices, **words)

    def solve(self, method: Any, poses: np.ndarray, **options) -> tuple[np.ndarray, SolveReport]:
        """Positions (n, 3) for ``poses`` (k, 3, 4), and a report; of a ``frame`` if the method has keys."""
        if "keys" in options:
            return method.solve_frame(poses=poses, **options)
        return method.solve(poses, **options)


@dataclass(frozen=True)
class ControlPoints:
    """The points (c, 3) float64 of a control at rest, in the frame of the target, for a space method."""

    points: np.ndarray

    @property
    def size(self) -> int:
        """How many points there are."""
        return len(self.points)

    def make(self, native, recipe: "Recipe", _mesh: object) -> Any:
        """The native method, still without bound points."""
        return make(native, recipe.method, self.points, recipe.options)

    def bound_points(self, recipe: "Recipe") -> np.ndarray:
        """The points of the target, as the native method takes them."""
        return recipe.target.points

    def can_reuse(self, recipe: "Recipe", made: Any, former: object) -> bool:
        """Whether the bound method ``former`` has the weights that the method ``made`` would compute."""
        return made.can_reuse(former, self.bound_points(recipe))

    def bind(
        self, _native, recipe: "Recipe", made: Any, former: Bound | None, progress: Progress | None
    ) -> object:
        """Compute the weights of the target's points, or reuse those of ``former``, and return the report."""
        if former is None:
            return made.bind(self.bound_points(recipe), progress)
        return made.rebind(former.method, self.bound_points(recipe), progress)

    def solve(
        self,
        method: Any,
        pose: np.ndarray,
        *,
        incoming: np.ndarray | None = None,
        out: np.ndarray | None = None,
        progress: Progress | None = None,
    ) -> tuple[np.ndarray, None]:
        """Positions (n, 3) for a ``pose`` (c, 3) of the points. There is nothing to report."""
        return method.warp(pose, out=out, incoming=incoming), None


@dataclass(frozen=True)
class LatticePoints(ControlPoints):
    """A lattice at rest: points in rows along u, then v, then w, or with ``faces`` the corners of hexahedra.

    ``resolution`` is how many points there are along each axis; ``interpolation`` names Blender's function
    along each of them, by the native module's names. ``faces`` are (counts, corners). ``axes`` (3, 3) are the
    directions of axes that have one point only, as rows; None if all have more.
    """

    resolution: tuple[int, int, int]
    interpolation: tuple[str, str, str]
    faces: tuple[np.ndarray, np.ndarray] | None = None
    axes: np.ndarray | None = None

    def make(self, native, recipe: "Recipe", _mesh: object) -> Any:
        """The native method, still without bound points. An error about the lattice names its points."""
        words = {"resolution": self.resolution, "interpolation": self.interpolation, "axes": self.axes}
        try:
            lattice = self.points if self.faces is None else native.SurfaceMesh(self.points, self.faces)
            return make(native, recipe.method, lattice, words | recipe.options)
        except native.InvalidMesh as error:
            elements = Elements(Owner.CONTROL, error.element_kind, error.elements)
            raise ConstraintError(str(error), elements, Remedy.LATTICE_REST) from error


@dataclass(frozen=True)
class HandlePoints(ControlPoints):
    """Points that move with handles, handle after handle: ``counts`` (k,) is how many each of them has.

    ``weights`` (c,) in (0, 1] is how strongly each point is held. The points of a handle move by one map, or
    each by itself if the handle is ``apart`` (k,): then each is a handle of the native method. ``edges``
    (e, 2) join points of such handles; those that are ``segments`` (e,) act as a whole, if the method takes
    segments. The native class is made of the points and weights alone.
    """

    counts: tuple[int, ...]
    weights: np.ndarray
    apart: tuple[bool, ...]
    edges: np.ndarray
    segments: np.ndarray

    def make(self, native, recipe: "Recipe", mesh: object) -> Any:
        """The native method, still without bound points."""
        options = {"weights": self.native_weights} | recipe.options
        return make(native, recipe.method, self.points, options, mesh)

    @cached_property
    def native_counts(self) -> np.ndarray:
        """How many points each handle of the native method has."""
        return np.repeat(np.where(self.apart, 1, self.counts), self._rows)

    @property
    def native_weights(self) -> np.ndarray | None:
        """The weights, or None if all points are held fully."""
        return None if (self.weights == 1.0).all() else self.weights

    @cached_property
    def _rows(self) -> np.ndarray:
        """How many handles of the native method each handle is, (k,)."""
        return np.where(self.apart, self.counts, 1)

    def located(self, row: int) -> tuple[int, int | None]:
        """As ``Recipe.located``."""
        ends = np.cumsum(self._rows)
        handle = int(np.searchsorted(ends, row, side="right"))
        if handle == len(ends):
            return row, None
        return handle, int(row - ends[handle] + self._rows[handle]) if self.apart[handle] else None

    def solve(
        self,
        method: Any,
        pose: np.ndarray,
        *,
        from_rest: np.ndarray | None = None,
        placed: np.ndarray | None = None,
        **options,
    ) -> tuple[np.ndarray, None]:
        """Positions (n, 3) for a ``pose`` (k, 3, 4) of the handles.

        ``placed`` (p, 3) are the points of those that are apart. The same displacements are added to the
        incoming shape whatever ``from_rest`` says.
        """
        posed, rows = self._posed(method, pose)
        if placed is not None:
            posed[np.repeat(self.apart, rows)] = placed
        return super().solve(method, posed, **options)

    def _posed(self, _method: Any, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The control of the native method in a pose, and how many of its rows (k,) each handle has."""
        ends = np.cumsum(self.counts)[:-1]
        posed = np.empty_like(self.points)
        parts = zip(np.split(posed, ends), np.split(self.points, ends), pose, strict=True)
        for part, points, matrix in parts:
            np.matmul(points, matrix[:, :3].T, out=part)
            part += matrix[:, 3]
        return posed, np.array(self.counts)


@dataclass(frozen=True)
class Around:
    """The ``shape`` of the target and of all that share handles with it. The ``frame`` (4, 4) leads there
    from the target, and takes its points to ``points`` (n, 3).
    """

    shape: Shape
    frame: np.ndarray
    points: np.ndarray

    def back(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) in the frame of the target."""
        return transformed(np.linalg.inv(self.frame), points)


@dataclass(frozen=True)
class HandlePoses(HandlePoints):
    """The same for a method that takes the poses of the handles, and is built around a shape: that of the
    target and of all objects that share handles with it.
    """

    around: Around | None

    def make(self, native, recipe: "Recipe", mesh: object) -> Any:
        """The native method, still without bound points."""
        points = self.points
        if self.around is not None:
            mesh = native.SurfaceMesh(self.around.shape.points, self.around.shape.faces)
            points = transformed(self.around.frame, points)
        own = {"points": points, "counts": self.native_counts, "weights": self.native_weights}
        return make(native, recipe.method, mesh, own | recipe.options)

    def bound_points(self, recipe: "Recipe") -> np.ndarray:
        """The points of the target, as the native method takes them."""
        return recipe.target.points if self.around is None else self.around.points

    def bind(
        self, native, recipe: "Recipe", made: Any, former: Bound | None, progress: Progress | None
    ) -> object:
        """As above; where handles have no place beside each other, the error has the remedy for that."""
        try:
            return super().bind(native, recipe, made, former, progress)
        except native.InvalidConstraint as error:
            elements = Elements(Owner.TARGET, error.element_kind, error.elements)
            has_remedy = recipe.method.finer and elements.element == "handle"
            raise ConstraintError(str(error), elements, Remedy.REFINE if has_remedy else None) from error

    def solve(
        self,
        method: Any,
        pose: np.ndarray,
        *,
        from_rest: np.ndarray | None = None,
        placed: np.ndarray | None = None,
        incoming: np.ndarray | None = None,
        out: np.ndarray | None = None,
        progress: Progress | None = None,
        **options,
    ) -> tuple[np.ndarray, None]:
        """As above; a point that is placed turns as what is around it does."""
        given = self._native_poses(pose, from_rest, placed, incoming) | options
        if self.around is None:
            return method.warp_poses(**given, out=out), None
        solved = self.around.back(method.warp_poses(**given))
        if out is None:
            return solved, None
        np.copyto(out, solved, casting="same_kind")
        return out, None

    def network(
        self,
        method: Any,
        pose: np.ndarray,
        *,
        from_rest: np.ndarray | None = None,
        placed: np.ndarray | None = None,
        incoming: np.ndarray | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """What moves the shape between the handles, for a pose as ``solve`` takes it: nodes, and pairs."""
        nodes, pairs = method.network(**self._native_poses(pose, from_rest, placed, incoming))
        return nodes if self.around is None else self.around.back(nodes), pairs

    def _native_poses(
        self,
        pose: np.ndarray,
        from_rest: np.ndarray | None,
        placed: np.ndarray | None,
        incoming: np.ndarray | None,
    ) -> dict[str, np.ndarray | None]:
        """The keywords that the native method takes."""
        poses, flags = self._own_poses(pose, from_rest, placed)
        if self.around is not None:
            frame, whole = self.around.frame, np.broadcast_to(np.eye(4), (len(poses), 4, 4)).copy()
            whole[:, :3] = poses
            poses = (frame @ whole @ np.linalg.inv(frame))[:, :3]
            if incoming is not None:
                incoming = transformed(frame, incoming.astype(np.float64))
        return {"poses": poses, "from_rest": flags, "incoming": incoming}

    def _own_poses(
        self, pose: np.ndarray, from_rest: np.ndarray | None, placed: np.ndarray | None
    ) -> tuple[np.ndarray, np.ndarray | None]:
        """The poses of the handles of the native method, in the frame of the target."""
        if placed is None:
            return pose, from_rest
        rows = np.repeat(pose, self._rows, axis=0)
        posed = self.points.copy()
        posed[np.repeat(self.apart, self.counts)] = placed
        first, row = 0, 0
        for count, apart, number in zip(self.counts, self.apart, self._rows, strict=True):
            last = first + count
            if apart:
                own = self.edges[(self.edges[:, 0] >= first) & (self.edges[:, 0] < last)] - first
                rows[row : row + number] = turned_poses(self.points[first:last], posed[first:last], own)
            first, row = last, row + number
        return rows, None if from_rest is None else np.repeat(from_rest, self._rows)


@dataclass(frozen=True)
class ControlParts(ControlPoints):
    """Points of several controls, one after the other. ``own`` are keywords with one value per control."""

    own: Mapping[str, Any]

    def make(self, native, recipe: "Recipe", _mesh: object) -> Any:
        """The native method, still without bound points."""
        return make(native, recipe.method, self.points, {**recipe.options, **self.own})


@dataclass(frozen=True)
class HandleMaps(HandlePoints):
    """Handle points for methods that take one affine map per handle.

    ``of_boxes``: segments count per length of the longest side of the box along the axes around all points,
    as in earlier builds.
    """

    of_boxes: bool = False

    def make(self, native, recipe: "Recipe", mesh: object) -> Any:
        """The native method, still without bound points; one around another gets the mesh, too."""
        given = self._given(native, recipe.method, recipe.options)
        base = given.get("base")
        if isinstance(base, Base):
            around = self._given(native, base.method, base.options)
            given |= {"base": make(native, base.method, self.points, around), "mesh": mesh}
        return make(native, recipe.method, self.points, given)

    @property
    def size(self) -> int:
        """How many points there are. For `bind_seconds`, a segment costs as much as 12 points."""
        return len(self.points) + 12 * int(self.segments.sum())

    def _given(self, native, method: Method, options: Mapping[str, object]) -> dict[str, object]:
        given = {"counts": self.native_counts, "weights": self.native_weights, **options}
        if method.takes_segments and self.segments.any():
            given["segments"] = ends = self.edges[self.segments]
            if self.of_boxes:  # that is a shorter length, so all else counts less
                less = BoxShare(self.weights, Size.HANDLES).of(native, self.points)
                is_end = np.isin(np.arange(len(self.points)), ends)
                given["weights"] = np.where(is_end, self.weights, less)
        return given

    def _posed(self, method: Any, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        counts = np.array(self.counts)
        rows = np.where(self.apart, counts, np.where(counts == 1, 1, 4))
        maps = np.repeat(pose, rows, axis=0)
        return np.einsum("rij,rj->ri", maps[:, :, :3], method.control) + maps[:, :, 3], rows


_NO_EDGES, _NO_SEGMENTS = np.zeros((0, 2), dtype=int), np.zeros(0, dtype=bool)


def handle_points(
    method: Method,
    points: np.ndarray,
    counts: tuple[int, ...],
    apart: tuple[bool, ...] = (),
    edges: np.ndarray = _NO_EDGES,
    segments: np.ndarray = _NO_SEGMENTS,
    weights: np.ndarray | None = None,
    around: Around | None = None,
    of_boxes: bool = False,
) -> HandlePoints:
    """The control of a space method that handles move: ``counts`` of ``points`` (c, 3) belong to each.

    By default none is ``apart``, and all are held fully. ``around``: the shape of several objects that
    they move, if there are several. ``of_boxes``: see ``HandleMaps``.
    """
    held = np.ones(len(points)) if weights is None else weights
    given = points, counts, held, apart or (False,) * len(counts), edges, segments
    if method.posed is Posed.POSES:
        return HandlePoses(*given, around)
    return HandleMaps(*given, of_boxes) if method.posed is Posed.CONTROL else HandlePoints(*given)


@dataclass(frozen=True)
class CageReport:
    """What a bind to a cage found: the vertices ``outside`` the cage, and its faces that cross others
    (indices).
    """

    outside: np.ndarray
    crossing: np.ndarray


@dataclass(frozen=True)
class Cage(ControlPoints):
    """The rest cage around a target, in the frame of the target. ``faces`` are (counts, corners)."""

    faces: tuple[np.ndarray, np.ndarray]

    @property
    def size(self) -> int:
        """How many triangles the faces of the cage are cut into."""
        counts, corners = self.faces
        return len(corners) - 2 * len(counts)

    def make(self, native, recipe: "Recipe", _mesh: object) -> Any:
        """The native method, still without bound points."""
        cage = native.SurfaceMesh(self.points, self.faces)
        with _naming_cage(native, cage):
            return make(native, recipe.method, cage, recipe.options)

    def bind(
        self, native, recipe: "Recipe", made: Any, former: Bound | None, progress: Progress | None
    ) -> object:
        """Compute the weights of the target's points, or reuse those of ``former``, and return the report."""
        points = recipe.target.points
        if former is not None:
            made.rebind(former.method, points, progress)
            return former.report
        cage = native.SurfaceMesh(self.points, self.faces)
        with _naming_cage(native, cage):
            outside = made.bind(points, progress).outside
        return CageReport(outside, np.unique(native.diagnose_cage(cage).crossing_faces))


@contextmanager
def _naming_cage(native, cage: Any) -> Iterator[None]:
    """Turn the error about a mesh into an error about the cage."""
    try:
        yield
    except native.InvalidMesh as error:
        inside_out = 0 < len(native.diagnose_cage(cage).inverted_faces) == cage.face_count
        remedy = Remedy.FLIP_CAGE if inside_out else Remedy.CAGE_REST
        elements = Elements(Owner.CONTROL, error.element_kind, error.elements)
        raise CageError(str(error), elements, remedy) from error


def _seconds(method: Method, points: int, size: int, options: dict[str, object]) -> float:
    bases = [value for value in options.values() if isinstance(value, Base)]
    return method.bind_seconds(points, size, options) + sum(
        _seconds(base.method, points, size, base.options) for base in bases
    )


@dataclass(frozen=True)
class Recipe:
    """Everything that a bind depends on. ``options`` are those of the native constructor.

    ``control`` holds the arrays of the control, and makes the native object from them.
    """

    method: Method
    target: Shape
    options: dict[str, object]
    control: Handles | ControlPoints

    @property
    def seconds(self) -> float:
        """About how long the bind takes, by the registry's rows; with that of a base method."""
        around = self.control.around if isinstance(self.control, HandlePoses) else None
        shape = self.target if around is None else around.shape
        return _seconds(self.method, len(shape.points), self.control.size, self.options)

    @property
    def moves_every_part(self) -> bool:
        """Whether parts without a handle move, too: to a target shape."""
        shapes = [parameter.id for parameter in self.method.parameters if isinstance(parameter, MeshShape)]
        return any(self.options[name] is not None for name in shapes)

    def located(self, row: int) -> tuple[int, int | None]:
        """The handle that a handle of the native method belongs to; and which of its points that is, if they
        are apart.
        """
        return self.control.located(row) if isinstance(self.control, HandlePoints) else (row, None)

    def native_class(self, native) -> type:
        """The class of the method in the native module."""
        return getattr(native, self.method.native)

    def preview(self) -> "Recipe | None":
        """A recipe for approximate weights, to pose with until the exact ones are computed; None if not
        needed.
        """
        if not self.options.get("exact"):
            return None
        return replace(self, options={**self.options, "exact": False, "directions": _PREVIEW_RAYS})
