# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh object as a parameter: the cage of the subspace Laplacian, moved, edited, and too small."""

from __future__ import annotations

import numpy as np
import pytest
from expected import faces_of
from inside import native
from rigs.cages import box
from rigs.kinds import HandleRig
from rigs.rig import CORNERS, close, update

METHOD = "subspace_laplacian"
ITERATED = 1e-3  # where the cage differs in its last digits, the method may stop a step earlier


@pytest.fixture
def rig() -> HandleRig:
    rig = HandleRig.new()
    rig.bind(METHOD)
    rig.lift(1.0)
    return rig


def test_the_native_object_gets_the_mesh_in_the_space_of_the_target(rig: HandleRig):
    own = rig.points()
    cage = box(size=4.0)
    cage.location = (0.2, 0.1, 0.0)
    update()
    rig.deformer.parameters.cage = cage
    caged = rig.points()
    assert rig.deformer.status_level == "INFO", rig.deformer.status
    assert np.abs(caged - own).max() > 5 * ITERATED
    corners = np.array(CORNERS) * 2.0 @ np.array(cage.matrix_world)[:3, :3].T + cage.matrix_world.translation
    back = np.array(rig.obj.matrix_world.inverted())
    shape = native().SurfaceMesh(corners @ back[:3, :3].T + back[:3, 3], faces_of(cage.data))
    expected = rig.expected(METHOD, cage=shape).lifted(1.0)
    assert np.abs(caged - expected).max() < ITERATED
    rig.deformer.parameters.cage = None
    assert close(rig.points(), own)


def test_an_edit_of_the_cage_binds_again(rig: HandleRig):
    cage = box(size=4.0)
    rig.deformer.parameters.cage = cage
    before = rig.points()
    for vertex in cage.data.vertices:
        vertex.co.x *= 1.5
    cage.data.update()
    assert np.abs(rig.points() - before).max() > 1e-4
    cage.scale = (1.0, 1.4, 1.0)
    moved = rig.points()
    assert np.abs(moved - before).max() > 1e-4


def test_a_cage_that_does_not_contain_the_mesh_is_refused(rig: HandleRig):
    rig.deformer.parameters.cage = box(size=0.6)
    rig.points()
    assert rig.deformer.status_level == "ERROR"
    assert "outside" in rig.deformer.status
