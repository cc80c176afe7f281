# SPDX-License-Identifier: GPL-3.0-or-later
"""What the figures of the tutorial show, on models of our own: shapes with captions, from edits and from operators.

Nothing here needs Blender. ``ours`` makes a row of a method, ``sn`` is the compiled module.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from types import ModuleType

import numpy as np

from ..models.sculpt import Clay, ball
from ..models.shapes import Ellipsoid, Tube, bars, rotation
from .cases import STILL, Case, about, bend, case_of, cylinder, moved, plane, sheet, split, tube
from .matrix import edges_of
from .numpy_rows import apart, cotan_laplacian, turned_triangles, unrotated_gradients
from .rows import Solve

INK, ORANGE, GREY = (0.03, 0.03, 0.035), (0.85, 0.17, 0.01), (0.26, 0.25, 0.23)
PLAIN, BLUE = (0.70, 0.66, 0.58), (0.04, 0.13, 0.45)
NOTHING = (np.empty(0, int), np.empty(0, int))  # two handles without vertices


@dataclass(frozen=True)
class Shown:
    """A mesh and its points (n, 3), under a caption. A note stands below it in place of the measured strain. Colours
    are (n, 3); a ``flat`` mesh shows its faces."""

    caption: str
    case: Case
    shape: np.ndarray
    note: str | None = None
    colours: np.ndarray | None = None
    flat: bool = False


Ours = Callable[..., Solve]  # the id of a method and its options -> a row
Show = Callable[[Ours, ModuleType, Case], Shown]
Draw = Callable[[Ours, ModuleType], Iterator[Shown]]


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
    inside = np.clip(np.minimum(points[:, 2] - 1.5, 8.5 - points[:, 2]) / 0.35, 0.0, 1.0)
    points[:, :2] *= 1.0 + 0.13 * (inside * np.sin(2.0 * np.pi * points[:, 2] / 0.7))[:, None]
    ends = points[:, 2] <= 1.501, points[:, 2] >= 8.499
    return case_of(f"Bellows, bent by {angle:.0f}°", (points, triangles), ends, bend(angle, 2, 7.0, 1.5))


def still(points: np.ndarray, triangles: np.ndarray, heading: float = 0.0) -> Case:
    """A mesh that nothing holds or moves."""
    return Case("", points, triangles, NOTHING, np.stack((STILL, STILL)), heading, closed=False)


def with_parts(shown: Shown, *parts: tuple[np.ndarray, np.ndarray, Sequence[float]]) -> Shown:
    """The view with further meshes in it: points (n, 3), faces (m, 3) or (m, 4), and a colour."""
    points, triangles = shown.shape, shown.case.triangles
    colours = np.tile(PLAIN, (len(points), 1)) if shown.colours is None else shown.colours
    for more, faces, colour in parts:
        faces = faces if faces.shape[1] == 3 else split(faces)
        triangles = np.vstack((triangles, faces + len(points)))
        points, colours = np.vstack((points, more)), np.vstack((colours, np.tile(colour, (len(more), 1))))
    case = replace(shown.case, points=points, triangles=triangles)
    return replace(shown, case=case, shape=points, colours=colours)


def lines(
    points: np.ndarray, edges: np.ndarray, radius: float, colour: Sequence[float] = INK
) -> tuple[np.ndarray, np.ndarray, Sequence[float]]:
    """Edges (k, 2) as bars."""
    corners, sides = bars(points[edges[:, 0]], points[edges[:, 1]], radius)
    every = sides + 8 * np.arange(len(edges))[:, None, None]
    return corners.reshape(-1, 3), every.reshape(-1, 4), colour


def heat(values: np.ndarray) -> np.ndarray:
    """Colours (n, 3) of numbers from -1, blue, over 0, plain, to 1, orange."""
    share = np.clip(np.abs(values), 0.0, 1.0)[:, None]
    return (1.0 - share) * PLAIN + share * np.where(values[:, None] > 0.0, ORANGE, BLUE)


def blocks(cells: Collection[tuple[int, int, int]]) -> tuple[np.ndarray, np.ndarray]:
    """The outside of unit cubes at these places: points (n, 3) and quads (m, 4)."""
    rings, axes = [], np.eye(3, dtype=int)
    for cell in cells:
        for axis in range(3):
            for side in (0, 1):
                if tuple(np.add(cell, (2 * side - 1) * axes[axis])) not in cells:
                    u, v = axes[(axis + 1) % 3], axes[(axis + 2) % 3]
                    ring = cell + side * axes[axis] + np.stack((0 * u, u, u + v, v))
                    rings.append(ring if side else ring[::-1])
    points, number = np.unique(np.concatenate(rings), axis=0, return_inverse=True)
    return points.astype(float), number.reshape(-1, 4)


def subdivided(_ours: Ours, sn: ModuleType) -> Iterator[Shown]:
    """A control mesh of cubes, an animal, refined."""
    body = {(x, y, 1) for x in range(4) for y in range(3)}
    legs = {(x, y, 0) for x in (0, 3) for y in (0, 2)}
    points, quads = blocks(body | legs | {(3, 1, 2), (4, 1, 2), (-1, 1, 1)})
    mesh = sn.SurfaceMesh(points, quads)
    levels = {"Control mesh": (0, False), "One step": (1, False), "Two steps": (2, False), "The limit": (5, True)}
    for caption, (level, limit) in levels.items():
        fine = sn.SubdivisionSurface(mesh, level=level, limit=limit)
        shape, faces = fine.refine(points), np.asarray(fine.faces)
        case = still(shape, split(faces), -38.0)
        shown = Shown(caption, case, shape, "" if limit else f"{len(faces):,} faces", flat=not limit)
        sides = np.unique(np.sort(np.concatenate([np.roll(faces, k, 1)[:, :2] for k in range(4)])), axis=0)
        yield shown if limit else with_parts(shown, lines(shape, sides, 0.025 / 1.3**level))


def spheres(_ours: Ours, sn: ModuleType) -> Iterator[Shown]:
    """A sphere of ever smaller triangles: how far they are off it, and their principal curvatures off 1."""
    points, triangles = icosahedron()
    for step in range(4):
        split_once = sn.SubdivisionSurface(sn.SurfaceMesh(points, triangles), scheme="loop", level=1)
        points, triangles = split_once.refine(points), np.asarray(split_once.faces)
        points /= np.linalg.norm(points, axis=1)[:, None]
        off, bent = sphere_errors(sn, points, triangles)
        note = f"off by {off:.1%},  curvature by {bent:.1%}"
        shown = Shown(f"{len(triangles):,} faces", still(points, triangles), points, note, flat=True)
        yield with_parts(shown, lines(points, edges_of(triangles), 0.016 / 1.7**step))


def icosahedron() -> tuple[np.ndarray, np.ndarray]:
    """With its corners on the unit sphere: points (12, 3) and triangles (20, 3) that look outward."""
    golden = 0.5 * (1.0 + 5.0**0.5)
    corners = [np.roll((0.0, a, b * golden), k) for k in range(3) for a in (1, -1) for b in (1, -1)]
    points = np.array(corners) / np.hypot(1.0, golden)
    near = np.linalg.norm(points[:, None] - points, axis=2) < 1.1
    found = [list(t) for t in combinations(range(12), 3) if near[np.ix_(t, t)].all()]
    return points, np.array([t if np.linalg.det(points[t]) > 0.0 else t[::-1] for t in found])


def sphere_errors(sn: ModuleType, points: np.ndarray, triangles: np.ndarray) -> tuple[float, float]:
    """Of a mesh with its corners on the unit sphere: how far faces are off it, and the largest error of a principal
    curvature."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    height = (across * a).sum(1) / np.linalg.norm(across, axis=1)
    return 1.0 - height.min(), np.abs(sn.curvature(sn.SurfaceMesh(points, triangles)).principal - 1.0).max()


