# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of the tutorial on models of our own: shapes with captions, from edits and from operators.

Nothing here needs Blender. ``ours`` makes a row of a method, ``sn`` is the compiled module.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product, starmap
from types import ModuleType

import numpy as np

from ..models.sculpt import Clay, ball
from ..models.shapes import Ellipsoid, Tube, bars, rotation
from .cases import STILL, Case, about, bend, case_of, cylinder, moved, plane, sheet, split, tube
from .matrix import edges_of
from .numpy_rows import apart, cotan_laplacian, turned_triangles, unrotated_gradients
from .rows import Solve

PLAIN, ORANGE, BLUE = (0.70, 0.66, 0.58), (0.85, 0.17, 0.01), (0.04, 0.13, 0.45)
INK, GREY, PAPER = (0.03, 0.03, 0.035), (0.26, 0.25, 0.23), (0.95, 0.93, 0.88)
NOTHING = (np.empty(0, int), np.empty(0, int))  # two handles without vertices
# The neighbours of a vertex: radius and degrees
RING = np.array([(1.0, 8), (1.2, 58), (0.9, 112), (1.15, 160), (1.0, 215), (1.25, 262), (0.95, 318)])


@dataclass(frozen=True)
class Shown:
    """A mesh and its points (n, 3), with a caption. A note stands below it in place of the measured strain.
    Colours are (n, 3); a ``flat`` mesh shows its faces."""

    case: Case
    shape: np.ndarray
    caption: str = ""
    note: str | None = None
    colours: np.ndarray | None = None
    flat: bool = False


Ours = Callable[..., Solve]  # the id of a method and its options -> a row
Show = Callable[[Ours, ModuleType, Case], Shown]
Draw = Callable[[Ours, ModuleType], Iterator[Shown]]
Part = tuple[np.ndarray, np.ndarray, Sequence[float]]  # points (n, 3), faces (m, 3) or (m, 4), colour


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


def bellows(angle: float = 60.0) -> Case:
    """A round bar whose outline is a sine wave, with its axis bent to an arc of the same length."""
    points, triangles = tube(40, 150, 1.0, 10.0)
    z = points[:, 2]
    wave = np.clip(np.minimum(z - 1.5, 8.5 - z) / 0.35, 0.0, 1.0) * np.sin(2.0 * np.pi * z / 0.7)
    points[:, :2] *= 1.0 + 0.13 * wave[:, None]
    return case_of("Bellows", (points, triangles), (z <= 1.501, z >= 8.499), bend(angle, 2, 7.0, 1.5))


def still(points: np.ndarray, triangles: np.ndarray, heading: float = 0.0) -> Case:
    """A mesh that nothing holds or moves."""
    return Case("", points, triangles, NOTHING, np.stack((STILL, STILL)), heading, closed=False)


def with_parts(shown: Shown, *parts: Part) -> Shown:
    """The view with further meshes in it."""
    points, triangles = shown.shape, shown.case.triangles
    colours = np.tile(PLAIN, (len(points), 1)) if shown.colours is None else shown.colours
    for more, faces, colour in parts:
        triangles = np.vstack((triangles, len(points) + (faces if faces.shape[1] == 3 else split(faces))))
        points, colours = np.vstack((points, more)), np.vstack((colours, np.tile(colour, (len(more), 1))))
    case = replace(shown.case, points=points, triangles=triangles)
    return replace(shown, case=case, shape=points, colours=colours)


def lines(points: np.ndarray, edges: np.ndarray, radius: float, colour: Sequence[float] = INK) -> Part:
    """Edges (k, 2) as bars."""
    corners, sides = bars(points[edges[:, 0]], points[edges[:, 1]], radius)
    every = sides + 8 * np.arange(len(edges))[:, None, None]
    return corners.reshape(-1, 3), every.reshape(-1, 4), colour


def heat(values: np.ndarray) -> np.ndarray:
    """Colours (n, 3) of numbers from -1, blue, over 0, plain, to 1, orange."""
    share = np.clip(np.abs(values), 0.0, 1.0)[:, None]
    return (1.0 - share) * PLAIN + share * np.where(values[:, None] > 0.0, ORANGE, BLUE)


