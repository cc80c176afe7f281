# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the silhouette of a mesh anew, or a line of edges, once and without a deformer.

The result is a shape key, relative to the basis, so that it can be faded, removed, and joined by others. It
starts from the mesh as its shape keys show it, before all modifiers. Main thread only.
"""

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from bpy.types import Collection, Depsgraph, Object, ShapeKey

from ...backend import Shape, sketched, sketched_part
from ...compat import read_edges, read_key, read_positions, write_key
from ...core.elements import Elements, Owner
from ...core.errors import ConstraintError, MeshError, SinewError
from ...core.geometry import frames, reach
from ...core.status import Remedy
from ...mesh_io import RestShape, read_rest
from ..datablocks.vertex_groups import fixed_vertices
from ..evaluation import binding
from ..targets import targets

KEY = "Silhouette"
NO_LINE = "There is no silhouette near both ends of the stroke - begin and end it on the outline to redraw"
NO_LINE_SEEN = f"{NO_LINE}, or let Hidden Lines count"
ALL_FIXED = "The line lies in Still regions, which stay - draw another part of it"
NO_EDGES_NEAR = "No line of selected edges is near both ends of the stroke - begin and end it on that line"
TOO_SHORT = "The stroke is too short - draw a longer one"
NO_EDGES = "No edges are selected - select the line to redraw in Edit Mode"
_RINGS = 3  # the energy depends on vertices two edges away, and their normals on one more
_SHARE = 0.25  # of the length of the line: how far the surface follows unless told otherwise


@dataclass(frozen=True)
class Sight:
    """A view of the world: ``axes`` (3, 3) are rows to the right, up and toward the viewer, orthonormal.

    ``eye`` (3,) is where the viewer of a perspective view is; None for an orthographic one.
    """

    axes: np.ndarray
    eye: np.ndarray | None


class Sketch:
    """A mesh of which a line is drawn anew. Call ``draw`` with a stroke, then ``follow`` with a reach.

    ``restore`` puts everything back. Only names and numbers are kept. Points are oriented and scaled as the
    world, relative to the location of the object.
    """

    def __init__(
        self, obj: Object, along_edges: bool = False, replaced: str = "", hidden: bool = False
    ) -> None:
        """Read the mesh. The shape key named ``replaced`` is redrawn; without a name a new one is made.

        ``hidden``: silhouettes count that the mesh itself hides.
        """
        binding.require_backend()
        _require(obj)
        if replaced and (replaced == _basis_name(obj) or replaced not in _keys(obj)):
            raise SinewError(f"{obj.name} has no shape key {replaced} that could be redrawn")
        world = np.array(obj.matrix_world, dtype=np.float64)
        self._inverse = frames.inverse(world, obj.name)[:3, :3]
        self._origin = world[:3, 3]
        self._key = self._replaced = replaced
        self._before = read_key(_keys(obj)[replaced]) if replaced else None
        self._had_keys = obj.data.shape_keys is not None
        self._active = obj.active_shape_key_index
        self._rest = _shown(obj, replaced)
        self._basis = _basis(obj)
        if len(self._rest.not_finite):
            raise MeshError(
                f"{obj.name} has vertices with invalid coordinates (NaN or infinite) - use Repair",
                Elements(Owner.TARGET, "vertex", self._rest.not_finite),
                Remedy.REPAIR,
            )
        self._points = self._rest.points @ world[:3, :3].T
        self._triangles = reach.TriangleMesh(len(self._points), self._rest.counts, self._rest.corners)
        self._edges = _selected_edges(obj) if along_edges else None
        self._hidden = hidden
        self._stays = fixed_vertices(obj, obj.data)
        self._line: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None

    def draw(self, stroke: np.ndarray, sight: Sight) -> float:
        """Find the line that a stroke (s, 3) in the world redraws.

        Returns how far the surface follows unless told otherwise.
        """
        if len(stroke) < 2:
            raise ConstraintError(TOO_SHORT)
        if not np.isfinite(stroke).all():
            raise ConstraintError("The stroke has a point that is not a finite number - draw another one")
        eye = None if sight.eye is None else sight.eye - self._origin
        seen = (stroke - self._origin) if eye is None else (stroke - sight.eye)
        if np.ptp(seen @ sight.axes[:2].T, axis=0).max() <= 0.0:
            raise ConstraintError(TOO_SHORT)
        shape = Shape(self._points, (self._rest.counts, self._rest.corners))
        line = sketched_part(shape, stroke - self._origin, sight.axes, eye, self._edges, self._hidden)
        if line is None:
            if self._edges is not None:
                raise ConstraintError(NO_EDGES_NEAR)
            raise ConstraintError(NO_LINE if self._hidden else NO_LINE_SEEN)
        if self._stays[line[0]].all():
            raise ConstraintError(ALL_FIXED, Elements(Owner.TARGET, "vertex", np.unique(line[0])))
        self._line = line
        before = self.line - self._origin
        lengths = np.linalg.norm(np.diff(line[2], axis=0), axis=1).sum()
        moved = np.linalg.norm(line[2] - before, axis=1).max()
        return max(_SHARE * float(lengths), float(moved))

    @property
    def line(self) -> np.ndarray:
        """The points (k, 3) that are redrawn, in the world, where they were before."""
        edges, shares, _targets = self._found()
        ends = self._points[edges]
        return ends[:, 0] + shares[:, None] * (ends[:, 1] - ends[:, 0]) + self._origin

    def follow(self, obj: Object, radius: float, sharpness: float = 0.0) -> None:
        """Let what lies within ``radius`` of the line follow it, in world units over the surface.

        Infinite: all connected. Still regions stay, and so does what only they connect with the line. The
        first call makes the shape key.
        """
        edges, shares, goals = self._found()
        counts, corners = self._rest.counts, self._rest.corners
        sources = np.zeros(len(self._points), dtype=bool)
        sources[edges] = True
        sources &= ~self._stays
        if np.isinf(radius):
            free = self._triangles.connected(sources, self._stays)
        else:
            free = self._triangles.lengths(self._points, sources, self._stays, radius) <= radius
        members, faces = reach.submesh(counts, corners, reach.with_rings(counts, corners, free, _RINGS))
        place = np.full(len(sources), -1, dtype=np.int32)
        place[members] = np.arange(len(members), dtype=np.int32)
        held = np.flatnonzero(~free[members])
        near = (place[edges] >= 0).all(axis=1)  # others lie deep in fixed regions
        line = place[edges][near], shares[near], goals[near]
        found = sketched(Shape(self._points[members], faces), line, held, sharpness)
        moves = np.zeros_like(self._points)
        moves[members] = (found - self._points[members]) @ self._inverse.T
        with np.errstate(over="ignore"):  # refused just below
            shape = (self._basis + moves).astype(np.float32)
        if not np.isfinite(shape).all():
            raise MeshError("The result is not finite - draw the stroke nearer to the mesh")
        write_key(self._shape_key(obj), shape)
        obj.data.update_tag()

    def restore(self, obj: Object) -> None:
        """Remove what was made."""
        keys = _keys(obj)
        if self._key in keys:
            if self._before is not None:
                write_key(keys[self._key], self._before)
                obj.data.update_tag()
            elif self._had_keys:
                obj.shape_key_remove(keys[self._key])
                obj.active_shape_key_index = self._active
            else:
                obj.shape_key_clear()
        self._key = self._replaced

    def _found(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        if self._line is None:
            raise ConstraintError("No line is drawn yet - draw a stroke first")
        return self._line

    def _shape_key(self, obj: Object) -> ShapeKey:
        """The key of this sketch; a new one at first."""
        if self._key in _keys(obj):
            return _keys(obj)[self._key]
        if obj.data.shape_keys is None:
            obj.shape_key_add(name="Basis", from_mix=False)
        key = obj.shape_key_add(name=KEY, from_mix=False)
        key.relative_key = obj.data.shape_keys.reference_key
        key.value = 1.0
        self._key = key.name
        obj.active_shape_key_index = _keys(obj).find(key.name)
        return key


def stroke_of(curve: Object, depsgraph: Depsgraph) -> np.ndarray:
    """The points (s, 3) of a curve object in the world, as Blender draws it. It must be one line."""
    if not targets.is_path(curve):
        raise SinewError(f"{curve.name} is a {targets.label(curve)} object - choose a curve")
    shown = curve.evaluated_get(depsgraph)
    mesh = shown.to_mesh()
    try:
        is_line = mesh is not None and not len(mesh.polygons)
        points = read_positions(mesh).astype(np.float64) if is_line else np.zeros((0, 3))
        closed = len(points) > 0 and len(mesh.edges) == len(points)
    finally:
        shown.to_mesh_clear()
    if not is_line or len(curve.data.splines) != 1:
        raise SinewError(f"{curve.name} is not a single line - remove its bevel and its other splines")
    if closed:
        points = np.concatenate((points, points[:1]))
    return frames.transformed(np.array(curve.matrix_world, dtype=np.float64), points)


def keep_stroke(name: str, stroke: np.ndarray, collection: Collection) -> Object:
    """A new curve object along the points (s, 3) of a stroke in the world."""
    curve = bpy.data.curves.new(name, "CURVE")
    curve.dimensions = "3D"
    line = curve.splines.new("POLY")
    line.points.add(len(stroke) - 1)
    line.points.foreach_set("co", np.column_stack((stroke, np.ones(len(stroke)))).astype(np.float32).ravel())
    kept = bpy.data.objects.new(name, curve)
    collection.objects.link(kept)
    return kept


def _require(obj: Object) -> None:
    """Refuse an object whose silhouette cannot be stored."""
    targets.require_mesh(obj, "A silhouette needs the surface of a mesh: this tool redraws")
    if obj.library is not None or obj.data.library is not None:
        raise SinewError(f"{obj.name} or its mesh is linked - make it local")
    if obj.mode != "OBJECT":
        raise SinewError(f"{obj.name} is not in Object Mode - bring it there first")
    if not len(obj.data.polygons):
        raise SinewError(f"{obj.name} has no faces - a silhouette needs a surface")
    keys = obj.data.shape_keys
    if keys is not None and not keys.use_relative:
        raise SinewError(f"The shape keys of {obj.name} are absolute - switch Relative on")
    if keys is not None and obj.show_only_shape_key:
        raise SinewError(f"{obj.name} shows one shape key only - switch off the pin beside the keys")


def _keys(obj: Object) -> Any:
    """The shape keys by their names."""
    keys = obj.data.shape_keys
    return {} if keys is None else keys.key_blocks


def _basis_name(obj: Object) -> str:
    keys = obj.data.shape_keys
    return "" if keys is None else keys.reference_key.name


def _shown(obj: Object, without: str) -> RestShape:
    """The mesh as its shape keys show it, but for one of them."""
    shape = read_rest(obj.data)
    if obj.data.shape_keys is not None:
        active = obj.active_shape_key_index
        if without:
            muted, _keys(obj)[without].mute = _keys(obj)[without].mute, True
        mix = obj.shape_key_add(name=KEY, from_mix=True)
        places = read_key(mix).astype(np.float64)
        obj.shape_key_remove(mix)
        if without:
            _keys(obj)[without].mute = muted
        obj.active_shape_key_index = active
        shape.not_finite = np.flatnonzero(~frames.are_valid(places))
        shape.points = places
    return shape


def _basis(obj: Object) -> np.ndarray:
    keys = obj.data.shape_keys
    return (read_positions(obj.data) if keys is None else read_key(keys.reference_key)).astype(np.float64)


def _selected_edges(obj: Object) -> np.ndarray:
    """The vertices (e, 2) of the edges that are selected in Edit Mode."""
    chosen = np.empty(len(obj.data.edges), dtype=bool)
    obj.data.edges.foreach_get("select", chosen)
    if not chosen.any():
        raise ConstraintError(NO_EDGES)
    return read_edges(obj.data)[chosen]