def not_manifold(_ours: Ours, sn: ModuleType) -> Iterator[Shown]:
    """Two sheets at a vertex, three at an edge, and two that touch in a corner of their borders."""
    turn = np.linspace(0.0, 2.0 * np.pi, 25)
    rim = np.stack((np.cos(turn), np.sin(turn), 0.9 + 0 * turn), 1)
    cones = [np.concatenate(([np.zeros(3)], side * rim[:: -side])) for side in (1, -1)]
    ways = [(np.cos(angle), np.sin(angle)) for angle in np.radians((165.0, 35.0, 295.0))]
    pages = [np.array([(*way, 0.7), (*way, -0.7), (0, 0, -0.7), (0, 0, 0.7)][:: -1 if way[0] < 0 else 1]) for way in ways]
    arc = np.radians(np.linspace(-40.0, 40.0, 7))
    wing = np.vstack((np.zeros(3), np.stack((1.3 * np.cos(arc), 0 * arc, 1.3 * np.sin(arc)), 1)))
    for caption, sheets in {
        "Two sheets at a vertex": cones,
        "Three sheets at an edge": pages,
        "Two borders at a vertex": [wing, wing * (-1, 1, -1)],
    }.items():
        corners = np.concatenate([each[[0, k, k + 1]] for each in sheets for k in range(1, len(each) - 1)])
        points, number = np.unique(np.round(corners, 9), axis=0, return_inverse=True)
        triangles = number.reshape(-1, 3)
        found = sn.SurfaceMesh(points, triangles).diagnose()
        marks = [(*ball(points[at], 0.09, 6), ORANGE) for at in found.non_manifold_vertices]
        if len(found.non_manifold_edges):
            marks = [lines(points, found.non_manifold_edges, 0.06, ORANGE)]
        shown = Shown(caption, still(points, triangles, 20.0), points, found.summary(), flat=True)
        yield with_parts(shown, lines(points, edges_of(triangles), 0.015), *marks)


