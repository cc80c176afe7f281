# SPDX-License-Identifier: GPL-3.0-or-later
"""Further figures of the tutorial on models of our own: one edit each, by the methods that it compares."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..models.sculpt import Clay
from ..models.shapes import Ellipsoid, Tube
from .cases import STILL, Case, bend, cylinder, moved, plane, sheet, split
from .numpy_rows import apart, turned_triangles, unrotated_gradients
from .rows import Solve

Ours = Callable[..., Solve]  # the id of a method and its options -> a row


@dataclass(frozen=True)
class Figure:
    """One edit by several methods. A view is a caption, a mesh, and its points (n, 3)."""

    title: str
    views: tuple[tuple[str, Case, np.ndarray], ...]


def uneven_strip(cells: int = 40) -> Case:
    """A flat strip whose faces grow from left to right and are irregular; its right end is lifted."""
    points, triangles = sheet(cells, cells // 2, 2.0, 1.0)
    x, y = points[:, 0].copy(), points[:, 1].copy()
    ends = x <= 0.201, x >= 1.799
    along = np.clip((x - 0.2) / 1.6, 0.0, 1.0)
    points[:, 0] = np.where(ends[0] | ends[1], x, 0.2 + 1.6 * (0.25 * along + 0.75 * along**2.2))
    inner = (x > 0.25) & (x < 1.75) & (y > 0.0) & (y < 1.0)
    points[inner, :2] += np.random.default_rng(1).uniform(-0.25, 0.25, (inner.sum(), 2)) / cells
    handles = np.flatnonzero(ends[0]), np.flatnonzero(ends[1])
    poses = np.stack((STILL, moved(0.0, 0.0, 0.8)))
    return Case("Uneven strip, lifted", points, triangles, handles, poses, 24.0, closed=False)


def lifted_disc(cells: int = 60, hollow: bool = False) -> Case:
    """A flat square with a fixed frame and a disc, or only its rim, as handle, which is lifted."""
    points, triangles = sheet(cells, cells, 2.0, 2.0)
    beside = points[:, :2] - 1.0
    outside = np.linalg.norm(beside, axis=1) - 0.45
    disc = (np.abs(outside) if hollow else outside) < 1.5 / cells
    frame = np.abs(beside).max(1) > 0.9
    poses = np.stack((STILL, moved(0.0, 0.0, 0.5)))
    handles = np.flatnonzero(frame), np.flatnonzero(disc)
    return Case("Disc, lifted", points, triangles, handles, poses, 24.0, closed=False)


def beast(voxel: float = 0.075) -> Case:
    """An animal on four legs; its hind feet stay, and its head is lifted high."""
    clay = Clay((-2.4, -0.9, -0.1), (3.0, 0.9, 2.4), voxel)
    clay.join(Ellipsoid((0.0, 0.0, 1.1), (1.3, 0.5, 0.42)))
    for x in (-0.9, 0.8):
        for y in (-0.32, 0.32):
            clay.join(Tube([(x, y, 1.0), (x + 0.1, y, 0.6), (x, y, 0.18)], [0.26, 0.18, 0.16]), 0.12)
    clay.join(Tube([(1.0, 0, 1.25), (1.5, 0, 1.5), (1.95, 0, 1.75)], [0.30, 0.22, 0.20]), 0.15)
    clay.join(Ellipsoid((2.2, 0.0, 1.8), (0.42, 0.25, 0.23)), 0.1)
    clay.join(Tube([(-1.1, 0, 1.2), (-1.6, 0, 1.3), (-2.1, 0, 1.15)], [0.22, 0.15, 0.11]), 0.12)
    points, quads = clay.skin(12)
    handles = (
        np.flatnonzero((points[:, 0] < 0.0) & (points[:, 2] < 0.25)),
        np.flatnonzero(points[:, 0] > 1.9),
    )
    lift = moved(-1.3, 0.0, 1.7)
    return Case("Animal, head lifted", points, split(quads), handles, np.stack((STILL, lift)), -20.0)


def bent_bumps(bumps: float = 0.055, angle: float = 90.0) -> Case:
    return plane(angle=angle, bumps=bumps)


def arc(angle: float = 90.0) -> Case:
    """The cylinder with its axis bent to an arc of the same length."""
    case = cylinder()
    return replace(
        case, name=f"Cylinder, bent by {angle:.0f}°", poses=np.stack((STILL, bend(angle, 2, 7.0, 1.5)))
    )


def all_figures(ours: Ours) -> Iterator[Figure]:
    """The figures whose methods are here, in the order of the tutorial."""
    strip, shell = uneven_strip(), "thin_shell"
    discretizations = ("uniform", "Uniform"), ("cotan", "Cotangent"), ("cotan_voronoi", "Cotangent + Area")
    yield Figure(
        "Figure 5: the Laplacian on uneven faces",
        (
            ("At rest", strip, strip.points),
            *((name, strip, ours(shell, laplacian=kind)(strip)) for kind, name in discretizations),
        ),
    )
    disc, spline = lifted_disc(), "spline_surface"
    yield Figure(
        "Figure 6: a grid of splines",
        (
            ("Spline Surface, degree 1", disc, ours(spline, degree=1)(disc)),
            ("Spline Surface, 8 x 8", disc, ours(spline)(disc)),
            ("Spline Surface, 20 x 20", disc, ours(spline, columns=20, rows=20)(disc)),
            ("Thin Shell", disc, ours(shell)(disc)),
        ),
    )
    ring = lifted_disc(hollow=True)
    yield Figure(
        "Figure 8: a dent inside the handle",
        (
            ("At rest", ring, ring.points),
            ("Propagation, geodesic", ring, ours("propagation", field="geodesic")(ring)),
            ("Propagation, harmonic", ring, ours("propagation")(ring)),
            ("Thin Shell", ring, ours(shell)(ring)),
        ),
    )
    lifted = plane()
    yield Figure(
        "Figure 10: the bumpy plane, lifted",
        (
            ("At rest", lifted, lifted.points),
            ("Thin Shell", lifted, ours(shell)(lifted)),
            ("and normal displacements", lifted, _around(ours, "normal_displacements")(lifted)),
            ("As-Rigid-As-Possible", lifted, ours("arap")(lifted)),
        ),
    )
    bent = bent_bumps()
    yield Figure(
        "Figure 13: details without and with local frames",
        (
            ("At rest", bent, bent.points),
            ("Thin Shell", bent, ours(shell)(bent)),
            ("and displacement vectors", bent, _around(ours, "displacement_vectors")(bent)),
            ("As-Rigid-As-Possible", bent, ours("arap")(bent)),
        ),
    )
    tight = bent_bumps(0.12, 140.0)
    yield Figure(
        "Figure 14: high bumps in a tight bend",
        (
            ("At rest", tight, tight.points),
            *(
                (name, tight, _around(ours, kind, wavelength=20.0)(tight))
                for kind, name in (
                    ("normal_displacements", "Normal displacements"),
                    ("displacement_volumes", "Displacement volumes"),
                    ("deformation_transfer", "Deformation transfer"),
                )
            ),
        ),
    )
    tube = arc()
    broken = apart(tube)
    yield Figure(
        "Figure 15: gradients of a cylinder, bent by 90°",
        (
            ("At rest", tube, tube.points),
            ("Gradients at rest", tube, unrotated_gradients(tube)),
            ("Turned triangles", broken, turned_triangles(tube)),
            ("Gradient Editing", tube, ours("gradient_editing")(tube)),
        ),
    )
    animal = beast()
    yield Figure(
        "Figure 16: a large edit in one step",
        (
            ("Thin Shell", animal, ours(shell)(animal)),
            ("Gradient Editing", animal, ours("gradient_editing")(animal)),
            ("Laplacian, implicit", animal, ours("laplacian_editing", transforms="implicit")(animal)),
            ("As-Rigid-As-Possible", animal, ours("arap")(animal)),
            ("Nonlinear Thin Shell", animal, ours("thin_shell_nonlinear")(animal)),
        ),
    )


def _around(ours: Ours, details: str, **options: object) -> Solve:
    """Multiresolution around the thin shell."""
    return ours("multiresolution", details=details, **options)
