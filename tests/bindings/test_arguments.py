# SPDX-License-Identifier: GPL-3.0-or-later
"""What enters as an array: layouts and types that are read, and those that are refused."""

import mmap
import tempfile

import numpy as np
import pytest

import sinew_native as sn

from .meshes import BENT, grid
from .methods import SURFACE_METHODS, bound

POINTS, FACES = grid(4)
POSES = np.ascontiguousarray(BENT)


def fortran(a: np.ndarray) -> np.ndarray:
    return np.asfortranarray(a)


def backwards(a: np.ndarray) -> np.ndarray:
    """The same values behind negative strides."""
    return np.ascontiguousarray(a[::-1])[::-1]


def spaced(a: np.ndarray) -> np.ndarray:
    """The same values, every second one in memory."""
    wide = np.zeros((*a.shape, 2), a.dtype)
    wide[..., 0] = a
    return wide[..., 0]


def swapped(a: np.ndarray) -> np.ndarray:
    """The other byte order."""
    return a.astype(a.dtype.newbyteorder())


def read_only(a: np.ndarray) -> np.ndarray:
    copy = a.copy()
    copy.flags.writeable = False
    return copy


LAYOUTS = (fortran, backwards, spaced, swapped, read_only, np.ndarray.tolist)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_points_and_faces_of_any_layout_are_read_alike(layout) -> None:
    mesh = sn.SurfaceMesh(layout(POINTS), layout(FACES))
    np.testing.assert_array_equal(mesh.points, POINTS)
    np.testing.assert_array_equal(mesh.triangles, FACES)


@pytest.mark.parametrize("kind", [np.float32, np.float16, np.longdouble, np.int32, np.uint8, np.int64])
def test_points_of_any_real_type_are_widened(kind: type) -> None:
    points = (10 * POINTS).round().clip(0).astype(kind)
    mesh = sn.SurfaceMesh(points, FACES)
    assert mesh.points.dtype == np.float64
    np.testing.assert_array_equal(mesh.points, points.astype(float))


@pytest.mark.parametrize("kind", ["i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8"])
def test_faces_of_any_integer_type_are_read(kind: str) -> None:
    np.testing.assert_array_equal(sn.SurfaceMesh(POINTS, FACES.astype(kind)).triangles, FACES)


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("method", SURFACE_METHODS)
def test_poses_and_incoming_points_of_any_layout_are_read_alike(method: type, layout) -> None:
    surface, points, _ = bound(method)
    expected, _ = surface.solve(POSES, incoming=points + 1)
    positions, _ = surface.solve(layout(POSES), incoming=layout(points + 1))
    np.testing.assert_array_equal(positions, expected)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_handles_and_weights_of_any_layout_are_read_alike(layout) -> None:
    surface, _, (first, second) = bound(sn.ThinShell)
    weights = np.linspace(0.1, 0.9, len(second))
    surface.set_handles([first, second], [None, weights])
    expected, _ = surface.solve(POSES)
    surface.set_handles([layout(first), layout(second)], [None, layout(weights)])
    np.testing.assert_array_equal(surface.solve(POSES)[0], expected)


def test_float32_poses_are_widened_not_rounded_further() -> None:
    surface, _, _ = bound(sn.ThinShell)
    narrow = POSES.astype(np.float32)
    np.testing.assert_array_equal(surface.solve(narrow)[0], surface.solve(narrow.astype(float))[0])


def test_faces_come_as_triangles_quads_polygons_or_mixed() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0]], float)
    assert sn.SurfaceMesh(square, [[0, 1, 2, 3]]).face_count == 1
    assert len(sn.SurfaceMesh(square, [[0, 1, 2, 3], [1, 4, 5, 2]]).triangles) == 4
    mixed = sn.SurfaceMesh(square, ([4, 3, 3], [0, 1, 2, 3, 1, 4, 2, 4, 5, 2]))
    assert mixed.face_count == 3
    assert len(mixed.triangles) == 4
    assert sn.SurfaceMesh(square, [[0, 1, 4, 5, 2, 3]]).face_count == 1
    for nothing in ([], np.zeros((0, 3), int), ([], [])):
        assert sn.SurfaceMesh(square, nothing).face_count == 0


def test_weights_come_as_none_a_number_or_one_a_vertex() -> None:
    surface, _, (first, second) = bound(sn.ThinShell)
    for weights in ([None, 0.5], [None, np.full(len(second), 0.5)], (1, 0.5), np.array([1.0, 0.5])):
        report = surface.set_handles([first, second], weights)
        assert report.soft_vertices == len(second)
        assert report.constrained_vertices == len(first)


def test_continuity_comes_as_a_number_or_one_a_handle() -> None:
    surface, _, handles = bound(sn.ThinShell)
    surface.set_handles(handles, continuity=1)
    expected, _ = surface.solve(POSES)
    for continuity in (1.0, np.float32(1), [1, 1], np.ones(2)):
        surface.set_handles(handles, continuity=continuity)
        np.testing.assert_array_equal(surface.solve(POSES)[0], expected)


@pytest.mark.parametrize("flag", [True, np.True_, [True, True], np.ones(2, bool)])
def test_from_rest_comes_as_a_flag_or_one_a_handle(flag) -> None:
    surface, points, handles = bound(sn.ThinShell)
    positions, _ = surface.solve(POSES, incoming=points + 5, from_rest=flag)
    held = handles[0]
    np.testing.assert_allclose(positions[held], points[held], atol=1e-12)  # one addition of rounding


