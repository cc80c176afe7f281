# SPDX-License-Identifier: GPL-3.0-or-later
"""Cage coordinates next to quadrature, to the papers' formulas with 60 digits, and to finite differences."""

import numpy as np
import pytest
from scipy import sparse
from scipy.integrate import dblquad
from scipy.sparse.linalg import splu

import sinew_native as sn

from ..cages import CUBE, QUADS, bound, u_prism
from ..meshes import sphere, turn
from ..oracles import cage_oracles


def bumpy(level: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    points, faces = sphere(level)
    return points + np.random.default_rng(seed).uniform(-0.1, 0.1, points.shape), faces


EVERY_CAGE = pytest.mark.parametrize(
    "cage", [*(sn.SurfaceMesh(*each) for each in (bumpy(0, 1), bumpy(1, 2), (CUBE, QUADS))), u_prism()]
)


def inside(cage: sn.SurfaceMesh, count: int, seed: int = 0) -> np.ndarray:
    low, high = cage.points.min(0), cage.points.max(0)
    points = np.random.default_rng(seed).uniform(low, high, (40 * count, 3))
    outside = sn.MeanValue(cage).bind(points).outside
    return np.delete(points, outside, 0)[:count]


def away_from_faces(cage: sn.SurfaceMesh, count: int) -> np.ndarray:
    """Where 60 x 60 Gauss points a triangle leave some 1e-12."""
    points = inside(cage, 30 * count)
    corners = cage.points[cage.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    heights = np.abs(np.einsum("ntk,tk->nt", points[:, None] - corners[None, :, 0], normals)).min(1)
    return points[np.argsort(-heights)[:count]]


@EVERY_CAGE
def test_mean_value_is_the_integral_over_the_sphere(cage: sn.SurfaceMesh) -> None:
    points = away_from_faces(cage, 5)
    weights = bound(sn.MeanValue, cage, points).vertex_weights
    expected = [cage_oracles.mean_value_by_quadrature(cage.points, cage.triangles, x) for x in points]
    np.testing.assert_allclose(weights, expected, rtol=0, atol=1e-9)


@EVERY_CAGE
def test_green_are_the_layers_of_its_identity(cage: sn.SurfaceMesh) -> None:
    points = away_from_faces(cage, 5)
    green = bound(sn.Green, cage, points)
    phi, psi = zip(*(cage_oracles.green_by_quadrature(cage.points, cage.triangles, x) for x in points))
    np.testing.assert_allclose(green.vertex_weights, phi, rtol=0, atol=1e-9)
    np.testing.assert_allclose(green.face_weights, psi, rtol=0, atol=1e-9)


def near(cage: sn.SurfaceMesh, distance: float, count: int = 4) -> np.ndarray:
    """Near vertices, edges, faces, and the lines and planes beyond them, at both sides."""
    rng = np.random.default_rng(5)
    found = []
    for a, b, c in cage.points[cage.triangles[:: max(1, len(cage.triangles) // count)]]:
        normal = np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a))
        for shares in ((1, 0, 0), (0.3, 0.7, 0), (0.2, 0.3, 0.5), (-0.7, 1.7, 0), (-1.1, 1.7, 0.4)):
            at = shares @ np.array([a, b, c])
            away = distance * (normal + 0.3 * rng.normal(size=3))
            found += [at + away, at - away]
    return np.array(found)


@pytest.mark.parametrize("distance", [1e-3, 1e-6, 1e-10, 1e-13])
def test_mean_value_is_exact_however_near_the_faces(distance: float) -> None:
    for cage in (sn.SurfaceMesh(*bumpy(0, 1)), u_prism()):
        points = near(cage, distance)
        expected = [cage_oracles.exact_mean_value(cage.points, cage.triangles, x) for x in points]
        found = bound(sn.MeanValue, cage, points).vertex_weights
        np.testing.assert_allclose(found, expected, rtol=0, atol=2e-12)


@pytest.mark.parametrize("distance", [1e-3, 1e-6, 1e-10])
def test_green_is_exact_however_near_the_faces(distance: float) -> None:
    for cage in (sn.SurfaceMesh(*bumpy(0, 1)), u_prism()):
        points = near(cage, distance)
        green = sn.Green(cage, precision="double")
        outside = set(green.bind(points).outside.tolist())
        weights = green.vertex_weights, green.face_weights
        assert len(outside) < len(points)
        for i in set(range(len(points))) - outside:
            exact = cage_oracles.exact_green(cage.points, cage.triangles, points[i])
            for ours, theirs in zip(weights, exact, strict=True):
                np.testing.assert_allclose(ours[i], theirs, rtol=0, atol=2e-12)


PLACE = [(0.1, 0.2, 0.3), (0.0, 0.0, 0.0)]


@pytest.mark.parametrize(
    ("method", "options", "weights", "tolerance"),
    [
        (sn.MeanValue, {}, (0.18652452, 0.08652452, 0.26392439, 0.06392439, 0.34955109, 0.04955109), 5e-9),
        (sn.PositiveMeanValue, {}, (0.186525, 0.086525, 0.263924, 0.063924, 0.349551, 0.049551), 6e-7),
        (sn.Green, {}, (0.179152, 0.117171, 0.228739, 0.099816, 0.288111, 0.087011), 6e-7),
        (sn.Harmonic, {"solver": "boundary"}, (0.19001, 0.09001, 0.26375, 0.06375, 0.34624, 0.04624), 1.5e-5),
        (sn.Harmonic, {"solver": "lattice"}, (0.19001, 0.09001, 0.26375, 0.06375, 0.34624, 0.04624), 3e-4),
    ],
)
def test_weights_in_the_octahedron_are_the_known_ones(method, options, weights, tolerance) -> None:
    """To the digits given; a lattice is of second order."""
    coordinates = bound(method, sn.SurfaceMesh(*sphere(0)), np.array(PLACE), **options)
    np.testing.assert_allclose(coordinates.vertex_weights[0], weights, rtol=0, atol=tolerance)
    np.testing.assert_allclose(coordinates.vertex_weights[1], 1 / 6, rtol=0, atol=tolerance)
    if method is sn.Green:
        np.testing.assert_allclose(coordinates.face_weights[1], 0.09963226, rtol=0, atol=5e-9)


def by_rays(vertices: np.ndarray, triangles: np.ndarray, x: np.ndarray, count: int = 20_000) -> np.ndarray:
    """The first face along each ray of a spiral counts, by its hat functions over its distance."""
    k = np.arange(count)
    z, angle = 1 - (2 * k + 1) / count, 2.399963229728653 * k  # the golden angle
    way = np.stack([np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z], 1)
    way = way @ turn((1, 2, 3), 10)[:, :3]  # off the planes of the faces
    nearest, hats = np.full(count, np.inf), np.zeros((count, len(vertices)))
    for corners in triangles:
        a, b, c = vertices[corners]  # x + s way = a + u (b - a) + v (c - a)
        sides = np.stack(np.broadcast_arrays(way, a - b, a - c), 2)
        s, u, v = np.linalg.solve(sides, np.broadcast_to(a - x, way.shape)[..., None])[..., 0].T
        first = (s > 0) & (s < nearest) & (u >= 0) & (v >= 0) & (u + v <= 1)
        nearest[first], hats[first] = s[first], 0
        hats[np.ix_(first, corners)] = np.stack([1 - u - v, u, v], 1)[first]
    total = (hats / nearest[:, None]).sum(0)
    return total / total.sum()


def test_positive_mean_value_is_what_rays_see_first() -> None:
    """20,000 rays are .025 apart; an edge cuts the square of that wrongly, times the edges in sight."""
    points, faces = sphere(1)
    spiky = sn.SurfaceMesh(points * np.random.default_rng(4).uniform(0.3, 1, (len(points), 1)), faces)
    far = np.array([(0.5, 2.5, 0.5), (1.5, 0.5, 0.5), (0.2, 0.3, 0.7)])
    for cage, places in ((u_prism(), far), (spiky, 0.1 * far / 2.5)):
        weights = bound(sn.PositiveMeanValue, cage, places).vertex_weights
        expected = [by_rays(cage.points, cage.triangles, x) for x in places]
        np.testing.assert_allclose(weights, expected, rtol=0, atol=3e-4)
    assert bound(sn.MeanValue, u_prism(), far).vertex_weights.min() == pytest.approx(-0.0068, abs=5e-5)


FLAG = np.array([(0, 0, 0), (4, 0, 0), (4, 3, 0), (2.5, 1, 0), (1, 3, 0), (0, 2.5, 0)])


def test_flat_mean_value_is_the_integral_of_the_border_over_all_directions() -> None:
    """Seen from a point in a convex cage, of the hat of each vertex over the distance."""
    corners, x = np.array([(0, 0, 0), (3, -0.5, 0), (4, 2, 0), (1, 3, 0)]), np.array([(1.7, 1.1, 0)])
    angle = 2 * np.pi * (np.arange(400_000) + 0.5) / 400_000
    ray, total = np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1), np.zeros(4)
    for e, (a, b) in enumerate(zip(corners - x, np.roll(corners, -1, 0) - x)):
        to_a, to_b = np.cross(a, ray)[:, 2], np.cross(ray, b)[:, 2]
        seen = (to_a >= 0) & (to_b >= 0)
        share = (to_a / (to_a + to_b))[seen, None]
        distance = np.linalg.norm((1 - share) * a + share * b, axis=1)[:, None]
        total[[e, (e + 1) % 4]] += ((1 - share) / distance).sum(), (share / distance).sum()
    ours = bound(sn.MeanValue, sn.SurfaceMesh(corners, [[0, 1, 2, 3]]), x).vertex_weights
    np.testing.assert_allclose(ours[0], total / total.sum(), rtol=0, atol=1e-9)


def test_flat_green_are_the_layers_of_its_identity() -> None:
    """The unit of length adds a constant to the poles, which a closed outline does not feel."""
    x = np.array([(1.2, 1.1, 0), (3.4, 0.7, 0)])
    green = bound(sn.Green, sn.SurfaceMesh(FLAG, [range(6)]), x)
    node, weight = np.polynomial.legendre.leggauss(200)
    t, size = (node[:, None] + 1) / 2, np.linalg.norm(np.ptp(FLAG, axis=0))
    edges = [(0, 1), (5, 0), (1, 2), (2, 3), (3, 4), (4, 5)]  # by their lower vertex
    for place, phi, psi in zip(x, green.vertex_weights, green.face_weights, strict=True):
        vertices = np.zeros(6)
        for e, (i, j) in enumerate(edges):
            a, b = FLAG[i], FLAG[j]
            r, share = a + t * (b - a) - place, weight * np.linalg.norm(b - a) / (4 * np.pi)
            outward = np.cross(b - a, (0, 0, 1)) / np.linalg.norm(b - a)
            layer = share * (r @ outward) / (r**2).sum(1)
            vertices[[i, j]] += (1 - t[:, 0]) @ layer, t[:, 0] @ layer
            pole = -(share * np.log(np.linalg.norm(r, axis=1) / size)).sum()
            assert psi[e] == pytest.approx(pole, abs=1e-11)
        np.testing.assert_allclose(phi, vertices, rtol=0, atol=1e-11)
        assert phi.sum() == pytest.approx(1.0, abs=1e-14)


SPACE_METHODS = (sn.MeanValue, sn.Green, sn.PositiveMeanValue, sn.Harmonic)


@pytest.mark.parametrize("method", SPACE_METHODS)
def test_single_precision_is_a_millionth_off_at_most(method: type) -> None:
    cage = sn.SurfaceMesh(*bumpy(1, 5))
    points = inside(cage, 1000)
    pose = cage.points + np.random.default_rng(6).uniform(-0.3, 0.3, cage.points.shape)
    single = method(cage)
    single.bind(points)
    double = bound(method, cage, points)
    size = np.linalg.norm(np.ptp(cage.points, axis=0))
    assert np.abs(single.warp(pose) - double.warp(pose)).max() < 1e-6 * size
    # Half a unit of a weight of up to 1.
    assert np.abs(single.vertex_weights - double.vertex_weights).max() < 1e-7


@pytest.mark.parametrize("method", SPACE_METHODS)
def test_open_cages_and_thresholds_that_are_no_number_are_refused(method: type) -> None:
    with pytest.raises(sn.InvalidMesh, match="open") as error:
        method(sn.SurfaceMesh(CUBE, QUADS[1:]))
    assert sorted(error.value.elements) == [0, 1, 2, 3]
    with pytest.raises(sn.InvalidOption, match="threshold"):
        method(sn.SurfaceMesh(CUBE, QUADS), threshold=np.nan).bind(CUBE)
    with pytest.raises(TypeError):
        method(sn.SurfaceMesh(CUBE, QUADS), threshold=None)


def test_faces_and_numbers_of_directions_that_there_are_not_are_refused() -> None:
    cage = sn.SurfaceMesh(CUBE, QUADS)
    for wrong in (6, 7, -1):
        with pytest.raises(sn.InvalidOption):
            sn.Green(cage, outside="face", exit_face=wrong)
    for count in (7, 9, 0, -1024):
        with pytest.raises(sn.InvalidOption):
            sn.PositiveMeanValue(cage, exact=False, directions=count)


SIGNS = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=np.float64)


def twisted() -> sn.SurfaceMesh:
    """A cube whose corners have moved, so that no side is flat."""
    return sn.SurfaceMesh(CUBE + np.random.default_rng(2).uniform(-0.2, 0.2, CUBE.shape), QUADS)


def patch(corners: np.ndarray, s: float, t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The bilinear weights (4,), the point, and the normal dP/ds x dP/dt."""
    weights = (1 + SIGNS[:, 0] * s) * (1 + SIGNS[:, 1] * t) / 4
    to_s = (SIGNS[:, 0] * (1 + SIGNS[:, 1] * t) / 4) @ corners
    to_t = (SIGNS[:, 1] * (1 + SIGNS[:, 0] * s) / 4) @ corners
    return weights, weights @ corners, np.cross(to_s, to_t)


def by_scipy(corners: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """phi of the corners, and the integrals of 1, s and t over 4 pi r."""

    def integral(value) -> float:
        return dblquad(lambda t, s: value(s, t), -1, 1, -1, 1, epsabs=1e-9, epsrel=1e-9)[0]

    def layer(k: int, s: float, t: float) -> float:
        weights, p, normal = patch(corners, s, t)
        return weights[k] * (p - x) @ normal / np.linalg.norm(p - x) ** 3 / (4 * np.pi)

    def pole(k: int, s: float, t: float) -> float:
        return (1.0, s, t)[k] / np.linalg.norm(patch(corners, s, t)[1] - x) / (4 * np.pi)

    phi = [integral(lambda s, t, k=k: layer(k, s, t)) for k in range(4)]
    psi = [integral(lambda s, t, k=k: pole(k, s, t)) for k in range(3)]
    return np.array(phi), np.array(psi)


@pytest.mark.slow
@pytest.mark.parametrize("x", [(0.3, -0.2, 0.4), (0.1, 0.2, 0.65)])
def test_phi_and_psi_are_the_layers_of_greens_identity(x: tuple) -> None:
    cage = twisted()
    points = cage.points.mean(0) + np.array([x]) * np.ptp(cage.points, axis=0).min() / 2
    green = sn.Green(cage, faces="quads", precision="double")
    assert not len(green.bind(points).outside)
    phi = np.zeros(len(cage.points))
    for q, corners in enumerate(QUADS):
        parts, psi = by_scipy(cage.points[corners], points[0])
        phi[corners] += parts
        np.testing.assert_allclose(green.face_weights[0, 3 * q : 3 * q + 3], psi, rtol=0, atol=1e-8)
    np.testing.assert_allclose(green.vertex_weights[0], phi, rtol=0, atol=1e-8)


def test_the_identity_reproduces_the_point() -> None:
    cage = twisted()
    points = cage.points.mean(0) + np.random.default_rng(1).uniform(-0.2, 0.2, (50, 3))
    green = bound(sn.Green, cage, points, faces="quads")
    normals = []
    for corners in QUADS:
        middle, to_s, to_t = (patch(cage.points[corners], s, t)[2] for s, t in ((0, 0), (1, 0), (0, 1)))
        normals += [middle, to_s - middle, to_t - middle]
    np.testing.assert_allclose(green.vertex_weights.sum(1), 1, rtol=0, atol=1e-14)
    there = green.vertex_weights @ cage.points + green.face_weights @ np.array(normals)
    np.testing.assert_allclose(there, points, rtol=0, atol=1e-14)


def test_a_quad_has_no_diagonal() -> None:
    """A pose that is its own mirror image gives shapes that are; two triangles show where they were cut."""
    cage = sn.SurfaceMesh(CUBE, QUADS)
    middle = CUBE.mean(0)
    offset = CUBE - middle
    pose = CUBE + np.where((offset[:, :1] > 0) & (offset[:, 2:] > 0), offset * (0.5, -0.4, 0.3), 0.0)
    points = middle + np.random.default_rng(3).uniform(-0.4, 0.4, (200, 3))

    def mirrored(x: np.ndarray) -> np.ndarray:
        return x * (1, -1, 1) + (0, 2 * middle[1], 0)

    def bias(faces: str) -> float:
        one, other = (bound(sn.Green, cage, x, faces=faces).warp(pose) for x in (points, mirrored(points)))
        return np.abs(one - mirrored(other)).max()

    assert bias("quads") < 1e-13
    assert bias("triangles") > 1e-3


CAPS = [(0, 1, 4), (0, 4, 5), (1, 2, 3), (1, 3, 4), (0, 5, 6), (0, 6, 7)]  # triangles of the outline


def capped() -> sn.SurfaceMesh:
    """Of triangles."""
    quads = u_prism(CAPS)
    return sn.SurfaceMesh(quads.points, quads.triangles)


def on_surface(points: np.ndarray) -> np.ndarray:
    """(n, 16) the vertices as linear functions on the triangles, for points on these."""
    cage, found = capped(), np.zeros((len(points), 16))
    for corners in cage.triangles:
        a, b, c = cage.points[corners]
        frame = np.column_stack([b - a, c - a, np.cross(b - a, c - a)])
        u, v, away = np.linalg.solve(frame, (points - a).T)
        holds = (abs(away) < 1e-9) & (np.minimum(u, v) > -1e-9) & (u + v < 1 + 1e-9)
        found[holds] = 0.0
        found[np.ix_(holds, corners)] = np.stack([1 - u - v, u, v], 1)[holds]
    return found


def by_differences(cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes inside the U and the harmonic functions there, by the seven-point Laplacian on an even grid."""
    x, y, z = (part.ravel() for part in np.mgrid[: 3 * cells + 1, : 3 * cells + 1, : cells + 1])
    hollow = (x > cells) & (x < 2 * cells) & (y > cells)
    rim = (x == 0) | (x == 3 * cells) | (y == 0) | (y == 3 * cells)
    rim |= ((x == cells) | (x == 2 * cells)) & (y >= cells)
    rim |= (y == cells) & (x >= cells) & (x <= 2 * cells)
    used = ~hollow
    free = used & ~rim & (z > 0) & (z < cells)
    nodes = np.stack((x, y, z), -1) / cells
    data = np.zeros((len(x), 16))
    data[used & ~free] = on_surface(nodes[used & ~free])
    strides = ((3 * cells + 1) * (cells + 1), cells + 1, 1)
    at = np.flatnonzero(free)
    number = np.full(len(x), -1)
    number[at] = np.arange(len(at))
    matrix = sparse.identity(len(at), format="csr") * 6.0
    right = np.zeros((len(at), 16))
    for step in (*strides, *(-stride for stride in strides)):
        beside = at + step
        linked = number[beside] >= 0
        entries = np.ones(linked.sum()), (np.flatnonzero(linked), number[beside[linked]])
        matrix -= sparse.csr_matrix(entries, shape=(len(at), len(at)))
        right[~linked] += data[beside[~linked]]
    solution = splu(matrix.tocsc()).solve(right)
    return nodes[at], solution


def test_finite_differences_converge_to_harmonic() -> None:
    errors = []
    for cells in (5, 10):
        nodes, expected = by_differences(cells)
        harmonic = bound(sn.Harmonic, capped(), nodes, quality="medium")
        errors.append(np.abs(harmonic.vertex_weights - expected).max(axis=1))
    coarse, fine = errors
    # The grid errs by h^(2/3) at the two edges of 270 degrees, by h^2 log h elsewhere: 1.6 to 4 a halving.
    assert fine.max() < 4e-2
    assert fine.mean() < 2e-3
    assert coarse.mean() > 1.6 * fine.mean()


def test_the_report_tells_the_quality() -> None:
    x = np.random.default_rng(0).uniform((0.05, 0.05, 0.05), (0.95, 2.95, 0.95), (20, 3))
    for solver in ("boundary", "lattice"):
        steps, weights = [], []
        for quality in ("fast", "medium"):
            harmonic = sn.Harmonic(capped(), quality=quality, solver=solver, precision="double")
            assert harmonic.unknowns == 0
            steps.append((harmonic.bind(x).error, harmonic.residual_rms, harmonic.unknowns))
            weights.append(harmonic.vertex_weights)
        (error, rms, unknowns), (finer_error, finer_rms, more) = steps
        assert 0 < finer_error < error
        assert unknowns < more
        difference = np.abs(weights[1] - weights[0]).max()
        assert 0.02 * error < difference < 2 * error
        if solver == "boundary":
            assert unknowns <= 1000 < more <= 2000
            assert 0 < finer_rms < rms <= harmonic.residual_max < 0.02
        else:
            assert harmonic.residual_max == 0
