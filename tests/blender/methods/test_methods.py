# SPDX-License-Identifier: GPL-3.0-or-later
"""Scripts and operators give the same; the add-on comes and goes without a trace."""

import bpy
import numpy as np
import pytest
from inside import inner, notes_of
from rigs.cages import ball
from rigs.rig import Rig, base_points, press, push, refused, update


def test_one_call_rigs_a_region_and_binds_it(plate: Rig):
    """As Make Handle does. A refused bind leaves the region, an unknown group leaves nothing."""
    errors, obj = inner.errors, plate.obj
    with pytest.raises(errors.SinewError):
        inner.rigging.rig_region(obj, inner.handles.NewRegion("HANDLE", "Nowhere"), "arap")
    assert obj.sinew.active is None
    plate.bind("arap").lift(0.3)
    by_operator = plate.points()
    press(plate.obj, "deformer_remove")
    for kind, group in (("HANDLE", "Top"), ("FIXED", "Base")):
        handle, refusal = inner.rigging.rig_region(obj, inner.handles.NewRegion(kind, group), "arap")
        assert handle.kind == kind
        assert refusal is None
    plate.lift(0.3)
    assert np.array_equal(plate.points(), by_operator)
    _handle, refusal = inner.rigging.rig_region(obj, inner.handles.NewRegion("FIXED", "Top"))
    assert isinstance(refusal, errors.ConstraintError)
    assert len(plate.deformer.handles) == 3
    assert plate.deformer.status_level == "ERROR"


def told(rig: Rig, words: str, **parameters: object) -> list[str]:
    """The notes with these words, once parameters are set."""
    for name, value in parameters.items():
        setattr(rig.deformer.parameters, name, value)
    update()
    return [line for line in notes_of(rig.deformer) if words in line]


def test_the_panel_counts_details_without_a_height():
    """Noise of three edges, as the base below it is not flat either."""
    plate, random = Rig.plate(cells=20), np.random.default_rng(1)
    for vertex in plate.obj.data.vertices:
        vertex.co = np.add(vertex.co, random.uniform(-0.3, 0.3, 3))
    plate.bind("multiresolution")
    for details, lines in (("displacement_vectors", 0), ("normal_displacements", 1)):
        assert len(told(plate, "no normal of the base leads there", details=details)) == lines


def test_the_panel_says_what_a_surface_method_uses_instead():
    """Limbs that the bases of eight bands would shrink to threads."""
    obj = ball("Limbs", 4)
    points = base_points(obj)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    along = np.abs(points).max(axis=1, keepdims=True)
    points *= 0.3 + 4.0 * np.clip((along - 0.9) / 0.1, 0.0, 1.0) + 0.1 * (along > 0.99)
    obj.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    limbs = Rig(obj, edge=3.0).bind("multiresolution")
    assert not told(limbs, "bands are used", bands=1)
    (line,) = told(limbs, "bands are used", bands=8)
    assert line.startswith("Only ")
    assert " of 8 " in line


def test_a_factor_is_offered_where_iterations_cannot_solve(plate: Rig):
    """The energy of variation has no multigrid."""
    plate.bind("thin_shell").lift(0.3)
    plate.deformer.thin_shell.variation = 0.1
    update()
    by_factor = plate.points()
    assert told(plate, "choose the factor", solver="multigrid") == []
    line = inner.status.current(plate.deformer.uid)
    assert ("choose the factor" in line.text, line.remedy) == (True, inner.status.Remedy.USE_FACTOR)
    push("Refused")
    press(plate.obj, "use_factor")
    assert plate.deformer.status_level == "INFO", plate.deformer.status
    assert np.array_equal(plate.points(), by_factor)
    plate.deformer.method = "laplacian_editing"
    refused("has no choice of solvers", "use_factor", plate.obj)
    push("Used")
    bpy.ops.ed.undo()
    assert bpy.context.object.sinew.active.thin_shell.solver == "multigrid"
