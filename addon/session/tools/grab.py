# SPDX-License-Identifier: GPL-3.0-or-later
"""Grab a selection in Edit Mode: the surface around follows it once, without a deformer.

Only the part of the mesh that may move, with the rings of fixed vertices that its energies look at, goes to
the native module. Everything held is arrays; each call that touches the mesh is given the object.
"""

import time
from dataclasses import dataclass

import bmesh
import bpy
import numpy as np
from bpy.types import Object

from ...backend import Factor, Handles, Recipe, Shape, build_factor
from ...core import frames, reach
from ...core.errors import ConstraintError, MeshError, TopologyChangedError
from ...core.methods import Method
from ...core.status import Remedy
from ...mesh_io import group_weights, read_rest
from ...preferences import preferences
from ..control.handles.poses import IDENTITY
from ..live import binding
from ..memory import sessions
from ..memory.background import Work

NOTHING_SELECTED = "Nothing is selected - select the vertices to grab"
ALL_FIXED = "The selected vertices belong to Fixed regions, which stay - select others"
NO_PLACE = "The selected vertices have coordinates that are no numbers - Repair the mesh, or select others"
CHANGED = "The mesh was edited meanwhile - grab again"
NOTHING_FREE = "Nothing around the selection is free to follow - only the selection moves"

_RINGS = 3  # energies up to the variation of curvature look three edges far
_HEADROOM = 1.5  # how much farther than asked the surface is measured when the radius grows
_FEW = 0.2  # of the vertices: below, updating their normals one by one is quicker than all by Blender
_PREVIEW_ITERATIONS = 4  # while the price of a step is unknown
_MOST_ITERATIONS = 10  # more would not show within a drag


@dataclass
class _Region:
    """What follows the selection within a radius.

    ``members`` (k,) are vertices of the mesh; ``free``, ``handle`` and ``fixed`` places among them. ``rest``
    (k, 3) is oriented and scaled as the world. ``moving`` (t,) are the selection and after it the free
    vertices, ``shaded`` the vertices and faces whose normals they change, None where those are many.
    """

    radius: float
    moving: np.ndarray
    shaded: tuple[np.ndarray, np.ndarray] | None
    members: np.ndarray
    free: np.ndarray
    handle: np.ndarray
    fixed: np.ndarray
    rest: np.ndarray
    faces: tuple[np.ndarray, np.ndarray]
    factor: Factor | None = None

    def rides_along(self, pose: np.ndarray) -> bool:
        """Nothing holds the region, and nothing bends it: it goes as one piece."""
        linear = pose[:, :3]
        return len(self.fixed) == 0 and np.allclose(linear.T @ linear, np.eye(3), rtol=0.0, atol=1e-9)


