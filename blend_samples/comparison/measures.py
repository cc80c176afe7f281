# SPDX-License-Identifier: GPL-3.0-or-later
"""How much a shape is distorted, by NumPy alone, so that no method is judged by its own library."""

from dataclasses import asdict, dataclass

import numpy as np

from .cases import Case


@dataclass(frozen=True)
class Distortion:
    """What is measured of one shape.

    Edges and faces of which every corner is held are left out: no method decides about them. Edge ratios and
    area ratios are those of lengths and areas to the ones at rest. Angles are changes of the corners of
    faces, in degrees. The volume is None for a mesh with a border.
    """

    edge_rms: float  # root of the mean square of the edge ratio less 1
    edge_least: float
    edge_largest: float
    angle_mean: float
    angle_max: float
    area: float  # of the whole surface
    face_area_mean: float  # of the faces, each with the weight of its area at rest, of |ratio - 1|
    face_area_max: float  # the largest ratio of one face
    volume: float | None
    handle_error: float  # how far a handle is from its target, as a share of the size of the mesh

    def as_dict(self) -> dict[str, float | None]:
        return asdict(self)


def distortion(case: Case, shape: np.ndarray) -> Distortion:
    """The distortion of a shape (n, 3) of a case."""
    rest, faces, free = case.points, case.triangles, case.free
    edges = edges_of(faces)
    edges = edges[free[edges].any(1)]
    ratio = lengths(shape, edges) / lengths(rest, edges)
    moving = faces[free[faces].any(1)]
    turned = np.degrees(np.abs(angles(shape, moving) - angles(rest, moving)))
    before, after = areas(rest, moving), areas(shape, moving)
    stretched = after / before
    whole = areas(shape, faces).sum() / areas(rest, faces).sum()
    gap = np.linalg.norm((shape - case.targets)[case.held], axis=1).max() / np.ptp(rest, axis=0).max()
    rms, mean = np.sqrt(np.mean((ratio - 1.0) ** 2)), np.average(np.abs(stretched - 1.0), weights=before)
    edges_found, angles_found = (rms, ratio.min(), ratio.max()), (turned.mean(), turned.max())
    areas_found = whole, mean, stretched.max()
    enclosed = volume(shape, faces) / volume(rest, faces) if case.closed else None
    return Distortion(*map(float, (*edges_found, *angles_found, *areas_found)), enclosed, float(gap))


def edges_of(faces: np.ndarray) -> np.ndarray:
    """Each edge of triangles (t, 3) once, (e, 2)."""
    pairs = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    return np.unique(np.sort(pairs, axis=1), axis=0)


def lengths(points: np.ndarray, edges: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)


def areas(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    a, b, c = (points[faces[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def angles(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The corners of triangles (t, 3) in radians; 0 where two corners coincide."""
    found = []
    for k in range(3):
        here = points[faces[:, k]]
        u, v = points[faces[:, (k + 1) % 3]] - here, points[faces[:, (k + 2) % 3]] - here
        found.append(np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), (u * v).sum(1)))
    return np.stack(found, 1)


def volume(points: np.ndarray, faces: np.ndarray) -> float:
    """The volume that a closed mesh encloses."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)
