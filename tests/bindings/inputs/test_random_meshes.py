# SPDX-License-Identifier: GPL-3.0-or-later
"""Random input of the worst kind: a finite result or a typed error, never a crash, never a NaN.

Examples are derived from the test's own code, so every run is the same.
"""

import contextlib

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import sinew_native as sn

from ..meshes import grid
from ..methods import EVERY_SURFACE_METHOD, made

EVERY_RUN = settings(
    derandomize=True,
    deadline=None,
    max_examples=300,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much],
)
FLAWS = ("double", "turn over", "lose", "flatten", "line", "needle", "far")
STIFFNESSES = ((1, 0, 0), (0, 1, 0), (0, 0, 1), (0.5, 1, 0.1))
KINDS = ("uniform", "cotan", "cotan_voronoi")
NUMBERS = st.floats(-1e100, 1e100, allow_nan=False)
SCALES = st.sampled_from([1.0, 1.0, 1.0, 1e-12, 1e-6, 1e6, 1e12])


@st.composite
def meshes(draw: st.DrawFn) -> tuple[np.ndarray, list[list[int]]]:
    """Points and faces: soup, or a surface with something wrong; flat, doubled, stretched, at any scale."""
    kind = draw(st.sampled_from(["soup", "surface", "few places"]))
    seed = draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    if kind == "surface":
        points, triangles = grid(
            draw(st.one_of(st.integers(1, 9), st.just(17))), draw(st.sampled_from([0.0, 0.2, 0.49]))
        )
        faces = triangles.tolist()
    else:
        n = draw(st.integers(1, 40))
        points = rng.normal(size=(n, 3)) if kind == "soup" else rng.integers(0, 2, (n, 3)).astype(float)
        faces = []
    n = len(points)
    for _ in range(draw(st.integers(0, 12))):  # n-gons, folded ones and such with a corner twice
        faces.append(rng.integers(0, n, rng.integers(3, 9)).tolist())
    for what in draw(st.lists(st.sampled_from(FLAWS), max_size=3)):
        if what == "double" and faces:
            faces.append(list(faces[rng.integers(len(faces))]))
        elif what == "turn over" and faces:
            faces[rng.integers(len(faces))].reverse()
        elif what == "lose":
            points = np.concatenate([points, rng.normal(size=(3, 3))])
        elif what == "flatten":
            points[:, 2] = 0
        elif what == "line":
            points[:, 1:] = 0
        elif what == "needle":
            points[rng.integers(n)] = points[rng.integers(n)] + draw(st.sampled_from([0, 1e-15, 1e-9, 1e-4]))
        elif what == "far":
            points[rng.integers(n)] *= draw(st.sampled_from([1e3, 1e8]))
    return points * draw(SCALES), faces


@st.composite
def tasks(draw: st.DrawFn) -> dict[str, object]:
    points, faces = draw(meshes())
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n = len(points)
    count = draw(st.integers(0, 4))
    taken = rng.permutation(n)
    handles, weights = [], []
    for h in range(count):
        own = taken[h::count][: rng.integers(1, max(2, n))]
        if len(own) == 0:
            own = taken[:1]  # refused where two hold it
        handles.append(own)
        weights.append(draw(st.sampled_from([None, 1.0, 0.5, 0.0, 1e-12, 1 - 1e-12])))
    scale = float(np.abs(points).max()) or 1.0
    poses = np.zeros((count, 3, 4))
    motions = {
        "still": np.eye(3),
        "affine": rng.normal(size=(3, 3)),
        "mirror": np.diag([1, 1, -1]),
        "collapse": np.zeros((3, 3)),
        "huge": 1e6 * np.eye(3),
    }
    for h in range(count):
        motion = draw(st.sampled_from(sorted(motions)))
        poses[h, :, :3] = motions[motion]
        if motion != "still":
            poses[h, :, 3] = scale * rng.normal(size=3)
    incoming = points + scale * rng.normal(size=points.shape) if draw(st.booleans()) else None
    free_parts = draw(st.sampled_from(["stay", "follow"]))
    return {
        "points": points,
        "faces": faces,
        "handles": handles,
        "weights": weights,
        "poses": poses,
        "incoming": incoming,
        "free_parts": free_parts,
    }