class Grab:
    """The selection of a mesh in Edit Mode as a handle, and what follows it.

    ``follow`` a radius, ``show`` motions, ``restore`` or leave it.
    """

    def __init__(self, obj: Object, method: Method) -> None:
        binding.require_backend()
        self._method = method
        world = np.array(obj.matrix_world, dtype=np.float64)
        self._inverse = frames.inverse(world, obj.name)[:3, :3]
        self._linear, self._origin = world[:3, :3], world[:3, 3]
        self._read(obj)
        self._surface = reach.Surface(len(self._rest), self._counts, self._corners)
        self._lengths: np.ndarray | None = None
        self._measured = 0.0
        self._region: _Region | None = None
        self._work: Work | None = None
        self._final: Work | None = None
        self._start: np.ndarray | None = None
        self._budget = _PREVIEW_ITERATIONS
        self._shown: _Region | None = None  # whose vertices are not at rest
        self.settled = True  # what is shown is the final answer for its motion

    @sessions.suspended()
    def _read(self, obj: Object) -> None:
        """Copy what Edit Mode shows, the active shape key included, bit for bit."""
        mesh = bpy.data.meshes.new(obj.data.name)
        try:
            bmesh.from_edit_mesh(obj.data).to_mesh(mesh)
            shape = read_rest(mesh)
            selected = np.empty(len(shape.points), dtype=bool)
            hidden = np.empty(len(shape.points), dtype=bool)
            mesh.vertices.foreach_get("select", selected)
            mesh.vertices.foreach_get("hide", hidden)
            groups = {
                handle.vertex_group
                for deformer in obj.sinew.deformers
                for handle in deformer.handles
                if handle.kind == "FIXED" and handle.enabled
            }
            painted = group_weights(mesh, [group.name for group in obj.vertex_groups], groups)
        finally:
            bpy.data.meshes.remove(mesh)
        self._rest, self._counts, self._corners = shape.compact, shape.counts, shape.corners
        self._points = shape.points @ self._linear.T
        stays = hidden.copy()
        stays[shape.not_finite] = True
        self.lost = len(shape.not_finite)  # vertices whose coordinates are no numbers
        for weights in painted.values():
            stays |= weights > 0.0
        if not (selected & ~hidden).any():
            raise ConstraintError(NOTHING_SELECTED)
        if not (selected & ~stays).any():
            if selected[shape.not_finite].any():
                raise MeshError(NO_PLACE, tuple(shape.not_finite), "vertex", Remedy.REPAIR)
            raise ConstraintError(ALL_FIXED, tuple(np.flatnonzero(selected)), "vertex")
        self._stays = stays
        self._selected = np.flatnonzero(selected & ~stays)

    @property
    def selection(self) -> np.ndarray:
        """The selected vertices in the world at rest, (s, 3)."""
        return self._points[self._selected] + self._origin

    @property
    def radius(self) -> float | None:
        """The radius that is bound; None until the first one is."""
        return None if self._region is None else self._region.radius

    @property
    def is_binding(self) -> bool:
        """Another radius is on its way."""
        return self._work is not None

    @property
    def moves_alone(self) -> bool:
        """Nothing is free to follow the selection."""
        return self._region is not None and len(self._region.free) == 0

    @property
    def job(self) -> Work | None:
        """A bind or a final answer under way in a thread."""
        return self._work or self._final

    # What follows

    def follow(self, radius: float, wait: bool = True) -> None:
        """Let the surface within ``radius`` (world units, over the surface) follow; infinite: all connected.

        Without ``wait`` a heavy part binds in a thread: see ``job`` and ``collect``.
        """
        self._abandon()
        region = self._within(radius)
        if len(region.free) == 0 or len(region.fixed) == 0:  # bound when a motion asks for it
            self._take(region)
        elif wait or not binding.may_wait(len(region.members)):
            region.factor = self._bind(region, None)
            self._take(region)
        else:
            self._work = Work(lambda progress: self._bind(region, progress), region)

    def collect(self) -> bool:
        """Take a finished bind in; True where there was one. The next ``show`` uses it."""
        if self._work is None or not self._work.done:
            return False
        done, self._work = self._work, None
        if done.error is not None:
            raise done.error
        done.subject.factor = done.result
        self._take(done.subject)
        return True

    def _is_bound(self, wait: bool) -> bool:
        """The region has its factor, or needs none; False while a thread builds it."""
        region = self._region
        if region.factor is not None or len(region.free) == 0:
            return True
        if wait or not binding.may_wait(len(region.members)):
            region.factor = self._bind(region, None)
            return True
        if self._work is None:
            self._work = Work(lambda progress: self._bind(region, progress), region)
        return False

    def _abandon(self) -> None:
        for work in (self._work, self._final):
            if work is not None:
                work.cancel()
        self._work = self._final = None

    def _take(self, region: _Region) -> None:
        self._region, self._start, self._budget = region, None, _PREVIEW_ITERATIONS

    def _within(self, radius: float) -> _Region:
        sources = np.zeros(len(self._rest), dtype=bool)
        sources[self._selected] = True
        if np.isinf(radius):
            free = self._surface.connected(sources, self._stays)
        else:
            free = self._measure(sources, radius) <= radius
        free &= ~sources
        inside = reach.surrounded(self._counts, self._corners, free, _RINGS)
        members, faces = reach.part(self._counts, self._corners, inside)
        return _Region(
            radius,
            moving=np.concatenate((self._selected, np.flatnonzero(free))),
            shaded=self._shaded(free | sources),
            members=members,
            free=np.flatnonzero(free[members]),
            handle=np.flatnonzero(sources[members]),
            fixed=np.flatnonzero(~free[members] & ~sources[members]),
            rest=self._points[members],
            faces=faces,
        )

    def _shaded(self, moving: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        faces = reach.met(self._counts, self._corners, moving)
        vertices = np.unique(self._corners[np.repeat(faces, self._counts)])
        few = len(vertices) < _FEW * len(self._rest)
        return (vertices, np.flatnonzero(faces)) if few else None

    def _measure(self, sources: np.ndarray, radius: float) -> np.ndarray:
        """Lengths (n,) over the surface, measured again only where the radius outgrew what is known."""
        if self._lengths is None or radius > self._measured:
            self._measured = radius if self._lengths is None else radius * _HEADROOM
            self._lengths = self._surface.lengths(self._points, sources, self._stays, self._measured)
        return self._lengths

    def _bind(self, region: _Region, progress: binding.Progress | None) -> Factor:
        options = {row.id: row.default for row in self._method.parameters if row.rebinds}
        handles = [places for places in (region.handle, region.fixed) if len(places)]
        target = Shape(region.rest, region.faces)
        recipe = Recipe(self._method, target, options, Handles(handles, [None] * len(handles)))
        return build_factor(recipe, progress)

    # How it moves

    def show(self, obj: Object, motion: np.ndarray, preview: bool = False) -> None:
        """Move the selection by a motion of the world (4, 4), the surface with it.

        A ``preview`` spends a moment only: see ``settled``.
        """
        self._drop_final()
        pose = self._pose(motion)
        region, followed = self._region, None
        self.settled = True
        if region.rides_along(pose):
            followed = frames.transformed(pose, region.rest)
        elif not self._is_bound(wait=not preview):
            return
        elif region.factor is not None:
            options = self._options()
            early = preview and self._method.iterative
            if early:
                options["max_iterations"] = min(self._budget, options.get("max_iterations", self._budget))
                options["start"] = self._start
            begin = time.perf_counter()
            followed, report = region.factor.solve(self._poses(pose), **options)
            self._start = followed
            if early:
                self.settled = report.converged
                self._spend(report.iterations, time.perf_counter() - begin)
        self._write(obj, pose, followed, final=not preview)

    def settle(self, obj: Object, motion: np.ndarray, wait: bool = True) -> bool:
        """Show the final answer, which depends on the motion alone; False while a thread works it out."""
        region, pose = self._region, self._pose(motion)
        heavy = self._method.iterative and binding.may_wait(len(region.members))
        if wait or not heavy or len(region.free) == 0 or region.rides_along(pose):
            self.show(obj, motion)
            return True
        if not self._is_bound(wait):
            return False
        if self._final is None:
            poses, options = self._poses(pose), self._options()
            self._final = Work(lambda progress: region.factor.solve(poses, progress=progress, **options))
        if not self._final.done:
            return False
        done, self._final = self._final, None
        if done.error is not None:
            raise done.error
        self._write(obj, pose, done.result[0])
        self.settled = True
        return True

    def restore(self, obj: Object) -> None:
        """Put every vertex back where it was, bit for bit."""
        self._abandon()
        if self._shown is not None:
            moving = self._shown.moving
            self._put(obj, moving, self._rest[moving])
            self._shown = None

    def _drop_final(self) -> None:
        if self._final is not None:
            self._final.cancel()
            self._final = None

    def _spend(self, iterations: int, seconds: float) -> None:
        """As many steps a redraw as the drag budget allows for this mesh."""
        if iterations:
            affordable = int(
                preferences(bpy.context).drag_budget * iterations / (1000.0 * max(seconds, 1e-9))
            )
            self._budget = min(max(affordable, 1), _MOST_ITERATIONS)

    def _options(self) -> dict[str, object]:
        return {row.id: row.default for row in self._method.parameters if not row.rebinds}

    def _pose(self, motion: np.ndarray) -> np.ndarray:
        """A motion of the world as the pose (3, 4) of points that lack only the object's place."""
        if not np.isfinite(motion).all():
            raise ConstraintError("The motion is not a finite number - type another one")
        pose = motion[:3].copy()
        pose[:, 3] += motion[:3, :3] @ self._origin - self._origin
        return pose

    def _poses(self, pose: np.ndarray) -> np.ndarray:
        poses = [pose] if len(self._region.handle) else []
        return np.array([*poses, IDENTITY] if len(self._region.fixed) else poses)

    def _write(self, obj: Object, pose: np.ndarray, followed: np.ndarray | None, final: bool = True) -> None:
        """The selection goes by its pose, the free vertices by the solution (k, 3); others go to rest."""
        region, stale = self._region, np.zeros(0, dtype=int)
        if self._shown is not None and self._shown is not region:
            stale = np.setdiff1d(self._shown.moving, region.moving)
        goals = [frames.transformed(pose, self._points[self._selected])]
        if followed is not None:
            goals.append(followed[region.free])
        with np.errstate(over="ignore"):  # refused just below
            moved = (np.concatenate(goals) @ self._inverse.T).astype(np.float32)
        if not np.isfinite(moved).all():
            raise MeshError("The result is not finite - move less far")
        if len(stale):
            self._put(obj, stale, self._rest[stale])
        self._put(obj, region.moving, moved, region.shaded, final)
        self._shown = region

    def _put(
        self,
        obj: Object,
        vertices: np.ndarray,
        positions: np.ndarray,
        shaded: tuple[np.ndarray, np.ndarray] | None = None,
        final: bool = True,
    ) -> None:
        """Write some vertices of the mesh in Edit Mode, (w,) and float32 (w, 3).

        Normals of the ``shaded`` vertices and faces follow, else all; n-gons are filled anew at the end.
        """
        edit = bmesh.from_edit_mesh(obj.data)
        if len(edit.verts) != len(self._rest) or len(edit.faces) != len(self._counts):
            raise TopologyChangedError(CHANGED)
        edit.verts.ensure_lookup_table()
        sequence = edit.verts
        for vertex, position in zip(vertices.tolist(), positions.tolist(), strict=True):
            sequence[vertex].co = position
        if shaded is None:
            edit.normal_update()
        else:
            edit.faces.ensure_lookup_table()
            for elements, chosen in ((edit.faces, shaded[1]), (sequence, shaded[0])):
                for index in chosen.tolist():
                    elements[index].normal_update()
        bmesh.update_edit_mesh(obj.data, loop_triangles=final, destructive=False)