def fan(count: int) -> np.ndarray:
    """The triangles around vertex 0 of a ring of others."""
    ring = np.arange(1, count)
    return np.stack((0 * ring, ring, np.roll(ring, -1)), 1)


def blocks(cells: set[tuple[int, int, int]]) -> tuple[np.ndarray, np.ndarray]:
    """The outside of unit cubes at these places: points (n, 3) and quads (m, 4)."""
    e = np.eye(3, dtype=int)
    rings = [
        (cell + side * e[a] + np.stack((0 * e[a], e[a - 2], e[a - 2] + e[a - 1], e[a - 1])))[:: 2 * side - 1]
        for cell, a, side in product(sorted(cells), range(3), (0, 1))
        if tuple(cell + (2 * side - 1) * e[a]) not in cells
    ]
    points, number = np.unique(np.concatenate(rings), axis=0, return_inverse=True)
    return points.astype(float), number.reshape(-1, 4)


def subdivided(_ours: Ours, sn: ModuleType) -> Iterator[Shown]:
    """An animal of cubes, refined. The first points are those of the control mesh."""
    body = {(x, y, 1) for x in range(4) for y in range(3)} | {(3, 1, 2), (4, 1, 2), (-1, 1, 1)}
    points, quads = blocks(body | {(x, y, 0) for x in (0, 3) for y in (0, 2)})
    for caption, level in {"Control mesh": 0, "One step": 1, "Two steps": 2, "The limit": 5}.items():
        fine = sn.SubdivisionSurface(sn.SurfaceMesh(points, quads), level=level, limit=level == 5)
        shape, faces = fine.refine(points), np.asarray(fine.faces)
        shown = Shown(still(shape, split(faces), -38.0), shape, caption, "")
        sides = np.unique(np.sort(np.concatenate([np.roll(faces, k, 1)[:, :2] for k in range(4)])), axis=0)
        if level < 5:
            shown = replace(shown, note=f"{len(faces):,} faces", flat=True)
            shown = with_parts(shown, lines(shape, sides, 0.025 / 1.3**level))
        yield shown


def spheres(_ours: Ours, sn: ModuleType) -> Iterator[Shown]:
    """A sphere of ever smaller triangles: how far they are off it, and their principal curvatures off 1."""
    points = np.vstack((np.eye(3), -np.eye(3)))
    octants = product((0, 3), (1, 4), (2, 5))
    triangles = np.array([octant[:: 1 if sum(octant) % 2 else -1] for octant in octants])
    for step in range(5):
        halves = sn.SubdivisionSurface(sn.SurfaceMesh(points, triangles), scheme="loop", level=1)
        points, triangles = halves.refine(points), np.asarray(halves.faces)
        points /= np.linalg.norm(points, axis=1)[:, None]
        a, b, c = (points[triangles[:, k]] for k in range(3))
        across = np.cross(b - a, c - a)
        off = 1.0 - ((across * a).sum(1) / np.linalg.norm(across, axis=1)).min()
        bent = np.abs(sn.curvature(sn.SurfaceMesh(points, triangles)).principal - 1.0).max()
        note = f"off by {off:.2%},  curvature by {bent:.1%}"
        shown = Shown(still(points, triangles), points, f"{len(triangles):,} faces", note, flat=True)
        if step:
            yield with_parts(shown, lines(points, edges_of(triangles), 0.025 / 1.7**step))


