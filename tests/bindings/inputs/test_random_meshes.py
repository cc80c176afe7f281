# SPDX-License-Identifier: GPL-3.0-or-later
"""Random input of the worst kind: a finite result or a typed error, never a crash, never a NaN.

Examples are derived from the test's own code, so every run is the same.
"""

import contextlib

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

import sinew_native as sn

from ..cages import CUBE, QUADS
from ..meshes import grid, sphere
from ..methods import EVERY_SURFACE_METHOD, made

EVERY_RUN = settings(
    derandomize=True,
    deadline=None,
    max_examples=300,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much],
)
FLAWS = ("double", "turn over", "lose", "flatten", "line", "needle", "far")
STIFFNESSES = ((1, 0, 0), (0, 1, 0), (0, 0, 1), (0.5, 1, 0.1))
KINDS = ("uniform", "cotan", "cotan_voronoi", "robust")
NUMBERS = st.floats(-1e100, 1e100, allow_nan=False)
SCALES = st.sampled_from([1.0, 1.0, 1.0, 1e-12, 1e-6, 1e6, 1e12])


@st.composite
def meshes(draw: st.DrawFn) -> tuple[np.ndarray, list[list[int]]]:
    """Points and faces: soup, or a surface with something wrong; flat, doubled, stretched, at any scale."""
    kind = draw(st.sampled_from(["soup", "surface", "few places"]))
    seed = draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    if kind == "surface":
        cells, jitters = st.one_of(st.integers(1, 9), st.just(17)), st.sampled_from([0.0, 0.2, 0.49])
        points, triangles = grid(draw(cells), draw(jitters))
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
    motions = {"still": np.eye(3), "affine": rng.normal(size=(3, 3)), "mirror": np.diag([1, 1, -1])}
    motions |= {"collapse": np.zeros((3, 3)), "huge": 1e6 * np.eye(3)}
    for h in range(count):
        motion = draw(st.sampled_from(sorted(motions)))
        poses[h, :, :3] = motions[motion]
        if motion != "still":
            poses[h, :, 3] = scale * rng.normal(size=3)
    incoming = points + scale * rng.normal(size=points.shape) if draw(st.booleans()) else None
    task = {"points": points, "faces": faces, "handles": handles, "weights": weights, "poses": poses}
    return task | {"incoming": incoming, "free_parts": draw(st.sampled_from(["stay", "follow"]))}


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
    assert np.isfinite([*positions.ravel(), solved.energy, solved.residual]).all()
    base = task["points"] if task["incoming"] is None else task["incoming"]
    np.testing.assert_array_equal(positions[report.free_vertices], base[report.free_vertices])


SHELLS = map(st.sampled_from, (STIFFNESSES, KINDS, (False, True), (None, 0, 1, 1.5)))


@EVERY_RUN
@given(tasks(), *SHELLS)
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


OTHERS = [each for each in EVERY_SURFACE_METHOD if each[0] not in (sn.ThinShell, sn.Arap)]


@EVERY_RUN
@given(tasks(), st.sampled_from(OTHERS))
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
        assert np.isfinite([*L.data, *mass]).all()
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


CAGE_RUN = settings(EVERY_RUN, max_examples=100)
CAGE_FLAWS = ("collapse", "flatten", "fold", "needle", "line")
CAGE_SCALES = st.sampled_from([1.0, 1.0, 1e-12, 1e-6, 1e6, 1e12])
SEEDS = st.integers(0, 2**32 - 1)
THRESHOLDS = st.sampled_from([0.0, 1e-3])
Cage = tuple[np.ndarray, np.ndarray]


def spoiled(draw: st.DrawFn, points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """With edges without length, faces without area, and folds; at any scale."""
    for flaw in draw(st.lists(st.sampled_from(CAGE_FLAWS), max_size=3)):
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
    return points * draw(CAGE_SCALES) + draw(st.sampled_from([0.0, 0.0, 1e3]))


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


def check_cage(methods: list[type], cage: Cage, seed: int, **options: object) -> None:
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
    check_cage([sn.MeanValue, sn.Green], cage, seed, threshold=threshold)


@CAGE_RUN
@given(boxes(), SEEDS, THRESHOLDS)
def test_quads_are_finite_or_refused(cage: Cage, seed: int, threshold: float) -> None:
    check_cage([sn.Green], cage, seed, threshold=threshold, faces="quads")


@CAGE_RUN
@given(outlines(), SEEDS, THRESHOLDS)
def test_flat_cages_are_finite_or_refused(cage: Cage, seed: int, threshold: float) -> None:
    check_cage([sn.MeanValue, sn.Green], cage, seed, threshold=threshold)
