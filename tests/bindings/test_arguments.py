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


def backwards(a: np.ndarray) -> np.ndarray:
    """The same values behind negative strides."""
    return np.ascontiguousarray(a[::-1])[::-1]


def spaced(a: np.ndarray) -> np.ndarray:
    """The same values, every second one in memory."""
    return np.repeat(a[..., None], 2, axis=-1)[..., 0]


def swapped(a: np.ndarray) -> np.ndarray:
    """The other byte order."""
    return a.astype(a.dtype.newbyteorder())


def read_only(a: np.ndarray) -> np.ndarray:
    return np.frombuffer(a.tobytes(), a.dtype).reshape(a.shape)


EVERY_LAYOUT = pytest.mark.parametrize(
    "layout", [np.asfortranarray, backwards, spaced, swapped, read_only, np.ndarray.tolist]
)


@EVERY_LAYOUT
def test_points_faces_handles_and_weights_of_any_layout_are_read_alike(layout) -> None:
    mesh = sn.SurfaceMesh(layout(POINTS), layout(FACES))
    np.testing.assert_array_equal(mesh.points, POINTS)
    np.testing.assert_array_equal(mesh.triangles, FACES)
    surface, _, (first, second) = bound(sn.ThinShell)
    weights = np.linspace(0.1, 0.9, len(second))
    surface.set_handles([first, second], [None, weights])
    expected, _ = surface.solve(BENT)
    surface.set_handles([layout(first), layout(second)], [None, layout(weights)])
    np.testing.assert_array_equal(surface.solve(BENT)[0], expected)


@EVERY_LAYOUT
@pytest.mark.parametrize("method", SURFACE_METHODS)
def test_poses_and_incoming_points_of_any_layout_are_read_alike(method: type, layout) -> None:
    surface, points, _ = bound(method)
    expected, _ = surface.solve(BENT, incoming=points + 1)
    positions, _ = surface.solve(layout(BENT), incoming=layout(points + 1))
    np.testing.assert_array_equal(positions, expected)


@pytest.mark.parametrize("kind", [np.float32, np.float16, np.longdouble, np.int32, np.uint8, np.int64])
def test_points_of_any_real_type_are_widened(kind: type) -> None:
    points = (10 * POINTS).round().clip(0).astype(kind)
    mesh = sn.SurfaceMesh(points, FACES)
    assert mesh.points.dtype == np.float64
    np.testing.assert_array_equal(mesh.points, points.astype(float))


@pytest.mark.parametrize("kind", ["i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8"])
def test_faces_of_any_integer_type_are_read(kind: str) -> None:
    np.testing.assert_array_equal(sn.SurfaceMesh(POINTS, FACES.astype(kind)).triangles, FACES)


def test_faces_come_as_triangles_quads_polygons_or_mixed() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0]], float)
    for faces, count, triangles in (
        ([[0, 1, 2, 3]], 1, 2),
        ([[0, 1, 2, 3], [1, 4, 5, 2]], 2, 4),
        (([4, 3, 3], [0, 1, 2, 3, 1, 4, 2, 4, 5, 2]), 3, 4),
        ([[0, 1, 4, 5, 2, 3]], 1, 4),
        *((nothing, 0, 0) for nothing in ([], np.zeros((0, 3), int), ([], []))),
    ):
        mesh = sn.SurfaceMesh(square, faces)
        assert (mesh.face_count, len(mesh.triangles)) == (count, triangles)


def test_weights_come_as_none_a_number_or_one_a_vertex() -> None:
    surface, _, (first, second) = bound(sn.ThinShell)
    for weights in ([None, 0.5], [None, np.full(len(second), 0.5)], (1, 0.5), np.array([1.0, 0.5])):
        report = surface.set_handles([first, second], weights)
        assert (report.constrained_vertices, report.soft_vertices) == (len(first), len(second))


def test_continuity_comes_as_a_number_or_one_a_handle() -> None:
    surface, _, handles = bound(sn.ThinShell)
    shapes = []
    for continuity in (1, 1.0, np.float32(1), [1, 1], np.ones(2)):
        surface.set_handles(handles, continuity=continuity)
        shapes.append(surface.solve(BENT)[0])
        np.testing.assert_array_equal(shapes[-1], shapes[0])


@pytest.mark.parametrize("flag", [True, np.True_, [True, True], np.ones(2, bool)])
def test_from_rest_comes_as_a_flag_or_one_a_handle(flag) -> None:
    surface, points, (held, _) = bound(sn.ThinShell)
    positions, _ = surface.solve(BENT, incoming=points + 5, from_rest=flag)
    np.testing.assert_allclose(positions[held], points[held], atol=1e-12)  # one addition of rounding


