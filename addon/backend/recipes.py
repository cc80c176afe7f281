# SPDX-License-Identifier: GPL-3.0-or-later
"""What a factor is made from. Recipes keep the arrays that they are given, so these must not change."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar, Protocol

import numpy as np

from ..core.elements import Elements, Owner
from ..core.errors import ConstraintError, SinewError
from ..core.geometry.frames import transformed
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
class Regions:
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

    def solve(
        self, _native, _recipe: "Recipe", method: Any, poses: np.ndarray, **options
    ) -> tuple[np.ndarray, SolveReport]:
        """Positions (n, 3) for ``poses`` (k, 3, 4), and a report; of a ``frame`` if the method has keys."""
        if "keys" in options:
            return method.solve_frame(poses=poses, **options)
        return method.solve(poses, **options)


def _weights(made: Any, points: np.ndarray, former: Bound | None, progress: Progress | None) -> Any:
    """Compute the weights of points for a space method, or reuse those of ``former``; the native report."""
    return made.bind(points, progress) if former is None else made.rebind(former.method, points, progress)


@dataclass(frozen=True)
class Faces:
    """The faces (``counts``, ``corners``) of a control: a mesh of its points, which the native class takes.

    A ``closed`` mesh lies around the target.
    """

    counts: np.ndarray
    corners: np.ndarray
    closed: bool = True

    def mesh(self, native, points: np.ndarray) -> Any:
        """The native mesh of these points."""
        return native.SurfaceMesh(points, (self.counts, self.corners))

    def are_inside_out(self, native, points: np.ndarray) -> bool:
        """Whether all faces of a closed mesh look inwards."""
        if not self.closed:
            return False
        mesh = self.mesh(native, points)
        return 0 < len(native.diagnose_cage(mesh).inverted_faces) == mesh.face_count


@dataclass(frozen=True)
class Refusal:
    """What a control means that the native module refuses: an ``error`` with a ``remedy``.

    ``flip`` is the remedy where its faces are inside out.
    """

    error: type[SinewError] = ConstraintError
    remedy: Remedy = Remedy.NONE
    flip: Remedy = Remedy.NONE


@dataclass(frozen=True)
class CageReport:
    """What a bind to closed faces found: points ``outside``, and faces that cross others (indices)."""

    outside: np.ndarray
    crossing: np.ndarray


@dataclass(frozen=True)
class ControlPoints:
    """The points (c, 3) float64 of controls at rest, in the frame of the target, for a space method.

    ``own`` are keywords of the native class that describe the controls: most have one value for each of them.
    With ``faces``, that class is made of a mesh instead of the points.
    """

    points: np.ndarray
    own: Mapping[str, Any] = field(default_factory=dict)
    faces: Faces | None = None
    refusal: Refusal = Refusal()

    @property
    def size(self) -> int:
        """How many points there are; of closed faces how many triangles they are cut into."""
        if self.faces is None or not self.faces.closed:
            return len(self.points)
        return len(self.faces.corners) - 2 * len(self.faces.counts)

    def make(self, native, recipe: "Recipe", _mesh: object) -> Any:
        """The native method, still without bound points."""
        with self._naming_control(native):
            control = self.points if self.faces is None else self.faces.mesh(native, self.points)
            return make(native, recipe.method, control, {**recipe.options, **self.own})

    def can_reuse(self, recipe: "Recipe", made: Any, former: object) -> bool:
        """Whether the bound method ``former`` has the weights that the method ``made`` would compute."""
        return made.can_reuse(former, recipe.target.points)

    def bind(
        self, native, recipe: "Recipe", made: Any, former: Bound | None, progress: Progress | None
    ) -> object:
        """Compute the weights of the target's points, or reuse those of ``former``, and return the report."""
        with self._naming_control(native):
            report = _weights(made, recipe.target.points, former, progress)
        if self.faces is None or not self.faces.closed:
            return report
        if former is not None:
            return former.report
        found = native.diagnose_cage(self.faces.mesh(native, self.points))
        return CageReport(report.outside, np.unique(found.crossing_faces))

    def solve(
        self,
        _native,
        _recipe: "Recipe",
        method: Any,
        pose: np.ndarray,
        *,
        incoming: np.ndarray | None = None,
        out: np.ndarray | None = None,
        progress: Progress | None = None,
    ) -> tuple[np.ndarray, None]:
        """Positions (n, 3) for a ``pose`` (c, 3) of the points. There is nothing to report."""
        return method.warp(pose, out=out, incoming=incoming), None

    @contextmanager
    def _naming_control(self, native) -> Iterator[None]:
        """Turn errors about a mesh into errors about the control, which is that mesh."""
        try:
            yield
        except native.InvalidMesh as error:
            elements = Elements(Owner.CONTROL, error.element_kind, error.elements)
            inside_out = self.faces is not None and self.faces.are_inside_out(native, self.points)
            remedy = self.refusal.flip if inside_out else self.refusal.remedy
            raise self.refusal.error(str(error), elements, remedy) from error