RING = np.array([(1.0, 8), (1.2, 58), (0.9, 112), (1.15, 160), (1.0, 215), (1.25, 262), (0.95, 318)])  # radius, degrees
EDGE = 2  # of the ring


def ring_of_a_vertex(_ours: Ours, sn: ModuleType) -> Iterator[Shown]:
    """A vertex with its neighbours: an edge with its opposite angles, and the Voronoi area."""
    radius, angle = RING[:, 0], np.radians(RING[:, 1])
    points = np.vstack((np.zeros(3), np.stack((radius * np.cos(angle), 0 * angle, radius * np.sin(angle)), 1)))
    ring = np.arange(1, len(points))
    triangles = np.stack((0 * ring, ring, np.roll(ring, -1)), 1)
    mesh, case = sn.SurfaceMesh(points, triangles), still(points, triangles)
    edges = lines(points, edges_of(triangles), 0.012)
    j = ring[EDGE]
    spans = [wedge(points[at], points[[0, j]]) for at in (ring[EDGE - 1], ring[EDGE + 1])]
    edge = lines(points, np.array([(0, j)]), 0.03, ORANGE)
    weight = -cotan_laplacian(points, triangles)[0, j]
    paper = np.tile((0.95, 0.93, 0.88), (len(points), 1))
    first = Shown("An edge and its opposite angles", case, points, f"weight {weight:.3f}", paper, flat=True)
    yield with_parts(first, edges, edge, *((*span, GREY) for span in spans))
    cell = [corner for t in triangles for corner in (points[t[:2]].mean(0), circumcentre(*points[t]))]
    corners = np.vstack((np.zeros(3), cell)) - (0.0, 0.012, 0.0)
    outline = np.arange(1, len(corners))
    fan = np.stack((0 * outline, outline, np.roll(outline, -1)), 1)
    second = Shown("The Voronoi area of the vertex", case, points, f"area {sn.mass(mesh)[0]:.3f}", paper, flat=True)
    yield with_parts(second, (corners, fan, GREY), edges)


