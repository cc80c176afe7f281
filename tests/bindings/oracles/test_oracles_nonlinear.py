# SPDX-License-Identifier: GPL-3.0-or-later
"""Nonlinear surface methods against their definitions in NumPy, libigl, and joint Gauss-Newton steps."""

import igl
import numpy as np
import pytest
import scipy.sparse as sparse

import sinew_native as sn

from ..meshes import (
    BENT,
    STILL,
    bar,
    ends,
    grid,
    halved,
    moved,
    nearest_rotations,
    quad_grid,
    shift,
    sphere,
    spread,
    turn,
)  # fmt: skip
from ..methods import bound_to
from .prisms import Prisms
from .rows import Rows, differences

POINTS, FACES = sphere(3)  # all cotangents positive: nothing is clamped on either side
POLES = [np.flatnonzero(POINTS[:, 2] < -0.8), np.flatnonzero(POINTS[:, 2] > 0.8)]
TURNED = np.stack([STILL, turn((1, 0, 0), 50, (0, 0, 1), (0.3, 0.4, 0.2))])


def sphere_arap(**options: object) -> sn.Arap:
    return bound_to(sn.Arap(sn.SurfaceMesh(POINTS, FACES), **options), POLES)


def spokes(p: np.ndarray, faces: np.ndarray) -> Rows:
    """The textbook energy over ordered pairs, by libigl's cotangents."""
    W = igl.cotmatrix(p, faces.astype(np.int64)).tocoo()
    edges = W.row != W.col
    i, D = W.row[edges], differences(W.row[edges], W.col[edges], len(p))
    return Rows(D, D @ p, i, 2 * W.data[edges])


TEXTBOOK = spokes(POINTS, FACES)


def libigl_arap(points, faces, handles, poses, iterations: int) -> np.ndarray:
    held = np.concatenate(handles)
    order = np.argsort(held)
    target = np.concatenate([moved(pose, points[h]) for pose, h in zip(poses, handles)])
    data = igl.ARAPData()
    data.energy = igl.ARAP_ENERGY_TYPE_SPOKES
    data.max_iter = iterations
    igl.arap_precomputation(points, faces.astype(np.int64), 3, held[order].astype(np.int32), data)
    return igl.arap_solve(np.ascontiguousarray(target[order]), data, points.copy())


@pytest.mark.parametrize("smoothness", [0.0, 5e-4, 0.1])
@pytest.mark.parametrize("cells", ["spokes", "rims"])
def test_reported_energy_is_that_of_the_returned_shape(cells: str, smoothness: float) -> None:
    arap = sphere_arap(cells=cells, smoothness=smoothness)
    for budget in (0, 3, 40, 400):
        q, report = arap.solve(TURNED, max_iterations=budget, tolerance=0)
        # A solve may end before its rotations have settled, to 1e-9 in energy().
        lag = 1e-12 if smoothness == 0 else 1e-6 if budget == 400 else 0.2
        assert report.energy * (1 - lag) <= arap.energy(q) <= report.energy * (1 + 1e-7)
        if (cells, smoothness) == ("spokes", 0):
            assert report.energy == pytest.approx(TEXTBOOK.energy(q), rel=1e-10)


def test_minimum_is_not_above_libigls() -> None:
    arap = sphere_arap(smoothness=0)
    q, report = arap.solve(TURNED, max_iterations=2000, tolerance=1e-12)
    theirs = libigl_arap(POINTS, FACES, POLES, TURNED, 3000)
    pole = POLES[1]
    np.testing.assert_allclose(theirs[pole], moved(TURNED[1], POINTS[pole]), atol=1e-12)  # the same task
    least = TEXTBOOK.energy(theirs)
    assert report.energy <= least * (1 + 1e-6)  # its alternation still creeps after 3,000 iterations
    assert report.energy == pytest.approx(least, rel=0.01)  # and is the same minimum
    assert np.abs(q - theirs).max() < 0.05


