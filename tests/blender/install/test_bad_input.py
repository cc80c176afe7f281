# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad input: a report and a status with remedy, the rest shape, nothing lost, no traceback."""

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from inside import inner, settle
from probe import render_points
from registry import WITH_HANDLES
from rigs.rig import (
    Rig,
    add_group,
    add_regions,
    close,
    grid_object,
    make_active,
    new_object,
    press,
    refused,
    reopen,
)


def assert_at_rest(plate: Rig) -> None:
    assert np.array_equal(plate.points(), plate.rest())


def assert_lifted(plate: Rig, height: float = 0.5) -> None:
    """The handle followed its control, so nothing was lost."""
    assert plate.points()[plate.top, 2] == pytest.approx(height, abs=4e-6)


def test_no_handles(plate: Rig):
    press(plate.obj, "deformer_add", method="thin_shell")
    assert "Make Handle" in plate.deformer.status
    refused("Make Handle", "bind")
    assert_at_rest(plate)


def test_all_vertices_constrained(plate: Rig):
    add_group(plate.obj, "All", lambda point: True)
    add_regions(plate.obj, "thin_shell", {"All": "HANDLE"})
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


def hold_by(name: str) -> Callable[[Rig], None]:
    """All vertices are in a group that one of the settings names."""

    def hold(plate: Rig) -> None:
        owner = plate.deformer if name == "mask_group" else plate.deformer.parameters
        plate.deformer.parameters.stretching = 1.0  # so that it counts how the surface resists bends
        plate.obj.vertex_groups["Left"].add(range(len(plate.rest())), 1.0, "REPLACE")
        setattr(owner, name, "Left")
        settle()

    return hold


def hold_as(role: str) -> Callable[[Rig], None]:
    def hold(plate: Rig) -> None:
        press(plate.obj, "handle_add", kind=role, vertex_group="Left")

    return hold


HOLDS = {
    "handle": ("thin_shell", hold_as("HANDLE")),
    "fixed": ("arap", hold_as("FIXED")),
    "support": ("thin_shell", hold_as("SUPPORT")),
    "painted parameter": ("thin_shell", hold_by("bending_group")),
    "mask": ("thin_shell", hold_by("mask_group")),
    "handle in space": ("rbf", hold_as("HANDLE")),
    "fixed in space": ("mls", hold_as("FIXED")),
}


@pytest.mark.parametrize("what", HOLDS)
def test_weights_above_1_count_as_1(plate: Rig, what: str):
    """With Automatic Weights leaves weights of 1.003 behind."""
    method, hold = HOLDS[what]
    add_group(plate.obj, "Left", lambda point: point[0] < -0.5 and abs(point[1]) < 0.5)
    plate.bind(method)
    hold(plate)
    plate.lift(0.5)
    before = plate.points()
    for weight in (1.003, 1.7):
        weigh(plate.obj, "Left", weight)
        for _ in range(2):
            assert plate.deformer.status_level == "INFO", plate.deformer.status
            assert close(plate.points(), before)
            assert close(render_points(plate.obj), before)
            press(plate.obj, "bind")


def test_vertex_in_two_hard_handles(plate: Rig):
    shared = add_group(plate.obj, "Overlap", lambda point: point[1] > 0.55)
    plate.bind()
    make_active(plate.obj)
    assert bpy.ops.sinew.handle_add(kind="FIXED", vertex_group="Overlap") == {"FINISHED"}  # with a warning
    assert plate.deformer.status_level == "ERROR"
    assert "Top and Overlap share 22 vertices" in plate.deformer.status
    assert_at_rest(plate)
    bpy.ops.sinew.select_problems()
    bpy.ops.object.mode_set(mode="OBJECT")
    selected = {vertex.index for vertex in plate.obj.data.vertices if vertex.select}
    assert selected == set(plate.top) & set(shared)
    bpy.ops.sinew.handle_remove()
    assert plate.deformer.status_level == "INFO"


def test_zero_area_mesh(plate: Rig):
    for vertex in plate.obj.data.vertices:
        vertex.co = (vertex.co.y, 0.0, 0.0)
    plate.bind()
    assert plate.deformer.status_level == "INFO"
    notes = inner.status.notes(plate.deformer.uid)
    assert any(line.text.endswith("faces without area") for line in notes)
    plate.lift(0.5)
    assert np.isfinite(plate.points()).all()
    assert_lifted(plate)


