# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertex groups deleted on a posed rig: what they held stays as it was bound, and a mask masks nothing."""

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from events import lives_on
from inside import settle
from mathutils import Matrix
from probe import render_points
from rigs.kinds import HandleRig
from rigs.rig import Rig, add_group, close, make_active, move_world, press, reopen, subdivided, update


def in_front(point: np.ndarray) -> bool:
    return point[0] > 0.5 and abs(point[1]) < 0.3


def a_region(role: str, where) -> Callable[[Rig], None]:
    def add(plate: Rig) -> None:
        add_group(plate.obj, "Lost", where)
        press(plate.obj, "handle_add", kind=role, vertex_group="Lost")

    return add


def a_painted_parameter(plate: Rig) -> None:
    add_group(plate.obj, "Lost", lambda point: point[0] < 0.0)
    plate.deformer.parameters.stretching = 1.0
    plate.deformer.parameters.bending_group = "Lost"
    settle()


LOST = {  # the method, what is held by the group, and what is said when it is not there
    "a second handle": ("thin_shell", a_region("HANDLE", in_front), "Lost is not used"),
    "a fixed region": ("thin_shell", a_region("FIXED", in_front), "Lost is not used"),
    "a support": ("thin_shell", a_region("SUPPORT", lambda point: point[1] > 0.0), "Lost is not used"),
    "a painted parameter": ("thin_shell", a_painted_parameter, "Bending is not painted"),
    "a handle in space": ("rbf", a_region("HANDLE", in_front), "Lost is not used"),
    "a fixed region in space": ("rbf", a_region("FIXED", in_front), "Lost is not used"),
}


@pytest.mark.parametrize("groups", [3, 12], ids=["few groups", "many groups"])
@pytest.mark.parametrize("what", LOST)
def test_what_a_deleted_group_held_is_left_out_by_the_next_bind(
    plate: Rig, tmp_path: Path, capfd: pytest.CaptureFixture, what: str, groups: int
):
    """Not by a render, a pause or a save: they all show the bound shape. Other groups are painted live."""
    method, hold, said = LOST[what]
    for number in range(groups - 3):
        add_group(plate.obj, f"Other {number}", lambda point: point[0] < 0.0)
    plate.bind(method)
    hold(plate)
    move_world(plate.control, Matrix.Translation((0.0, 0.0, 0.5)) @ Matrix.Rotation(0.4, 4, "X"))
    before = plate.points()
    remove_group(plate.obj, "Lost")

    def assert_shows_it() -> None:
        assert close(render_points(plate.obj), before)
        for pause in (update, settle):
            pause()
            assert close(plate.points(), before)
        assert plate.deformer.status_level == "INFO", plate.deformer.status

    assert_shows_it()
    plate.obj.vertex_groups["Top"].name = "Head"
    plate.obj.update_tag()
    assert_shows_it()
    assert plate.deformer.handles[0].vertex_group == "Head"
    reopen(tmp_path / "lost.blend")
    assert_shows_it()
    plate.obj.vertex_groups["Head"].remove(plate.top[:6].tolist())
    settle()
    assert not close(plate.points(), before, 1e-4)
    plate.obj.vertex_groups["Head"].add(plate.top.tolist(), 1.0, "REPLACE")
    settle()
    assert_shows_it()
    capfd.readouterr()
    press(plate.obj, "bind")
    for text in (plate.deformer.status, capfd.readouterr().out):
        assert said in text, text
        assert "'Lost' is not on the mesh" in text, text
    after = plate.points()
    assert not close(after, before, 0.01)
    assert close(render_points(plate.obj), after)


def remove_group(obj: bpy.types.Object, name: str) -> None:
    make_active(obj)
    obj.vertex_groups.active = obj.vertex_groups[name]
    assert bpy.ops.object.vertex_group_remove() == {"FINISHED"}


@pytest.mark.parametrize("levels", [(2, 3), (2, 1), (1, 3)], ids=["finer", "coarser", "other in both"])
@pytest.mark.parametrize("what", ["a second handle", "a fixed region"])
def test_what_a_deleted_group_held_stays_in_renders_of_other_vertices(
    plate: Rig, what: str, levels: tuple[int, int]
):
    """Also while the viewport waits for a Rebind."""
    modifier = subdivided(plate.obj, 2, 2)
    plate.bind(LOST[what][0])
    LOST[what][1](plate)
    plate.lift(0.5)
    seen = []
    for _ in range(2):
        modifier.levels, modifier.render_levels = levels
        seen.append(render_points(plate.obj))
        modifier.levels = modifier.render_levels = 2
        settle()
        if "Lost" in plate.obj.vertex_groups:
            plate.obj.vertex_groups.remove(plate.obj.vertex_groups["Lost"])
            plate.obj.update_tag()
            settle()
    assert close(seen[1], seen[0], 0.02)  # the border of a region lies between vertices


def test_a_mask_whose_group_is_deleted_masks_nothing_anywhere(posed: HandleRig):
    """As in any modifier: at once, in renders, after a pause and in the file; and the status says it."""
    if "Top" not in posed.obj.vertex_groups:
        pytest.skip("a target without vertex groups has no mask")
    add_group(posed.obj, "Left", lambda point: point[0] < 0.0)
    posed.deformer.mask_group = "Left"
    assert not posed.is_right()
    remove_group(posed.obj, "Left")
    assert posed.renders(posed.at(posed.height))
    for _ in range(2):
        lives_on(posed)
        settle()
    for _ in range(2):
        assert "The mask is not used" in posed.deformer.status
        posed.press("bind")
    reopen(posed.folder / "mask.blend")
    lives_on(posed)
    posed.deformer.mask_group = ""
    posed.obj.update_tag()
    update()
    assert "mask" not in posed.deformer.status