def not_manifold(_ours: Ours, sn: ModuleType) -> Iterator[Shown]:
    """Two sheets at a vertex, three at an edge, and two that touch in a corner of their borders."""
    turn = np.linspace(0.0, 2.0 * np.pi, 25)
    rim = np.stack((np.cos(turn), np.sin(turn), 0.9 + 0 * turn), 1)
    cones = [np.vstack((np.zeros(3), side * rim[::-side])) for side in (1, -1)]
    ways = zip(np.cos(np.radians((165, 35, 295))), np.sin(np.radians((165, 35, 295))), (1, -1, -1))
    pages = [np.array([(x, y, 0.7), (x, y, -0.7), (0, 0, -0.7), (0, 0, 0.7)])[::end] for x, y, end in ways]
    wing = np.array([(0, 0, 0), (1.1, 0, -0.8), (1.3, 0, 0), (1.1, 0, 0.8)])
    names = ("Two sheets at a vertex", "Three sheets at an edge", "Two borders at a vertex")
    for caption, sheets in zip(names, (cones, pages, (wing, wing * (-1, 1, -1)))):
        corners = np.concatenate([each[[0, k, k + 1]] for each in sheets for k in range(1, len(each) - 1)])
        points, number = np.unique(np.round(corners, 9), axis=0, return_inverse=True)
        triangles = number.reshape(-1, 3)
        found = sn.SurfaceMesh(points, triangles).diagnose()
        marks = [(*ball(points[at], 0.09, 6), ORANGE) for at in found.non_manifold_vertices]
        if len(found.non_manifold_edges):
            marks = [lines(points, found.non_manifold_edges, 0.06, ORANGE)]
        shown = Shown(still(points, triangles, 20.0), points, caption, found.summary(), flat=True)
        yield with_parts(shown, lines(points, edges_of(triangles), 0.015), *marks)


def ring_of_a_vertex(_ours: Ours, sn: ModuleType) -> Iterator[Shown]:
    """A vertex with its neighbours: the edge to the third with its opposite angles, and the Voronoi area."""
    angle = np.radians(RING[:, 1])
    ring = RING[:, :1] * np.stack((np.cos(angle), 0 * angle, np.sin(angle)), 1)
    points, triangles = np.vstack((np.zeros(3), ring)), fan(1 + len(ring))
    case, paper, nearer = still(points, triangles), np.tile(PAPER, (len(points), 1)), (0.0, -0.012, 0.0)
    edges, edge = lines(points, edges_of(triangles), 0.012), lines(points, np.array([(0, 3)]), 0.03, ORANGE)
    spans = []
    for corner, order in ((2, (0, 2, 1)), (4, (0, 1, 2))):
        arms = points[[0, 3]] - points[corner]
        arms *= 0.3 / np.linalg.norm(arms, axis=1)[:, None]
        spans.append((np.vstack((np.zeros(3), arms)) + points[corner] + nearer, np.array([order]), GREY))
    note = f"weight {-cotan_laplacian(points, triangles)[0, 3]:.3f}"
    yield with_parts(Shown(case, points, "An edge and its angles", note, paper, True), edges, edge, *spans)
    cell = [np.zeros(3)]
    for u, v in zip(ring, np.roll(ring, -1, axis=0)):
        n = np.cross(u, v)
        cell += [0.5 * u, np.cross(n, (v @ v) * u - (u @ u) * v) / (2.0 * n @ n)]  # a middle, a circumcentre
    note = f"area {sn.mass(sn.SurfaceMesh(points, triangles))[0]:.3f}"
    area = (np.array(cell) + nearer, fan(len(cell)), GREY)
    yield with_parts(Shown(case, points, "The area of the vertex", note, paper, True), area, edges)


def propagated(ours: Ours, _sn: ModuleType) -> Iterator[Shown]:
    """Regions, the field from 0 to 1, and a handle that is lifted and tilted."""
    lift, solve = lifted_disc(), ours("propagation")
    field = solve(lift)[:, 2] / lift.poses[1, 2, 3]
    tilt = about((1.0, 1.0, 0.0), rotation(x=-18.0, y=-24.0)) + moved(0.0, 0.0, 0.5) - STILL
    case = replace(lift, poses=np.stack((STILL, tilt)))
    yield Shown(lift, lift.points, "Regions", "")
    yield Shown(replace(lift, handles=NOTHING), lift.points, "The field", "", heat(field))
    yield Shown(case, solve(case), "The handle tilted")


def in_two_bands(make: Callable[[], Case], wavelength: float, _ours: Ours, sn: ModuleType) -> Iterator[Shown]:
    """Decomposition, editing and reconstruction, one by one."""
    case = make()
    mesh = sn.SurfaceMesh(case.points, case.triangles)
    shell, whole = sn.ThinShell(mesh), sn.Multiresolution(mesh, sn.ThinShell(mesh), wavelength=wavelength)
    for method in (shell, whole):
        method.set_handles(list(case.handles))
    base = whole.levels()[-1]
    yield Shown(case, case.points, "The surface", "")
    yield Shown(case, base, "Decomposed: its base", "")
    yield Shown(case, shell.solve(case.poses, incoming=base)[0], "Edited: the base is bent", "")
    yield Shown(case, whole.solve(case.poses)[0], "Reconstructed: with details")


