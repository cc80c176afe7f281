# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad input: a report and a status with remedy, the rest shape, nothing lost, no traceback."""

import re

import bpy
import numpy as np
import pytest
from inside import inner, settle
from probe import render_points
from registry import METHODS, WITH_HANDLES, Control
from rigs import rig as scenes
from rigs.cages import assert_goes_on, assert_rests, ball, box, motion_of, selected, set_rest, surround
from rigs.kinds import BY_CONTROL


def assert_at_rest(plate: scenes.Rig) -> None:
    assert np.array_equal(plate.points(), plate.rest())


def assert_lifted(plate: scenes.Rig, height: float = 0.5) -> None:
    """The handle followed its control, so nothing was lost."""
    assert plate.points()[plate.top, 2] == pytest.approx(height, abs=4e-6)


def test_all_vertices_constrained(plate: scenes.Rig):
    scenes.add_group(plate.obj, "All", lambda point: True)
    scenes.add_regions(plate.obj, "thin_shell", {"All": "HANDLE"})
    plate.lift(0.5)
    assert np.abs(plate.points() - plate.rest() - (0.0, 0.0, 0.5)).max() < 4e-6


def weigh(obj: bpy.types.Object, name: str, weight: float) -> None:
    """Store a weight of all its vertices as Blender itself does: a user or ``add`` cannot pass 1."""
    index = obj.vertex_groups[name].index
    for vertex in obj.data.vertices:
        groups = vertex.groups
        groups.foreach_set("weight", [weight if row.group == index else row.weight for row in groups])
    obj.data.update_tag()
    settle()


HOLDS = {  # the method, and how all its vertices are held: by a role, or by a group that a setting names
    "handle": ("thin_shell", "HANDLE"),
    "fixed": ("arap", "FIXED"),
    "support": ("thin_shell", "SUPPORT"),
    "painted parameter": ("thin_shell", "bending_group"),
    "mask": ("thin_shell", "mask_group"),
    "handle in space": ("rbf", "HANDLE"),
    "fixed in space": ("mls", "FIXED"),
}


@pytest.mark.parametrize("what", HOLDS)
def test_weights_above_1_count_as_1(plate: scenes.Rig, what: str):
    """With Automatic Weights leaves weights of 1.003 behind."""
    method, hold = HOLDS[what]
    scenes.add_group(plate.obj, "Left", lambda point: point[0] < -0.5 and abs(point[1]) < 0.5)
    plate.bind(method)
    if hold.isupper():
        scenes.press(plate.obj, "handle_add", kind=hold, vertex_group="Left")
    else:
        plate.deformer.parameters.stretching = 1.0  # so that it counts how the surface resists bends
        plate.obj.vertex_groups["Left"].add(range(len(plate.rest())), 1.0, "REPLACE")
        owner = plate.deformer if hold == "mask_group" else plate.deformer.parameters
        setattr(owner, hold, "Left")
        settle()
    plate.lift(0.5)
    before = plate.points()
    for weight in (1.003, 1.7):
        weigh(plate.obj, "Left", weight)
        for _ in range(2):
            assert plate.deformer.status_level == "INFO", plate.deformer.status
            assert scenes.close(plate.points(), before)
            assert scenes.close(render_points(plate.obj), before)
            scenes.press(plate.obj, "bind")


def test_zero_area_mesh(plate: scenes.Rig):
    for vertex in plate.obj.data.vertices:
        vertex.co = (vertex.co.y, 0.0, 0.0)
    plate.bind()
    assert plate.deformer.status_level == "INFO"
    notes = inner.status.notes(plate.deformer.uid)
    assert any(line.text.endswith("faces without area") for line in notes)
    plate.lift(0.5)
    assert np.isfinite(plate.points()).all()
    assert_lifted(plate)


@pytest.mark.parametrize("method", WITH_HANDLES)
@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_not_finite_coordinates_are_counted_and_the_rest_works(plate: scenes.Rig, method: str, value: float):
    reference = scenes.Rig(scenes.grid_object("Reference")).bind(method)
    reference.lift(0.5)
    plate.obj.data.vertices[60].co.z = value
    plate.bind(method)
    plate.lift(0.5)
    points = plate.points()
    others = np.arange(len(points)) != 60  # that one stays nowhere, as in the mesh
    np.testing.assert_allclose(points[others], reference.points()[others], atol=1e-6)
    status = inner.status
    (line,) = (line for line in status.notes(plate.deformer.uid) if "finite" in line.text)
    assert (line.remedy, line.elements.indices) == (status.Remedy.REPAIR, (60,))
    assert selected(plate.obj, "vertex")[1] == {60}
    bpy.ops.sinew.repair()
    assert not any("finite" in line.text for line in status.notes(plate.deformer.uid))
    assert np.isfinite(plate.rest()).all()
    np.testing.assert_allclose(plate.points(), reference.points(), atol=1e-5)