@pytest.mark.parametrize("method", [sn.ThinShell, sn.Arap])
def test_a_stiffness_comes_as_a_number_or_one_a_vertex(method: type) -> None:
    name = "bending" if method is sn.ThinShell else "rigidity"
    even, points, _ = bound(method, **{name: 2})
    expected, _ = even.solve(POSES)
    for value in (np.full(len(points), 2.0), [2.0] * len(points), np.full(len(points), 2, np.float32)):
        painted, _, _ = bound(method, **{name: value})
        # A mean of three equal values rounds.
        np.testing.assert_allclose(painted.solve(POSES)[0], expected, atol=1e-8)


def test_points_are_copied_once_at_construction() -> None:
    points = POINTS.copy()
    mesh = sn.SurfaceMesh(points, FACES)
    points[:] = 0
    np.testing.assert_array_equal(mesh.points, POINTS)


def test_points_and_triangles_are_views_that_cannot_be_written() -> None:
    mesh = sn.SurfaceMesh(POINTS, FACES)
    first, second = mesh.points, mesh.points
    assert np.shares_memory(first, second)
    for view in (mesh.points, mesh.triangles):
        with pytest.raises(ValueError, match="read-only"):
            view[0, 0] = 1
    del mesh
    np.testing.assert_array_equal(first, POINTS)  # the view keeps the mesh alive


def test_results_are_the_callers_own() -> None:
    surface, _, _ = bound(sn.ThinShell)
    positions, _ = surface.solve(POSES)
    assert positions.dtype == np.float64
    assert positions.flags.c_contiguous
    assert positions.flags.writeable
    again, _ = surface.solve(POSES)
    positions[:] = 0
    assert not np.shares_memory(positions, again)
    np.testing.assert_array_equal(surface.solve(POSES)[0], again)


def test_contiguous_float64_is_read_in_place() -> None:
    # 64 GiB of a file that takes no space: a copy could not be made, and is not needed to refuse it.
    surface, _, _ = bound(sn.ThinShell)
    with tempfile.TemporaryFile() as file:
        file.truncate(2**36)
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as mapped:
            array = np.frombuffer(mapped, np.float64)[: 3 * (2**33 // 3)].reshape(-1, 3)
            with pytest.raises(sn.InvalidConstraint, match="incoming"):
                surface.solve(POSES, incoming=array)
            del array


@pytest.mark.parametrize(
    "bad",
    [
        np.zeros((25, 3), complex),
        np.full((25, 3), "a"),
        np.full((25, 3), b"a"),
        np.full((25, 3), None),
        np.zeros((25, 3), bool),
        np.zeros((25, 3), "datetime64[s]"),
        "points",
        object(),
        {},
    ],
    ids=["complex", "text", "bytes", "objects", "bool", "dates", "a string", "an object", "a dict"],
)
def test_points_that_are_no_real_numbers_are_a_type_error(bad: object) -> None:
    with pytest.raises(TypeError, match="points"):
        sn.SurfaceMesh(bad, FACES)


@pytest.mark.parametrize("kind", [float, complex, str, bool])
def test_faces_that_are_no_integers_are_a_type_error(kind: type) -> None:
    with pytest.raises(TypeError, match="faces"):
        sn.SurfaceMesh(POINTS, FACES.astype(kind))


@pytest.mark.parametrize("method", SURFACE_METHODS)
def test_plain_numbers_are_no_handles_and_the_error_says_what_to_write(method: type) -> None:
    surface, _points, _handles = bound(method)
    with pytest.raises(TypeError, match=r"write \[\[0, 7\]\] for one handle"):
        surface.set_handles([0, 7])


@pytest.mark.parametrize("method", SURFACE_METHODS)
def test_wrong_types_elsewhere_are_type_errors(method: type) -> None:
    surface, points, handles = bound(method)
    before, _ = surface.solve(POSES)
    for bad in ([[0.5, 1.5]], [["a"]], ["ab"], [[True, False]], 5, [None]):
        with pytest.raises(TypeError):
            surface.set_handles(bad)
    for bad in (5, 0.5, "ab", [1j, None], ["x", None]):
        with pytest.raises(TypeError):
            surface.set_handles(handles, bad)
    for bad in (POSES.astype(complex), POSES.astype(str), "poses", None):
        with pytest.raises(TypeError, match="poses"):
            surface.solve(bad)
    for bad in (points.astype(complex), "text", points.astype(str)):
        with pytest.raises(TypeError, match="incoming"):
            surface.solve(POSES, incoming=bad)
    for bad in ("ab", 3.5, [1, 1], [None, None]):
        with pytest.raises(TypeError):
            surface.solve(POSES, from_rest=bad)
    for bad in (5, "call me", [print]):
        with pytest.raises(TypeError, match="progress"):
            surface.set_handles(handles, progress=bad)
    with pytest.raises(TypeError):
        surface.solve()
    with pytest.raises(TypeError):
        surface.solve(POSES, points)  # keywords only
    with pytest.raises(TypeError):
        method(points)
    np.testing.assert_array_equal(surface.solve(POSES)[0], before)
