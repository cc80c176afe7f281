# SPDX-License-Identifier: GPL-3.0-or-later
"""Curvatures against closed forms: how fast errors fall (Figure 2), signs, forms, refusals."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import sinew_native as sn

from ..meshes import grid, messy, sphere, torus


def saddle_curvatures(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    g = 1 + 4 * x**2 + 4 * y**2
    H, K = 4 * (x**2 - y**2) / g**1.5, -4 / g**2
    return H - np.sqrt(H**2 - K), H + np.sqrt(H**2 - K)


def spun(u, radius, height) -> np.ndarray:
    return np.stack([radius * np.cos(u), radius * np.sin(u), height], -1)


# Each from u and v in [0, 1]: points with x_u, x_v and the outer normal right-handed, and both curvatures.
SURFACES = {
    "sphere": (lambda u, v: spun(u, np.cos(v), np.sin(v)), lambda u, v: (1 + 0 * u, 1 + 0 * u)),
    "cylinder": (lambda u, v: spun(u, 1, v), lambda u, v: (0 * u, 1 + 0 * u)),
    "torus": (
        lambda u, v: spun(u, 2 + np.cos(v + 1.2), np.sin(v + 1.2)),
        lambda u, v: (np.cos(v + 1.2) / (2 + np.cos(v + 1.2)), 1 + 0 * u),
    ),
    "catenoid": (
        lambda u, v: spun(u, np.cosh(v - 0.3), v),
        lambda u, v: (-(np.cosh(v - 0.3) ** -2), np.cosh(v - 0.3) ** -2),
    ),
    "saddle": (
        lambda u, v: np.stack([u - 0.5, v - 0.3, (u - 0.5) ** 2 - (v - 0.3) ** 2], -1),
        lambda u, v: saddle_curvatures(u - 0.5, v - 0.3),
    ),
}


def sampled(name: str, n: int):
    """An irregular mesh of n x n cells: u, v, faces, points, curvatures (n, 2)."""
    place, bends = SURFACES[name]
    corners, faces = grid(n)
    u, v = corners[:, :2].T / n
    return u, v, faces, place(u, v), np.stack(bends(u, v), -1)


def falls(errors: list[np.ndarray], factor: float) -> None:
    sizes = [np.sqrt((error**2).mean()) for error in errors]
    assert all(b < a / factor or b < 1e-10 for a, b in pairwise(sizes)), sizes


@pytest.mark.parametrize("name", SURFACES)
def test_each_halving_of_the_edges_leaves_a_quarter_of_the_error(name: str) -> None:
    """Of the surface between the vertices, as Figure 2 shows, of its curvatures, normals and directions."""
    away, bends, border, turned = [], [], [], []
    for n in (12, 24, 48):
        u, v, faces, points, exact = sampled(name, n)
        found = sn.curvature(sn.SurfaceMesh(points, faces))
        inner = np.minimum(np.minimum(u, 1 - u), np.minimum(v, 1 - v)) > 0.15
        away.append(points[faces].mean(1) - SURFACES[name][0](u[faces].mean(1), v[faces].mean(1)))
        bends.append((found.principal - exact)[inner])
        border.append((found.principal - exact)[~inner])
        if name == "torus":
            along_u, outward = spun(u + np.pi / 2, 1, 0 * u), points - spun(u, 2, 0 * u)
            turned.append(
                np.array([np.cross(found.directions[:, 0], along_u), found.normals - outward])[:, inner]
            )
    for errors in (away, bends, border, turned):
        falls(errors, 3.3)  # a quarter, but for the random places of the vertices


def test_mean_and_gaussian_curvature_quarter_on_a_regular_torus_and_sum_up_on_every_surface() -> None:
    errors = []
    for n in (16, 32, 64):
        points, faces = torus(2 * n, n)
        found = sn.curvature(mesh := sn.SurfaceMesh(points, faces))
        small = 1 - 3 / np.hypot(points[:, 0], points[:, 1])  # cos v / (3 + cos v)
        errors.append(np.concatenate([found.mean - (1 + small) / 2, found.gaussian - small]))
        assert abs(sn.mass(mesh) @ found.gaussian) < 1e-9
    falls(errors, 3.5)
    ball = sn.SurfaceMesh(sphere(3)[0] * (1, 2, 3), sphere(3)[1])
    np.testing.assert_allclose(sn.mass(ball) @ sn.curvature(ball).gaussian, 4 * np.pi, rtol=1e-12)


def test_curvature_follows_the_surface_and_its_faces() -> None:
    _, _, faces, points, _ = sampled("torus", 12)
    found = sn.curvature(sn.SurfaceMesh(points, faces))
    R = Rotation.from_euler("xyz", (0.3, 1.1, -2)).as_matrix()
    moved = sn.curvature(sn.SurfaceMesh(2 * points @ R.T + (5, -3, 1), faces))
    back = sn.curvature(sn.SurfaceMesh(points, faces[:, ::-1]))
    for name, power in (("mean", 1), ("gaussian", 2), ("principal", 1)):
        np.testing.assert_allclose(getattr(moved, name) * 2**power, getattr(found, name), atol=1e-8)
    np.testing.assert_allclose(moved.normals @ R, found.normals, atol=1e-10)
    np.testing.assert_allclose(back.mean, -found.mean, atol=1e-9)
    np.testing.assert_allclose(back.principal, -found.principal[:, ::-1], atol=1e-8)


def test_forms_give_the_curvature_in_every_direction() -> None:
    """Euler's formula, and K = det II / det I."""
    _, _, faces, points, _ = sampled("catenoid", 12)
    found = sn.curvature(sn.SurfaceMesh(points, faces))
    first, second = found.first_form, found.second_form
    np.testing.assert_allclose(first, np.einsum("nik,njk->nij", found.tangents, found.tangents), atol=1e-12)
    np.testing.assert_allclose(
        np.linalg.det(second) / np.linalg.det(first), found.principal.prod(1), atol=1e-10
    )
    angle = np.linspace(0, 3, len(points))
    d = np.cos(angle)[:, None] * found.directions[:, 0] + np.sin(angle)[:, None] * found.directions[:, 1]
    euler = np.cos(angle) ** 2 * found.principal[:, 0] + np.sin(angle) ** 2 * found.principal[:, 1]
    np.testing.assert_allclose(found.along(7 * d + 2 * found.normals), euler, atol=1e-10)
    np.testing.assert_array_equal(found.along(0 * d), 0)
    frame = np.linalg.det(np.concatenate([found.directions, found.normals[:, None]], 1))
    np.testing.assert_allclose(frame, 1, atol=1e-12)


