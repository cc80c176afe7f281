# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples that show figures of the tutorial: what its page says about each, in the scene of the sample."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

from blend_samples import posing
from blend_samples.lineups import LINEUPS

pytestmark = pytest.mark.skipif(bpy.app.version >= (4, 2, 0), reason="samples are made in Debian's Blender")


def posed(name: str, *labels: str) -> list[tuple[bpy.types.Object, np.ndarray, np.ndarray]]:
    """The objects of a row, or of some labels of it, with their points (n, 3) at rest and in the pose."""
    row = LINEUPS[name]
    replace(row, row={label: row.row[label] for label in labels or row.row}, active=0, smooth=False).make()
    objects = [(obj, posing.vertices(obj)) for obj in bpy.context.scene.objects if obj.sinew.deformers]
    return [(obj, rest, posing.shape(obj)[: len(rest)]) for obj, rest in objects]


def in_group(obj: bpy.types.Object, name: str) -> np.ndarray:
    index = obj.vertex_groups[name].index
    return np.array([any(row.group == index for row in vertex.groups) for vertex in obj.data.vertices])


def test_stretching_makes_a_tent_and_bending_a_hill():
    """Beside the handle, a membrane leaves the plane of the handle at once; further out it hangs lower."""
    gaps, heights = [], []
    for obj, rest, shape in posed("plate"):
        handle, flat = in_group(obj, "Handle"), np.column_stack((rest[:, :2], np.ones(len(rest))))
        plane = flat @ np.linalg.lstsq(flat[handle], shape[handle], rcond=None)[0]
        beside = ~handle & (np.linalg.norm(rest, axis=1) < 0.3)
        gaps.append(np.linalg.norm(plane - shape, axis=1)[beside].mean())
        heights.append(shape[~handle, 2].mean())
    assert gaps[0] > 3.0 * gaps[1] > 4.0 * gaps[2]
    assert heights == sorted(heights)


def test_the_rows_of_a_lattice_show_in_a_ridge_across_them():
    """Half way up, its outline should be an oval. It departs from one, by less where rows are finer."""
    spreads = []
    for _obj, rest, shape in posed("ffd"):
        level = np.linalg.norm(rest[:, :2] @ ((0.8, -0.6), (0.6, 0.8)) / (0.86, 0.36), axis=1)
        half_way = np.abs(shape[:, 2] / shape[:, 2].max() - 0.5) < 0.03
        spreads.append(level[half_way].std())
    assert spreads[0] > 1.5 * spreads[1] > 2.0 * spreads[2] > 0.04


def test_wheels_that_handles_hold_stay_round():
    ((engine, rest, shape),) = posed("machine", "Radial Basis Functions")
    for group in ("Bogie", "Drivers"):
        held = in_group(engine, group)
        radii = [np.linalg.norm(points[held] - points[held].mean(0), axis=1) for points in (rest, shape)]
        np.testing.assert_allclose(*radii, atol=1e-4)
    assert np.ptp(shape[:, 0]) > 1.3 * np.ptp(rest[:, 0])


def test_a_cow_follows_its_coarse_cage():
    """As the library alone says, for the cage as it is posed."""
    ((cow, rest, shape),) = posed("coordinates", "Mean Value")
    cage, native = cow.sinew.active.cage, posing.native()
    faces = [list(face.vertices) for face in cage.data.polygons]
    coordinates = native.MeanValue(native.SurfaceMesh(posing.vertices(cage), faces))
    coordinates.bind(rest)
    np.testing.assert_allclose(coordinates.warp(posing.shape(cage)), shape, atol=1e-4)
    assert len(faces) < 0.1 * len(rest)
    assert np.abs(shape - rest).max() > 0.3
