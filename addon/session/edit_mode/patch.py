# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh in Edit Mode, which a tool reads once, writes, and puts back.

Only arrays are kept. Each function that uses the mesh is given the object.
"""

from dataclasses import dataclass

import bmesh
import bpy
import numpy as np
from bpy.types import Object
from mathutils.kdtree import KDTree

from ...backend import connected_parts
from ...compat import read_positions
from ...core.elements import Elements, Owner
from ...core.errors import ConstraintError, MeshError, TopologyChangedError
from ...core.geometry import frames, reach, rigid_motion
from ...core.status import Remedy
from ...mesh_io import read_rest
from ..datablocks.vertex_groups import fixed_vertices
from ..state import sessions
from ..targets.modified import evaluated_mesh

NOTHING_SELECTED = "Nothing is selected - select the vertices to grab"
ALL_FIXED = "The selected vertices belong to Still regions, which stay - select others"
NO_PLACE = "The selected vertices have invalid coordinates (NaN or infinite) - use Repair, or select others"
CHANGED = "The mesh was edited meanwhile - grab again"

_RINGS = 3  # energies up to the variation of curvature depend on vertices three edges away
_HEADROOM = 1.5  # when the radius grows, the surface is measured up to this multiple of it
_NEAR = 0.02  # of the diagonal of what is grabbed: a loose part that is nearer lies on it, or in it
_SMALL = 0.5  # of the same: larger parts are things of their own
_SAMPLES = 16  # vertices of a loose part for which the vertices beneath are looked up
_FEW = 0.2  # up to this share of the vertices, it is quicker to update normals one by one than all of them


@dataclass(frozen=True)
class LoosePart:
    """A part without a selected vertex that lies on a part with one, or in it.

    ``vertices`` are its own; ``beneath`` are the nearest vertices of the other, the nearest of all first.
    """

    vertices: np.ndarray
    beneath: np.ndarray


@dataclass(frozen=True)
class Region:
    """What follows the selection within a radius, loose parts on it included.

    ``members`` (k,) are vertices of the mesh; ``free``, ``handle`` and ``fixed`` are indices into them.
    ``rest`` (k, 3) is oriented and scaled as the world. ``moving`` (t,) are the selected vertices and then
    the free ones. ``shaded`` are the vertices and faces whose normals change with them, or None if these are
    many.
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

    def rides_along(self, pose: np.ndarray) -> bool:
        """Whether the region moves as one piece: nothing holds it, and the pose is rigid."""
        linear = pose[:, :3]
        return len(self.fixed) == 0 and np.allclose(linear.T @ linear, np.eye(3), rtol=0.0, atol=1e-9)


