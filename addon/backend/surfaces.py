# SPDX-License-Identifier: GPL-3.0-or-later
"""What the native module measures on a surface: everything unusual about it, and how it bends."""

from dataclasses import dataclass

import numpy as np

from ..core.geometry import frames
from .native import _module as native_module, _translated as translated


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
