# SPDX-License-Identifier: GPL-3.0-or-later
"""Green coordinates of quads as bilinear patches, next to SciPy's adaptive quadrature."""

import numpy as np
import pytest
from scipy.integrate import dblquad

import sinew_native as sn

from ..cages import CUBE, QUADS

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

    def pole(factor, s: float, t: float) -> float:
        return factor(s, t) / np.linalg.norm(patch(corners, s, t)[1] - x) / (4 * np.pi)

    factors = (lambda s, t: 1.0, lambda s, t: s, lambda s, t: t)
    phi = [integral(lambda s, t, k=k: layer(k, s, t)) for k in range(4)]
    psi = [integral(lambda s, t, factor=factor: pole(factor, s, t)) for factor in factors]
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
    green = sn.Green(cage, faces="quads", precision="double")
    green.bind(points)
    normals = []
    for corners in QUADS:
        middle = patch(cage.points[corners], 0, 0)[2]
        normals += [middle, patch(cage.points[corners], 1, 0)[2] - middle]
        normals += [patch(cage.points[corners], 0, 1)[2] - middle]
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
    image = points.copy()
    image[:, 1] = 2 * middle[1] - image[:, 1]

    def bias(faces: str) -> float:
        shapes = []
        for some in (points, image):
            green = sn.Green(cage, faces=faces, precision="double")
            green.bind(some)
            shapes.append(green.warp(pose))
        shapes[1][:, 1] = 2 * middle[1] - shapes[1][:, 1]
        return np.abs(shapes[0] - shapes[1]).max()

    assert bias("quads") < 1e-13
    assert bias("triangles") > 1e-3
