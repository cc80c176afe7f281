# SPDX-License-Identifier: GPL-3.0-or-later
"""Controls that gain or lose points: a word about it and what to press, or with Automatic Rebind nothing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from inside import catch_up, inner, settle
from registry import RIGID_ON_HANDLE_POINTS
from rigs import rig as scenes
from rigs.cages import ball, box
from rigs.rig_of_curves import polyline
from rigs.rig_of_lattice import lattice_object, small_ball

LIFT = np.array((0.0, 0.0, 0.3))
FITS = 2e-5  # some methods keep their weights in single precision
LINE = np.column_stack((np.linspace(-1.0, 1.0, 6), np.zeros((6, 2))))
CORNERS = [(-1.0, -1.0, 0.2), (1.0, -1.0, 0.0), (1.0, 1.0, -0.3), (-1.0, 1.0, 0.4)]


def by_a_cage() -> None:
    scenes.press(ball("Target"), "cage_add", source="OBJECT", cage=box("Control").name)


def by_a_lattice() -> None:
    lattice_object((3, 3, 3), "Control")
    scenes.press(small_ball("Target", 2), "lattice_add", source="OBJECT", lattice="Control")


def by_hexahedra() -> None:
    box("Control", 4.0)
    scenes.press(small_ball("Target", 2), "lattice_add", source="OBJECT", lattice="Control")


def by_a_wire() -> None:
    """It reaches so far that it carries everything."""
    polyline(LINE, "Control")
    scenes.press(scenes.grid_object("Target"), "wire_add", curve="Control", radius=1e5)


def by_points(method: str = "mls") -> None:
    scenes.new_object("Control", CORNERS, edges=[(0, 1), (1, 2), (2, 3)])
    use_points(scenes.grid_object("Target"), method)


def by_points_of_a_curve() -> None:
    polyline(np.array(CORNERS), "Control")
    use_points(scenes.grid_object("Target"), "rbf")


def use_points(target: bpy.types.Object, method: str = "mls") -> None:
    scenes.press(target, "deformer_add", method=method)
    control().select_set(True)
    bpy.ops.sinew.point_add(source="POINTS")


def control() -> bpy.types.Object:
    return bpy.data.objects["Control"]


def target(name: str = "Target") -> bpy.types.Object:
    """Looked up each time: undo and load make new Python objects."""
    return bpy.data.objects[name]


def subdivided() -> None:
    scenes.on_all(control(), bpy.ops.curve.subdivide if control().type == "CURVE" else bpy.ops.mesh.subdivide)


def repeated() -> None:
    """By a modifier."""
    array = control().modifiers.new("Array", "ARRAY")
    array.use_merge_vertices = True
    array.relative_offset_displace = (1.0, 0.0, 0.0)


def not_repeated() -> None:
    control().modifiers.remove(control().modifiers["Array"])


def resolution(**points: int) -> Callable[[], None]:
    """As artists set it of a lattice."""

    def change() -> None:
        for name, count in points.items():
            setattr(control().data, name, count)

    return change


def smooth() -> None:
    """Blender then draws the curve in steps."""
    with scenes.in_mode(control()):
        bpy.ops.curve.select_all(action="SELECT")
        bpy.ops.curve.spline_type_set(type="BEZIER")
        bpy.ops.curve.handle_type_set(type="AUTOMATIC")


MORE = "Control has 7 points, at bind it had 4 - Rebind takes it as it is now"
# How it is bound, what happens to the control, what then takes it as it is now, and what is said until then.
CASES = {
    "a cage, subdivided": (by_a_cage, subdivided, "cage_set_rest", "26 vertices, at bind it had 8"),
    "a finer lattice": (by_a_lattice, resolution(points_u=5), "lattice_set_rest", "5 x 3 x 3"),
    "a coarser lattice": (by_a_lattice, resolution(points_u=2), "lattice_set_rest", "2 x 3 x 3"),
    "as many": (by_a_lattice, resolution(points_u=9, points_v=1), "lattice_set_rest", "9 x 1 x 3"),
    "hexahedra, repeated": (by_hexahedra, repeated, "lattice_set_rest", "at bind it had"),
    "a wire, subdivided": (by_a_wire, subdivided, "bind", "at bind it had 6"),
    "a wire that is smooth": (by_a_wire, smooth, "bind", "at bind it had 6"),
    "points, subdivided": (by_points, subdivided, "bind", MORE),
    "points, repeated": (by_points, repeated, "bind", "at bind it had 4"),
    "a curve, subdivided": (by_points_of_a_curve, subdivided, "bind", "at bind it had 4"),
}
each_case = pytest.mark.parametrize(("rig", "change", "remedy", "said"), CASES.values(), ids=CASES)


def posed(rig: Callable[..., None], automatic: bool = True, **words: str) -> None:
    """Bound, and moved by its control."""
    rig(**words)
    assert target().sinew.active.status_level == "INFO", target().sinew.active.status
    target().sinew.active.auto_rebind = automatic
    assert_follows()


def at_rest(obj: bpy.types.Object | None = None) -> bool:
    obj = obj or target()
    return scenes.close(scenes.evaluated_points(obj), scenes.base_points(obj), FITS)


def assert_bound_at_rest() -> None:
    assert target().sinew.active.status_level == "INFO", target().sinew.active.status
    assert at_rest()


def assert_goes_on_from_rest() -> None:
    settle()
    assert_bound_at_rest()
    assert_follows()


def assert_follows() -> None:
    """A motion of the whole control moves everything, from where it was."""
    before = scenes.evaluated_points(target())
    control().location.z += LIFT[2]
    assert scenes.close(scenes.evaluated_points(target()), before + LIFT, FITS), target().sinew.active.status


@pytest.mark.parametrize("automatic", [False, True])
@each_case
def test_a_control_with_other_points(rig, change, remedy: str, said: str, automatic: bool):
    posed(rig, automatic)
    change()
    settle()
    if not automatic:
        deformer = target().sinew.active
        assert deformer.status_level == "ERROR"
        for words in ("at bind it had", said, "Rebind" if remedy == "bind" else "New Rest"):
            assert words in deformer.status
        assert at_rest()
        scenes.press(target(), remedy)
    assert_bound_at_rest()
    assert_follows()


@pytest.mark.parametrize("method", RIGID_ON_HANDLE_POINTS)
def test_every_method_goes_on_with_more_handle_points(method: str):
    posed(by_points, method=method)
    subdivided()
    assert_goes_on_from_rest()


@each_case
def test_undo_and_redo_of_the_edit(rig, change, remedy: str, said: str):
    posed(rig)
    scenes.push("Posed")
    change()
    settle()
    scenes.push("Changed")
    for step in (bpy.ops.ed.undo, bpy.ops.ed.redo, bpy.ops.ed.undo):
        step()
        settle()
        assert target().sinew.active.status_level == "INFO", target().sinew.active.status
        assert_follows()
        control().location.z -= LIFT[2]  # Blender 5 relies on it that a step finds what the last one left
        scenes.update()


@pytest.mark.parametrize("automatic", [False, True])
@each_case
def test_saving_right_after_the_edit(rig, change, remedy: str, said: str, automatic: bool, tmp_path: Path):
    """No timer had time to look."""
    posed(rig, automatic)
    change()
    scenes.reopen(tmp_path / "rig.blend")
    settle()
    assert at_rest()
    if automatic:
        assert_goes_on_from_rest()
    else:
        assert "at bind it had" in target().sinew.active.status


def test_it_waits_for_the_end_of_edit_mode():
    posed(by_points)
    with scenes.in_mode(control()):
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.mesh.subdivide()
        control().update_from_editmode()
        settle()
        assert "at bind it had 4" in target().sinew.active.status
    assert_goes_on_from_rest()


def test_modifiers_come_and_go():
    posed(by_points)
    for _again in range(2):
        for change in (repeated, not_repeated):
            change()
            assert_goes_on_from_rest()


def test_the_points_of_other_controls_stay_posed():
    """Of two wires, the one that has gained points rests as it is; the other still moves what it moved."""
    plate = scenes.grid_object("Target")
    for name, y in (("Control", -0.5), ("Other", 0.5)):
        polyline(LINE + (0.0, y, 0.0), name)
        scenes.press(plate, "wire_add", curve=name, radius=0.4)
    plate.sinew.active.auto_rebind = True
    bpy.data.objects["Other"].location.z = control().location.z = 0.5
    before, rest = scenes.evaluated_points(plate), scenes.base_points(plate)
    subdivided()
    settle()
    assert plate.sinew.active.status_level == "INFO", plate.sinew.active.status
    near, far = rest[:, 1] < 0.0, rest[:, 1] > 0.0
    assert before[near, 2].max() > 0.4
    assert scenes.close(scenes.evaluated_points(plate)[near], rest[near], FITS)
    assert scenes.close(scenes.evaluated_points(plate)[far], before[far], FITS)


def test_all_objects_that_the_points_move_are_bound_again():
    posed(by_points)
    other = scenes.grid_object("Second", cells=7)
    use_points(other)
    other.sinew.active.auto_rebind = True
    subdivided()
    settle()
    before = scenes.evaluated_points(other)
    assert_bound_at_rest()
    assert at_rest(other)
    assert_follows()
    assert scenes.close(scenes.evaluated_points(other), before + LIFT, FITS)


def test_what_cannot_be_bound_says_so_once():
    """It is unbound then, so that no pause tries again."""
    posed(by_a_wire)
    control().data.bevel_depth = 0.1
    settle()
    deformer = target().sinew.active
    assert "Control shows faces" in deformer.status
    assert at_rest()
    assert not deformer.is_bound
    assert not catch_up()
    scenes.update()
    assert not inner.housekeeping.has_pending()
    control().data.bevel_depth = 0.0
    scenes.press(target(), "bind")
    assert scenes.close(scenes.evaluated_points(target()), scenes.base_points(target()) + LIFT, FITS), (
        "nothing took another rest"
    )
    assert_follows()