class Patch:
    """The selection of a mesh in Edit Mode and the surface around it.

    ``region`` gives what lies within a radius; ``write`` moves its vertices, ``restore`` puts them back.
    ``points`` (n, 3) are at rest, oriented and scaled as the world, relative to the location of the object,
    ``origin`` (3,).
    """

    def __init__(self, obj: Object) -> None:
        world = np.array(obj.matrix_world, dtype=np.float64)
        self._inverse = frames.inverse(world, obj.name)[:3, :3]
        self._linear, self.origin = world[:3, :3], world[:3, 3]
        self._read(obj)
        self._triangles = reach.TriangleMesh(len(self._rest), self._counts, self._corners)
        self._lengths: np.ndarray | None = None
        self._loose = self._loose_parts()
        self.surface = self._surface(obj)
        self._measured = 0.0
        self._written: Region | None = None  # the region whose vertices are not at rest

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
            fixed = fixed_vertices(obj, mesh)
        finally:
            bpy.data.meshes.remove(mesh)
        self._rest, self._counts, self._corners = shape.points_float32, shape.counts, shape.corners
        self.points = shape.points @ self._linear.T
        stays = hidden.copy()
        stays[shape.not_finite] = True
        self.lost = len(shape.not_finite)  # vertices with invalid coordinates
        stays |= fixed
        if not (selected & ~hidden).any():
            raise ConstraintError(NOTHING_SELECTED)
        if not (selected & ~stays).any():
            if selected[shape.not_finite].any():
                raise MeshError(NO_PLACE, Elements(Owner.TARGET, "vertex", shape.not_finite), Remedy.REPAIR)
            raise ConstraintError(ALL_FIXED, Elements(Owner.TARGET, "vertex", np.flatnonzero(selected)))
        self._stays = stays
        self.selected = np.flatnonzero(selected & ~stays)

    def _surface(self, obj: Object) -> np.ndarray:
        """How modifiers that are shown in Edit Mode have moved what is selected as a whole, (4, 4).

        It takes ``points`` to where an artist sees them.
        """
        shown = [
            modifier for modifier in obj.modifiers if modifier.show_viewport and modifier.show_in_editmode
        ]
        if not shown:
            return np.eye(4)
        with evaluated_mesh(obj, bpy.context.evaluated_depsgraph_get()) as mesh:
            if mesh is None or len(mesh.vertices) != len(self.points):
                return np.eye(4)
            seen = read_positions(mesh).astype(np.float64) @ self._linear.T
        piece = rigid_motion.piece(self.points, self._counts, self._corners, self.selected)
        return rigid_motion.motion(self.points[piece], seen[piece], np.eye(3))

    @property
    def selection(self) -> np.ndarray:
        """The selected vertices in the world before they are grabbed, where an artist sees them, (s, 3)."""
        return frames.transformed(self.surface, self.points[self.selected]) + self.origin

    def region(self, radius: float) -> Region:
        """What follows within ``radius``, in world units over the surface; infinite: all connected."""
        sources = np.zeros(len(self._rest), dtype=bool)
        sources[self.selected] = True
        if np.isinf(radius):
            free = self._triangles.connected(sources, self._stays)
        else:
            free = self._measure(sources, radius) <= radius
        free &= ~sources
        moving, near = free | sources, free.copy()
        for part in self._loose:
            if moving[part.beneath[0]]:
                free[part.vertices] = near[part.beneath] = True
        near |= free
        inside = reach.with_rings(self._counts, self._corners, near, _RINGS)
        members, faces = reach.submesh(self._counts, self._corners, inside)
        return Region(
            radius,
            moving=np.concatenate((self.selected, np.flatnonzero(free))),
            shaded=self._shaded(free | sources),
            members=members,
            free=np.flatnonzero(free[members]),
            handle=np.flatnonzero(sources[members]),
            fixed=np.flatnonzero(~free[members] & ~sources[members]),
            rest=self.points[members],
            faces=faces,
        )

    def _loose_parts(self) -> list[LoosePart]:
        """The parts that ride on what is grabbed. A hidden or fixed vertex keeps its part in place."""
        labels = connected_parts(len(self._rest), (self._counts, self._corners))
        in_face = np.bincount(self._corners, minlength=len(labels)) > 0
        host = in_face & np.isin(labels, labels[self.selected])
        loose = np.flatnonzero(in_face & ~np.isin(labels, labels[np.flatnonzero(host | self._stays)]))
        if not len(loose) or not host.any():
            return []
        diagonal = np.linalg.norm(np.ptp(self.points[host], axis=0))
        places = KDTree(int(host.sum()))
        for vertex in np.flatnonzero(host).tolist():
            places.insert(self.points[vertex], vertex)
        places.balance()
        found = []
        loose = loose[np.argsort(labels[loose], kind="stable")]
        for part in np.split(loose, np.flatnonzero(np.diff(labels[loose])) + 1):
            if np.linalg.norm(np.ptp(self.points[part], axis=0)) > _SMALL * diagonal:
                continue
            some = part[:: max(len(part) // _SAMPLES, 1)]
            nearest = sorted((places.find(point)[1:] for point in self.points[some]), key=lambda hit: hit[1])
            if nearest[0][1] <= _NEAR * diagonal:
                found.append(LoosePart(part, np.array([vertex for vertex, _distance in nearest])))
        return found

    def _shaded(self, moving: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        faces = reach.touching_faces(self._counts, self._corners, moving)
        vertices = np.unique(self._corners[np.repeat(faces, self._counts)])
        few = len(vertices) < _FEW * len(self._rest)
        return (vertices, np.flatnonzero(faces)) if few else None

    def _measure(self, sources: np.ndarray, radius: float) -> np.ndarray:
        """Lengths (n,) over the surface. They are measured again only if the radius is larger than before."""
        if self._lengths is None or radius > self._measured:
            self._measured = radius if self._lengths is None else radius * _HEADROOM
            self._lengths = self._triangles.lengths(self.points, sources, self._stays, self._measured)
        return self._lengths

    def write(self, obj: Object, region: Region, places: np.ndarray, final: bool = True) -> None:
        """Move the vertices ``region.moving`` to ``places`` (t, 3) (frame of ``points``); others rest."""
        with np.errstate(over="ignore"):  # refused just below
            moved = (places @ self._inverse.T).astype(np.float32)
        if not np.isfinite(moved).all():
            raise MeshError("The result is not finite - move less far")
        if self._written is not None and self._written is not region:
            stale = np.setdiff1d(self._written.moving, region.moving)
            if len(stale):
                self._put(obj, stale, self._rest[stale])
        self._put(obj, region.moving, moved, region.shaded, final)
        self._written = region

    def restore(self, obj: Object) -> None:
        """Put every vertex back where it was, bit for bit."""
        if self._written is not None:
            moving = self._written.moving
            self._put(obj, moving, self._rest[moving])
            self._written = None

    def _put(
        self,
        obj: Object,
        vertices: np.ndarray,
        positions: np.ndarray,
        shaded: tuple[np.ndarray, np.ndarray] | None = None,
        final: bool = True,
    ) -> None:
        """Write some vertices of the mesh in Edit Mode, (w,) and float32 (w, 3).

        Normals of the ``shaded`` vertices and faces are updated, or all if it is None. N-gons are
        triangulated again if this is the ``final`` call.
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
