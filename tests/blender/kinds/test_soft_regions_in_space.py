# SPDX-License-Identifier: GPL-3.0-or-later
"""Regions painted with weights, which share vertices as those of bones do, for methods that move space."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from inside import notes_of
from registry import ON_HANDLE_POINTS
from rigs.cages import ball
from rigs.rig import add_regions, base_points, evaluated_points, update

LIFT = 0.5


def painted(method: str) -> bpy.types.Object:
    """A ball whose weights fade from the upper region to the lower one; they sum to 1 everywhere."""
    obj = ball("Target", 4)
    upper = np.clip(0.5 + 1.25 * base_points(obj)[:, 2], 0.0, 1.0)
    for name, weights in (("Upper", upper), ("Lower", 1.0 - upper)):
        group = obj.vertex_groups.new(name=name)
        for index in np.flatnonzero(weights):
            group.add([int(index)], float(weights[index]), "REPLACE")
    add_regions(obj, method, {"Upper": "HANDLE", "Lower": "FIXED"})
    return obj


def lifted(obj: bpy.types.Object) -> np.ndarray:
    return (evaluated_points(obj) - base_points(obj))[:, 2]


@pytest.mark.parametrize("method", ON_HANDLE_POINTS)
def test_regions_that_share_painted_vertices_blend(method: str):
    obj = painted(method)
    deformer = obj.sinew.active
    assert deformer.is_bound, deformer.status
    deformer.handles[0].control.location.z += LIFT
    update()
    assert deformer.status_level != "ERROR", (deformer.status, notes_of(deformer))
    height, up = base_points(obj)[:, 2], lifted(obj)
    assert up[height > 0.5].min() > 0.6 * LIFT
    assert up[height < -0.5].max() < 0.4 * LIFT
    rings = [up[np.abs(height - z) < 0.07].mean() for z in np.linspace(-0.36, 0.36, 7)]
    assert (np.diff(rings) > 0.0).all(), rings


@pytest.mark.parametrize("method", ON_HANDLE_POINTS)
def test_the_weight_of_a_region_counts_as_soon_as_it_changes(method: str):
    obj = painted(method)
    deformer = obj.sinew.active
    deformer.handles[0].control.location.z += LIFT
    before = lifted(obj)
    middle = np.abs(base_points(obj)[:, 2]) < 0.12
    deformer.handles[0].weight = 0.2
    update()
    assert deformer.status_level != "ERROR", deformer.status
    assert lifted(obj)[middle].mean() < before[middle].mean() - 1e-3
    deformer.handles[0].weight = 0.0
    assert np.abs(lifted(obj)).max() < 1e-5  # the lower one alone holds it
    assert any("weight is 0" in note for note in (deformer.status, *notes_of(deformer)))