def test_messy_mesh_binds_and_follows():
    """A duplicate face, a zero-area face, a loose vertex, a non-manifold edge, a loose edge."""
    mesh = grid_object().data
    points = [tuple(vertex.co) for vertex in mesh.vertices]
    faces = [tuple(polygon.vertices) for polygon in mesh.polygons]
    count = len(points)
    points += [(0.0, 0.0, 1.0), (3.0, 3.0, 3.0), (0.5, 0.5, 0.0)]
    faces += [faces[12], (60, 61, count), (40, 41, 42)]
    rig = Rig(new_object("Messy", points, faces, [(count + 1, 5)])).bind("arap")
    rig.lift(0.5)
    assert np.isfinite(rig.points()).all()
    hard = np.setdiff1d(rig.top, [count + 1])
    assert rig.points()[hard, 2] - rig.rest()[hard, 2] == pytest.approx(0.5, abs=4e-6)


@pytest.mark.parametrize("method", WITH_HANDLES)
@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_not_finite_coordinates_are_counted_and_the_rest_works(plate: Rig, method: str, value: float):
    reference = Rig(grid_object("Reference")).bind(method)
    reference.lift(0.5)
    plate.obj.data.vertices[60].co.z = value
    plate.bind(method)
    plate.lift(0.5)
    points = plate.points()
    others = np.arange(len(points)) != 60  # that one stays nowhere, as in the mesh
    np.testing.assert_allclose(points[others], reference.points()[others], atol=1e-6)
    press(plate.obj, "select_problems")
    bpy.ops.object.mode_set(mode="OBJECT")
    assert [vertex.index for vertex in plate.obj.data.vertices if vertex.select] == [60]
    bpy.ops.sinew.repair()
    assert np.isfinite(plate.rest()).all()
    np.testing.assert_allclose(plate.points(), reference.points(), atol=1e-5)


def test_control_scaled_to_zero_flattens_its_region_only(plate: Rig):
    plate.bind()
    plate.control.scale = (0.0, 0.0, 0.0)
    points = plate.points()
    assert np.ptp(points[plate.top], axis=0).max() < 1e-6
    assert np.isfinite(points).all()


def test_target_scaled_to_zero_says_so(plate: Rig):
    plate.bind().lift(0.5)
    plate.obj.scale = (1.0, 1.0, 0.0)
    assert_at_rest(plate)
    assert "scale" in plate.deformer.status
    plate.obj.scale = (1.0, 1.0, 1.0)
    assert_lifted(plate)
    assert plate.deformer.status_level == "INFO"


def test_cancel_in_the_middle_of_a_bind(plate: Rig):
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
    press(plate.obj, "bind")
    assert_lifted(plate)


def test_native_module_missing(plate: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The last solution stays, the panel says which wheel is needed, and what the artist does is kept."""
    plate.bind().lift(0.5)
    before = plate.points()
    missing = inner.backend.Availability(None, "The native module is missing. Install the Sinew zip")
    monkeypatch.setattr(inner.binding, "availability", lambda: missing)
    reopen(tmp_path / "rig.blend")
    assert np.array_equal(plate.points(), before)
    assert "native module is missing" in plate.deformer.status
    plate.lift(0.25)
    bpy.context.scene.frame_set(7)
    assert np.array_equal(plate.points(), before)
    add_group(plate.obj, "Side", lambda point: abs(point[1]) < 0.1)
    make_active(plate.obj)
    assert bpy.ops.sinew.handle_add(kind="FIXED", vertex_group="Side") == {"FINISHED"}  # with a warning
    assert len(plate.deformer.handles) == 3
    assert np.array_equal(plate.points(), before)
    monkeypatch.undo()
    bpy.ops.sinew.bind()
    assert plate.deformer.status_level == "INFO"
    assert_lifted(plate, 0.75)


def test_another_version_of_the_module_asks_for_a_restart(monkeypatch: pytest.MonkeyPatch):
    loader = inner.loader
    monkeypatch.setattr(loader, "VERSION", "99.0.0")
    assert "Restart Blender" in loader.load().remedy


@pytest.mark.parametrize(("method", "painted"), [("arap", "rigidity"), ("thin_shell", "bending")])
def test_a_painted_number_that_is_none_is_named_and_mended(plate: Rig, method: str, painted: str):
    plate.bind(method)
    plate.lift(0.5)
    add_group(plate.obj, "Paint", lambda _point: True)
    group = plate.obj.vertex_groups["Paint"]
    group.add([60], float("nan"), "REPLACE")
    setattr(plate.deformer.parameters, f"{painted}_group", "Paint")
    make_active(plate.obj)
    refused(f"{painted}: values at vertices 60 are not finite", "bind")
    assert plate.deformer.status_level == "ERROR"
    assert np.isfinite(plate.points()).all()
    assert bpy.ops.sinew.select_problems() == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    assert [vertex.index for vertex in plate.obj.data.vertices if vertex.select] == [60]
    group.add([60], 1.0, "REPLACE")
    assert bpy.ops.sinew.bind() == {"FINISHED"}
    assert_lifted(plate)
