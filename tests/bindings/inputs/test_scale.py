# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes of any size at any place: the same answer, or a typed error. Nothing here names a method.

Sizes are powers of two, and moving the coordinates loses no bit, so that the answers can be compared.
"""

import itertools
from collections.abc import Callable

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import STILL, grid, shift, sphere, turn
from ..methods import (
    EVERY_CAGE_METHOD,
    EVERY_SURFACE_METHOD,
    SPACE_METHODS,
    bound_to,
    called,
    control,
    inside,
    made,
    required,
)

SCALES = [2.0**k for k in range(-180, 181, 40)]  # 1e-54 to 1e54
PLACES = [2.0**k for k in (8, 20, 33, 44)]  # up to 2e13
KINDS = ("uniform", "cotan", "cotan_voronoi")
HANDLES = ([0, 1, 2, 22, 23], [460, 461, 483])


def refusal(error: type[sn.Error], call: Callable[..., object], *arguments: object) -> sn.Error | None:
    try:
        call(*arguments)
    except error as refused:
        return refused
    return None


def bent(scale: float) -> np.ndarray:
    poses = np.stack([STILL, turn((0, 1, 0), 40, (20, 0, 0), (-1, 0.5, 2))])
    poses[:, :, 3] *= scale
    return poses


def hill(scale: float) -> tuple[sn.SurfaceMesh, np.ndarray]:
    points, faces = grid(21)
    return sn.SurfaceMesh(points * scale, faces), points * scale


@pytest.mark.slow
@pytest.mark.parametrize(("method", "options"), EVERY_SURFACE_METHOD, ids=called)
def test_surface_methods_give_the_same_shape_in_every_unit(method: type, options: dict) -> None:
    expected = {}
    for scale in (1.0, *SCALES):
        mesh, points = hill(scale)
        surface = made(method, mesh, **options)
        refused = refusal(sn.FactorizationFailed, surface.set_handles, HANDLES)
        if refused is not None:  # stiffnesses of different orders have units
            assert "variation" in options
            assert refused.elements
            assert "merge vertices" in str(refused)
            continue
        for word, shape in (("incoming", points + 0.1 * scale * np.sin(points / scale)), ("start", points)):
            for request in ({}, {word: shape}):
                positions, report = surface.solve(bent(scale), **request)
                assert np.isfinite([*positions.ravel(), report.energy, report.residual]).all()
                if "variation" not in options:
                    shown = expected.setdefault(str(list(request)), positions)
                    np.testing.assert_allclose(positions / scale, shown, atol=1e-6, err_msg=f"{scale}")


@pytest.mark.parametrize(("method", "options"), EVERY_SURFACE_METHOD, ids=called)
def test_no_pose_gives_a_silent_nan(method: type, options: dict) -> None:
    mesh, _ = hill(1.0)
    surface = bound_to(made(method, mesh, **options), HANDLES)
    for size in (1e10, 1e30, 1e60, 1e100, 1e155, 1e200, 1e307):
        for poses in (size * bent(1.0), np.stack([STILL, shift(size, 0, 0)])):
            assert is_finite_or_refused(lambda given: surface.solve(given, max_iterations=4)[0], poses), size


@pytest.mark.parametrize(("method", "options"), EVERY_SURFACE_METHOD, ids=called)
def test_a_coordinate_that_is_hardly_any_solves_as_zero_does(method: type, options: dict) -> None:
    points, faces = grid(21)
    shapes = []
    for tiny in (0.0, 1e-300):
        points[200, 2] = tiny
        surface = made(method, sn.SurfaceMesh(points, faces), **options)
        surface.set_handles(HANDLES)
        shapes.append(surface.solve(bent(1.0))[0])
    np.testing.assert_allclose(shapes[1], shapes[0], atol=1e-6)


def is_finite_or_refused(call: Callable[[np.ndarray], np.ndarray], pose: np.ndarray) -> bool:
    try:
        return bool(np.isfinite(call(pose)).all())
    except sn.InvalidConstraint:
        return True


@pytest.mark.parametrize("method", SPACE_METHODS, ids=called)
def test_space_methods_take_hardly_any_and_far_too_much(method: type) -> None:
    """Poses out of all measure are refused, or move the points to finite places, soon."""
    points, faces = sphere(2)
    shapes = []
    for tiny in (0.0, 1e-300):
        points[9, 1] = tiny
        mesh = sn.SurfaceMesh(points, faces)
        space, rest = made(method, mesh), control(method, mesh)
        space.bind(points if "base" in required(method) else 0.5 * points)
        shapes.append(space.warp(rest + 0.1 * np.sin(rest)))
    np.testing.assert_allclose(shapes[1], shapes[0], atol=1e-6)
    for far in (1e60, 1e150, 1e300):
        assert is_finite_or_refused(space.warp, far * rest), far


@pytest.mark.parametrize("counts", [[1, 1], [2]], ids=("two tools", "a path"))
def test_tools_that_are_posed_out_of_all_measure_end(counts: list[int]) -> None:
    frames = np.concatenate([np.zeros((1, 3)), np.eye(3)] * 2)
    field = sn.VectorField(frames, counts, tools=["drag"] * len(counts))
    field.bind(np.random.default_rng(5).uniform(-3, 3, (300, 3)))
    apart = np.repeat([-1.0, 1.0], 4)[:, None] * (0.3, 1.0, 0.2)
    for far in (1e60, 1e150, 1e300):
        for posed in (far * frames, frames + far * apart):
            assert is_finite_or_refused(field.warp, posed), far


@pytest.fixture(scope="module")
def ball() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    points, faces = sphere(1)
    points = np.round(points * 64) / 64
    return points, faces, np.round(inside(points, 30) * 64) / 64


def bound(method: type, options: dict, cage: tuple[np.ndarray, np.ndarray], points: np.ndarray):
    """Coordinates of points, and the error that they report."""
    quick = {"quality": "fast"} if "solver" in options else {"levels": 1} if "smooth" in options else {}
    coordinates = made(method, sn.SurfaceMesh(*cage), **options, **quick)
    report = coordinates.bind(points)
    assert not len(report.outside)
    assert np.isfinite([report.error, report.dropped]).all()
    return coordinates, report.error


@pytest.mark.slow
@pytest.mark.parametrize(("method", "options"), EVERY_CAGE_METHOD, ids=called)
def test_cages_give_the_same_weights_in_every_unit_and_place(method, options: dict, ball) -> None:
    cage, faces, points = ball
    here, error = bound(method, options, (cage, faces), points)
    places = [(scale, 0.0) for scale in SCALES] + list(itertools.product((1.0, 2.0**-70, 2.0**70), PLACES))
    for scale, place in places:
        at = scale * place * np.array([1.0, -1.0, 0.5])
        there, error_there = bound(method, options, (scale * cage + at, faces), scale * points + at)
        name = f"{scale} at {place}"
        allowed = 1e-6 + error + error_there  # on a lattice, rounding decides which faces a line crosses
        np.testing.assert_allclose(there.vertex_weights, here.vertex_weights, atol=allowed, err_msg=name)
        np.testing.assert_array_equal(there.warp(scale * cage + at), scale * points + at)
        found = (there.warp(scale * 2.0 * cage + at) - at) / scale
        close = 1e-2 if "exact" in options else 2e-6
        np.testing.assert_allclose(found, 2.0 * points, atol=close, err_msg=name)


@pytest.mark.parametrize(("method", "options"), EVERY_CAGE_METHOD, ids=called)
def test_a_cage_that_goes_far_away_takes_its_points_along(method, options: dict, ball) -> None:
    cage, faces, points = ball
    coordinates, _ = bound(method, options, (cage, faces), points)
    for place in (1e2, 1e4, 1e8):
        far, bent = np.array([place, -place, 3.0]), cage * (1.0, 1.5, 1.0)
        for pose, close in ((cage, 1e-12), (bent, 1e-6)):
            found = coordinates.warp(pose + far) - far
            np.testing.assert_allclose(found, coordinates.warp(pose), atol=4e-15 * place + close)


def test_shapes_that_nobody_can_measure_are_refused_and_a_single_vertex_too_far_is_named() -> None:
    points, faces = sphere(1)
    for scale in (1e61, 1e100, 1e160, 1e300, 1e-61, 1e-100, 1e-160, 1e-300):
        refused = refusal(sn.InvalidMesh, sn.SurfaceMesh, points * scale, faces)
        assert "unit of length" in str(refused)
        assert (refused.element_kind, len(refused.elements)) == ("vertex", len(points))
    points[5, 1] = -1e90
    assert refusal(sn.InvalidMesh, sn.SurfaceMesh, points, faces).elements == [5]


@pytest.mark.slow
@pytest.mark.parametrize("scale", [1e-59, *SCALES, 1e59])
def test_operators_are_finite_or_refused(scale: float) -> None:
    mesh, _ = hill(scale / 25)
    for kind in KINDS:
        assert np.isfinite([*sn.laplacian(mesh, kind).data, *sn.mass(mesh, kind)]).all()
        assert sn.mass(mesh, kind).min() > 0
        for order in range(1, 12):
            refused = refusal(sn.InvalidMesh, sn.laplacian_power, mesh, order, kind)
            if refused is not None:
                assert "unit of length" in str(refused)
                assert (order > 3, kind) == (True, "cotan_voronoi")
                continue
            power = sn.laplacian_power(mesh, order, kind)
            assert np.isfinite(power.data).all()
            assert abs(power.data).max() > 0
    for operator in (sn.gradient(mesh), sn.divergence(mesh)):
        assert np.isfinite(operator.data).all()
        assert abs(operator.data).max() > 0


@pytest.mark.parametrize("scale", [1e-59, 1e-30, 1.0, 1e30, 1e59])
def test_cages_of_any_size_are_made_and_diagnosed(scale: float) -> None:
    points, faces = sphere(2)
    points *= np.array((1.0, 0.8, 0.65)) * scale / 2  # on a ball, rounding chooses between equal edges
    for quads in (False, True):
        cage, polygons, report = sn.automatic_cage(sn.SurfaceMesh(points, faces), 60, 0.06, quads=quads)
        assert (report.reached, report.faces) == (True, 60)
        assert 0.0 < report.clearance < 0.2
        assert sn.diagnose_cage(sn.SurfaceMesh(cage, polygons), points).clean


@pytest.mark.slow
@pytest.mark.parametrize("tiny", [5e-324, 1e-310, -1e-308, 1e-200, 1e-160])
def test_a_coordinate_that_is_hardly_any_is_nothing_special(tiny: float) -> None:
    points, faces = sphere(1)
    for vertex, axis in itertools.product((0, 2, 7), range(3)):
        meshes = []
        for value in (tiny, 0.0):
            changed = points.copy()
            changed[vertex, axis] = value
            meshes.append(sn.SurfaceMesh(changed, faces))
        found, expected = (sn.diagnose_cage(mesh, points).summary() for mesh in meshes)
        assert found == expected
        assert sn.automatic_cage(meshes[0], 60, 0.06)[2].faces <= 61


def test_a_breakdown_names_vertices_and_a_remedy() -> None:
    points, faces = grid(20)
    points[:, 2] = 0.0
    points[200:] = points[200]  # many vertices in one place
    for stiffness in ({"variation": 1.0}, {"bending": 1.0}, {"stretching": 1.0, "bending": 0.0}):
        shell = sn.ThinShell(sn.SurfaceMesh(points, faces), **stiffness, laplacian="cotan_voronoi")
        refused = refusal(sn.FactorizationFailed, shell.set_handles, [[0]])
        if refused is not None:
            assert refused.element_kind == "vertex"
            assert all(0 <= vertex < len(points) for vertex in refused.elements)
            assert "merge vertices" in str(refused)
            assert "unknown" not in str(refused)