def test_smooth_rotations_keep_their_stiffness_on_finer_meshes() -> None:
    """What plain rotations do not: their bending stiffness falls with the square of the edge length."""

    def energy(n: int, smoothness: float) -> float:
        points, faces = grid(n, jitter=0.0)
        points *= 12 / n
        arap = bound_to(sn.Arap(sn.SurfaceMesh(points, faces), smoothness=smoothness), ends(points, 2.0))
        return arap.solve(BENT, max_iterations=100)[1].energy

    assert energy(24, 5e-3) == pytest.approx(energy(12, 5e-3), rel=0.1)
    assert energy(24, 0.0) < 0.5 * energy(12, 0.0)


def test_energy_with_point_handles_is_that_of_the_paper() -> None:
    """(1 - lambda) E + 2 lambda |r|^2 / m: the quadratic form of lambda L M^-1 L + (1 - lambda) L."""
    tip = [POLES[0], np.array([int(np.argmax(POINTS[:, 2]))])]
    lift = np.stack([STILL, turn((1, 0, 0), 0, (0, 0, 0), (0, 0, 0.5))])
    L = -igl.cotmatrix(POINTS, FACES.astype(np.int64)).toarray()
    mass = igl.massmatrix(POINTS, FACES.astype(np.int64), igl.MASSMATRIX_TYPE_VORONOI).diagonal()
    mass /= mass.mean()
    free = np.setdiff1d(np.arange(len(POINTS)), np.concatenate(tip))
    for weight in (0.2, 0.8):
        arap = bound_to(sn.Arap(sn.SurfaceMesh(POINTS, FACES), smoothness=0, point_handles=weight), tip)
        q, report = arap.solve(lift, max_iterations=300)
        r = TEXTBOOK.gradient(q) / 4
        expected = (1 - weight) * TEXTBOOK.energy(q) + 2 * weight * float((r**2 / mass[:, None]).sum())
        assert report.energy == pytest.approx(expected, rel=1e-8)
        # The positions solve the system of the paper for these rotations, but for the last steps.
        system = weight * L @ np.diag(1 / mass) @ L + (1 - weight) * L
        gradient = ((1 - weight) * r + weight * L @ (r / mass[:, None]))[free]
        step = np.linalg.solve(system[np.ix_(free, free)], gradient)
        assert np.abs(step).max() < 0.01 * 0.5


class Definition:
    """The energy of the header term by term, with weights from angles, and its gradient."""

    def __init__(self, points, triangles, cells: str, smoothness: float, rigidity) -> None:
        n = len(points)
        corners = [np.roll(triangles, -k, axis=1).T for k in range(3)]  # an edge (a, b) and what is opposite
        a, b, c = (np.concatenate(part) for part in zip(*corners))
        u, v = points[a] - points[c], points[b] - points[c]
        across = np.linalg.norm(np.cross(u, v), axis=1)
        w = 0.5 * np.einsum("ki,ki->k", u, v) / across

        def summed(w: np.ndarray) -> np.ndarray:
            W = sparse.coo_matrix((w, (a, b)), (n, n)).toarray()
            return W + W.T

        W, joined = summed(w), summed(np.ones(len(w))) > 0
        mean = np.abs(W[joined]).mean()
        if cells == "rims":
            w = np.clip(w, 1e-6 * mean, 1e4 * mean)
            cell, i, j, own = np.concatenate([a, b, c]), np.tile(a, 3), np.tile(b, 3), np.tile(w, 3)
            W = summed(w)
        else:
            W = np.where(joined, np.clip(W, 1e-6 * mean, 1e4 * mean), 0.0)
            i, j = np.nonzero(joined)
            cell, own = i, W[joined]
        D, rigidity = differences(i, j, n), np.broadcast_to(rigidity, n)
        self.rows = Rows(D, D @ points, cell, 2 * own * rigidity[cell])
        self.smooth = smoothness * across.sum() / 6 * W * (rigidity + rigidity[:, None]) / 2

    def settled(self, q: np.ndarray) -> tuple[float, np.ndarray]:
        """The energy and its gradient with the best rotations: with smoothness until they no longer move."""
        S = self.rows.covariances(q) / 2
        R, before = nearest_rotations(S), np.inf
        pull = 2 * (self.smooth + np.diag(self.smooth.sum(1)))  # with its own rotation, no step overshoots
        for _sweep in range(20_000):
            apart = ((R[:, None] - R[None]) ** 2).sum((2, 3))
            energy = self.rows.energy(q, R) + float((self.smooth * apart).sum())
            if energy > before * (1 - 1e-13):
                break
            before, R = energy, nearest_rotations(S + np.einsum("ij,jab->iab", pull, R))
        return energy, self.rows.gradient(q, R)


