# SPDX-License-Identifier: GPL-3.0-or-later
"""Further figures of the tutorial on models of our own: one edit each, by the methods that it compares."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..models.sculpt import Clay
from ..models.shapes import Ellipsoid, Tube
from .cases import STILL, Case, bend, case_of, cylinder, moved, plane, sheet, split
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
    return case_of("Uneven strip, lifted", (points, triangles), ends, moved(0, 0, 0.8), 24.0, closed=False)


def lifted_disc(cells: int = 60, hollow: bool = False) -> Case:
    """A flat square with a fixed frame and a disc, or only its rim, as handle, which is lifted."""
    points, triangles = sheet(cells, cells, 2.0, 2.0)
    beside = points[:, :2] - 1.0
    outside = np.linalg.norm(beside, axis=1) - 0.45
    disc = (np.abs(outside) if hollow else outside) < 1.5 / cells
    frame = np.abs(beside).max(1) > 0.9
    return case_of("Disc, lifted", (points, triangles), (frame, disc), moved(0, 0, 0.5), 24.0, closed=False)


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
    ends = (points[:, 0] < 0.0) & (points[:, 2] < 0.25), points[:, 0] > 1.9
    return case_of("Animal, head lifted", (points, split(quads)), ends, moved(-1.3, 0.0, 1.7), -20.0)


def bent_bumps(bumps: float = 0.055, angle: float = 90.0) -> Case:
    return plane(angle=angle, bumps=bumps)


def arc(angle: float = 90.0) -> Case:
    """The cylinder with its axis bent to an arc of the same length."""
    poses = np.stack((STILL, bend(angle, 2, 7.0, 1.5)))
    return replace(cylinder(), name=f"Cylinder, bent by {angle:.0f}°", poses=poses)


def all_figures(ours: Ours) -> Iterator[Figure]:
    """The figures whose methods are here, in the order of the tutorial."""
    for title, (make, views) in FIGURES.items():
        case = make()
        yield Figure(title, tuple((caption, *show(ours, case)) for caption, show in views.items()))


Show = Callable[[Ours, Case], tuple[Case, np.ndarray]]  # the mesh that is shown, and its points


def _at_rest(_ours: Ours, case: Case) -> tuple[Case, np.ndarray]:
    return case, case.points


def _by(method: str, **options: object) -> Show:
    return lambda ours, case: (case, ours(method, **options)(case))


def _around(details: str, **options: object) -> Show:
    """Multiresolution around the thin shell."""
    return _by("multiresolution", details=details, **options)


REST, SHELL = {"At rest": _at_rest}, {"Thin Shell": _by("thin_shell")}
ARAP = {"As-Rigid-As-Possible": _by("arap")}
GRADIENTS = {"Gradient Editing": _by("gradient_editing")}
FIGURES: dict[str, tuple[Callable[[], Case], dict[str, Show]]] = {
    "Figure 5: the Laplacian on uneven faces": (
        uneven_strip,
        REST
        | {"Uniform": _by("thin_shell", laplacian="uniform")}
        | {"Cotangent": _by("thin_shell", laplacian="cotan")}
        | {"Cotangent + Area": _by("thin_shell", laplacian="cotan_voronoi")},
    ),
    "Figure 6: a grid of splines": (
        lifted_disc,
        {"Spline Surface, degree 1": _by("spline_surface", degree=1)}
        | {"Spline Surface, 8 x 8": _by("spline_surface")}
        | {"Spline Surface, 20 x 20": _by("spline_surface", columns=20, rows=20)}
        | SHELL,
    ),
    "Figure 8: a dent inside the handle": (
        partial(lifted_disc, hollow=True),
        REST
        | {"Propagation, geodesic": _by("propagation", field="geodesic")}
        | {"Propagation, harmonic": _by("propagation")}
        | SHELL,
    ),
    "Figure 10: the bumpy plane, lifted": (
        plane,
        REST | SHELL | {"and normal displacements": _around("normal_displacements")} | ARAP,
    ),
    "Figure 13: details without and with local frames": (
        bent_bumps,
        REST | SHELL | {"and displacement vectors": _around("displacement_vectors")} | ARAP,
    ),
    "Figure 14: high bumps in a tight bend": (
        partial(bent_bumps, 0.12, 140.0),
        REST
        | {"Normal displacements": _around("normal_displacements", wavelength=20.0)}
        | {"Displacement volumes": _around("displacement_volumes", wavelength=20.0)}
        | {"Deformation transfer": _around("deformation_transfer", wavelength=20.0)},
    ),
    "Figure 15: gradients of a cylinder, bent by 90°": (
        arc,
        REST
        | {"Gradients at rest": lambda _ours, case: (case, unrotated_gradients(case))}
        | {"Turned triangles": lambda _ours, case: (apart(case), turned_triangles(case))}
        | GRADIENTS,
    ),
    "Figure 16: a large edit in one step": (
        beast,
        SHELL
        | GRADIENTS
        | {"Laplacian, implicit": _by("laplacian_editing", transforms="implicit")}
        | ARAP
        | {"Nonlinear Thin Shell": _by("thin_shell_nonlinear")},
    ),
}