def mesh_of(task: dict[str, object]) -> sn.SurfaceMesh:
    faces = task["faces"]
    return sn.SurfaceMesh(task["points"], ([len(f) for f in faces], [v for f in faces for v in f]))


def bind_and_solve(surface: sn.SurfaceMethod, task: dict[str, object], **options: object) -> None:
    try:
        report = surface.set_handles(task["handles"], task["weights"], free_parts=task["free_parts"])
        positions, solved = surface.solve(task["poses"], incoming=task["incoming"], **options)
    except sn.Error:
        return
    assert positions.shape == task["points"].shape
    assert np.isfinite(positions).all()
    assert np.isfinite(solved.energy)
    assert np.isfinite(solved.residual)
    base = task["points"] if task["incoming"] is None else task["incoming"]
    np.testing.assert_array_equal(positions[report.free_vertices], base[report.free_vertices])


@EVERY_RUN
@given(
    tasks(),
    st.sampled_from(STIFFNESSES),
    st.sampled_from(KINDS),
    st.booleans(),
    st.sampled_from([None, 0, 1, 1.5]),
)
def test_thin_shell_answers_or_refuses(task, k, kind: str, basis: bool, continuity) -> None:
    stiffness = dict(zip(("stretching", "bending", "variation"), k))
    shell = sn.ThinShell(mesh_of(task), **stiffness, laplacian=kind, affine_basis=basis)
    bind_and_solve(shell, task)
    if continuity is not None:
        with contextlib.suppress(sn.Error):
            shell.set_handles(task["handles"], task["weights"], continuity)
            assert np.isfinite(shell.solve(task["poses"])[0]).all()


@EVERY_RUN
@given(tasks(), st.sampled_from([0.0, 5e-4, 1.0]), st.sampled_from(["spokes", "rims"]), st.booleans())
def test_arap_answers_or_refuses(task, smoothness: float, cells: str, painted: bool) -> None:
    n = len(task["points"])
    rigidity = 10.0 ** np.random.default_rng(n).uniform(-4, 4, n) if painted else 1.0
    arap = sn.Arap(mesh_of(task), smoothness=smoothness, cells=cells, rigidity=rigidity)
    bind_and_solve(arap, task, max_iterations=8)


@EVERY_RUN
@given(
    tasks(),
    st.sampled_from([each for each in EVERY_SURFACE_METHOD if each[0] not in (sn.ThinShell, sn.Arap)]),
)
def test_every_other_method_answers_or_refuses(task, method_and_options) -> None:
    method, options = method_and_options
    bind_and_solve(made(method, mesh_of(task), **options), task)


@pytest.mark.slow
@EVERY_RUN
@given(meshes())
def test_operators_and_diagnosis_are_finite(mesh_data) -> None:
    points, faces = mesh_data
    mesh = mesh_of({"points": points, "faces": faces})
    assert len(mesh.triangles) == sum(len(f) - 2 for f in faces)
    found = mesh.diagnose()
    assert found.component_count == mesh.component_count == len(set(mesh.components))
    assert found.clean == (found.summary() == "clean")
    for kind in KINDS:
        L, mass = sn.laplacian(mesh, kind), sn.mass(mesh, kind)
        assert np.isfinite(L.data).all()
        assert np.isfinite(mass).all()
        assert (mass >= 0).all()
        largest = abs(L).max() if L.nnz else 0.0
        assert np.abs(L @ np.ones(len(points))).max() <= 1e-12 * largest  # some hundred terms a row at most
        assert np.linalg.eigvalsh(L.toarray()).min() >= -1e-12 * largest * max(1, len(points))
    # Gradients of nearly flat triangles grow as one over their height.
    assert np.isfinite(sn.gradient(mesh).data).all()


@EVERY_RUN
@given(st.lists(st.lists(NUMBERS, min_size=9, max_size=9), min_size=1, max_size=5))
def test_rotation_fits_are_rotations(rows) -> None:
    R = sn.fit_rotations(np.array(rows).reshape(-1, 3, 3))
    np.testing.assert_allclose(np.linalg.det(R), 1, atol=1e-12)
    np.testing.assert_allclose(R @ R.transpose(0, 2, 1), np.broadcast_to(np.eye(3), R.shape), atol=1e-12)