@dataclass(frozen=True)
class Around:
    """The ``shape`` of the target and of all that share handles with it. The ``frame`` (4, 4) leads there
    from the target, and takes its points to ``points`` (n, 3).
    """

    shape: Shape
    frame: np.ndarray
    points: np.ndarray

    def poses(self, poses: np.ndarray) -> np.ndarray:
        """The same motions (k, 3, 4) there."""
        whole = np.broadcast_to(np.eye(4), (len(poses), 4, 4)).copy()
        whole[:, :3] = poses
        return (self.frame @ whole @ np.linalg.inv(self.frame))[:, :3]

    def back(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) in the frame of the target."""
        return transformed(np.linalg.inv(self.frame), points)


@dataclass(frozen=True)
class Apart:
    """That each point of a handle moves by itself. ``edges`` (e, 2) join the handle's points; they act as a
    whole where they are ``segments``, which only some methods take.
    """

    edges: np.ndarray
    segments: bool = False


@dataclass(frozen=True)
class HandlePoints:
    """Points (c, 3) that move with handles, handle after handle: ``counts`` (k,) is how many each has.

    ``weights`` (c,) in (0, 1] is how strongly each point is held; None if all are held fully. The points of a
    handle move by one map, or each by itself if its row is in ``apart``: then each is a handle of the native
    method. ``around``: the shape of several objects that they move, if there are several. ``of_boxes``:
    segments count per length of the longest side of the box along the axes around all points, as in earlier
    builds.
    """

    points: np.ndarray
    counts: tuple[int, ...]
    weights: np.ndarray | None = None
    apart: Mapping[int, Apart] = field(default_factory=dict)
    around: Around | None = None
    of_boxes: bool = False

    @cached_property
    def _segments(self) -> np.ndarray:
        """(s, 2) the points at the ends of all segments."""
        found = [
            joined.edges + sum(self.counts[:row]) for row, joined in self.apart.items() if joined.segments
        ]
        return np.concatenate(found) if found else np.zeros((0, 2), dtype=int)

    @property
    def size(self) -> int:
        """How many points there are. For `bind_seconds`, a segment costs as much as 12 points."""
        return len(self.points) + 12 * len(self._segments)

    @cached_property
    def _is_apart(self) -> np.ndarray:
        """Which handles are apart, (k,)."""
        return np.isin(np.arange(len(self.counts)), list(self.apart))

    @cached_property
    def _rows(self) -> np.ndarray:
        """How many handles of the native method each handle is, (k,)."""
        return np.where(self._is_apart, self.counts, 1)

    @cached_property
    def native_counts(self) -> np.ndarray:
        """How many points each handle of the native method has."""
        return np.repeat(np.where(self._is_apart, 1, self.counts), self._rows)

    def located(self, row: int) -> tuple[int, int | None]:
        """As ``Recipe.located``."""
        ends = np.cumsum(self._rows)
        handle = int(np.searchsorted(ends, row, side="right"))
        if handle == len(ends):
            return row, None
        return handle, int(row - ends[handle] + self._rows[handle]) if handle in self.apart else None

    def make(self, native, recipe: "Recipe", mesh: object) -> Any:
        """The native method, still without bound points; one around another gets the mesh, too."""
        method, options = recipe.method, recipe.options
        given = self._given(native, method, options)
        if method.posed is Posed.POSES:
            points = self.points
            if self.around is not None:
                mesh = native.SurfaceMesh(self.around.shape.points, self.around.shape.faces)
                points = transformed(self.around.frame, points)
            return make(native, method, mesh, {"points": points, **given})
        base = options.get("base")
        if isinstance(base, Base):
            around = self._given(native, base.method, base.options)
            given |= {"base": Base(base.method, around), "mesh": mesh}
        return make(native, method, self.points, given, mesh)

    def _given(self, native, method: Method, options: Mapping[str, object]) -> dict[str, object]:
        given = {"counts": self.native_counts, "weights": self.weights, **options}
        if method.takes_segments and len(self._segments):
            given["segments"] = self._segments
            if self.of_boxes:  # that is a shorter length, so all else counts less
                held = np.ones(len(self.points)) if self.weights is None else self.weights
                less = BoxShare(held, Size.HANDLES).of(native, self.points)
                is_end = np.isin(np.arange(len(self.points)), self._segments)
                given["weights"] = np.where(is_end, held, less)
        return given

    def _bound_points(self, recipe: "Recipe") -> np.ndarray:
        """The points of the target, as the native method takes them."""
        return recipe.target.points if self.around is None else self.around.points

    def can_reuse(self, recipe: "Recipe", made: Any, former: object) -> bool:
        """Whether the bound method ``former`` has the weights that the method ``made`` would compute."""
        return made.can_reuse(former, self._bound_points(recipe))

    def bind(
        self, native, recipe: "Recipe", made: Any, former: Bound | None, progress: Progress | None
    ) -> object:
        """Compute the weights of the target's points, or reuse those of ``former``, and return the report.

        Where handles have no place beside each other, the error has the remedy for that.
        """
        try:
            return _weights(made, self._bound_points(recipe), former, progress)
        except native.InvalidConstraint as error:
            elements = Elements(Owner.TARGET, error.element_kind, error.elements)
            has_remedy = recipe.method.finer and elements.element == "handle"
            raise ConstraintError(str(error), elements, Remedy.REFINE if has_remedy else None) from error

    def solve(
        self,
        native,
        recipe: "Recipe",
        method: Any,
        pose: np.ndarray,
        *,
        out: np.ndarray | None = None,
        progress: Progress | None = None,
        **options,
    ) -> tuple[np.ndarray, None]:
        """Positions (n, 3) for a ``pose`` (k, 3, 4) of the handles. ``options`` are those of ``network``."""
        given = self._posed(native, recipe, pose, **options)
        if self.around is None:
            return method.warp_poses(**given, out=out), None
        solved = self.around.back(method.warp_poses(**given))
        if out is None:
            return solved, None
        np.copyto(out, solved, casting="same_kind")
        return out, None

    def network(
        self, native, recipe: "Recipe", method: Any, pose: np.ndarray, **options
    ) -> tuple[np.ndarray, np.ndarray]:
        """What moves the shape between the handles: nodes, and pairs of them.

        ``options``: the ``incoming`` shape (n, 3); ``from_rest`` (k,), whether the pose of a handle applies
        to the rest shape; and ``placed`` (p, 3), the points of those that are apart.
        """
        nodes, pairs = method.network(**self._posed(native, recipe, pose, **options))
        return nodes if self.around is None else self.around.back(nodes), pairs

    def _posed(
        self,
        native,
        recipe: "Recipe",
        pose: np.ndarray,
        *,
        from_rest: np.ndarray | None = None,
        placed: np.ndarray | None = None,
        incoming: np.ndarray | None = None,
    ) -> dict[str, np.ndarray | None]:
        """The keywords that the native method takes."""
        if self.apart:
            pose = np.repeat(pose, self._rows, axis=0)
            from_rest = None if from_rest is None else np.repeat(from_rest, self._rows)
        if placed is not None:
            turns = recipe.method.posed is Posed.POSES
            of_points = self._turned(native, placed) if turns else self._moved(placed)
            pose[np.repeat(self._is_apart, self._rows)] = of_points
        if self.around is not None:
            pose = self.around.poses(pose)
            if incoming is not None:
                incoming = transformed(self.around.frame, incoming.astype(np.float64))
        return {"poses": pose, "from_rest": from_rest, "incoming": incoming}

    @cached_property
    def _points_apart(self) -> np.ndarray:
        """The points (p, 3) of handles that are apart."""
        return self.points[np.repeat(self._is_apart, self.counts)]

    def _moved(self, placed: np.ndarray) -> np.ndarray:
        """A translation (p, 3, 4) for each point that is apart: all that a method takes whose points do not
        turn.
        """
        poses = np.tile(np.eye(3, 4), (len(placed), 1, 1))
        poses[:, :, 3] = placed - self._points_apart
        return poses

    def _turned(self, native, placed: np.ndarray) -> np.ndarray:
        """A pose (p, 3, 4) for each point that is apart, which turns as what is around it does."""
        rows = sorted(self.apart)
        ends = np.cumsum([self.counts[row] for row in rows])[:-1]
        parts = zip(rows, np.split(self._points_apart, ends), np.split(placed, ends), strict=True)
        return np.concatenate(
            [native.turned_poses(rest, posed, self.apart[row].edges) for row, rest, posed in parts]
        )


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
    control: Regions | ControlPoints | HandlePoints

    @property
    def seconds(self) -> float:
        """About how long the bind takes, by the registry's rows; with that of a base method."""
        around = self.control.around if isinstance(self.control, HandlePoints) else None
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
