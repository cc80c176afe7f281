# SPDX-License-Identifier: GPL-3.0-or-later
"""Pyramid coordinates against NumPy's, minimised by Gauss-Newton over points and rotations together."""

import numpy as np
import pytest
import scipy.sparse as sp

import sinew_native as sn

from ..meshes import STILL, ends, grid, moved, sphere, turn
from ..methods import bound_to
from .rows import Rows

SIDE = 0.05


def rings_of(count: int, faces: np.ndarray) -> tuple[list[list[int]], np.ndarray]:
    """The ring of each vertex in order, and whether it is open."""
    after: list[dict[int, int]] = [{} for _ in range(count)]
    for a, b, c in faces:
        after[a][b], after[b][c], after[c][a] = c, a, b
    rings, is_open = [], np.zeros(count, dtype=bool)
    for i, following in enumerate(after):
        first = set(following) - set(following.values())
        is_open[i] = bool(first)
        ring = [first.pop() if first else next(iter(following))]
        while ring[-1] in following and following[ring[-1]] != ring[0]:
            ring.append(following[ring[-1]])
        rings.append(ring)
    return rings, is_open


def mean_values(p: np.ndarray, i: int, ring: list[int]) -> np.ndarray:
    around = p[ring]
    middle = around.mean(0)
    normal = np.cross(around - middle, np.roll(around, -1, 0) - middle).sum(0)
    normal /= np.linalg.norm(normal)
    flat = around - p[i]
    flat -= np.outer(flat @ normal, normal)
    away = np.linalg.norm(flat, axis=1)
    angle = np.arccos(np.clip((flat * np.roll(flat, -1, 0)).sum(1) / away / np.roll(away, -1), -1, 1))
    w = (np.tan(angle / 2) + np.tan(np.roll(angle, 1) / 2)) / away
    return w / w.sum()


def table_of(p: np.ndarray, faces: np.ndarray) -> Rows:
    rings, is_open = rings_of(len(p), faces)
    a, b, c = p[faces].swapaxes(0, 1)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    rows, columns, values, group, weight = [], [], [], [], []
    for i, ring in enumerate(rings):
        share = np.full(len(ring), 1 / len(ring)) if is_open[i] else mean_values(p, i, ring)
        tip = p[i] - share @ p[ring]
        square = ((p[ring] - p[i]) ** 2).sum(1).mean()
        depth = tip @ tip
        k = area / (866 * square)
        if k * depth > 2 * SIDE * square:
            k = 2 * SIDE * square / depth
        rows += [len(weight)] * (len(ring) + 1)
        columns += [i, *ring]
        values += [1.0, *-share]
        group.append(i)
        weight.append(k)
        for j in ring:
            rows += [len(weight)] * 2
            columns += [j, i]
            values += [1.0, -1.0]
            group.append(i)
            weight.append(SIDE / len(ring))
    D = sp.csr_matrix((values, (rows, columns)), (len(weight), len(p)))
    return Rows(D, D @ p, np.array(group), np.array(weight))


def plate() -> tuple[np.ndarray, np.ndarray]:
    points, faces = grid(9)
    points = points.copy()
    points[:, 2] += 0.8 * np.sin(0.7 * points[:, 0]) * np.cos(0.5 * points[:, 1])
    return points, faces


@pytest.mark.parametrize("shape", [sphere(2), plate()], ids=["closed", "open"])
def test_minimum_is_that_of_gauss_newton(shape: tuple[np.ndarray, np.ndarray]) -> None:
    p, faces = shape
    low, high = p[:, 0].min(), p[:, 0].max()
    handles = ends(p, 0.15 * (high - low))
    centre = tuple(p[handles[1]].mean(0))
    poses = np.stack([STILL, turn((1, 0.3, 0.2), 50, centre, (0.1 * (low - high), 0.1 * (high - low), 0.05))])
    method = bound_to(sn.PyramidCoordinates(sn.SurfaceMesh(p, faces), side=SIDE), handles)
    ours, report = method.solve(poses, max_iterations=3000, tolerance=1e-14)

    x = p.copy()
    for pose, handle in zip(poses, handles):
        x[handle] = moved(pose, p[handle])
    free = np.setdiff1d(np.arange(len(p)), np.concatenate(handles))
    theirs, least, _turns = table_of(p, faces).minimum(x, free)
    assert report.energy == pytest.approx(least, rel=1e-6)  # both are flat there
    assert np.abs(ours - theirs).max() < 1e-3 * (high - low)


def test_a_morph_is_exact_at_both_ends_and_needs_no_handle() -> None:
    p, faces = sphere(2)
    other = moved(turn((1, 1, 0), 70), p * (1.5, 1.0, 0.6))
    method = sn.PyramidCoordinates(sn.SurfaceMesh(p, faces), target_shape=sn.SurfaceMesh(other, faces))
    method.set_handles([])
    nothing = np.zeros((0, 3, 4))
    np.testing.assert_array_equal(method.solve(nothing)[0], p)
    np.testing.assert_allclose(method.solve(nothing, morph=1.0)[0], other, atol=1e-11)
    half, report = method.solve(nothing, morph=0.5)
    assert report.converged
    np.testing.assert_array_equal(method.solve(nothing)[0], p)
    # Between the two sizes and turns: 35 degrees, and about the mean of the axes.
    back = moved(turn((1, 1, 0), -35), half)
    np.testing.assert_allclose(np.ptp(back, axis=0), 2 * np.array([1.25, 1.0, 0.8]), atol=0.08)
    assert method.folded_rings.size == 0
    # Lengths do not shrink half-way, as they do on straight lines between shapes that are turned.
    turned = sn.SurfaceMesh(moved(turn((0, 0, 1), 150), p), faces)
    method = bound_to(sn.PyramidCoordinates(sn.SurfaceMesh(p, faces), target_shape=turned), [])
    half, _ = method.solve(nothing, morph=0.5)
    np.testing.assert_allclose(half, moved(turn((0, 0, 1), 75), p), atol=1e-9)


def test_refusals() -> None:
    p, faces = sphere(1)
    mesh = sn.SurfaceMesh(p, faces)
    swapped = faces.copy()
    swapped[3] = swapped[3, [1, 0, 2]]
    with pytest.raises(sn.InvalidMesh, match="other vertices") as refused:
        sn.PyramidCoordinates(mesh, target_shape=sn.SurfaceMesh(p, swapped))
    assert refused.value.elements == [3]
    with pytest.raises(sn.InvalidMesh, match="vertices"):
        sn.PyramidCoordinates(mesh, target_shape=sn.SurfaceMesh(*sphere(2)))
    with pytest.raises(TypeError):
        sn.PyramidCoordinates(mesh, target_shape=p)
    method = bound_to(sn.PyramidCoordinates(mesh, target_shape=mesh), [[0, 1]])
    for morph in (-0.1, 1.5, float("nan")):
        with pytest.raises(sn.InvalidOption, match="morph"):
            method.solve([STILL], morph=morph)