def test_curvature_of_odd_meshes_is_finite_and_flat_ones_have_none() -> None:
    points, faces = messy()
    found = sn.curvature(sn.SurfaceMesh(points, faces))
    for name in ("mean", "gaussian", "principal", "directions", "normals", "first_form", "second_form"):
        assert np.isfinite(getattr(found, name)).all(), name
    assert found.mean[-1] == found.gaussian[-1] == 0, "the loose vertex"
    flat = sn.curvature(sn.SurfaceMesh(points[:81] * (1, 1, 0), grid(8)[1]))
    assert abs(flat.principal).max() < 1e-12 > abs(flat.mean).max()
    line = sn.curvature(sn.SurfaceMesh(np.arange(12.0).reshape(4, 3), [(0, 1, 2), (1, 2, 3)]))
    assert not line.principal.any()
    assert not line.along(np.ones((4, 3))).any()
    turn, k = np.linspace(0, 2 * np.pi, 3000, endpoint=False), np.arange(3000)
    ring = np.column_stack([np.cos(turn), np.sin(turn)])
    tube = np.vstack([np.column_stack([ring, 0 * k + z]) for z in (0, 0.1)])
    sides = np.column_stack([k, np.roll(k, -1), np.roll(k, -1) + 3000, k + 3000])
    counts = [4] * 3000 + [3000] * 2  # with two caps, in which each corner has all the others for neighbours
    capped = sn.SurfaceMesh(tube, (counts, np.concatenate([sides.ravel(), k[::-1], k + 3000])))
    assert np.isfinite(sn.curvature(capped).principal).all()
    with pytest.raises(sn.InvalidOption, match="rings: 0 is below 1"):
        sn.curvature(sn.SurfaceMesh(points, faces), rings=0)
    for wrong in (points[1:], points[:, :2], points + np.nan):
        with pytest.raises(sn.InvalidOption, match="directions"):
            found.along(wrong)
