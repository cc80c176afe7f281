# SPDX-License-Identifier: GPL-3.0-or-later
"""Random cages of the worst kind, of triangles, quads or flat: finite answers or a typed error, never a NaN.

Examples are derived from the test's own code, so every run is the same.
"""

import contextlib

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import sinew_native as sn

from ..cages import CUBE, QUADS
from ..meshes import sphere

EVERY_RUN = settings(
    derandomize=True, deadline=None, max_examples=100, suppress_health_check=[HealthCheck.too_slow]
)
FLAWS = ("collapse", "flatten", "fold", "needle", "line")
SCALES = st.sampled_from([1.0, 1.0, 1e-12, 1e-6, 1e6, 1e12])
SEEDS = st.integers(0, 2**32 - 1)
THRESHOLDS = st.sampled_from([0.0, 1e-3])
Cage = tuple[np.ndarray, np.ndarray]


def spoiled(draw: st.DrawFn, points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """With edges without length, faces without area, and folds; at any scale."""
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
def balls(draw: st.DrawFn) -> Cage:
    """Closed meshes of triangles with vertices anywhere, twice where there are two parts, and loose ones."""
    points, faces = sphere(draw(st.integers(0, 1)))
    rng = np.random.default_rng(draw(SEEDS))
    points = points + rng.normal(size=points.shape) * draw(st.sampled_from([0.0, 0.1, 1.0]))
    if draw(st.booleans()):
        faces = np.concatenate([faces, faces + len(points)])
        points = np.concatenate([points, points + draw(st.sampled_from([0.0, 1e-9, 0.5, 5.0]))])
    if draw(st.booleans()):
        points = np.concatenate([points, rng.normal(size=(1, 3))])
    return spoiled(draw, points, rng), faces


@st.composite
def boxes(draw: st.DrawFn) -> Cage:
    """Closed cages of quads, twisted, folded and without area."""
    rng = np.random.default_rng(draw(SEEDS))
    points = CUBE - 0.5 + rng.normal(size=CUBE.shape) * draw(st.sampled_from([0.0, 0.1, 0.5]))
    return spoiled(draw, points, rng), QUADS


@st.composite
def outlines(draw: st.DrawFn) -> Cage:
    """Polygons in a plane, often concave."""
    rng = np.random.default_rng(draw(SEEDS))
    count = draw(st.integers(3, 12))
    angle = 2 * np.pi * (np.arange(count) + rng.uniform(0, 0.9, count)) / count
    radius = rng.uniform(draw(st.sampled_from([0.9, 0.3, 0.01])), 1.0, count)
    points = np.stack((radius * np.cos(angle), radius * np.sin(angle), np.zeros(count)), 1)
    return spoiled(draw, points, rng), np.arange(count)[None]


def check(methods: list[type], cage: Cage, seed: int, **options: object) -> None:
    """At points on the cage, by a hair beside it, and far away; and for a pose out of all measure."""
    (vertices, faces), rng = cage, np.random.default_rng(seed)
    size = np.linalg.norm(np.ptp(vertices, axis=0))
    shares = rng.dirichlet(np.ones(faces.shape[1]), len(faces))
    points = np.concatenate(
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
    pose = vertices + size * rng.normal(size=vertices.shape)
    pose[rng.integers(len(pose))] = pose[0]
    precision = rng.choice(["single", "double"])
    for method in methods:
        with contextlib.suppress(sn.InvalidMesh):
            coordinates = method(sn.SurfaceMesh(vertices, faces), precision=precision, **options)
            coordinates.bind(points)
            assert np.isfinite(coordinates.vertex_weights).all()
            assert np.isfinite(coordinates.warp(pose)).all()
            np.testing.assert_array_equal(coordinates.warp(vertices), points)


@settings(EVERY_RUN, max_examples=200)
@given(balls(), SEEDS, THRESHOLDS)
def test_triangles_are_finite_or_refused(cage: Cage, seed: int, threshold: float) -> None:
    check([sn.MeanValue, sn.Green], cage, seed, threshold=threshold)


@EVERY_RUN
@given(boxes(), SEEDS, THRESHOLDS)
def test_quads_are_finite_or_refused(cage: Cage, seed: int, threshold: float) -> None:
    check([sn.Green], cage, seed, threshold=threshold, faces="quads")


@EVERY_RUN
@given(outlines(), SEEDS, THRESHOLDS)
def test_flat_cages_are_finite_or_refused(cage: Cage, seed: int, threshold: float) -> None:
    check([sn.MeanValue, sn.Green], cage, seed, threshold=threshold)