def wedge(corner: np.ndarray, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The angle at a corner between the ways to two ends (2, 3), as a fan just before y = 0."""
    arms = [np.arctan2(arm[2], arm[0]) for arm in ends - corner]
    sweep = arms[0] + np.linspace(0.0, 1.0, 13) * ((arms[1] - arms[0] + np.pi) % (2.0 * np.pi) - np.pi)
    sweep = np.sort(sweep)
    rim = corner + 0.28 * np.stack((np.cos(sweep), 0 * sweep, np.sin(sweep)), 1)
    return np.vstack((corner, rim)) - (0.0, 0.012, 0.0), np.array([(0, k, k + 1) for k in range(1, 13)])


def circumcentre(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    u, v = b - a, c - a
    normal = np.cross(u, v)
    return a + np.cross(normal, (v @ v) * u - (u @ u) * v) / (2.0 * normal @ normal)


def propagated(ours: Ours, _sn: ModuleType) -> Iterator[Shown]:
    """Regions, the field from 0 to 1, and a handle that is lifted and tilted."""
    lift = lifted_disc()
    solve = ours("propagation")
    field = solve(lift)[:, 2] / lift.poses[1, 2, 3]
    tilt = about((1.0, 1.0, 0.0), rotation(x=-18.0, y=-24.0)) + moved(0.0, 0.0, 0.5) - STILL
    case = replace(lift, poses=np.stack((STILL, tilt)))
    yield Shown("Support and handle", lift, lift.points, "")
    yield Shown("The field", replace(lift, handles=NOTHING), lift.points, "", heat(field))
    yield Shown("The handle tilted", case, solve(case))


def in_two_bands(make: Callable[[], Case], wavelength: float) -> Draw:
    """Decomposition, editing and reconstruction, one by one."""

    def draw(_ours: Ours, sn: ModuleType) -> Iterator[Shown]:
        case = make()
        mesh = sn.SurfaceMesh(case.points, case.triangles)
        shell, whole = sn.ThinShell(mesh), sn.Multiresolution(mesh, sn.ThinShell(mesh), wavelength=wavelength)
        for method in (shell, whole):
            method.set_handles(list(case.handles))
        base = whole.levels()[-1]
        yield Shown("The surface", case, case.points, "")
        yield Shown("Decomposed: its base", case, base, "")
        yield Shown("Edited: the base is bent", case, shell.solve(case.poses, incoming=base)[0], "")
        yield Shown("Reconstructed: with its details", case, whole.solve(case.poses)[0])

    return draw


def edits(make: Callable[[], Case], views: Mapping[str, Show]) -> Draw:
    """Views of one edit, by their captions."""

    def draw(ours: Ours, sn: ModuleType) -> Iterator[Shown]:
        case = make()
        return (replace(show(ours, sn, case), caption=caption) for caption, show in views.items())

    return draw


def by(method: str, **options: object) -> Show:
    return lambda ours, _sn, case: Shown("", case, ours(method, **options)(case))


def around(details: str, **options: object) -> Show:
    """Multiresolution around the thin shell."""
    return by("multiresolution", details=details, **options)


def in_curvature(laplacian: str) -> Show:
    """A lifted thin shell, coloured by its mean curvature."""

    def show(ours: Ours, sn: ModuleType, case: Case) -> Shown:
        shape = ours("thin_shell", laplacian=laplacian)(case)
        bent = sn.curvature(sn.SurfaceMesh(shape, case.triangles)).mean
        return Shown("", case, shape, colours=heat(bent / 0.94))

    return show


def with_edges(_ours: Ours, _sn: ModuleType, case: Case) -> Shown:
    return with_parts(Shown("", case, case.points, ""), lines(case.points, edges_of(case.triangles), 0.0015))


def at_rest(_ours: Ours, _sn: ModuleType, case: Case) -> Shown:
    return Shown("", case, case.points, "")


def gradients_at_rest(_ours: Ours, _sn: ModuleType, case: Case) -> Shown:
    return Shown("", case, unrotated_gradients(case))


def torn(_ours: Ours, _sn: ModuleType, case: Case) -> Shown:
    return Shown("", apart(case), turned_triangles(case))


def bent_further(ours: Ours, _sn: ModuleType) -> Iterator[Shown]:
    """The bumpy plane in a bend of growing angle."""
    for angle, method in ((-170.0, ""), (-90.0, "arap"), (-170.0, "arap"), (-170.0, "thin_shell")):
        case = bent_bumps(0.09, angle)
        label = {"": "At rest", "arap": "As-Rigid-As-Possible", "thin_shell": "Thin Shell"}[method]
        caption = f"{label}, {-angle:.0f}°" if method else label
        yield Shown(caption, case, ours(method)(case)) if method else Shown(caption, case, case.points, "")