@pytest.mark.parametrize(("method", "name"), [(sn.ThinShell, "bending"), (sn.Arap, "rigidity")])
def test_a_stiffness_comes_as_a_number_or_one_a_vertex(method: type, name: str) -> None:
    even, points, _ = bound(method, **{name: 2})
    for value in (np.full(len(points), 2.0), [2.0] * len(points), np.full(len(points), 2, np.float32)):
        painted, _, _ = bound(method, **{name: value})
        # A mean of three equal values rounds.
        np.testing.assert_allclose(painted.solve(BENT)[0], even.solve(BENT)[0], atol=1e-8)


def test_points_are_copied_once_and_shown_by_views_that_cannot_be_written() -> None:
    points = POINTS.copy()
    mesh = sn.SurfaceMesh(points, FACES)
    points[:] = 0
    first, second = mesh.points, mesh.points
    assert np.shares_memory(first, second)
    for view in (first, mesh.triangles):
        with pytest.raises(ValueError, match="read-only"):
            view[0, 0] = 1
    del mesh
    np.testing.assert_array_equal(first, POINTS)  # the view keeps the mesh alive


def test_results_are_the_callers_own() -> None:
    surface, _, _ = bound(sn.ThinShell)
    positions, again = (surface.solve(BENT)[0] for _ in range(2))
    assert positions.dtype == np.float64
    assert positions.flags.c_contiguous
    positions[:] = 0
    assert not np.shares_memory(positions, again)
    np.testing.assert_array_equal(surface.solve(BENT)[0], again)


def test_contiguous_float64_is_read_in_place_and_float32_is_widened() -> None:
    # 64 GiB of a file that takes no space: a copy could not be made, and is not needed to refuse it.
    surface, _, _ = bound(sn.ThinShell)
    with tempfile.TemporaryFile() as file:
        file.truncate(2**36)
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as mapped:
            array = np.frombuffer(mapped, np.float64)[: 3 * (2**33 // 3)].reshape(-1, 3)
            with pytest.raises(sn.InvalidConstraint, match="incoming"):
                surface.solve(BENT, incoming=array)
            del array
    narrow = BENT.astype(np.float32)
    np.testing.assert_array_equal(surface.solve(narrow)[0], surface.solve(narrow.astype(float))[0])


NO_NUMBERS = {
    "complex": np.zeros((25, 3), complex),
    "text": np.full((25, 3), "a"),
    "bytes": np.full((25, 3), b"a"),
    "objects": np.full((25, 3), None),
    "bool": np.zeros((25, 3), bool),
    "dates": np.zeros((25, 3), "datetime64[s]"),
    "a string": "points",
    "an object": object(),
    "a dict": {},
}


@pytest.mark.parametrize("bad", NO_NUMBERS.values(), ids=NO_NUMBERS)
def test_points_that_are_no_real_numbers_are_a_type_error(bad: object) -> None:
    with pytest.raises(TypeError, match="points"):
        sn.SurfaceMesh(bad, FACES)


@pytest.mark.parametrize("kind", [float, complex, str, bool])
def test_faces_that_are_no_integers_are_a_type_error(kind: type) -> None:
    with pytest.raises(TypeError, match="faces"):
        sn.SurfaceMesh(POINTS, FACES.astype(kind))


@pytest.mark.parametrize("method", SURFACE_METHODS)
def test_wrong_types_elsewhere_are_type_errors(method: type) -> None:
    surface, points, handles = bound(method)
    before, _ = surface.solve(BENT)
    bind, solve, texts = surface.set_handles, surface.solve, (points.astype(str), "text")
    # Plain numbers are no handles, and the error says what to write.
    wrong = [(bind, r"write \[\[0, 7\]\] for one handle", ([0, 7],), {})]
    wrong += [(bind, "", (bad,), {}) for bad in ([[0.5, 1.5]], [["a"]], ["ab"], [[True, False]], 5, [None])]
    wrong += [(bind, "", (handles, bad), {}) for bad in (5, 0.5, "ab", [1j, None], ["x", None])]
    wrong += [(bind, "progress", (handles,), {"progress": bad}) for bad in (5, "call me", [print])]
    wrong += [(solve, "poses", (bad,), {}) for bad in (BENT.astype(complex), BENT.astype(str), "poses", None)]
    wrong += [(solve, "incoming", (BENT,), {"incoming": bad}) for bad in (points.astype(complex), *texts)]
    wrong += [(solve, "", (BENT,), {"from_rest": bad}) for bad in ("ab", 3.5, [1, 1], [None, None])]
    wrong += [(solve, "", (), {}), (solve, "", (BENT, points), {}), (method, "", (points,), {})]
    for call, words, arguments, keywords in wrong:
        with pytest.raises(TypeError, match=words or None):
            call(*arguments, **keywords)
    np.testing.assert_array_equal(surface.solve(BENT)[0], before)
