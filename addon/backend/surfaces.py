# SPDX-License-Identifier: GPL-3.0-or-later
"""What the native module measures on a surface, and the triangles that it makes of one."""

from dataclasses import dataclass

import numpy as np

from ..core.geometry import frames
from .native import _module as native_module, _translated as translated
from .recipes import Progress


@dataclass(frozen=True)
class Survey:
    """What a surface consists of. ``found`` are indices by name: vertices or faces (k,), edges (k, 2)."""

    parts: int
    borders: int
    one_sided: int
    euler_characteristic: int
    found: dict[str, np.ndarray]


@dataclass(frozen=True)
class Curvature:
    """Curvatures of each vertex, in 1 / length, ``gaussian`` in 1 / area; convex places are positive."""

    mean: np.ndarray  # (n,)
    gaussian: np.ndarray  # (n,)
    principal: np.ndarray  # (n, 2) the smallest and the largest
    directions: np.ndarray  # (n, 2, 3) unit tangents along which these are


def survey(points: np.ndarray, faces: tuple[np.ndarray, np.ndarray], crossings: bool) -> Survey:
    """Find everything unusual. ``points`` (n, 3) float64, ``faces`` (counts, corners).

    Points that are not finite are treated as points at the origin. ``crossings``: look for faces that pass
    through each other, too, which takes longest.
    """
    bad = ~frames.are_valid(points)
    native = native_module()
    with translated(native):
        mesh = native.SurfaceMesh(np.where(bad[:, None], 0.0, points), faces)
        told = mesh.diagnose()
        crossing = np.unique(mesh.crossing_faces()) if crossings else np.zeros(0, dtype=int)
    coincident = told.coincident_vertices
    found = {
        "not_finite": np.flatnonzero(bad),
        "border": np.unique(np.concatenate([*told.boundary_loops, np.zeros(0, dtype=int)])),
        "non_manifold": told.non_manifold_edges,
        "pinched": told.non_manifold_vertices,
        "degenerate": told.degenerate_faces,
        "duplicate": told.duplicate_faces,
        "flipped": told.flipped_faces,
        "slit": told.slit_edges,
        "coincident": coincident[~bad[coincident]],
        "loose": told.loose_vertices,
        "crossing": crossing,
    }
    borders = len(told.boundary_loops)
    return Survey(told.component_count, borders, told.one_sided_count, told.euler_characteristic, found)


def curvature(points: np.ndarray, faces: tuple[np.ndarray, np.ndarray], rings: int) -> Curvature:
    """The curvatures of a surface, from so many rings of neighbours of each vertex."""
    native = native_module()
    with translated(native):
        measured = native.curvature(native.SurfaceMesh(points, faces), rings)
        return Curvature(measured.mean, measured.gaussian, measured.principal, measured.directions)


@dataclass(frozen=True)
class Lined:
    """A surface, and the edges of it that new triangles keep."""

    points: np.ndarray  # (n, 3) float64
    faces: tuple[np.ndarray, np.ndarray]  # counts, corners
    lines: np.ndarray  # (k, 2) their vertices


@dataclass(frozen=True)
class Carried:
    """New triangles for a surface, and where they lie on the old one, whose values they take over."""

    old_points: np.ndarray  # (n, 3)
    points: np.ndarray  # (v, 3)
    faces: np.ndarray  # (f, 3)
    lines: np.ndarray  # (k, 2) edges that lie on given lines
    line_sources: np.ndarray  # (k,) which of these
    face_sources: np.ndarray  # (f,) the old face
    distance: float  # the largest one between the surfaces
    told: str  # what else there is to say
    _vertices: tuple[np.ndarray, np.ndarray]  # (v, 3) old vertices, and their weights
    _corners: tuple[np.ndarray, np.ndarray]  # (3 f, 3) old corners, and their weights

    def at_vertices(self, values: np.ndarray) -> np.ndarray:
        """Values of the old vertices, mixed at the new ones."""
        return _mixed(values, self._vertices)

    def at_corners(self, values: np.ndarray) -> np.ndarray:
        """Values of the old corners, mixed at the new ones."""
        return _mixed(values, self._corners)

    def nearest_at_vertices(self, values: np.ndarray) -> np.ndarray:
        """Values of the old vertices that are nearest, for such as cannot be mixed."""
        return _nearest(values, self._vertices)

    def nearest_at_corners(self, values: np.ndarray) -> np.ndarray:
        """Values of the old corners that are nearest, for such as cannot be mixed."""
        return _nearest(values, self._corners)


