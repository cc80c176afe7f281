# SPDX-License-Identifier: GPL-3.0-or-later
"""Random cages of quads, and random flat ones: finite answers or a typed error, never a crash, never a NaN.

Examples are derived from the test's own code, so every run is the same.
"""

import contextlib

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import sinew_native as sn

from ..cages import CUBE, QUADS

EVERY_RUN = settings(
    derandomize=True, deadline=None, max_examples=100, suppress_health_check=[HealthCheck.too_slow]
)
FLAWS = ("collapse", "flatten", "fold", "needle", "line")
SCALES = st.sampled_from([1.0, 1.0, 1e-12, 1e-6, 1e6, 1e12])


def spoiled(draw: st.DrawFn, points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    for flaw in draw(st.lists(st.sampled_from(FLAWS), max_size=3)):
        i, j, k = rng.integers(len(points), size=3)
        if flaw == "collapse":
            points[i] = points[j]
        elif flaw == "flatten":
            points[:, 1] *= draw(st.sampled_from([1e-3, 1e-9, 1e-13]))
        elif flaw == "fold":
            points[i] *= -1
        elif flaw == "needle":
            points[i] = points[j] + draw(st.sampled_from([1e-15, 1e-9, 1e-4]))
        elif flaw == "line":
            points[i] = (points[j] + points[k]) / 2
    return points * draw(SCALES) + draw(st.sampled_from([0.0, 0.0, 1e3]))


@st.composite
def boxes(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray]:
    """Closed cages of quads, twisted, folded and without area."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    points = CUBE - 0.5 + rng.normal(size=CUBE.shape) * draw(st.sampled_from([0.0, 0.1, 0.5]))
    return spoiled(draw, points, rng), QUADS


@st.composite
def outlines(draw: st.DrawFn) -> np.ndarray:
    """Corners (k, 3) of polygons in a plane, often concave."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count = draw(st.integers(3, 12))
    angle = 2 * np.pi * (np.arange(count) + rng.uniform(0, 0.9, count)) / count
    radius = rng.uniform(draw(st.sampled_from([0.9, 0.3, 0.01])), 1.0, count)
    points = np.stack((radius * np.cos(angle), radius * np.sin(angle), np.zeros(count)), 1)
    return spoiled(draw, points, rng)


def around(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    size = np.linalg.norm(np.ptp(vertices, axis=0))
    shares = rng.dirichlet(np.ones(faces.shape[1]), len(faces))
    return np.concatenate(
        [
            vertices,
            vertices[faces].mean(1),
            np.einsum("fk,fkd->fd", shares, vertices[faces]),
            (vertices[faces[:, 0]] + vertices[faces[:, 1]]) / 2,
            vertices + 1e-12 * size * rng.normal(size=vertices.shape),
            vertices + 1e-10 * size * rng.normal(size=vertices.shape),
            vertices.mean(0) + size * rng.normal(size=(20, 3)),
            1e3 * size * rng.normal(size=(3, 3)),
            1e30 * rng.normal(size=(3, 3)),
        ]
    )


def check(make, vertices: np.ndarray, points: np.ndarray, rng: np.random.Generator) -> None:
    pose = vertices + np.linalg.norm(np.ptp(vertices, axis=0)) * rng.normal(size=vertices.shape)
    pose[rng.integers(len(pose))] = pose[0]
    with contextlib.suppress(sn.InvalidMesh):
        coordinates = make()
        coordinates.bind(points)
        assert np.isfinite(coordinates.vertex_weights).all()
        assert np.isfinite(coordinates.warp(pose)).all()
        np.testing.assert_array_equal(coordinates.warp(vertices), points)


@EVERY_RUN
@given(boxes(), st.integers(0, 2**32 - 1), st.sampled_from([0.0, 1e-3]))
def test_quads_are_finite_or_refused(box: tuple[np.ndarray, np.ndarray], seed: int, threshold: float) -> None:
    vertices, faces = box
    rng = np.random.default_rng(seed)
    points = around(vertices, faces, rng)
    options = {"precision": rng.choice(["single", "double"]), "threshold": threshold, "faces": "quads"}
    check(lambda: sn.Green(sn.SurfaceMesh(vertices, faces), **options), vertices, points, rng)


@EVERY_RUN
@given(outlines(), st.integers(0, 2**32 - 1), st.sampled_from([0.0, 1e-3]))
def test_flat_cages_are_finite_or_refused(vertices: np.ndarray, seed: int, threshold: float) -> None:
    rng = np.random.default_rng(seed)
    faces = np.arange(len(vertices))[None]
    points = around(vertices, faces, rng)
    options = {"precision": rng.choice(["single", "double"]), "threshold": threshold}
    for method in (sn.MeanValue, sn.Green):
        cage = sn.SurfaceMesh(vertices, faces)
        check(lambda: method(cage, **options), vertices, points, rng)  # noqa: B023