def test_control_scaled_to_zero_flattens_its_region_only_and_a_target_says_so(plate: scenes.Rig):
    plate.bind()
    plate.control.scale = (0.0, 0.0, 0.0)
    points = plate.points()
    assert np.ptp(points[plate.top], axis=0).max() < 1e-6
    assert np.isfinite(points).all()
    plate.control.scale = (1.0, 1.0, 1.0)
    plate.lift(0.5)
    plate.obj.scale = (1.0, 1.0, 0.0)
    assert_at_rest(plate)
    assert "scale" in plate.deformer.status
    plate.obj.scale = (1.0, 1.0, 1.0)
    assert_lifted(plate)
    assert plate.deformer.status_level == "INFO"


def test_cancel_in_the_middle_of_a_bind(plate: scenes.Rig):
    plate.bind().lift(0.5)
    stages = []

    def cancel(fraction: float, stage: str) -> bool:
        stages.append((fraction, stage))
        return False

    with pytest.raises(inner.errors.CancelledError):
        inner.bind.bind(plate.obj, plate.deformer, progress=cancel)
    assert stages
    assert_at_rest(plate)
    assert plate.deformer.status_level == "ERROR"
    assert len(plate.deformer.handles) == 2
    scenes.press(plate.obj, "bind")
    assert_lifted(plate)


def test_what_the_artist_does_without_the_native_module_is_kept(
    plate: scenes.Rig, monkeypatch: pytest.MonkeyPatch
):
    """What is seen and said then: ``test_event_files``."""
    plate.bind().lift(0.5)
    before = plate.points()
    missing = inner.backend.Availability(None, "The native module is missing. Install the Sinew zip")
    monkeypatch.setattr(inner.binding, "availability", lambda: missing)
    inner.sessions.find(plate.deformer.uid).bound = None
    plate.lift(0.25)
    scenes.add_group(plate.obj, "Side", lambda point: abs(point[1]) < 0.1)
    scenes.press(plate.obj, "handle_add", kind="FIXED", vertex_group="Side")  # with a warning
    assert "native module is missing" in plate.deformer.status
    assert len(plate.deformer.handles) == 3
    assert np.array_equal(plate.points(), before)
    monkeypatch.undo()
    scenes.press(plate.obj, "bind")
    assert plate.deformer.status_level == "INFO"
    assert_lifted(plate, 0.75)


@pytest.mark.parametrize(("method", "painted"), [("arap", "rigidity"), ("thin_shell", "bending")])
def test_a_painted_number_that_is_none_is_named_and_mended(plate: scenes.Rig, method: str, painted: str):
    plate.bind(method)
    plate.lift(0.5)
    scenes.add_group(plate.obj, "Paint", lambda _point: True)
    group = plate.obj.vertex_groups["Paint"]
    group.add([60], float("nan"), "REPLACE")
    setattr(plate.deformer.parameters, f"{painted}_group", "Paint")
    scenes.make_active(plate.obj)
    scenes.refused(f"{painted}: values at vertices 60 are not finite", "bind")
    assert plate.deformer.status_level == "ERROR"
    assert np.isfinite(plate.points()).all()
    assert selected(plate.obj, "vertex")[1] == {60}
    group.add([60], 1.0, "REPLACE")
    assert bpy.ops.sinew.bind() == {"FINISHED"}
    assert_lifted(plate)


LIMIT = 0.0001  # gigabytes; shown as 0.1 MB
OVERSHOT = 0.02  # surfaces that resist bending rise a little above the handle that lifts them


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.id)
def test_a_bind_above_the_limit_names_both_sizes_and_waits_for_a_higher_one(preferences, method):
    """A limit that is lowered afterwards leaves what is bound alone."""
    status = inner.status
    preferences.memory_limit = LIMIT
    kind = BY_CONTROL[method.control]
    # On handle points, a method may need no more than 4 bytes per vertex.
    rig = kind.large(cells=180) if method.is_space and method.control is Control.HANDLES else kind.large()
    rig.attach(method.id)
    obj = rig.obj
    scenes.refused(r"needs [\d.]+ MB, the memory limit is 0\.1 MB", "bind", obj)
    said = status.current(obj.sinew.active.uid)
    assert (said.level, said.remedy) == (status.Level.ERROR, status.Remedy.PREFERENCES)
    (needed,) = re.findall(r"needs ([\d.]+) MB, the memory limit is 0\.1 MB: raise the limit", said.text)
    assert float(needed) >= 0.1
    rig.lift(0.5)
    assert_rests(obj)
    preferences.memory_limit = 1.0
    scenes.press(obj, "bind")
    assert motion_of(obj)[:, 2].max() == pytest.approx(0.5, abs=OVERSHOT)
    preferences.memory_limit = LIMIT
    rig.lift(0.5)
    assert motion_of(obj)[:, 2].max() == pytest.approx(1.0, abs=2 * OVERSHOT)


def test_a_finer_cage_above_the_limit_is_refused_until_it_is_coarse_again(preferences):
    target, cage = ball(), box()
    deformer = surround(target, cage)
    preferences.memory_limit = LIMIT / 2
    smoother = scenes.subdivided(cage, 3, 3)
    smoother.subdivision_type = "SIMPLE"
    scenes.refused("memory limit", "cage_set_rest", target)
    assert_rests(target)
    assert inner.status.current(deformer.uid).remedy.name == "PREFERENCES"
    cage.modifiers.clear()
    set_rest(target)
    assert_goes_on(target, cage)
