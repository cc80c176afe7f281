# SPDX-License-Identifier: GPL-3.0-or-later
"""Random closed cages of the worst kind: finite answers or a typed error, never a crash, never a NaN.

Examples are derived from the test's own code, so every run is the same.
"""

import contextlib

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import sinew_native as sn

from ..meshes import sphere

EVERY_RUN = settings(
    derandomize=True, deadline=None, max_examples=200, suppress_health_check=[HealthCheck.too_slow]
)
FLAWS = ("collapse", "flatten", "fold", "needle", "twice", "loose")
SCALES = st.sampled_from([1.0, 1.0, 1e-12, 1e-6, 1e6, 1e12])


@st.composite
def cages(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray]:
    """Closed triangle meshes with vertices anywhere: parts, edges without length, faces without area."""
    points, faces = sphere(draw(st.integers(0, 1)))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n = len(points)
    points = points + rng.normal(size=points.shape) * draw(st.sampled_from([0.0, 0.1, 1.0]))
    for flaw in draw(st.lists(st.sampled_from(FLAWS), max_size=3)):
        i, j = rng.integers(n, size=2)
        if flaw == "collapse":
            points[i] = points[j]
        elif flaw == "flatten":
            points[:, 2] *= draw(st.sampled_from([1e-3, 1e-9, 1e-13]))
        elif flaw == "fold":
            points[i] *= -1
        elif flaw == "needle":
            points[i] = points[j] + draw(st.sampled_from([1e-15, 1e-9, 1e-4]))
        elif flaw == "twice":
            points = np.concatenate([points, points + draw(st.sampled_from([0.0, 1e-9, 0.5, 5.0]))])
            faces = np.concatenate([faces, faces + len(points) // 2])
        elif flaw == "loose":
            points = np.concatenate([points, rng.normal(size=(1, 3))])
    return points * draw(SCALES) + draw(st.sampled_from([0.0, 0.0, 1e3])), faces


@EVERY_RUN
@given(cages(), st.integers(0, 2**32 - 1), st.sampled_from([0.0, 1e-3]))
def test_answers_are_finite_or_refused(
    cage: tuple[np.ndarray, np.ndarray], seed: int, threshold: float
) -> None:
    vertices, faces = cage
    rng = np.random.default_rng(seed)
    size = np.linalg.norm(np.ptp(vertices, axis=0))
    shares = rng.dirichlet([1, 1, 1], len(faces))
    points = np.concatenate(
        [
            vertices,
            vertices[faces].mean(1),
            np.einsum("fk,fkd->fd", shares, vertices[faces]),
            (vertices[faces[:, 0]] + vertices[faces[:, 1]]) / 2,
            vertices + 1e-12 * size * rng.normal(size=vertices.shape),
            vertices.mean(0) + size * rng.normal(size=(20, 3)),
            1e3 * size * rng.normal(size=(3, 3)),
            1e30 * rng.normal(size=(3, 3)),
        ]
    )
    pose = vertices + size * rng.normal(size=vertices.shape)
    pose[rng.integers(len(pose))] = pose[0]
    for method in (sn.MeanValue, sn.Green):
        with contextlib.suppress(sn.InvalidMesh):
            coordinates = method(
                sn.SurfaceMesh(vertices, faces),
                precision=rng.choice(["single", "double"]),
                threshold=threshold,
            )
            coordinates.bind(points)
            assert np.isfinite(coordinates.vertex_weights).all()
            assert np.isfinite(coordinates.warp(pose)).all()
            np.testing.assert_array_equal(coordinates.warp(vertices), points)
