# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a surface reaches, against closed forms and a Dijkstra over edges."""

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from sinew.core.geometry import reach

SIZE = 41


def grid(size: int = SIZE) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A square from -1 to 1 of quads: points (n, 3), counts, corners."""
    line = np.linspace(-1.0, 1.0, size)
    points = np.array([(x, y, 0.0) for y in line for x in line])
    index = np.arange(size * size).reshape(size, size)
    quads = np.stack((index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]), axis=-1).reshape(-1, 4)
    return points, np.full(len(quads), 4), quads.ravel()


def mask(size: int, members) -> np.ndarray:
    chosen = np.zeros(size, dtype=bool)
    chosen[members] = True
    return chosen


def lengths(mesh: tuple, sources, barred=(), limit: float = 10.0) -> np.ndarray:
    """From some vertices to all, past those that are barred."""
    points, counts, corners = mesh
    surface = reach.TriangleMesh(len(points), counts, corners)
    sources, barred = (mask(len(points), np.array(some, dtype=int)) for some in (sources, barred))
    return surface.lengths(points, sources, barred, limit)


def by_edges(points: np.ndarray, triangles: np.ndarray, source: int) -> np.ndarray:
    """Dijkstra over the edges of the triangles: never shorter than the way over the surface."""
    ends = np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    lengths = np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1)
    graph = coo_matrix((lengths, ends.T), shape=(len(points), len(points)))
    return dijkstra(graph, directed=False, indices=source)


def test_a_fan_of_each_polygon():
    triangles = reach.triangulated(np.array([3, 5, 4]), np.array([0, 1, 2, 5, 6, 7, 8, 9, 3, 2, 1, 0]))
    assert triangles.tolist() == [[0, 1, 2], [5, 6, 7], [5, 7, 8], [5, 8, 9], [3, 2, 1], [3, 1, 0]]
    none = np.zeros(0, dtype=int)
    assert reach.triangulated(none, none).shape == (0, 3)


def test_lengths_in_a_plane_are_straight_and_end_at_the_limit():
    points, *_ = mesh = grid()
    middle, distance = len(points) // 2, np.linalg.norm(points, axis=1)
    found = lengths(mesh, [middle])
    assert np.abs(found - distance).max() < 2e-3  # a share of 1e-3 of the way is let go
    found = lengths(mesh, [middle], limit=0.3)
    assert np.isfinite(found[distance < 0.299]).all()
    assert np.isinf(found[distance > 0.301]).all()


def test_lengths_go_around_what_is_barred():
    points, *_ = mesh = grid()
    start, goal = (int(np.argmin(np.linalg.norm(points - (0.0, y, 0.0), axis=1))) for y in (-0.5, 0.5))
    on_the_line = np.abs(points[:, 1]) < 0.01
    wall = on_the_line & (points[:, 0] < 0.51)
    found = lengths(mesh, [start], np.flatnonzero(wall))
    gap = points[on_the_line & ~wall][0]
    around = np.linalg.norm(gap - points[start]) + np.linalg.norm(points[goal] - gap)
    assert found[goal] == pytest.approx(around, rel=0.05)  # a corner is a new source, whose first rings err
    assert np.isinf(found[wall]).all()


def test_lengths_on_a_bent_irregular_surface_lie_between_the_chord_and_the_edges():
    points, counts, corners = mesh = grid(21)
    points[:, :2] += np.random.default_rng(3).uniform(-0.02, 0.02, (len(points), 2))
    points[:, 2] = 0.4 * np.sin(3.0 * points[:, 0]) * points[:, 1]
    found = lengths(mesh, [30])
    edges = by_edges(points, reach.triangulated(counts, corners), 30)
    assert (found <= edges * (1.0 + 1e-9)).all()
    assert (found >= np.linalg.norm(points - points[30], axis=1) * 0.99).all()


def test_other_parts_are_out_of_reach_and_numbers_that_are_none_too():
    points, counts, corners = grid(5)
    points = np.concatenate((points, points + (5.0, 0.0, 0.0)))
    counts, corners = np.concatenate((counts, counts)), np.concatenate((corners, corners + 25))
    points[24] = np.nan
    found = lengths((points, counts, corners), [0], limit=100.0)
    assert np.isfinite(found[:24]).all()
    assert np.isinf(found[24:]).all()
    surface = reach.TriangleMesh(len(points), counts, corners)
    reached = surface.connected(mask(len(points), 0), mask(len(points), []))
    assert reached.tolist() == [True] * 25 + [False] * 25


def test_connected_stops_at_what_is_barred():
    points, counts, corners = grid(5)
    surface = reach.TriangleMesh(len(points), counts, corners)
    reached = surface.connected(mask(25, 0), points[:, 0] == 0.0)
    assert reached.tolist() == (points[:, 0] < 0.0).tolist()


def test_rings_and_the_part_between_them():
    points, counts, corners = grid(9)
    inside = reach.with_rings(counts, corners, mask(81, 40), 2)
    assert inside.tolist() == (np.abs(points).max(axis=1) < 0.51).tolist()
    members, (part_counts, part_corners) = reach.submesh(counts, corners, inside)
    assert len(members) == 25
    assert len(part_counts) == 16
    original = {tuple(quad) for quad in corners.reshape(-1, 4).tolist()}
    assert {tuple(quad) for quad in members[part_corners].reshape(-1, 4).tolist()} <= original


def test_a_mesh_without_faces():
    none = np.zeros(0, dtype=int)
    surface = reach.TriangleMesh(3, none, none)
    nobody = np.zeros(3, dtype=bool)
    found = surface.lengths(np.zeros((3, 3)), mask(3, 1), nobody, 1.0)
    assert found.tolist() == [np.inf, 0.0, np.inf]
    assert surface.connected(mask(3, 1), nobody).tolist() == [False, True, False]
    assert reach.with_rings(none, none, mask(3, 1), 3).tolist() == [False, True, False]
    members, faces = reach.submesh(none, none, mask(3, 1))
    assert members.tolist() == [1]
    assert len(faces[0]) == 0