SURFACES = {"sphere": sphere(1), "hill": grid(4), "squares": bar(4, 2)}  # acute, obtuse and right angles


@pytest.mark.parametrize("smoothness", [0.0, 5e-4, 0.1])
@pytest.mark.parametrize("cells", ["spokes", "rims"])
@pytest.mark.parametrize("name", SURFACES)
def test_energy_is_that_of_the_definition(name: str, cells: str, smoothness: float) -> None:
    points, faces = SURFACES[name]
    mesh = sn.SurfaceMesh(points, faces)
    rng = np.random.default_rng(6)
    paint = 10 ** rng.uniform(-1, 1, len(points))
    arap = bound_to(sn.Arap(mesh, cells=cells, smoothness=smoothness, rigidity=paint), [[0]])
    oracle = Definition(points, mesh.triangles, cells, smoothness, paint)
    shapes = [points + 0.3 * rng.uniform(-1, 1, points.shape)]
    if smoothness == 0:  # mirrored cells have several settled fields of rotations
        shapes.append(shapes[0] * (1, 1, -1))
    for q in shapes:
        # The settling stops at 1e-9; slower modes are left to either side.
        assert arap.energy(q) == pytest.approx(oracle.settled(q)[0], rel=1e-5 if smoothness else 1e-12)


SHARP = np.where(np.arange(66) % 3 == 0, 300.0, 1.0)


@pytest.mark.parametrize(("smoothness", "rigidity"), [(0.0, 1.0), (5e-3, 1.0), (0.0, SHARP)], ids=str)
@pytest.mark.parametrize("cells", ["spokes", "rims"])
def test_ends_where_the_definition_is_stationary(cells: str, smoothness: float, rigidity) -> None:
    points, faces = sphere(2)
    # A contrast of 300 leaves two digits fewer.
    iterations, left = (3000, 1e-2) if rigidity is SHARP else (2000, 2e-4)
    arap = sn.Arap(sn.SurfaceMesh(points, faces), cells=cells, smoothness=smoothness, rigidity=rigidity)
    arap.set_handles([np.flatnonzero(points[:, 2] < -0.8), np.flatnonzero(points[:, 2] > 0.8)])
    poses = np.stack([STILL, turn((1, 0, 0), 30, (0, 0, 1), (0.2, 0.4, 0.3))])
    rough = arap.solve(poses, max_iterations=0)[0]
    end = arap.solve(poses, max_iterations=iterations, tolerance=1e-14)[0]
    oracle, free = Definition(points, faces, cells, smoothness, rigidity), np.abs(points[:, 2]) <= 0.8
    at_start, at_end = (np.linalg.norm(oracle.settled(q)[1][free], axis=1).sum() for q in (rough, end))
    assert at_end < left * at_start


