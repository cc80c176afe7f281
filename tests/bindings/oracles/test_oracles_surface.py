# SPDX-License-Identifier: GPL-3.0-or-later
"""Linear surface methods against dense matrices of libigl's operators and SciPy's rotations."""

from collections.abc import Iterator
from itertools import product

import igl
import numpy as np
import pytest
from scipy.linalg import lstsq
from scipy.spatial.transform import Rotation

import sinew_native as sn

from ..meshes import STILL, bar, edges_of, ends, grid, joined, nearest_rotations, shift, sphere, turn
from .test_oracles_spline import design

MESHES = {"hill": grid(8), "bar": bar(6, 2), "sphere": sphere(2), "obtuse": grid(9, 0.45)}
EVERY = tuple(MESHES)
MESHES["two parts"] = joined(grid(8), (grid(8)[0] + (0, 20, 0), grid(8)[1]))
KINDS = ("uniform", "cotan", "cotan_voronoi")


class Rest:
    """A rest shape with two or more handles: operators, and what is free."""

    def __init__(self, name: str, handles: list | None = None, weights: list | None = None) -> None:
        self.points, self.faces = MESHES[name]
        self.mesh = sn.SurfaceMesh(self.points, self.faces)
        self.n = len(self.points)
        self.handles = handles or ends(self.points, np.linalg.norm(np.ptp(self.points, axis=0)) / 8)
        self.weights = weights or [np.ones(len(handle)) for handle in self.handles]
        self.triangles = self.mesh.triangles.astype(np.int64)
        self.owner = np.full(self.n, -1)
        for h, (handle, w) in enumerate(zip(self.handles, self.weights)):
            self.owner[np.asarray(handle)[w == 1]] = h
        self.free = np.flatnonzero(self.owner < 0)

    def pulls(self) -> Iterator[tuple[int, int, float]]:
        """Soft vertices with their handles and w / (1 - w)."""
        for h, (handle, weights) in enumerate(zip(self.handles, self.weights)):
            for v, w in zip(handle, weights):
                if 0 < w < 1 and self.owner[v] < 0:
                    yield int(v), h, w / (1 - w)

    def elements(self, kind: str) -> list[tuple[tuple[int, ...], np.ndarray]]:
        """The parts that L is the sum of: for edges, or for triangles."""
        if kind == "uniform":
            return [((a, b), np.array([[1.0, -1.0], [-1.0, 1.0]])) for a, b in edges_of(self.faces)]
        corner = np.array([[0, 1, 2]])
        return [(tuple(t), -igl.cotmatrix(self.points[t], corner).toarray()) for t in self.triangles]

    def laplacian(self, kind: str, scale=lambda element: 1.0) -> np.ndarray:
        L = np.zeros((self.n, self.n))
        for element, own in self.elements(kind):
            L[np.ix_(element, element)] += scale(list(element)) * own
        return L

    def rings(self, kind: str) -> list[np.ndarray]:
        """The vertex itself and all that share an element with it."""
        rings: list[set[int]] = [set() for _ in range(self.n)]
        for element, _own in self.elements(kind):
            for v in element:
                rings[v].update(element)
        return [np.array(sorted(ring)) for ring in rings]

    def mass(self, kind: str) -> np.ndarray:
        if kind == "cotan_voronoi":
            return igl.massmatrix(self.points, self.triangles, igl.MASSMATRIX_TYPE_VORONOI).diagonal()
        return np.ones(self.n) if kind == "cotan" else np.diag(self.laplacian("uniform")).copy()

    def solution(self, A: np.ndarray, b: np.ndarray, x: np.ndarray, of: int = 1) -> np.ndarray:
        """x with A x = b in the rows of free vertices, `of` rows each."""
        free = (of * self.free[:, None] + np.arange(of)).ravel()
        x = x.astype(float)
        x[free] = 0.0
        x[free] = np.linalg.solve(A[np.ix_(free, free)], (b - A @ x)[free])
        return x

    def field(self) -> np.ndarray:
        """The harmonic field of the second handle."""
        return self.solution(positive(self.laplacian("cotan")), np.zeros(self.n), 1.0 * (self.owner == 1))

    def targets(self, poses: np.ndarray, y: np.ndarray) -> np.ndarray:
        x = y.copy()
        for h, pose in enumerate(poses):
            x[self.owner == h] = y[self.owner == h] @ pose[:, :3].T + pose[:, 3]
        return x

    def pulled(self, A: np.ndarray, b: np.ndarray, y: np.ndarray, poses: np.ndarray):
        """A x = b, with springs as stiff as the diagonal at soft vertices: x, and the energy of springs."""
        K, b, springs = A.copy(), b.copy(), []
        for v, h, w in self.pulls():
            stiffness, aim = w * A[v, v], poses[h][:, :3] @ y[v] + poses[h][:, 3]
            K[v, v] += stiffness
            b[v] += stiffness * aim
            springs.append((v, stiffness, aim))
        x = self.solution(K, b, self.targets(poses, y))
        return x, sum(0.5 * k * float(((x[v] - aim) ** 2).sum()) for v, k, aim in springs)

    def solved(self, method, poses: np.ndarray, incoming: np.ndarray | None = None, **options: object):
        made = method(self.mesh, **options)
        made.set_handles(self.handles, self.weights)
        return made.solve(poses, incoming=incoming)

    def agrees(self, found, x: np.ndarray, energy: float | None = None, rtol: float = 1e-9) -> None:
        positions, report = found
        np.testing.assert_allclose(positions, x, rtol=0, atol=rtol * np.linalg.norm(np.ptp(x, axis=0)))
        if energy is not None:
            assert report.energy == pytest.approx(energy, rel=rtol, abs=rtol)
        assert report.residual < 1e-8


