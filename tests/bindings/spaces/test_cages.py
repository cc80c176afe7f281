# SPDX-License-Identifier: GPL-3.0-or-later
"""Mean value and Green coordinates next to quadrature and to the papers' formulas with 60 digits."""

import numpy as np
import pytest

import sinew_native as sn

from ..cages import CUBE, QUADS, bound, u_prism
from ..meshes import sphere
from ..oracles.cage_oracles import (
    exact_green,
    exact_mean_value,
    green_by_quadrature,
    mean_value_by_quadrature,
)


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
def test_thin_weights_tell_what_was_dropped(method: type) -> None:
    cage = sn.SurfaceMesh(*bumpy(1, 3))
    for threshold in (0.0, 1e-2):
        report = method(cage, threshold=threshold).bind(inside(cage, 300))
        assert (report.dropped > 0) == (threshold > 0)


@pytest.mark.parametrize("method", SPACE_METHODS)
def test_cages_and_choices_that_do_not_fit_are_refused(method: type) -> None:
    with pytest.raises(sn.InvalidMesh, match="open") as error:
        method(sn.SurfaceMesh(CUBE, QUADS[1:]))
    assert sorted(error.value.elements) == [0, 1, 2, 3]
    cage = sn.SurfaceMesh(CUBE, QUADS)
    with pytest.raises(sn.InvalidOption, match="threshold"):
        method(cage, threshold=np.nan).bind(CUBE)
    with pytest.raises(sn.InvalidOption, match="precision"):
        method(cage, precision="half")
    coordinates = method(cage)
    with pytest.raises(sn.InvalidConstraint, match="not finite") as error:
        coordinates.bind([[0, 0, 0], [np.nan, 0, 0]])
    assert error.value.elements == [1]
    with pytest.raises(sn.InvalidConstraint, match="bind"):
        coordinates.warp(CUBE)


@pytest.mark.parametrize(
    ("method", "options"),
    [
        (sn.Green, {"outside": "face", "exit_face": 7}),
        (sn.Green, {"outside": "zero"}),
        (sn.Harmonic, {"quality": "best"}),
        (sn.Harmonic, {"outside": "zero"}),
        (sn.Harmonic, {"solver": "grid"}),
        (sn.PositiveMeanValue, {"outside": "zero"}),
        (sn.PositiveMeanValue, {"exact": False, "directions": 7}),
    ],
)
def test_unknown_choices_are_refused(method: type, options: dict) -> None:
    with pytest.raises(sn.InvalidOption):
        method(sn.SurfaceMesh(CUBE, QUADS), **options)


OUTSIDE = np.array([[0.5, 0.5, 0.5], [0.5, 0.5, 2]])


@pytest.mark.parametrize(
    "coordinates",
    [
        sn.Green(sn.SurfaceMesh(CUBE, QUADS), outside="error"),
        sn.Harmonic(sn.SurfaceMesh(CUBE, QUADS)),
        sn.PositiveMeanValue(sn.SurfaceMesh(CUBE, QUADS)),
        sn.PositiveMeanValue(sn.SurfaceMesh(CUBE, QUADS), exact=False),
    ],
)
def test_points_outside_are_refused_and_named(coordinates: sn.SpaceMethod) -> None:
    with pytest.raises(sn.PointsOutside, match="outside") as refusal:
        coordinates.bind(OUTSIDE)
    assert (refusal.value.elements, refusal.value.element_kind) == ([1], "vertex")


@pytest.mark.parametrize(
    ("method", "options"),
    [
        (sn.MeanValue, {}),
        (sn.Green, {}),
        (sn.Green, {"outside": "face", "exit_face": 1}),
        (sn.Harmonic, {"outside": "mean_value"}),
        (sn.PositiveMeanValue, {"outside": "mean_value"}),
    ],
)
def test_points_outside_may_be_bound(method: type, options: dict) -> None:
    coordinates = method(sn.SurfaceMesh(CUBE, QUADS), **options)
    assert coordinates.bind(OUTSIDE).outside.tolist() == [1]
    np.testing.assert_allclose(coordinates.warp(CUBE + 1), OUTSIDE + 1, rtol=0, atol=1e-6)