@pytest.mark.parametrize("bending", [0.0, 1e-3, 0.1])
def test_mesh_puppetry_has_the_energy_of_its_header_at_a_minimum(bending: float) -> None:
    points, faces = bar(12, 3)
    mesh = sn.SurfaceMesh(points, faces)
    L = -igl.cotmatrix(points, mesh.triangles.astype(np.int64)).toarray()
    mass = igl.massmatrix(points, mesh.triangles.astype(np.int64), igl.MASSMATRIX_TYPE_VORONOI).diagonal()
    i, j = np.nonzero(L - np.diag(np.diag(L)))
    handles, D = ends(points, 2), np.concatenate([differences(i, j, len(points)).toarray(), L])
    weights = np.concatenate([-L[i, j], bending * mass.sum() / mass])
    rows = Rows(D, D @ points, np.concatenate([i, np.arange(len(points))]), weights)

    def energy(q: np.ndarray, poses: np.ndarray) -> float:
        R = rows.rotations(q)
        for handle, pose in zip(handles, poses):
            R[handle] = pose[:, :3]
        return rows.energy(q, R)

    method = bound_to(sn.MeshPuppetry(mesh, bending=bending, max_iterations=400, tolerance=1e-12), handles)
    rng = np.random.default_rng(3)
    free = np.setdiff1d(np.arange(len(points)), np.concatenate(handles))
    for turned in (turn((0, 0, 1), 90, (10, 0, 0), (-2, 5, 0)), turn((1, 0, 0), 135)):
        poses = np.stack([STILL, turned])
        q, report = method.solve(poses)
        least = energy(q, poses)
        # The kernels tie a rotation to the last one by 1e-8 of its covariance, whose edges are some 100
        # times as large as what the energy is about.
        assert report.energy == pytest.approx(least, rel=2e-6)
        assert least > 0.1
        for _ in range(20):
            other = q.copy()
            other[free] += 1e-3 * rng.uniform(-1, 1, (len(free), 3))
            assert energy(other, poses) > least


