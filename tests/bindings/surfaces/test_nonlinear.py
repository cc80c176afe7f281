# SPDX-License-Identifier: GPL-3.0-or-later
"""What iterations of the nonlinear methods reach, and what stiffnesses and heights do to shapes."""

import itertools

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import STILL, closed_bar, ends, halved, moved, off, quad_grid, shift, sphere, tube, turn

VARIANTS = [{"smoothness": s, "cells": c} for s in (0.0, 5e-4, 0.1) for c in ("spokes", "rims")]
LONG = {"max_iterations": 1000, "tolerance": 1e-12}


def bar(along: int, across: int, triangles: bool = False) -> sn.SurfaceMesh:
    mesh = sn.SurfaceMesh(*closed_bar(along, across))
    return sn.SurfaceMesh(mesh.points, mesh.triangles) if triangles else mesh


def alternating(columns: int, rows: int, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """A sheet whose cells are cut along one diagonal and the other by turns."""
    points, quads = quad_grid(columns, rows, spacing)
    odd = quads[:, 0] % (columns + 1) + quads[:, 0] // (columns + 1)
    quads = np.where(odd[:, None] % 2 == 1, quads, np.roll(quads, -1, axis=1))
    return points, halved(quads)


def bend(degrees: float, along: float = 12, depth: float = 2) -> list[np.ndarray]:
    """The end at `along` goes to the end of a circular arc."""
    angle = np.radians(degrees)
    radius, start = (along - 2 * depth) / angle, np.array((along - depth, 0, 0))
    end = np.array((depth + radius * np.sin(angle), radius * (1 - np.cos(angle)), 0))
    return [STILL, turn((0, 0, 1), degrees, start, end - start)]


def twist(degrees: float) -> list[np.ndarray]:
    return [STILL, turn((1, 0, 0), degrees)]


def bound(method: type, mesh, depth: float, **options: object) -> sn.SurfaceMethod:
    mesh = mesh if isinstance(mesh, sn.SurfaceMesh) else sn.SurfaceMesh(*mesh)
    made = method(mesh, **options)
    made.set_handles(ends(mesh.points, depth))
    return made


def size(points: np.ndarray) -> float:
    return np.linalg.norm(np.ptp(points, axis=0))


def test_arap_lifts_the_octahedron_as_known() -> None:
    """The equator keeps its radius and rises to the middle, nothing turns, and eight edges are strained."""
    arap = sn.Arap(sn.SurfaceMesh(*sphere(0)), smoothness=0.0, max_iterations=500, tolerance=1e-15)
    arap.set_handles([[5], [4]])
    found, report = arap.solve([STILL, shift(0, 0, 0.5)])
    assert report.energy == pytest.approx(1 / np.sqrt(3), abs=1e-10)  # 16 / 16 / sqrt 3
    # E is flat at its minimum: half the digits of E in the positions.
    np.testing.assert_allclose(found[:4, 2], 0.25, rtol=0, atol=1e-7)
    np.testing.assert_allclose(np.linalg.norm(found[:4, :2], axis=1), 1, rtol=0, atol=1e-7)


@pytest.mark.parametrize("options", VARIANTS)
def test_arap_never_raises_its_energy_with_painted_rigidity(options: dict) -> None:
    mesh = bar(12, 3)
    painted = 10 ** np.random.default_rng(5).uniform(-1, 1, mesh.vertex_count)
    arap = bound(sn.Arap, mesh, 2, **options, rigidity=painted)
    for poses in (bend(120), twist(135), [STILL, shift(-6, 8, 0)]):
        energies = [arap.solve(poses, max_iterations=k, tolerance=0)[1].energy for k in range(17)]
        for before, after in itertools.pairwise(energies):
            assert after <= before * (1 + 1e-12)


def test_arap_is_near_its_minimum_after_ten_iterations() -> None:
    """What the method promises: 1 % in 10, 0.1 % in 40."""
    arap = bound(sn.Arap, bar(20, 5), 1)
    lifts = ([STILL, shift(-8, 11, 0)], [STILL, shift(0, 10, 0)])
    for poses in (bend(90, 20, 1), twist(135), *lifts):
        energies = [arap.solve(poses, max_iterations=k, tolerance=0)[1].energy for k in (400, 10, 40)]
        (least, ten, forty), report = energies, arap.solve(poses)[1]
        assert ten < 1.01 * least
        assert max(forty, report.energy) < 1.001 * least
        assert report.converged


@pytest.mark.parametrize(("along", "across"), [(40, 10), (60, 6)])
def test_six_iterations_of_arap_settle_soft_bends_and_twists(along: int, across: int) -> None:
    """Steps in the metric alone leave .2 to .4 % of the box of a slab that bends softly."""
    mesh = bar(along, across)
    arap = bound(sn.Arap, mesh, 3)
    for poses in (bend(60, along), twist(90)):
        limit = arap.solve(poses, max_iterations=600, tolerance=1e-12)[0]
        six = arap.solve(poses, max_iterations=6, tolerance=0)[0]
        assert off(six, limit) < 1e-3 * size(mesh.points)


def bar_with_cut_lids(along: int, across: int) -> tuple[np.ndarray, tuple]:
    """Of quads, and triangles at its ends: of ties, those of quads are left."""
    points, (_counts, corners) = closed_bar(along, across)
    quads, lids = corners[: 16 * along * across], bar(along, across).triangles[8 * along * across :]
    counts = [4] * (len(quads) // 4) + [3] * len(lids)
    return points, (counts, np.concatenate([quads, lids.ravel()]))


ON_BAR = [bend(60, 24)[1], twist(90)[1], turn((0.3, 1, 0.2), 70, (22, 0, 0), (-3, 2, 4))]
TIP = (0.9, 0, 0)
ON_SPHERE = [turn((0, 0, 1), 60, TIP, (0.3, 0.2, 0)), turn((1, 0.2, 0), 80, TIP, (0.5, 0, 0.3))]


@pytest.mark.parametrize(
    ("mesh", "depth", "targets"),
    [(bar_with_cut_lids(24, 6), 2, ON_BAR), (sphere(4), 0.2, ON_SPHERE)],
    ids=["bar", "sphere"],
)
def test_last_bits_of_poses_and_of_the_rest_shape_stay_small(mesh, depth: float, targets: list) -> None:
    """On symmetric meshes, whose clusters and diagonals are decided between equals."""
    (points, faces), rng = mesh, np.random.default_rng(3)
    whole, handles = size(points), ends(points, depth)
    noise = 3e-8 * whole * rng.uniform(-1, 1, points.shape)
    arap, other = (sn.Arap(sn.SurfaceMesh(shape, faces)) for shape in (points, points + noise))
    arap.set_handles(handles)
    other.set_handles(handles)
    for target in targets:
        poses = [STILL, target]
        found = arap.solve(poses)[0]
        assert off(other.solve(poses)[0], found) < 1e-4 * whole
        noise = 1e-7 * rng.uniform(-1, 1, (2, 3, 4)) * (1, 1, 1, whole)
        assert off(arap.solve(np.array(poses) + noise)[0], found) < 1e-4 * whole


def test_arap_from_a_warm_start_stays_near_the_answer_from_the_poses_alone() -> None:
    mesh = bar(16, 4)
    arap, shape = bound(sn.Arap, mesh, 2), mesh.points
    for k in range(1, 21):
        shape = arap.solve(bend(4.5 * k, 16), start=shape, max_iterations=4)[0]
    assert off(shape, arap.solve(bend(90, 16))[0]) < 0.02 * size(mesh.points)  # the study: .01 rms at worst
    exact = bound(sn.Arap, bar(12, 3), 2, tolerance=1e-10)
    answer, report = exact.solve(bend(60), max_iterations=300)
    again, other = exact.solve(bend(60), start=answer)
    assert off(again, answer) < 1e-3 * 12  # E settles to 1e-10: half its digits
    assert other.energy <= report.energy * (1 + 1e-6)


@pytest.mark.parametrize(
    ("method", "triangles", "depth", "iterations"),
    [(sn.Primo, False, 2, 1000), (sn.Primo, True, 2, 1000), (sn.ThinShellNonlinear, False, 1, 2000)],
)
def test_unrelated_starts_meet(method: type, triangles: bool, depth: float, iterations: int) -> None:
    mesh = bar(20, 5, triangles)
    made = bound(method, mesh, depth)
    for poses in (bend(90, 20, depth), twist(135)):
        own, first = made.solve(poses, max_iterations=iterations, tolerance=1e-15)
        words = {"max_iterations": 2 * iterations, "tolerance": 1e-15}
        other, second = made.solve(poses, start=mesh.points, **words)
        assert second.energy == pytest.approx(first.energy, rel=1e-7)
        assert off(own, other) < 1e-4 * size(mesh.points)


@pytest.mark.parametrize("triangles", [False, True])
def test_four_iterations_of_primo_are_within_one_percent(triangles: bool) -> None:
    mesh = bar(40, 10, triangles)
    primo = bound(sn.Primo, mesh, 2)
    for poses in (bend(90, 40), twist(135)):
        limit = primo.solve(poses, **LONG)[0]
        for words in ({"max_iterations": 4, "tolerance": 0}, {}):
            left = np.linalg.norm(primo.solve(poses, **words)[0] - limit)
            assert left < 0.01 * np.linalg.norm(limit - mesh.points)


def test_five_iterations_of_a_puppet_without_bones_are_near_the_end() -> None:
    few = bound(sn.MeshPuppetry, bar(20, 5), 2, max_iterations=5)
    end = bound(sn.MeshPuppetry, bar(20, 5), 2, max_iterations=2000, tolerance=1e-13)
    for poses in (bend(90, 20), twist(135)):
        found, report = few.solve(poses)
        assert report.iterations + report.rejected <= 5
        assert off(found, end.solve(poses)[0]) < 0.1 * size(found)


def turns_along(q: np.ndarray, row: int = 2) -> np.ndarray:
    """The angles between neighbouring edges along a row of a strip of 30 cells."""
    sides = np.diff(q.reshape(-1, 31, 3)[row], axis=0)
    a, b = sides[:-1], sides[1:]
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(1))


def test_a_painted_height_stiffens_its_region_and_black_is_solved() -> None:
    points, quads = quad_grid(30, 4)
    painted = np.where((points[:, 0] >= 10) & (points[:, 0] <= 20), 0.2, 0.005)
    poses = [STILL, turn((0, 1, 0), 80, (29, 2, 0), (-5, 0, 0))]
    primos = [bound(sn.Primo, (points, quads), 1, height=height) for height in (painted, 0.005)]
    stiff, even = (turns_along(primo.solve(poses, max_iterations=400)[0]) for primo in primos)
    assert stiff[11:18].sum() < 0.2 * even[11:18].sum()
    painted[7] = 0  # raised to a thousandth of the largest value
    assert np.isfinite(bound(sn.Primo, (points, quads), 1, height=painted).solve(bend(60, 30))[0]).all()


@pytest.mark.parametrize("scale", [(1, 2, 1.5), (0.5, 0.5, 0.5), (1, 1, -1)])
def test_an_affine_pose_takes_its_handle_along(scale: tuple) -> None:
    mesh, pose = bar(12, 3), STILL * np.array(scale)[:, None]
    found = bound(sn.Primo, mesh, 2).solve([STILL, pose], max_iterations=100)[0]
    handle = ends(mesh.points, 2)[1]
    assert np.isfinite(found).all()
    np.testing.assert_allclose(found[handle], moved(pose, mesh.points[handle]), rtol=0, atol=1e-12)
    x, y, _ = mesh.points.T  # and a bar whose ends grow grows near them: no prism is against it
    found = bound(sn.Primo, mesh, 2).solve([2 * STILL] * 2)[0]
    near = (x == 3) | (x == 9)
    assert (np.abs(found[near, 1] - found[:, 1].mean()) > 1.2 * np.abs(y[near] - y.mean())).all()


def test_faces_of_many_corners_stay_stiff() -> None:
    """A drum: two polygons of 24 corners and a wall of quads."""
    points, wall = tube(3, 24)
    corners = np.concatenate([wall.ravel(), np.arange(24)[::-1], 72 + np.arange(24)])
    primo = sn.Primo(sn.SurfaceMesh(points, ([4] * 72 + [24, 24], corners)))
    primo.set_handles([np.arange(24), [72]])  # the bottom, and a vertex of the top
    lid = primo.solve([STILL, shift(0.5, 0.5, 0)], max_iterations=200)[0][72:]
    # Its vertices are means of where it and two faces of the wall take them.
    across = np.linalg.norm(lid - np.roll(lid, 12, axis=0), axis=1)
    np.testing.assert_allclose(np.delete(across, [0, 12]), 2, atol=0.2)


STIFF = {"measure": "stiffness"}


def test_rolling_and_re_rolling_a_sheet_cost_what_curvature_says() -> None:
    """1/2 k_b k^2 over 4 units of area, of which half a row of faces at each border bends nothing."""
    n = 24
    flat, faces = alternating(n, n, 2 / n)
    a, b = flat[:, 0] - 1, flat[:, 1] - 1
    one = np.column_stack([a, np.sin(b), np.cos(b)])
    other = np.column_stack([np.sin(a), b, np.cos(a)])
    words = STIFF | {"stretching": 1e-3, "bending": 1.0}
    rolled, sheet = 2.0 * (n - 1) / n, bound(sn.ThinShellNonlinear, (flat, faces), 0.1, **words)
    assert sheet.energy(one) == pytest.approx(rolled, rel=0.01)
    # From one cylinder to the other across: the mean curvature is the same, and II is not.
    roll = bound(sn.ThinShellNonlinear, (one, faces), 0.1, **words)
    assert roll.energy(other) == pytest.approx(2 * rolled, rel=0.01)
    assert roll.energy(one) < 1e-20


def test_painted_thickness_decides_where_a_sheet_bends() -> None:
    points, faces = alternating(33, 5, 0.25)
    poses = [STILL, turn((0, 1, 0), -60, (8, 0, 0), (-1, 0, 3))]

    def turned(left: float) -> float:
        """How much the left half turns, from its first edge to its last one."""
        thickness = np.where(points[:, 0] < 4, left, 0.5)
        shell = bound(sn.ThinShellNonlinear, (points, faces), 0.5, measure="length", thickness=thickness)
        found = shell.solve(poses, max_iterations=300)[0].reshape(6, 34, 3).sum(0)
        first, last = found[2] - found[1], found[16] - found[15]
        return np.arccos(first @ last / np.linalg.norm(first) / np.linalg.norm(last))

    assert turned(0.1) > turned(0.5) + 0.05
    assert turned(2.0) < turned(0.5) - 0.05
    assert np.isfinite(turned(0.0))


def test_triangles_at_one_edge_of_several_all_hold_together() -> None:
    """Three wings at an edge, a lone triangle that touches them at a corner, and a face without area."""
    wings = [(0, 0, 0), (0, 0, 1), (1, 0, 0.5), (-0.5, 0.8, 0.5), (-0.5, -0.8, 0.5), (2, 0, 0), (2, 0, 1)]
    points = np.array([*wings, (0, 0, 0.5)], float)
    mesh = sn.SurfaceMesh(points, [(0, 1, 2), (0, 1, 3), (1, 0, 4), (2, 5, 6), (0, 7, 1)])
    shell, pose = sn.ThinShellNonlinear(mesh), turn((1, 1, 0), 120, move=(1, 2, 3))
    shell.set_handles([[2], [3], [4]])
    # Three points fix a rotation, which the start takes from the poses.
    found = shell.solve([pose] * 3, max_iterations=500, tolerance=1e-16)[0]
    np.testing.assert_allclose(found, moved(pose, points), rtol=0, atol=1e-6)
