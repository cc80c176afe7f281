# SPDX-License-Identifier: GPL-3.0-or-later
"""Mean value and Green coordinates next to quadrature and to the papers' formulas with 60 digits."""

import numpy as np
import pytest

import sinew_native as sn

from .cage_oracles import exact_green, exact_mean_value, green_by_quadrature, mean_value_by_quadrature
from .cages import CUBE, QUADS, bound, u_prism
from .meshes import sphere

BOTH = pytest.mark.parametrize("method", [sn.MeanValue, sn.Green])


def bumpy(level: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    points, faces = sphere(level)
    return points + np.random.default_rng(seed).uniform(-0.1, 0.1, points.shape), faces


def cages() -> list[sn.SurfaceMesh]:
    return [
        sn.SurfaceMesh(*bumpy(0, 1)),
        sn.SurfaceMesh(*bumpy(1, 2)),
        sn.SurfaceMesh(CUBE, QUADS),
        u_prism(),
    ]


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


@pytest.mark.parametrize("cage", cages())
def test_mean_value_is_the_integral_over_the_sphere(cage: sn.SurfaceMesh) -> None:
    points = away_from_faces(cage, 5)
    weights = bound(sn.MeanValue, cage, points).vertex_weights
    for x, ours in zip(points, weights, strict=True):
        np.testing.assert_allclose(
            ours, mean_value_by_quadrature(cage.points, cage.triangles, x), rtol=0, atol=1e-9
        )


@pytest.mark.parametrize("cage", cages())
def test_green_are_the_layers_of_its_identity(cage: sn.SurfaceMesh) -> None:
    points = away_from_faces(cage, 5)
    green = bound(sn.Green, cage, points)
    for x, phi, psi in zip(points, green.vertex_weights, green.face_weights, strict=True):
        layers = green_by_quadrature(cage.points, cage.triangles, x)
        np.testing.assert_allclose(phi, layers[0], rtol=0, atol=1e-9)
        np.testing.assert_allclose(psi, layers[1], rtol=0, atol=1e-9)


def near(cage: sn.SurfaceMesh, distance: float, count: int = 4) -> np.ndarray:
    """Near vertices, edges, faces, and the lines and planes beyond them, at both sides."""
    rng = np.random.default_rng(5)
    found = []
    for a, b, c in cage.points[cage.triangles[:: max(1, len(cage.triangles) // count)]]:
        normal = np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a))
        for at in (
            a,
            0.3 * a + 0.7 * b,
            0.2 * a + 0.3 * b + 0.5 * c,
            a + 1.7 * (b - a),
            a + 1.7 * (b - a) + 0.4 * (c - a),
        ):
            away = distance * (normal + 0.3 * rng.normal(size=3))
            found += [at + away, at - away]
    return np.array(found)


@pytest.mark.parametrize("distance", [1e-3, 1e-6, 1e-10])
def test_mean_value_is_exact_however_near_the_faces(distance: float) -> None:
    for cage in (sn.SurfaceMesh(*bumpy(0, 1)), u_prism()):
        points = near(cage, distance)
        for x, ours in zip(points, bound(sn.MeanValue, cage, points).vertex_weights, strict=True):
            np.testing.assert_allclose(
                ours, exact_mean_value(cage.points, cage.triangles, x), rtol=0, atol=2e-12
            )


@pytest.mark.parametrize("distance", [1e-3, 1e-6, 1e-10])
def test_green_is_exact_however_near_the_faces(distance: float) -> None:
    for cage in (sn.SurfaceMesh(*bumpy(0, 1)), u_prism()):
        points = near(cage, distance)
        green = sn.Green(cage, precision="double")
        outside = set(green.bind(points).outside.tolist())
        weights = green.vertex_weights, green.face_weights
        assert len(outside) < len(points)
        for i in set(range(len(points))) - outside:
            exact = exact_green(cage.points, cage.triangles, points[i])
            for ours, theirs in zip(weights, exact, strict=True):
                np.testing.assert_allclose(ours[i], theirs, rtol=0, atol=2e-12)


def test_mean_value_reproduces_affine_maps() -> None:
    cage = u_prism()
    points = np.random.default_rng(3).uniform(-1, 4, (200, 3))
    linear, shift = np.random.default_rng(4).normal(size=(3, 3)), np.array([1.0, 2, 3])
    warped = bound(sn.MeanValue, cage, points).warp(cage.points @ linear.T + shift)
    np.testing.assert_allclose(warped, points @ linear.T + shift, rtol=0, atol=1e-9)


def test_green_reproduces_similarities_and_no_shear() -> None:
    cage = u_prism()
    points = np.random.default_rng(3).uniform(-1, 4, (200, 3))
    rotation = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    rotation *= 2.5 * np.sign(np.linalg.det(rotation))
    green = bound(sn.Green, cage, points)
    np.testing.assert_allclose(
        green.warp(cage.points @ rotation.T + 1), points @ rotation.T + 1, rtol=0, atol=1e-9
    )
    shear = np.array([[1, 0.5, 0], [0, 1, 0], [0, 0, 1]])
    assert np.abs(green.warp(cage.points @ shear.T) - points @ shear.T).max() > 0.1


@BOTH
def test_single_precision_is_a_millionth_off_at_most(method) -> None:
    cage = sn.SurfaceMesh(*bumpy(2, 5))
    points = inside(cage, 1000)
    pose = cage.points + np.random.default_rng(6).uniform(-0.3, 0.3, cage.points.shape)
    single = method(cage)
    single.bind(points)
    double = bound(method, cage, points)
    size = np.linalg.norm(np.ptp(cage.points, axis=0))
    assert np.abs(single.warp(pose) - double.warp(pose)).max() < 1e-6 * size
    assert np.abs(single.vertex_weights - double.vertex_weights).max() < 1e-6


@BOTH
def test_warp_writes_where_it_is_told(method) -> None:
    cage = sn.SurfaceMesh(CUBE, QUADS)
    points = np.random.default_rng(1).uniform(0, 1, (50, 3))
    coordinates = method(cage)
    coordinates.bind(points)
    pose = 2 * CUBE
    expected = coordinates.warp(pose)
    out = np.full((50, 3), 9, np.float32)
    assert coordinates.warp(pose, out=out) is out
    np.testing.assert_array_equal(out, expected.astype(np.float32))
    for wrong in (np.zeros((49, 3), np.float32), np.zeros((50, 3, 1), np.float32)):
        with pytest.raises(sn.InvalidConstraint, match="out: the shape must be"):
            coordinates.warp(pose, out=wrong)
    fixed = np.zeros((50, 3), np.float32)
    fixed.setflags(write=False)
    for wrong in (np.zeros((50, 3)), np.zeros((50, 6), np.float32)[:, ::2], [[0.0] * 3] * 50, fixed):
        with pytest.raises(TypeError, match="a writable C-contiguous float32 array"):
            coordinates.warp(pose, out=wrong)
    with pytest.raises(sn.InvalidConstraint, match="not finite in single precision"):
        coordinates.warp(1e39 * pose, out=out)


@BOTH
def test_rest_in_rest_out_and_drags_return(method) -> None:
    cage = sn.SurfaceMesh(*bumpy(1, 3))
    points = np.random.default_rng(1).uniform(-1.2, 1.2, (300, 3))
    for threshold in (0.0, 1e-2):
        coordinates = method(cage, threshold=threshold)
        report = coordinates.bind(points)
        assert (report.dropped > 0) == (threshold > 0)
        np.testing.assert_array_equal(coordinates.warp(cage.points), points)
        drag = [
            coordinates.warp(cage.points + [0, 0, np.sin(angle)])
            for angle in np.append(np.linspace(0, 2 * np.pi, 20, endpoint=False), 0)
        ]
        np.testing.assert_array_equal(drag[-1], drag[0])


@BOTH
def test_what_does_not_fit_is_refused(method) -> None:
    cage = sn.SurfaceMesh(CUBE, QUADS)
    with pytest.raises(sn.InvalidMesh, match="open") as error:
        method(sn.SurfaceMesh(CUBE, QUADS[1:]))
    assert sorted(error.value.elements) == [0, 1, 2, 3]
    with pytest.raises(sn.InvalidMesh, match="inside out"):
        method(sn.SurfaceMesh(CUBE, QUADS[:, ::-1]))
    for threshold in (-1, 1, np.nan):
        with pytest.raises(sn.InvalidOption, match="threshold"):
            method(cage, threshold=threshold).bind(CUBE)
    with pytest.raises(sn.InvalidOption, match="precision"):
        method(cage, precision="half")
    coordinates = method(cage)
    with pytest.raises(sn.InvalidConstraint, match="bind"):
        coordinates.warp(CUBE)
    with pytest.raises(sn.InvalidConstraint, match="not finite") as error:
        coordinates.bind([[0, 0, 0], [np.nan, 0, 0]])
    assert error.value.elements == [1]
    coordinates.bind(CUBE)
    with pytest.raises(sn.InvalidConstraint, match="bind again"):
        coordinates.warp(CUBE[:5])
    with pytest.raises(sn.InvalidConstraint, match="not finite") as error:
        coordinates.warp(np.where(np.arange(8)[:, None] == 3, np.inf, CUBE))
    assert error.value.elements == [3]


def test_green_says_what_it_does_outside() -> None:
    cage = sn.SurfaceMesh(CUBE, QUADS)
    with pytest.raises(sn.InvalidConstraint, match="outside") as error:
        sn.Green(cage, outside="error").bind([[0.5, 0.5, 0.5], [2, 2, 2]])
    assert error.value.elements == [1]
    with pytest.raises(sn.InvalidOption, match="exit face 7"):
        sn.Green(cage, outside="face", exit_face=7)
    through = sn.Green(cage, outside="face", exit_face=1)
    assert through.bind([[0.5, 0.5, 2]]).outside.tolist() == [0]
    np.testing.assert_allclose(through.warp(CUBE + 1), [[1.5, 1.5, 3]], rtol=0, atol=1e-6)


@BOTH
def test_cancel_and_memory_leave_the_last_bind(method) -> None:
    cage = sn.SurfaceMesh(*bumpy(2, 5))
    coordinates = method(cage)
    points = inside(cage, 100)
    coordinates.bind(points)
    before = coordinates.warp(2 * cage.points)
    many = np.random.default_rng(0).uniform(-1, 1, (20_000, 3))
    ticks: list[float] = []
    with pytest.raises(sn.Cancelled):
        coordinates.bind(many, progress=lambda share, stage: ticks.append(share) or share < 0.01)
    assert ticks == sorted(ticks)
    sn.limit_memory(1 << 20)
    try:
        with pytest.raises(sn.OutOfMemory, match=r"weights needs [\d.]+ MB, the memory limit is 1.0 MB"):
            coordinates.bind(many)
    finally:
        sn.limit_memory(0)
    np.testing.assert_array_equal(coordinates.warp(2 * cage.points), before)