def sharpness(n: int, smoothness: float, point_handles: float) -> float:
    """Of a plate whose rim stays and whose middle vertex is lifted: how far its neighbour stays behind, as a
    share of the mean slope from there to the rim.
    """
    points, faces = grid(n, jitter=0.0)
    points *= (10 / n, 10 / n, 0)
    rim = np.flatnonzero(np.abs(points[:, :2] - 5).max(1) > 5 - 1e-9)
    middle = n // 2 * (n + 1) + n // 2
    arap = sn.Arap(sn.SurfaceMesh(points, faces), smoothness=smoothness, point_handles=point_handles)
    arap.set_handles([rim, [middle]])
    q, _ = arap.solve(np.stack([STILL, shift(0, 0, 1)]), max_iterations=300)
    assert q[middle, 2] == 1
    return (1 - q[middle + 1, 2]) * (n // 2)


@pytest.mark.parametrize("smoothness", [0.0, 5e-4])
def test_point_handles_round_the_tip_which_is_the_sharper_the_finer_the_mesh(smoothness: float) -> None:
    coarse, fine = ([sharpness(n, smoothness, weight) for weight in (0, 0.5, 0.9)] for n in (20, 40))
    for own, some, most in (coarse, fine):
        assert most < some < 0.6 * own
    assert fine[0] > coarse[0]
    # Then the tip becomes rounder. Without smoothness the start decides between several minima.
    assert smoothness == 0 or fine[2] < coarse[2]


def shell_rows(points: np.ndarray, faces: np.ndarray, k_s: float, k_b: float) -> Rows:
    """The energy of the header, for manifold meshes of sound triangles: seven rows per hinge."""
    sides: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for t, face in enumerate(faces.tolist()):
        for k in range(3):
            a, b = face[(k + 1) % 3], face[(k + 2) % 3]
            sides.setdefault((min(a, b), max(a, b)), []).append((t, face[k]))
    pairs = [(edge, found) for edge, found in sides.items() if len(found) == 2]
    corners = np.array([(*edge, found[0][1], found[1][1]) for edge, found in pairs])
    triangles = np.array([[side[0] for side in found] for _edge, found in pairs])
    share = 1.0 / np.bincount(triangles.ravel(), minlength=len(faces))[triangles]

    p = points[corners]  # (m, 4, 3): both ends of the edge, then what lies opposite
    e = p[:, 1] - p[:, 0]
    areas, rows, weights, bend = [], [], [], np.zeros((len(corners), 4))
    for side in range(2):
        a, b, c = 0, 1, 2 + side
        area = 0.5 * np.linalg.norm(np.cross(e, p[:, c] - p[:, 0]), axis=1)
        areas.append(area)
        for i, j, k in ((a, b, c), (b, c, a), (c, a, b)):  # the edge (i, j) opposite k
            cotan = np.einsum("mi,mi->m", p[:, i] - p[:, k], p[:, j] - p[:, k]) / (2 * area)
            row = np.zeros((len(corners), 4))
            row[:, i], row[:, j] = 1.0, -1.0
            rows.append(row)
            weights.append(0.5 * k_s * share[:, side] * cotan)
            if k != c:  # this cotangent stands at an end of the hinge, at k
                bend[:, b if k == a else a] += cotan
                bend[:, c] -= cotan
    areas_of_both = areas[0] + areas[1]
    own = k_s * share.mean(1) * areas_of_both**2 / (4 * np.einsum("mi,mi->m", e, e))
    rows.append(bend)
    weights.append(np.maximum(k_b - own, 0.0) / areas_of_both)
    m = len(corners)
    columns = np.repeat(corners, 7, axis=0)
    at = np.repeat(np.arange(7 * m), 4)
    D = sparse.csr_matrix((np.stack(rows, 1).ravel(), (at, columns.ravel())), (7 * m, len(points)))
    return Rows(D, D @ points, np.repeat(np.arange(m), 7), np.stack(weights, 1).ravel())


def shells(thickness: float) -> tuple["sn.ThinShellNonlinear", Rows]:
    shell = sn.ThinShellNonlinear(sn.SurfaceMesh(POINTS, FACES), measure="length", thickness=thickness)
    shell.set_handles(POLES)
    return shell, shell_rows(POINTS, FACES, 1.0, thickness**2)


@pytest.mark.parametrize("thickness", [0.01, 0.3, 2.0])
@pytest.mark.parametrize("surface", [(POINTS, FACES), grid(4), bar(4, 2)], ids=["sphere", "hill", "squares"])
def test_energy_of_a_shell_is_that_of_the_definition(surface, thickness: float) -> None:
    """Of acute triangles, obtuse ones, and right angles on both sides of each edge."""
    points, faces = surface
    mesh = sn.SurfaceMesh(points, faces)
    shell = bound_to(sn.ThinShellNonlinear(mesh, measure="length", thickness=thickness), [[0]])
    oracle = shell_rows(points, mesh.triangles, 1.0, thickness**2)
    rng = np.random.default_rng(4)
    for size in (0.01, 0.1, 1.0):
        q = points + size * rng.normal(size=points.shape)
        # Thousands of terms round.
        assert shell.energy(q) == pytest.approx(oracle.energy(q), rel=1e-10)


def test_gradient_of_the_definition_is_that_of_differences() -> None:
    shell, oracle = shells(0.2)
    rng = np.random.default_rng(5)
    q = POINTS + 0.05 * rng.normal(size=POINTS.shape)
    way = rng.normal(size=q.shape)
    step = 1e-5
    slope = (shell.energy(q + step * way) - shell.energy(q - step * way)) / (2 * step)
    assert slope == pytest.approx(float((oracle.gradient(q) * way).sum()), rel=1e-7)


@pytest.mark.parametrize("thickness", [0.05, 0.2])
def test_gauss_newton_ends_in_the_same_shape(thickness: float) -> None:
    shell, oracle = shells(thickness)
    start, _ = shell.solve(TURNED, max_iterations=0)
    ours, report = shell.solve(TURNED, max_iterations=2000, tolerance=1e-14)
    shape, energy, _turns = oracle.minimum(start, np.setdiff1d(np.arange(len(POINTS)), np.concatenate(POLES)))
    assert report.energy == pytest.approx(energy, rel=1e-4)
    # Both energies are flat at their minimum: half of the digits of the energy.
    assert np.abs(ours - shape).max() < 1e-3


def test_reported_energy_of_a_shell_is_that_of_the_returned_shape() -> None:
    shell, oracle = shells(0.1)
    for budget in (0, 3, 40):
        shape, report = shell.solve(TURNED, max_iterations=budget, tolerance=0.0)
        assert report.energy == pytest.approx(oracle.energy(shape), rel=1e-9)


def test_vertices_where_the_sheet_is_too_thin_for_the_mesh_are_named() -> None:
    points, faces = grid(8, jitter=0.0)
    points *= (1, 1, 0)

    def thin(thickness: float | np.ndarray) -> np.ndarray:
        shell = sn.ThinShellNonlinear(sn.SurfaceMesh(points, faces), measure="length", thickness=thickness)
        return shell.set_handles([[0]]).thin_vertices

    assert len(thin(1.0)) == 0
    assert len(thin(0.1)) == 79  # two corners lie at no inner edge
    named = thin(np.where(points[:, 0] < 3.5, 0.0, 1.0))
    assert points[named, 0].max() < 4.5
    assert len(named) >= 27


def test_measures_are_ways_to_say_the_same() -> None:
    points, faces = bar(12, 3)
    handles = [np.flatnonzero(points[:, 0] <= 2), np.flatnonzero(points[:, 0] >= 10)]
    size = spread(points, faces)
    shapes = []
    for words in (
        {"thickness": 0.05},
        {"measure": "length", "thickness": 0.05 * size},
        {"measure": "stiffness", "stretching": 4.0, "bending": 0.01 * size**2},  # four times both
    ):
        shell = bound_to(sn.ThinShellNonlinear(sn.SurfaceMesh(points, faces), **words), handles)
        shapes.append(shell.solve([STILL, turn((0, 0, 1), 60, (10, 0, 0), (-2, 4, 0))])[0])
    np.testing.assert_allclose(shapes[1:], [shapes[0]] * 2, rtol=0, atol=1e-6)


TUBE, QUADS = bar(16, 4)
HILL, HILL_FACES = grid(10)
ENDS = [np.flatnonzero(TUBE[:, 0] <= 1), np.flatnonzero(TUBE[:, 0] >= 15)]
SIDES = [np.flatnonzero(HILL[:, 0] < 1.5), np.flatnonzero(HILL[:, 0] > 8.5), np.array([60])]
BENDS = np.stack([STILL, turn((0, 0, 1), 70, (15, 0, 0), (-3, 7, 0))])
TWISTS = np.stack([STILL, turn((1, 0, 0), 100)])
PULLS = np.stack([STILL, turn((1, 2, 0.5), 50, (9, 5, 0), (-1, 0, 2)), shift(0, 0, 1.5)])


@pytest.mark.parametrize(
    ("points", "faces", "handles", "poses"),
    [
        (TUBE, QUADS, ENDS, BENDS),
        (TUBE, halved(QUADS), ENDS, BENDS),
        (TUBE, halved(QUADS), ENDS, TWISTS),
        (HILL, HILL_FACES, SIDES, PULLS),  # with a single vertex
    ],
    ids=["quads, bend", "triangles, bend", "triangles, twist", "hill"],
)
def test_ends_where_joint_steps_end(points, faces, handles, poses) -> None:
    size, height = spread(points, faces), 0.05
    primo = sn.Primo(sn.SurfaceMesh(points, faces), height=height)
    primo.set_handles(handles)
    start, first = primo.solve(poses, max_iterations=0)
    found, report = primo.solve(poses, max_iterations=3000, tolerance=1e-13)
    oracle = Prisms(points, faces, handles, poses, height * size)
    oracle.start_from(start)
    energy = oracle.gauss_newton()
    # Rotations lag behind positions by a part of a step: the last steps win nothing, 4e-6 on the hill.
    assert report.energy == pytest.approx(energy, rel=1e-5)
    assert first.energy < 1.3 * energy
    assert np.abs(found - oracle.vertices()).max() < 1e-4 * size
    # A frame is within a per cent.
    assert np.linalg.norm(primo.solve(poses)[0] - found) < 0.01 * np.linalg.norm(found - points)


def test_counts_turned_faces() -> None:
    points, quads = quad_grid(4, 4)
    primo = sn.Primo(sn.SurfaceMesh(points, quads), height=0.5)
    rim = np.flatnonzero((points[:, :2] % 4 == 0).any(1))
    primo.set_handles([np.append(rim, 13), [12]])
    for far, turned in ((0.2, False), (4.0, True)):
        assert (primo.solve([STILL, shift(far, 0, 0)])[1].inverted_faces > 0) == turned


SIDE = 0.05


def rings_of(count: int, faces: np.ndarray) -> tuple[list[list[int]], np.ndarray]:
    """The ring of each vertex in order, and whether it is open."""
    after: list[dict[int, int]] = [{} for _ in range(count)]
    for a, b, c in faces:
        after[a][b], after[b][c], after[c][a] = c, a, b
    rings, is_open = [], np.zeros(count, dtype=bool)
    for i, following in enumerate(after):
        first = set(following) - set(following.values())
        is_open[i] = bool(first)
        ring = [first.pop() if first else next(iter(following))]
        while ring[-1] in following and following[ring[-1]] != ring[0]:
            ring.append(following[ring[-1]])
        rings.append(ring)
    return rings, is_open


def mean_values(p: np.ndarray, i: int, ring: list[int]) -> np.ndarray:
    around = p[ring]
    middle = around.mean(0)
    normal = np.cross(around - middle, np.roll(around, -1, 0) - middle).sum(0)
    normal /= np.linalg.norm(normal)
    flat = around - p[i]
    flat -= np.outer(flat @ normal, normal)
    away = np.linalg.norm(flat, axis=1)
    angle = np.arccos(np.clip((flat * np.roll(flat, -1, 0)).sum(1) / away / np.roll(away, -1), -1, 1))
    w = (np.tan(angle / 2) + np.tan(np.roll(angle, 1) / 2)) / away
    return w / w.sum()


def table_of(p: np.ndarray, faces: np.ndarray) -> Rows:
    rings, is_open = rings_of(len(p), faces)
    a, b, c = p[faces].swapaxes(0, 1)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    rows, columns, values, group, weight = [], [], [], [], []
    for i, ring in enumerate(rings):
        share = np.full(len(ring), 1 / len(ring)) if is_open[i] else mean_values(p, i, ring)
        tip = p[i] - share @ p[ring]
        square = ((p[ring] - p[i]) ** 2).sum(1).mean()
        depth = tip @ tip
        k = area / (866 * square)
        if k * depth > 2 * SIDE * square:
            k = 2 * SIDE * square / depth
        rows += [len(weight)] * (len(ring) + 1)
        columns += [i, *ring]
        values += [1.0, *-share]
        group.append(i)
        weight.append(k)
        for j in ring:
            rows += [len(weight)] * 2
            columns += [j, i]
            values += [1.0, -1.0]
            group.append(i)
            weight.append(SIDE / len(ring))
    D = sparse.csr_matrix((values, (rows, columns)), (len(weight), len(p)))
    return Rows(D, D @ p, np.array(group), np.array(weight))


def plate() -> tuple[np.ndarray, np.ndarray]:
    points, faces = grid(9)
    points = points.copy()
    points[:, 2] += 0.8 * np.sin(0.7 * points[:, 0]) * np.cos(0.5 * points[:, 1])
    return points, faces


@pytest.mark.parametrize("shape", [sphere(2), plate()], ids=["closed", "open"])
def test_pyramids_have_the_minimum_of_gauss_newton(shape: tuple[np.ndarray, np.ndarray]) -> None:
    p, faces = shape
    low, high = p[:, 0].min(), p[:, 0].max()
    handles = ends(p, 0.15 * (high - low))
    centre = tuple(p[handles[1]].mean(0))
    poses = np.stack([STILL, turn((1, 0.3, 0.2), 50, centre, (0.1 * (low - high), 0.1 * (high - low), 0.05))])
    method = bound_to(sn.PyramidCoordinates(sn.SurfaceMesh(p, faces), side=SIDE), handles)
    ours, report = method.solve(poses, max_iterations=3000, tolerance=1e-14)

    x = p.copy()
    for pose, handle in zip(poses, handles):
        x[handle] = moved(pose, p[handle])
    free = np.setdiff1d(np.arange(len(p)), np.concatenate(handles))
    theirs, least, _turns = table_of(p, faces).minimum(x, free)
    assert report.energy == pytest.approx(least, rel=1e-6)  # both are flat there
    assert np.abs(ours - theirs).max() < 1e-3 * (high - low)


def test_a_morph_is_exact_at_both_ends_and_needs_no_handle() -> None:
    p, faces = sphere(2)
    other = moved(turn((1, 1, 0), 70), p * (1.5, 1.0, 0.6))
    method = sn.PyramidCoordinates(sn.SurfaceMesh(p, faces), target_shape=sn.SurfaceMesh(other, faces))
    method.set_handles([])
    nothing = np.zeros((0, 3, 4))
    np.testing.assert_array_equal(method.solve(nothing)[0], p)
    np.testing.assert_allclose(method.solve(nothing, morph=1.0)[0], other, atol=1e-11)
    half, report = method.solve(nothing, morph=0.5)
    assert report.converged
    np.testing.assert_array_equal(method.solve(nothing)[0], p)
    # Between the two sizes and turns: 35 degrees, and about the mean of the axes.
    back = moved(turn((1, 1, 0), -35), half)
    np.testing.assert_allclose(np.ptp(back, axis=0), 2 * np.array([1.25, 1.0, 0.8]), atol=0.08)
    assert method.folded_rings.size == 0
    # Lengths do not shrink half-way, as they do on straight lines between shapes that are turned.
    turned = sn.SurfaceMesh(moved(turn((0, 0, 1), 150), p), faces)
    method = bound_to(sn.PyramidCoordinates(sn.SurfaceMesh(p, faces), target_shape=turned), [])
    half, _ = method.solve(nothing, morph=0.5)
    np.testing.assert_allclose(half, moved(turn((0, 0, 1), 75), p), atol=1e-9)


def test_target_shapes_that_do_not_fit_are_refused() -> None:
    p, faces = sphere(1)
    mesh = sn.SurfaceMesh(p, faces)
    swapped = faces.copy()
    swapped[3] = swapped[3, [1, 0, 2]]
    with pytest.raises(sn.InvalidMesh, match="other vertices") as refused:
        sn.PyramidCoordinates(mesh, target_shape=sn.SurfaceMesh(p, swapped))
    assert refused.value.elements == [3]
    with pytest.raises(sn.InvalidMesh, match="vertices"):
        sn.PyramidCoordinates(mesh, target_shape=sn.SurfaceMesh(*sphere(2)))
    with pytest.raises(TypeError):
        sn.PyramidCoordinates(mesh, target_shape=p)
    method = bound_to(sn.PyramidCoordinates(mesh, target_shape=mesh), [[0, 1]])
    for morph in (-0.1, 1.5, float("nan")):
        with pytest.raises(sn.InvalidOption, match="morph"):
            method.solve([STILL], morph=morph)