def _mixed(values: np.ndarray, places: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    sources, weights = places
    mixed = values[sources[:, 0]].astype(np.float64)
    mixed *= weights[:, :1] if values.ndim > 1 else weights[:, 0]
    for k in (1, 2):
        mixed += values[sources[:, k]] * (weights[:, k : k + 1] if values.ndim > 1 else weights[:, k])
    return mixed


def _nearest(values: np.ndarray, places: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    sources, weights = places
    return values[sources[np.arange(len(sources)), weights.argmax(axis=1)]]


def remesh(
    old: Lined, progress: Progress | None = None, *, length: float, share: float, rounds: int, angle: float
) -> Carried:
    """Even triangles of the ``length``, or where that is 0 of a ``share`` of the mean edge. Any thread."""
    native = native_module()
    with translated(native):
        mesh = native.SurfaceMesh(old.points, old.faces)
        wanted = length or share * _mean_edge(mesh)
        made = native.remesh(
            mesh, wanted or None, rounds=rounds, angle=angle, lines=old.lines, progress=progress
        )
    return _carried(old.points, made)


def decimate(old: Lined, progress: Progress | None = None, *, share: float, angle: float) -> Carried:
    """A ``share`` of the triangles, as far as that can be. Any thread."""
    native = native_module()
    with translated(native):
        mesh = native.SurfaceMesh(old.points, old.faces)
        wanted = max(4, round(share * len(mesh.triangles)))
        made = native.decimate(mesh, wanted, angle=angle, lines=old.lines, progress=progress)
    more = len(made.faces) - wanted
    return _carried(
        old.points, made, f"{more:,} more than asked for, to keep lines" if more > 0.01 * wanted else ""
    )


def remove_degenerate(
    old: Lined, progress: Progress | None = None, *, ratio: float, cap: float, angle: float
) -> Carried:
    """The triangles without needles and caps. Any thread may call this."""
    native = native_module()
    with translated(native):
        mesh = native.SurfaceMesh(old.points, old.faces)
        made = native.remove_degenerate(
            mesh, ratio=ratio, cap=cap, angle=angle, lines=old.lines, progress=progress
        )
    return _carried(old.points, made)


def semi_regular(
    old: Lined, progress: Progress | None = None, *, levels: int, base_faces: int, angle: float
) -> Carried:
    """A base of so many triangles, or where that is 0 of so many that the count stays, subdivided.

    Any thread may call this.
    """
    native = native_module()
    with translated(native):
        mesh = native.SurfaceMesh(old.points, old.faces)
        made = native.semi_regular(
            mesh, levels, base_faces=base_faces or None, angle=angle, lines=old.lines, progress=progress
        )
    return _carried(old.points, made.finest, f"a base of {len(made.base_faces):,} faces")


def _mean_edge(mesh) -> float:
    """The mean length of the edges of the triangles."""
    corners = mesh.triangles
    pairs = np.unique(
        np.sort(np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]]), axis=1), axis=0
    )
    along = mesh.points[pairs[:, 0]] - mesh.points[pairs[:, 1]]
    return float(np.linalg.norm(along, axis=1).mean()) if len(pairs) else 0.0


def _carried(points: np.ndarray, made, told: str = "") -> Carried:
    places = made.corner_sources.reshape(-1, 3), made.corner_weights.reshape(-1, 3)
    return Carried(
        points,
        made.points,
        made.faces,
        made.lines,
        made.line_sources,
        made.face_sources,
        made.distance,
        told,
        (made.vertex_sources, made.vertex_weights),
        places,
    )


@dataclass(frozen=True)
class Subdivision:
    """How a mesh is refined, as Blender's Subdivision modifier says."""

    levels: int
    scheme: str
    limit: bool
    boundary_smooth: str
    creased: bool


class RefinedSurface:
    """A control mesh refined in every frame.

    ``points`` (n, 3) float64, ``faces`` (counts, corners), ``creases`` of edges and of vertices: each the
    elements and their creases from 0 to 1, float64 (k,). Cost: about 1 us per refined vertex.
    """

    def __init__(
        self,
        points: np.ndarray,
        faces: tuple[np.ndarray, np.ndarray],
        creases: tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]],
        subdivision: Subdivision,
    ) -> None:
        self._native = native = native_module()
        used = zip(("creases", "corners"), creases if subdivision.creased else (), strict=False)
        with translated(native):
            self._surface = native.SubdivisionSurface(
                native.SurfaceMesh(points, faces),
                level=subdivision.levels,
                scheme=subdivision.scheme,
                limit=subdivision.limit,
                boundary_smooth=subdivision.boundary_smooth,
                **{name: (where, 10.0 * crease**2) for name, (where, crease) in used if len(where)},
            )
        self.control_count, self.vertex_count = self._surface.control_count, self._surface.vertex_count
        self._refined = np.empty((self.vertex_count, 3), dtype=np.float32)

    @property
    def corners(self) -> np.ndarray:
        """The vertices at the corners of the refined faces, int32 (4 faces,). The levels are above 0."""
        return self._surface.faces.ravel()

    def put_in_order(self, order: np.ndarray) -> None:
        """Let vertex k be what was vertex ``order[k]``, int32 (m,)."""
        with translated(self._native):
            self._surface = self._surface.reordered(order)

    def refine(self, points: np.ndarray) -> np.ndarray:
        """The refined points, float32 (m, 3), of control points float32 (n, 3). The next call overwrites
        them.
        """
        return self._surface.refine(np.ascontiguousarray(points, dtype=np.float32), out=self._refined)
