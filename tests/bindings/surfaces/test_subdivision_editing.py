# SPDX-License-Identifier: GPL-3.0-or-later
"""Subdivision editing: the control meshes that it finds, details, and parts that it leaves whole."""

import numpy as np
import pytest

import sinew_native as sn

from .. import limits
from ..cages import CUBE, QUADS
from ..meshes import STILL, closed_bar, ends, grid, moved, quad_grid, shift, sphere, torus, turn

LIFT = [STILL, shift(1, -2, 3)]
X, Y, Z = (0, 2, 4, 0, 2, 4, 1, 3, 6), (0, 0, 0, 2, 2, 2, 4, 4, 1), (0, 0.1, 0, 0.3, 1, 0.2, 0, 0.4, 0)
POLYGONS = (np.column_stack([X, Y, Z]), ([4, 4, 5, 3], [0, 1, 4, 3, 1, 2, 5, 4, 3, 4, 5, 7, 6, 2, 8, 5]))


def rough_hill(columns: int, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Without symmetry, with noise on every vertex."""
    points, quads = quad_grid(columns, rows)
    points[:, 2] = 2 * np.sin(3 * points[:, 0] / columns) * np.cos(2 * points[:, 1] / rows)
    return points + np.random.default_rng(5).uniform(-0.1, 0.1, points.shape), quads


def refined(mesh, scheme: str, level: int) -> tuple[np.ndarray, object]:
    """The mesh of OpenSubdiv, whose first vertices are those of the control mesh."""
    surface = sn.SubdivisionSurface(sn.SurfaceMesh(*mesh), scheme=scheme, level=level)
    return surface.refine(mesh[0]), surface.faces


def shuffled(mesh, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """The same with its vertices and faces in another order, and each face from another corner on."""
    (points, faces), rng = mesh, np.random.default_rng(seed)
    order = rng.permutation(len(points))
    faces = np.argsort(order)[faces][rng.permutation(len(faces))]
    return points[order], np.array([np.roll(face, rng.integers(len(face))) for face in faces])


def bound(mesh, levels: int, handles=((0,),), **weights) -> sn.SubdivisionEditing:
    editing = sn.SubdivisionEditing(sn.SurfaceMesh(*mesh), coarsening="levels", levels=levels)
    editing.set_handles(handles, **weights)
    return editing


CONTROLS = [
    ((CUBE, QUADS), "catmull_clark"),
    (POLYGONS, "catmull_clark"),
    (closed_bar(5, 2), "catmull_clark"),
    (torus(7, 5), "catmull_clark"),
    (rough_hill(5, 3), "catmull_clark"),
    (sphere(0), "catmull_clark"),
    (sphere(0), "loop"),
    (grid(5), "loop"),
    (sphere(1), "loop"),
]
EVERY_CONTROL = pytest.mark.parametrize(("control", "scheme"), CONTROLS)


@EVERY_CONTROL
@pytest.mark.parametrize("level", [1, 2, 3])
def test_control_meshes_are_those_of_opensubdiv(control, scheme: str, level: int) -> None:
    editing = bound(refined(control, scheme, level), level)
    assert editing.level_counts() == [level]
    found, expected = editing.control_mesh(), sn.SurfaceMesh(*control)
    assert found.face_count == expected.face_count
    assert (sn.laplacian(found, "uniform") != sn.laplacian(expected, "uniform")).nnz == 0, "the same edges"
    # Rounding, times the damping of what alternates on a cube: a control mesh is not unique there.
    np.testing.assert_allclose(found.points, control[0], rtol=0, atol=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_control_meshes_are_found_whatever_the_order_of_the_vertices(seed: int) -> None:
    points, quads = rough_hill(5, 3)
    found = bound(shuffled(refined((points, quads), "catmull_clark", 2), seed), 2).control_mesh()
    assert (found.vertex_count, found.face_count) == (len(points), len(quads))
    gaps = np.linalg.norm(found.points[:, None] - points, axis=2)
    assert gaps.min(1).max() < 1e-9


def test_regular_meshes_keep_their_lowest_vertex() -> None:
    """Each of the four colourings of a torus is a subdivision."""
    for seed in (1, 2, 3):
        fine = shuffled(torus(12, 8), seed)
        one, other = bound(fine, 1).control_mesh(), bound(fine, 1).control_mesh()
        assert one.vertex_count == 24
        np.testing.assert_array_equal(one.points, other.points)
        assert np.linalg.norm(one.points - fine[0][0], axis=1).argmin() == 0
    # Opposite corners of a torus of two quads around are one vertex.
    assert bound(torus(8, 8), 9).level_counts() == [1]
    assert bound(torus(4, 4), 9).level_counts() == [0]


def test_without_levels_it_is_a_thin_shell() -> None:
    mesh = rough_hill(12, 8)
    handles, shell = ends(mesh[0], 1.5), sn.ThinShell(sn.SurfaceMesh(*mesh))
    shell.set_handles(handles)
    found = bound(mesh, 0, handles).solve(LIFT)[0]
    np.testing.assert_allclose(found, shell.solve(LIFT)[0], rtol=0, atol=1e-10)


def test_studs_turn_with_a_strip_that_is_bent() -> None:
    """They stand on the bent strip as they stood on the flat one."""
    flat, quads = quad_grid(64, 16, 0.25)
    row, column = np.divmod(np.arange(len(flat)), 65)
    studs = np.flatnonzero((column % 8 == 5) & (row % 4 == 2) & (column > 12) & (column < 52))
    raised = flat.copy()
    raised[studs, 2] = 0.1
    handles, bend = ends(raised, 1.5), [STILL, turn((0, 1, 0), -80, (11, 0, 0))]
    q, base = (bound((points, quads), 3, handles).solve(bend)[0] for points in (raised, flat))
    normals = np.cross(base[studs + 1] - base[studs - 1], base[studs + 65] - base[studs - 65])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    sides = studs[:, None] + (1, -1, 65, -65)
    risen = (q[studs] - q[sides].mean(1)) - (base[studs] - base[sides].mean(1))
    assert np.arccos(normals[:, 2]).max() > 0.8
    # Details that keep their directions are wrong by 0.08 here.
    assert np.linalg.norm(risen - 0.1 * normals, axis=1).max() < 0.01


@EVERY_CONTROL
def test_sculpted_meshes_rest_and_move_rigidly_with_all_their_details(control, scheme: str) -> None:
    smooth, faces = refined(control, scheme, 2)
    rng = np.random.default_rng(3)
    sculpted, incoming = (smooth + rng.uniform(-by, by, smooth.shape) for by in (0.05, 0.2))
    editing = bound((sculpted, faces), 2, [[0, 1], [len(smooth) - 1]], weights=[1.0, 0.5])
    pose = turn((1, 2, -0.5), 170, (3, 7, 1), (3, -2, 1))
    for y in (sculpted, incoming):
        np.testing.assert_allclose(editing.solve([STILL] * 2, incoming=y)[0], y, rtol=0, atol=1e-13)
        found = editing.solve([pose] * 2, incoming=y)[0]
        np.testing.assert_allclose(found, moved(pose, y), rtol=0, atol=1e-11)


def together(*meshes) -> tuple[np.ndarray, tuple[list[int], list[int]]]:
    """In one, faces of any number of corners."""
    points, counts, corners = [], [], []
    for own, faces in meshes:
        first = sum(map(len, points))
        points.append(own)
        counts += [len(face) for face in faces]
        corners += [first + v for face in faces for v in face]
    return np.concatenate(points), (counts, corners)


def test_a_part_that_cannot_be_undone_stays_whole_and_the_others_do_not_mind() -> None:
    ball, box = sphere(3), refined((CUBE, QUADS), "catmull_clark", 3)
    n, m = len(ball[0]), len(box[0])
    holed = (box[0] + (0, 9, 0), box[1][:-1])
    mesh = sn.SurfaceMesh(*together(ball, holed, (box[0] + (0, 18, 0), box[1])))
    handles = [[0, n, n + m], [1, n + 1, n + m + 1]]
    editing = sn.SubdivisionEditing(mesh, coarsening="levels", levels=2)
    report = editing.set_handles(handles)
    assert editing.level_counts() == [2, 0, 2]
    assert report.irregular_parts == 1
    np.testing.assert_array_equal(report.irregular_vertices, np.arange(n, n + m))
    poses = [STILL, turn((1, 2, 3), 30, (0, 0, 0), (0.1, 0.2, 0.3))]
    alone = bound(ball, 2, [[0], [1]]).solve(poses)[0]
    np.testing.assert_allclose(editing.solve(poses)[0][:n], alone, rtol=0, atol=1e-9)
    # With nothing to undo, nothing is told; and a small part is not an irregular one.
    plain = sn.SubdivisionEditing(mesh, coarsening="levels", levels=0)
    assert plain.set_handles(handles).irregular_parts == 0
    small = sn.SubdivisionEditing(sn.SurfaceMesh(*refined((CUBE, QUADS), "catmull_clark", 1)))
    assert small.set_handles([[0]]).irregular_parts == 0


SQUARE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)
LINE = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 0, 0), (2, 0, 0), (3, 1, 0), (4, 0, 0), (1, 2, 0)]


@pytest.mark.parametrize(
    "mesh",
    [
        (SQUARE, [(0, 1, 2, 3)]),
        (SQUARE[:3], [(0, 1, 2)]),
        (SQUARE, [(0, 1, 2, 3), (3, 2, 1, 0)]),  # back to back
        (SQUARE[:3], [(0, 1, 2), (2, 1, 0)]),
        (SQUARE, [(0, 1, 2, 3), (0, 1, 2, 3)]),
        (SQUARE, [(0, 1, 0, 1), (0, 1, 2, 3)]),
        (LINE, [(0, 1, 7), (1, 2, 7), (4, 5, 6)]),
        together(sphere(0), (SQUARE + (5, 0, 0), [(0, 1, 2, 3)])),
    ],
)
def test_tiny_and_odd_parts_are_no_subdivisions(mesh) -> None:
    for vertices in ([0], range(len(mesh[0]))):
        editing = bound(mesh, 5, [vertices], weights=[0.5])
        assert set(editing.level_counts()) == {0}
        assert np.isfinite(editing.solve([shift(1, 2, 3)])[0]).all()


def test_two_fans_that_meet_in_one_vertex_are_no_subdivision_though_each_alone_is() -> None:
    points, quads = quad_grid(2, 2)
    other = np.where(quads == 0, 8, quads + 8)
    both = np.concatenate([points, points[1:] + (2, 2, 0)]), np.concatenate([quads, other])
    assert bound(both, 1).level_counts() == [0]
    assert bound((points, quads), 1).level_counts() == [1]


def test_two_handles_may_hold_the_vertices_of_one_quad() -> None:
    """And so two handles pull at each control point, which neither holds alone."""
    points, quads = rough_hill(24, 16)
    column = np.arange(len(points)) % 25
    left, right = np.flatnonzero(column < 12), np.flatnonzero(column >= 12)[:-20]
    pose = turn((0, 1, 0), 40, (18, 0, 0), (-1, 0.5, 2))
    found = bound((points, quads), 3, [left, right]).solve([STILL, pose])[0]
    np.testing.assert_array_equal(found[left], points[left])
    np.testing.assert_allclose(found[right], moved(pose, points[right]), rtol=0, atol=1e-13)
    assert np.linalg.norm(found - points, axis=1).max() < 40


def test_a_surface_leaves_its_handles_without_a_crease() -> None:
    """The border of the handle lies across the faces of the control mesh."""
    points, quads = quad_grid(48, 32)
    x, y = points[:, :2].T
    patch = np.flatnonzero((np.abs(x - 25 + 0.3 * y) < 5) & (np.abs(y - 15) < 6))
    handles, lift = [ends(points, 1.5)[0], patch], [STILL, shift(0, 0, 6)]

    def sharpest(method: sn.SurfaceMethod) -> float:
        z = method.solve(lift)[0][:, 2].reshape(33, 49)
        return max(np.abs(np.diff(z[1:-1], 2, axis=1)).max(), np.abs(np.diff(z[:, 1:-1], 2, axis=0)).max())

    shell = sn.ThinShell(sn.SurfaceMesh(points, quads))
    shell.set_handles(handles)
    for levels in (1, 2, 3):
        assert sharpest(bound((points, quads), levels, handles)) < 2.5 * sharpest(shell)


@pytest.mark.parametrize("limit", [1_000, 1_000_000, 5_000_000])
def test_levels_above_the_memory_limit_are_refused_before_they_are_made(limit: int) -> None:
    points, quads = rough_hill(128, 128)
    editing = bound((points, quads), 5, ends(points, 1.5))
    before = editing.solve(LIFT)[0]
    with limits.memory(limit), pytest.raises(sn.OutOfMemory):
        editing.set_handles(ends(points, 2.5))
    np.testing.assert_array_equal(editing.solve(LIFT)[0], before)