def positive(L: np.ndarray) -> np.ndarray:
    """A Laplacian whose negative weights became positive ones of a millionth of their size."""
    W = np.diag(np.diag(L)) - L
    W = np.where(W < -1e-9, -1e-6 * W, W)
    return np.diag(W.sum(1)) - W


def half_square(rows: np.ndarray, weights: np.ndarray) -> float:
    return 0.5 * float((weights[:, None] * rows**2).sum())


def gradients(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(t, 3, n) derivatives on each triangle: grad . u = f_j - f_i, grad . v = f_k - f_i, grad . n = 0."""
    G = np.zeros((len(triangles), 3, len(points)))
    for own, (i, j, k) in zip(G, triangles, strict=True):
        u, v = points[j] - points[i], points[k] - points[i]
        slopes = np.linalg.inv([u, v, np.cross(u, v)])
        own[:, j], own[:, k], own[:, i] = slopes[:, 0], slopes[:, 1], -slopes[:, 0] - slopes[:, 1]
    return G


def affine(seed: int, degrees: float) -> tuple[np.ndarray, Rotation, np.ndarray]:
    """A pose of a rotation after a symmetric stretch, and both."""
    rng = np.random.default_rng(seed)
    A, axis = rng.uniform(-1, 1, (3, 3)), rng.normal(size=3)
    R = Rotation.from_rotvec(np.radians(degrees) * axis / np.linalg.norm(axis))
    S = np.eye(3) + 0.2 * (A + A.T)
    return np.column_stack([R.as_matrix() @ S, rng.uniform(-1, 1, 3)]), R, S


def between(s: np.ndarray, R: Rotation, S: np.ndarray) -> np.ndarray:
    """(n, 3, 3) shares s of a rotation after a stretch."""
    turns = Rotation.from_rotvec(s[:, None] * R.as_rotvec()).as_matrix()
    return turns @ (s[:, None, None] * S + (1 - s[:, None, None]) * np.eye(3))


def mean_rotation(poses: np.ndarray) -> np.ndarray:
    """By the largest eigenvector of the sum of squares of their quaternions."""
    q = Rotation.from_matrix(poses[:, :, :3]).as_quat()
    return Rotation.from_quat(np.linalg.eigh(q.T @ q)[1][:, 3]).as_matrix()


def entering(rest: Rest, size: float) -> list[np.ndarray]:
    return [rest.points, rest.points + size * np.random.default_rng(5).uniform(-1, 1, rest.points.shape)]


@pytest.mark.parametrize("name", ["hill", "bar", "sphere"])
def test_gradient_editing_turns_gradients_by_its_field(name: str) -> None:
    rest = Rest(name)
    G = gradients(rest.points, rest.triangles)
    area = np.repeat(igl.doublearea(rest.points, rest.triangles) / 2, 3)
    rows = G.reshape(-1, rest.n)
    L = rows.T @ (area[:, None] * rows)
    s = rest.field()[rest.triangles].mean(1)
    for t, owners in enumerate(rest.owner[rest.triangles]):  # a face that one handle touches moves with it
        if len(touching := set(owners) - {-1}) == 1:
            s[t] = touching.pop()
    for y, degrees in product(entering(rest, 0.3), (0.0, 40.0, 170.0, -90.0)):
        pose, R, S = affine(6, degrees)
        poses = np.stack([STILL, pose])
        turned = np.einsum("tij,tdj->tdi", between(s, R, S), G @ y).reshape(-1, 3)
        x = rest.solution(L, rows.T @ (area[:, None] * turned), rest.targets(poses, y))
        found = rest.solved(sn.GradientEditing, poses, y)
        rest.agrees(found, x, half_square(rows @ x - turned, area), 1e-10)
        assert found[1].iterations == 1


class Bending:
    """The equations of Laplacian editing for given maps of the vertices."""

    def __init__(self, rest: Rest, kind: str) -> None:
        self.rest, self.L, self.m = rest, rest.laplacian(kind), rest.mass(kind)
        self.rings = rest.rings(kind)
        self.A = self.L @ (self.L / self.m[:, None])

    def solve(self, y: np.ndarray, poses: np.ndarray, T: np.ndarray) -> tuple[np.ndarray, float]:
        turned = np.einsum("vij,vj->vi", T, self.L @ y / self.m[:, None])
        x, springs = self.rest.pulled(self.A, self.L @ turned, y, poses)
        return x, springs + half_square(self.L @ x / self.m[:, None] - turned, self.m)

    def fitted(self, y: np.ndarray, x: np.ndarray) -> np.ndarray:
        """The rotations of the edges at each vertex from y to x."""
        found = np.empty((len(y), 3, 3))
        for i, ring in enumerate(self.rings):
            found[i] = nearest_rotations((x[ring] - x[i]).T @ (y[ring] - y[i]))
        return found


@pytest.mark.parametrize("transforms", ["explicit", "none"])
@pytest.mark.parametrize(("name", "kind"), list(product(EVERY, KINDS)))
def test_laplacian_editing_turns_by_the_maps_of_handles(name: str, kind: str, transforms: str) -> None:
    rest = Rest(name)
    bending = Bending(rest, kind)
    s = rest.solution(positive(bending.L), np.zeros(rest.n), 1.0 * (rest.owner == 1))
    s *= transforms == "explicit"
    for y, degrees in product(entering(rest, 0.1), (0.0, 170.0, -90.0)):
        pose, R, S = affine(7, degrees)
        poses = np.stack([STILL, pose])
        x, energy = bending.solve(y, poses, between(s, R, S))
        found = rest.solved(sn.LaplacianEditing, poses, y, transforms=transforms, laplacian=kind)
        rest.agrees(found, x, energy)


@pytest.mark.parametrize(("name", "kind", "mean_frame"), list(product(("hill", "bar"), KINDS, (True, False))))
def test_laplacian_editing_estimates_rotations(name: str, kind: str, mean_frame: bool) -> None:
    handles = [*ends(MESHES[name][0], 1.5), np.array([38, 39])]
    rest = Rest(name, handles, [np.ones(len(handles[0])), np.ones(len(handles[1])), np.array([0.4, 0.7])])
    poses = np.stack([STILL, turn((0, 1, 0), 70, (6, 0, 0), (-1, 0.5, 2)), turn((1, 1, 0), 20, (4, 4, 0))])
    bending = Bending(rest, kind)
    mean = mean_rotation(poses) if mean_frame else np.eye(3)
    for y in entering(rest, 0.1):
        x, energy = bending.solve(y, poses, np.tile(mean, (rest.n, 1, 1)))
        for refits in range(4):
            if refits:
                x, energy = bending.solve(y, poses, bending.fitted(y, x))
            words = {"laplacian": kind, "refits": refits, "mean_frame": mean_frame}
            rest.agrees(rest.solved(sn.LaplacianEditing, poses, y, **words), x, energy, 1e-8)


def ends_or_many(name: str, many: bool) -> tuple[Rest, np.ndarray]:
    """Two handles, or more than a bind keeps answers for; the second one is soft."""
    points = MESHES[name][0]
    handles, poses = ends(points, 1.1), [STILL, turn((0, 1, 0), 50, (6, 0, 0), (-1, 0.5, 2))]
    if many:
        handles, rng = [np.array([v]) for v in range(0, 80, 4)], np.random.default_rng(3)
        poses = [turn(rng.normal(size=3), 20, points[v], rng.uniform(-0.3, 0.3, 3)) for [v] in handles]
    weights = [np.full(len(handle), 0.9 if h == 1 else 1.0) for h, handle in enumerate(handles)]
    return Rest(name, handles, weights), np.stack(poses)


@pytest.mark.parametrize("mean_frame", [True, False])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("name", "many"), [("hill", False), ("bar", False), ("hill", True)])
def test_laplacian_editing_turns_by_implicit_similarities(name, many, kind, mean_frame) -> None:
    """Similarities are fitted to rings by pseudo-inverses, with their translations as unknowns."""
    rest, poses = ends_or_many(name, many)
    p, n = rest.points, rest.n
    R = mean_rotation(poses) if mean_frame else np.eye(3)
    bending = Bending(rest, kind)
    D = bending.L / bending.m[:, None]
    delta = D @ p
    sides = np.sort(np.concatenate([rest.faces, np.roll(rest.faces, 1, 1)]).reshape(2, -1).T, axis=1)
    edges, counts = np.unique(sides, axis=0, return_counts=True)
    border = np.isin(np.arange(n), edges[counts == 1])
    residual, fits = np.kron(D, np.eye(3)), []
    for i, ring in enumerate(bending.rings):
        model = np.zeros((len(ring), 3, 7))  # s, h, t of s x + h x x + t
        model[:, :, 0] = p[ring]
        for axis in range(3):
            model[:, :, 1 + axis] = np.cross(np.eye(3)[axis], p[ring])
        model[:, :, 4:] = np.eye(3)
        fits.append((ring, np.linalg.pinv(model.reshape(-1, 7))[:4]))
        change = np.outer(delta[i], fits[i][1][0])
        if not border[i]:
            change += np.cross(fits[i][1][1:4].T, delta[i]).T
        residual[3 * i : 3 * i + 3, (3 * ring[:, None] + np.arange(3)).ravel()] -= change
    H = residual.T @ (np.repeat(bending.m, 3)[:, None] * residual) + 1e-7 * np.kron(bending.A, np.eye(3))
    diagonal = np.diag(H).reshape(n, 3).mean(1)
    b, d = np.zeros((n, 3)), rest.targets(poses, p) @ R - p
    for v, h, w in rest.pulls():
        stiffness = w * diagonal[v]
        b[v] += stiffness * ((poses[h][:, :3] @ p[v] + poses[h][:, 3]) @ R - p[v])
        H[3 * v : 3 * v + 3, 3 * v : 3 * v + 3] += stiffness * np.eye(3)
    first = p + rest.solution(H, b.ravel(), d.ravel(), 3).reshape(n, 3)
    T = np.empty((n, 3, 3))
    for i, (ring, fit) in enumerate(fits):
        s, *h = fit @ first[ring].ravel()
        angle = np.arctan2(np.linalg.norm(h), s)
        T[i] = R @ Rotation.from_rotvec(angle * np.array(h) / np.linalg.norm(h)).as_matrix()
    x, energy = bending.solve(p, poses, T)
    words = {"transforms": "implicit", "laplacian": kind, "mean_frame": mean_frame}
    rest.agrees(rest.solved(sn.LaplacianEditing, poses, **words), x, energy, 1e-6)


@pytest.mark.parametrize(("name", "kind"), list(product(("hill", "bar"), ("cotan", "uniform"))))
def test_rotation_invariant_coordinates_solve_the_statement_of_the_paper(name: str, kind: str) -> None:
    """With any frames at rest: what keeps the rotations between them, then the edges, by least squares."""
    rest = Rest(name, ends(MESHES[name][0], 1.1))
    L = rest.laplacian(kind)
    i, j = np.nonzero(np.tril(np.abs(L) > 1e-9, -1))
    w, n = -L[i, j], rest.n
    frames = Rotation.random(n, random_state=11).as_matrix()
    A = np.zeros((n, 3, n, 3))
    for a, b, weight in zip(i, j, np.where(w > 0, w, -1e-6 * w)):  # w |f_b - f_a R|^2
        A[a, :, a] += weight * np.eye(3)
        A[b, :, b] += weight * np.eye(3)
        A[a, :, b] -= weight * frames[a].T @ frames[b]
        A[b, :, a] -= weight * frames[b].T @ frames[a]
    for y, degrees in product(entering(rest, 0.3), (0.0, 40.0, 150.0)):
        pose = turn((1, -2, 0.5), degrees, (0.3, 0.1, -0.5), (0.4, -0.2, 0.7))
        held = np.where((rest.owner == 1)[:, None, None], pose[:, :3], np.eye(3)) @ frames
        poses = np.stack([STILL, pose * (1.5, 1.5, 1.5, 1)])  # only rotations count beyond a handle
        f = rest.solution(
            A.reshape(3 * n, 3 * n), np.zeros((3 * n, 3)), held.swapaxes(1, 2).reshape(-1, 3), 3
        )
        U, _, Vt = np.linalg.svd(f.reshape(n, 3, 3).swapaxes(1, 2) @ frames.swapaxes(1, 2))
        turned = U @ Vt
        e = np.einsum("kab,kb->ka", turned[i] + turned[j], y[i] - y[j]) / 2
        b = np.zeros((n, 3))
        np.add.at(b, i, w[:, None] * e)
        np.add.at(b, j, -w[:, None] * e)
        x = rest.solution(L, b, rest.targets(poses, y))
        energy = half_square(x[i] - x[j] - e, w)
        rest.agrees(rest.solved(sn.RotationInvariantCoordinates, poses, y, laplacian=kind), x, energy)


@pytest.mark.parametrize("name", ["hill", "sphere"])
def test_hierarchical_smoothing_without_levels_has_the_least_second_differences(name: str) -> None:
    """By planes through unfolded triangles, and the share of the Laplacian."""
    rest = Rest(name)
    H = 1e-8 * rest.laplacian("cotan")
    apexes: dict[tuple[int, int], list[int]] = {}
    for t in rest.triangles.tolist():
        for k in range(3):
            a, b = sorted((t[k], t[(k + 1) % 3]))
            apexes.setdefault((a, b), []).append(t[(k + 2) % 3])
    for (a, b), pair in apexes.items():
        if len(pair) < 2:
            continue
        vertices = [a, b, *pair]
        j, k = rest.points[[a, b]]
        length = np.linalg.norm(k - j)
        along = (rest.points[pair] - j) @ (k - j) / length
        away = np.sqrt(((rest.points[pair] - j) ** 2).sum(1) - along**2)
        places = np.array([(0, 0), (length, 0), (along[0], away[0]), (along[1], -away[1])])
        jump = np.zeros(4)  # of the slopes across the edge, for a function that is 1 at one vertex
        for side, sign in ((2, 1), (3, -1)):
            corners = [0, 1, side]
            jump[corners] += sign * np.linalg.inv(np.column_stack([np.ones(3), places[corners]]))[2]
        H[np.ix_(vertices, vertices)] += away[0] * away[1] * np.outer(jump, jump)
    poses = np.stack([STILL, shift(1, -2, 3)])
    x = rest.solution(H, np.zeros((rest.n, 3)), rest.targets(poses, rest.points) - rest.points)
    energy = 0.5 * float(np.trace(x.T @ H @ x))
    rest.agrees(rest.solved(sn.HierarchicalSmoothing, poses, levels=0), rest.points + x, energy, 1e-10)


@pytest.mark.parametrize("transfer", [(0.0, 1.0), (0.0, 0.1, 1.0), (0.0, 1.0, 1.0, 1.0)])
def test_propagation_damps_rotation_scale_and_move_apart_about_the_centre_of_the_handle(transfer) -> None:
    rest = Rest("hill")
    centre = rest.points[rest.handles[1]].mean(0)
    t = np.interp(rest.field(), np.linspace(0, 1, len(transfer)), transfer)
    for degrees in (0.0, 40.0, 170.0):
        pose, R, S = affine(8, degrees)
        move = pose[:, 3].copy()
        pose[:, 3] += centre - pose[:, :3] @ centre
        away = np.einsum("vij,vj->vi", between(t, R, S), rest.points - centre)
        found, _ = rest.solved(sn.Propagation, np.stack([STILL, pose]), transfer=transfer)
        np.testing.assert_allclose(found, centre + away + t[:, None] * move, rtol=0, atol=1e-11)


ORDERS = ((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0.5, 0), (0.3, 1, 2))


PAINTED = 10 ** np.random.default_rng(4).uniform(-2, 2, len(MESHES["hill"][0]))
BLACK = np.where(MESHES["hill"][0][:, 1] > 4, 0.0, 1.0)


def with_term(values: tuple, term: int, painted: np.ndarray) -> list:
    return [painted if k == term else value for k, value in enumerate(values)]


SHELLS = {  # mesh, three stiffnesses, a soft handle, continuity, tolerance
    **{f"stiffness {order}": ("hill", order, False, 2.0, 1e-6) for order in ORDERS},
    "polygons": ("bar", (0.1, 1, 0), False, 2.0, 1e-6),
    **{f"painted {k}": ("hill", with_term((0.2, 0.5, 0.1), k, PAINTED), False, 2.0, 1e-6) for k in range(3)},
    # A contrast of 1e6 costs six more digits.
    **{f"black {k}": ("hill", with_term((0.0, 0.0, 0.0), k, BLACK), False, 2.0, 1e-3) for k in range(2)},
    **{f"continuity {c}": ("hill", (0.3, 1, 2), False, c, 1e-6) for c in (0.4, 1.5)},
    "soft handles": ("hill", (0.2, 1, 0), True, 2.0, 1e-8),  # condition about 1e5
}


@pytest.mark.parametrize("basis", [True, False])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("case", SHELLS)
def test_thin_shell_solves_its_formula(case: str, kind: str, basis: bool) -> None:
    """k_s L + k_b L C/M L + k_v L C/M L C/M L, with stiffnesses on elements and continuity at handles."""
    name, stiffness, soft, continuity, tolerance = SHELLS[case]
    poses = np.stack([STILL, turn((0, 1, 0), 40, (6, 0, 0), (-1, 0.5, 2)), shift(0, 0, 3)])
    poses = poses[: 2 + soft]
    handles = ends(MESHES[name][0], 1.5 if name == "hill" else 1.1)
    weights = [np.ones(len(handle)) for handle in handles]
    if soft:
        weights[1] = np.resize((1.0, 0.0, 0.3, 0.8, 0.55), len(handles[1]))
        handles.append(np.array([38, 39, 40, handles[1][2]]))  # the last one has two handles
        weights.append(np.array([0.5, 0.9, 0.1, 0.3]))
    rest = Rest(name, handles, weights)
    held = rest.owner >= 0
    C = np.where(held, min(continuity, 1.0), 1.0)
    spread = [np.maximum(k, 1e-6 * np.max(k)) * np.ones(rest.n) for k in stiffness]
    L, CM = rest.laplacian(kind), C / rest.mass(kind)

    def smooth(element: list[int]) -> float:
        return max(continuity - 1.0, 0.0) if held[element].all() else 1.0

    stretch = rest.laplacian(kind, lambda e: spread[0][e].mean())
    vary = rest.laplacian(kind, lambda e: spread[2][e].mean() * min(smooth(e), 1.0))
    A = stretch + L @ ((CM * spread[1])[:, None] * L) + L @ (CM[:, None] * vary * CM) @ L
    x, springs = rest.pulled(A, A @ rest.points, rest.points, poses)
    d = x - rest.points
    energy = springs + 0.5 * float(np.trace(d.T @ A @ d))
    terms = dict(zip(("stretching", "bending", "variation"), stiffness))
    shell = sn.ThinShell(rest.mesh, **terms, laplacian=kind, affine_basis=basis)
    shell.set_handles(rest.handles, rest.weights, continuity=[continuity] * len(rest.handles))
    found, report = shell.solve(poses)
    np.testing.assert_allclose(found, x, rtol=0, atol=tolerance)
    assert report.energy == pytest.approx(energy, rel=tolerance)
    assert report.residual < 1e-8
    assert (report.converged, report.iterations) == (True, 1)


@pytest.mark.parametrize("weight", [1.0, 0.6])
def test_a_spline_surface_spreads_what_least_squares_miss_by_a_harmonic_field(weight: float) -> None:
    handles = ends(MESHES["hill"][0], 2.5)
    rest = Rest("hill", handles, [np.ones(len(handles[0])), np.full(len(handles[1]), weight)])
    p, uv = rest.points, rest.points[:, :2]
    B = np.einsum("nj,ni->nji", design(uv[:, 1], 2, 3), design(uv[:, 0], 2, 4)).reshape(rest.n, -1)
    poses = np.stack([STILL, turn((0.3, 1, 0.2), 70, (7, 4, 0), (-1, 0.5, 2))])
    L = positive(rest.laplacian("cotan"))
    W, S, d = np.zeros(rest.n), np.zeros(rest.n), np.zeros((rest.n, 3))
    for pose, handle, w in zip(poses, rest.handles, rest.weights):
        W[handle] = w / len(handle)
        d[handle] = p[handle] @ pose[:, :3].T + pose[:, 3] - p[handle]
    for v, _h, ratio in rest.pulls():
        S[v] = ratio * L[v, v]
    # Every handle is within the margin, and with both ends no control point is left open.
    c = lstsq(np.sqrt(W)[:, None] * B, np.sqrt(W)[:, None] * d)[0]
    gap = d - B @ c
    h = rest.solution(L + np.diag(S), S[:, None] * gap, gap)
    missed = np.sqrt((W[:, None] * gap**2).sum() / (W[:, None] * d**2).sum())
    energy = 0.5 * float(np.trace(h.T @ L @ h)) + half_square(h - gap, S)
    assert missed > 0.01
    assert energy > 1e-3
    words = {"degree": 2, "columns": 4, "rows": 3, "smoothing": 0.0, "margin": 9.0, "uv_map": uv}
    for incoming in (None, p):  # with the basis, and without
        found, report = rest.solved(sn.SplineSurface, poses, incoming, **words)
        np.testing.assert_allclose(found, p + B @ c + h, rtol=0, atol=1e-9)
        assert report.residual == pytest.approx(missed, abs=1e-9)
        assert report.energy == pytest.approx(energy, rel=1e-8)


def test_moved_grid_points_add_their_spline_and_soft_handles_pull_against_it() -> None:
    points = MESHES["two parts"][0]
    handles = ends(points, 2.5)
    rest = Rest("two parts", handles, [np.ones(len(handles[0])), np.full(len(handles[1]), 0.6)])
    L, S = positive(rest.laplacian("cotan")), np.zeros(rest.n)
    for v, _h, ratio in rest.pulls():
        S[v] = ratio * L[v, v]
    moves = np.random.default_rng(3).uniform(-1, 1, (60, 3))  # of two grids
    spline, half = np.zeros((rest.n, 3)), rest.n // 2
    for part in (0, 1):
        u, v = points[part * half :][:half, :2].T
        B = np.einsum("nj,ni->nji", design(v, 2, 5), design(u, 2, 6)).reshape(half, -1)
        spline[part * half :][:half] = B @ moves[30 * part :][:30]
    h = rest.solution(L + np.diag(S), -S[:, None] * spline, -spline)
    surface = sn.SplineSurface(rest.mesh, degree=2, columns=6, rows=5, margin=9.0, uv_map=points[:, :2])
    surface.set_handles(rest.handles, rest.weights)
    poses = np.stack([STILL, turn((0, 1, 0), 40, (6, 0, 0), (-1, 0.5, 2))])
    expected = surface.solve(poses)[0] + spline + h
    np.testing.assert_allclose(surface.solve(poses, grid=moves)[0], expected, rtol=0, atol=1e-10)


@pytest.mark.parametrize(("kind", "sharpness"), list(product(KINDS, (0.0, 0.7))))
def test_a_silhouette_sketch_is_the_least_squares_solution_of_the_paper(kind: str, sharpness: float) -> None:
    rest = Rest("hill", [np.flatnonzero(np.abs(MESHES["hill"][0][:, 0] - 4) > 3.5)])
    p, weight = rest.points, 0.9
    pairs = edges_of(rest.faces)
    a, b = p[pairs[:, 0]], p[pairs[:, 1]]
    across = ((a[:, 0] < 3.4) != (b[:, 0] < 3.4)) & (np.abs(a[:, 1] - b[:, 1]) < 0.5)
    edges, a, b = pairs[across], a[across], b[across]
    shares = (3.4 - a[:, 0]) / (b[:, 0] - a[:, 0])
    targets = (1 - shares[:, None]) * p[edges[:, 0]] + shares[:, None] * p[edges[:, 1]]
    targets[:, 2] += 0.8 * np.sin(0.4 * targets[:, 1]) + 0.1
    L, m = rest.laplacian(kind), rest.mass(kind)
    rows, diagonal = L / np.sqrt(m)[:, None], np.diag(L @ (L / m[:, None]))
    scale = np.where(np.isin(np.arange(rest.n), edges), 1 + sharpness, 1.0)
    s = weight / (1 - weight) * ((1 - shares) * diagonal[edges[:, 0]] + shares * diagonal[edges[:, 1]])
    pulled = np.zeros((len(edges), rest.n))
    pulled[np.arange(len(edges)), edges[:, 0]] = 1 - shares
    pulled[np.arange(len(edges)), edges[:, 1]] = shares
    A = np.concatenate([rows, np.sqrt(s)[:, None] * pulled])
    aims = np.concatenate([scale[:, None] * (rows @ p), np.sqrt(s)[:, None] * targets])
    x = p.copy()
    held = rest.owner >= 0
    x[~held] = lstsq(A[:, ~held], aims - A[:, held] @ p[held])[0]
    words = {"laplacian": kind, "refits": 0, "sharpness": sharpness, "weight": weight}
    found = sn.SilhouetteSketch(rest.mesh, edges, shares, np.flatnonzero(held), **words).solve(targets)
    np.testing.assert_allclose(found, x, rtol=0, atol=1e-9)  # condition numbers of some 1e5


@pytest.mark.parametrize(
    ("name", "scheme"),
    [("bar", "catmull_clark"), ("hill", "catmull_clark"), ("hill", "loop"), ("sphere", "loop")],
)
def test_the_control_mesh_of_subdivision_editing_is_the_nearest_one(name: str, scheme: str) -> None:
    surface = sn.SubdivisionSurface(Rest(name).mesh, scheme=scheme, level=1)
    smooth = surface.refine(MESHES[name][0])
    sculpted = smooth + np.random.default_rng(9).uniform(-0.2, 0.2, smooth.shape)
    editing = sn.SubdivisionEditing(sn.SurfaceMesh(sculpted, surface.faces), coarsening="levels", levels=1)
    editing.set_handles([[0]])
    expected = lstsq(surface.matrix.toarray(), sculpted)[0]
    np.testing.assert_allclose(editing.control_mesh().points, expected, rtol=0, atol=1e-11)


def test_subdivision_editing_moves_its_control_mesh_as_a_thin_plate() -> None:
    """Translations turn no detail: where no band reaches, far from handles, there is S (y + u) alone."""
    rest, move = Rest("bar"), np.array([1.0, -2.0, 3.0])
    surface = sn.SubdivisionSurface(rest.mesh, level=2)
    S = surface.matrix.toarray()
    fine = S @ rest.points
    handles = ends(fine, 1.3)
    editing = sn.SubdivisionEditing(sn.SurfaceMesh(fine, surface.faces), coarsening="levels", levels=2)
    editing.set_handles(handles)
    L, held = rest.laplacian("cotan_voronoi"), np.concatenate(handles)
    K = L @ (L / rest.mass("cotan_voronoi")[:, None])
    goals = np.repeat([np.zeros(3), move], [len(handle) for handle in handles], axis=0)
    mean, pulls = goals.mean(0), (1e4 * S[held] @ np.diag(K))[:, None] * S[held]
    u = np.linalg.solve(K + S[held].T @ pulls, pulls.T @ (goals - mean))
    expected = S @ (rest.points + u + mean)
    found, _ = editing.solve([STILL, shift(*move)])
    free = abs(fine[:, 0] - 3) < 0.6
    assert free.sum() > 50
    assert np.linalg.norm(expected - fine, axis=1)[free].max() > 1
    # Pulls are 1e6 times as stiff as the plate.
    np.testing.assert_allclose(found[free], expected[free], rtol=0, atol=1e-8)