def edits(make: Callable[[], Case], *shows: Show) -> Draw:
    """Views of one edit."""

    def draw(ours: Ours, sn: ModuleType) -> Iterator[Shown]:
        case = make()
        return (show(ours, sn, case) for show in shows)

    return draw


def by(caption: str, method: str, **options: object) -> Show:
    return lambda ours, _sn, case: Shown(case, ours(method, **options)(case), caption)


def detailed(*codings: str, **options: object) -> Iterator[Show]:
    """Multiresolution around the thin shell."""
    for coding in codings:
        yield by(coding.replace("_", " ").capitalize(), "multiresolution", details=coding, **options)


def in_curvature(caption: str, laplacian: str) -> Show:
    """A lifted thin shell, coloured by its mean curvature."""

    def show(ours: Ours, sn: ModuleType, case: Case) -> Shown:
        shape = ours("thin_shell", laplacian=laplacian)(case)
        bent = sn.curvature(sn.SurfaceMesh(shape, case.triangles)).mean
        return Shown(case, shape, caption, colours=heat(bent / 0.94))

    return show


def with_edges(_ours: Ours, _sn: ModuleType, case: Case) -> Shown:
    edges = lines(case.points, edges_of(case.triangles), 0.0015)
    return with_parts(Shown(case, case.points, "Irregular faces", ""), edges)


def solved(
    caption: str, solve: Solve, note: str | None = None, mesh: Callable[[Case], Case] = replace
) -> Show:
    return lambda _ours, _sn, case: Shown(mesh(case), solve(case), caption, note)


REST = solved("At rest", lambda case: case.points, "")
UNTURNED = solved("Gradients at rest", unrotated_gradients)
TORN = solved("Turned triangles", turned_triangles, mesh=apart)
SHELL, ARAP = by("Thin Shell", "thin_shell"), by("As-Rigid-As-Possible", "arap")
GRADIENTS = by("Gradient Editing", "gradient_editing")
RUBBER = by("Nonlinear Thin Shell", "thin_shell_nonlinear")
IMPLICIT = by("Laplacian, implicit", "laplacian_editing", transforms="implicit")
LAPLACIANS = {"Uniform": "uniform", "Cotangent": "cotan", "Cotangent + Area": "cotan_voronoi"}
GRIDS = {"degree 1": {"degree": 1}, "8 x 8": {}, "20 x 20": {"columns": 20, "rows": 20}}
CODINGS = ("displacement_vectors", "normal_displacements", "displacement_volumes", "deformation_transfer")
SPLINES = [by(f"Spline Surface, {grid}", "spline_surface", **options) for grid, options in GRIDS.items()]
FIELDS = [by(f"Propagation, {field}", "propagation", field=field) for field in ("geodesic", "harmonic")]
LOCAL = by("In local frames", "multiresolution", details="displacement_vectors")
FIGURES: dict[int, Draw] = {
    1: subdivided,
    2: spheres,
    3: not_manifold,
    4: ring_of_a_vertex,
    5: edits(uneven_strip, with_edges, *starmap(in_curvature, LAPLACIANS.items())),
    6: edits(lifted_disc, *SPLINES, SHELL),
    7: propagated,
    8: edits(partial(lifted_disc, hollow=True), REST, *FIELDS, SHELL),
    10: edits(plane, REST, SHELL, *detailed("normal_displacements"), ARAP),
    11: partial(in_two_bands, bellows, 14.0),
    12: partial(in_two_bands, bent_bumps, 20.0),
    13: edits(bent_bumps, REST, by("In global coordinates", "thin_shell"), LOCAL, ARAP),
    14: edits(partial(bent_bumps, 0.12, 140.0), REST, *detailed(*CODINGS, wavelength=20.0)),
    15: edits(arc, REST, UNTURNED, TORN, GRADIENTS),
    16: edits(beast, SHELL, GRADIENTS, IMPLICIT, ARAP, RUBBER),
    22: edits(lambda: replace(plane(angle=-170.0, bumps=0.09), heading=-58.0), REST, SHELL, ARAP),
}
