# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys and mouse of a modal transform against what Blender 3.4 does with the same events.

The view is Blender's front view: x to the right, z up, the viewer at -y. A pixel is a centimetre.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from sinew.core.transform.motion import Mode, Motion
from sinew.core.transform.typed_motion import TypedMotion, View
from sinew.core.transform.typed_numbers import TypedNumbers

X, Y, Z = np.eye(3)
FRONT = View(right=X, up=Z, toward=-Y, pixel=0.01, centre=(400.0, 300.0))
TILT = math.radians(30.0)
TILTED = np.column_stack(
    (X, math.cos(TILT) * Y + math.sin(TILT) * Z, -math.sin(TILT) * Y + math.cos(TILT) * Z)
)
CHARACTERS = {"PERIOD": ".", "MINUS": "-", "NUMPAD_MINUS": "-", "COMMA": ","}


def begin(mode: str = "TRANSLATE", view: View = FRONT, **keywords: float) -> TypedMotion:
    """The mouse a metre to the right of the pivot."""
    return TypedMotion(Mode(mode), view, TILTED, (500.0, 300.0), **keywords)


def keys(tool: TypedMotion, *sequence: str) -> TypedMotion:
    """``"G"`` a key, ``"+X"`` with Shift, ``"^TAB"`` with Ctrl, ``"-1.5"`` its characters one by one."""
    for word in sequence:
        if word[0].isdigit() or word[0] in ".-,":
            for character in word:
                assert tool.press("", character)
        else:
            assert tool.press(word.lstrip("+^"), "", shift=word[0] == "+", ctrl=word[0] == "^")
    return tool


def dragged(tool: TypedMotion, right: float, up: float) -> TypedMotion:
    tool.drag(500.0 + right, 300.0 + up)
    return tool


def metres(value: float) -> str:
    return f"{value:.4g} m"


def whole(tool: TypedMotion, pivot: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> np.ndarray:
    return tool.motion.matrix(TILTED, np.array(pivot))


# Move


def test_the_mouse_moves_in_the_view_plane():
    assert np.allclose(dragged(begin(), 50, 30).motion.move, (0.5, 0.0, 0.3))


@pytest.mark.parametrize(
    ("sequence", "expected"),
    [
        (["X"], (0.5, 0.0, 0.0)),
        (["Z"], (0.0, 0.0, 0.3)),
        (["+Z"], (0.5, 0.0, 0.0)),
        (["+X"], (0.0, 0.0, 0.3)),
        (["+Y"], (0.5, 0.0, 0.3)),
        (["X", "X", "X"], (0.5, 0.0, 0.3)),
        (["X", "Z"], (0.0, 0.0, 0.3)),
        (["X", "X", "Z"], (0.0, 0.0, 0.3)),
    ],
)
def test_global_constraints(sequence: list[str], expected: tuple[float, float, float]):
    tool = dragged(keys(begin(), *sequence), 50, 30)
    assert np.allclose(tool.motion.move, expected)
    assert not tool.motion.local


def test_the_second_press_is_local():
    tool = dragged(keys(begin(), "Z", "Z"), 50, 30)
    assert tool.motion.local
    along = whole(tool)[:3, 3]
    assert np.allclose(np.cross(along, TILTED[:, 2]), 0.0)
    assert along[2] == pytest.approx(0.3)  # it lies under the mouse


def test_shift_after_the_plain_letter_locks_the_local_axis():
    tool = dragged(keys(begin(), "Z", "+Z"), 50, 30)
    assert tool.motion.local
    assert whole(tool)[:3, 3] @ TILTED[:, 2] == pytest.approx(0.0, abs=1e-12)
    assert np.allclose(whole(tool)[[0, 2], 3], (0.5, 0.3))


def test_an_axis_along_the_line_of_sight_goes_by_up_and_down():
    """Measured in Blender 3.4: at 0.0109 units a pixel, 40 pixels up move -0.7602 along y."""
    view = replace(FRONT, pixel=0.010898770519823218)
    assert dragged(keys(begin(view=view), "Y"), 30, 40).motion.move[1] == pytest.approx(-0.7602, abs=1e-4)


def test_perspective_keeps_the_axis_under_the_mouse():
    """The viewer 5 away; an axis that comes towards the viewer: similar triangles give the point."""
    view = replace(FRONT, eye=np.array((0.0, -5.0, 0.0)))
    axes = np.column_stack(((1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (0.0, 0.0, math.sqrt(2.0)))) / math.sqrt(2.0)
    tool = TypedMotion(Mode.TRANSLATE, view, axes, (500.0, 300.0))
    keys(tool, "X", "X").drag(600.0, 300.0)
    t = tool.motion.move[0] / math.sqrt(2.0)  # the point (t, -t, 0) is seen at 5 t / (5 - t) = 1
    assert 5.0 * t / (5.0 - t) == pytest.approx(1.0)


def test_perspective_meets_the_plane_under_the_mouse():
    view = replace(FRONT, eye=np.array((0.0, -5.0, 2.0)), toward=np.array((0.0, -5.0, 2.0)) / math.sqrt(29.0))
    view = replace(view, up=np.cross(view.toward, X))
    tool = keys(TypedMotion(Mode.TRANSLATE, view, np.eye(3), (500.0, 300.0)), "+Z")
    tool.drag(530.0, 320.0)
    seen = 0.3 * X + 0.2 * view.up
    moved = np.array(tool.motion.move)
    assert moved[2] == pytest.approx(0.0, abs=1e-12)
    assert np.allclose(np.cross(moved - view.eye, seen - view.eye), 0.0)


def test_shift_slows_the_mouse_from_where_it_is():
    tool = dragged(begin(), 50, 0)
    tool.hold(shift=True, ctrl=False)
    dragged(tool, 70, 10)
    assert np.allclose(tool.motion.move, (0.52, 0.0, 0.01))


@pytest.mark.parametrize(
    ("shift", "grid", "expected"),
    [(False, 1.0, (1.0, 0.0, 0.0)), (True, 1.0, (0.1, 0.0, 0.0)), (False, 0.5, (0.5, 0.0, 0.5))],
)
def test_ctrl_snaps_moves(shift: bool, grid: float, expected: tuple[float, float, float]):
    tool = begin(grid=grid)
    tool.hold(shift, ctrl=True)
    assert np.allclose(dragged(tool, 66, 38).motion.move, expected)


def test_ctrl_let_go_gives_the_unsnapped_move_back():
    tool = begin()
    tool.hold(shift=False, ctrl=True)
    dragged(tool, 66, 38)
    tool.hold(shift=False, ctrl=False)
    assert np.allclose(tool.motion.move, (0.66, 0.0, 0.38))


# Rotate


def test_an_unconstrained_turn_is_positive_clockwise():
    """Blender: R 90 in front view takes x to -z."""
    assert np.allclose(whole(keys(begin("ROTATE"), "90"))[:3, 0], -Z)


def test_the_turn_follows_the_mouse():
    tool = begin("ROTATE")
    tool.drag(400.0, 400.0)
    assert np.allclose(whole(tool)[:3, 0], Z)
    assert "Rotation: -90.00°" in tool.header(metres)


@pytest.mark.parametrize(("key", "expected"), [("Y", Z), ("+Y", Z)])
def test_a_constrained_turn_follows_the_mouse_too(key: str, expected: np.ndarray):
    tool = keys(begin("ROTATE"), key)
    tool.drag(400.0, 400.0)
    assert np.allclose(whole(tool)[:3, 0], expected)


def test_an_axis_towards_the_viewer_turns_with_the_mouse():
    tool = keys(begin("ROTATE", replace(FRONT, toward=Y, right=-X)), "Y")
    tool.drag(400.0, 400.0)
    assert np.allclose(whole(tool)[:3, 0], -Z)  # x points left on this screen


def test_typed_turns_go_by_the_right_hand():
    assert np.allclose(whole(keys(begin("ROTATE"), "X", "90"))[:3, 1], Z)
    assert np.allclose(
        whole(keys(begin("ROTATE", turn=1.0), "Z", "1"))[:2, 0], (math.cos(1.0), math.sin(1.0))
    )


def test_more_than_a_full_turn():
    tool = keys(begin("ROTATE"), "Y")
    for degrees in range(0, 451, 30):
        angle = math.radians(degrees)
        tool.drag(400.0 + 100.0 * math.cos(angle), 300.0 + 100.0 * math.sin(angle))
    assert tool.motion.angle == pytest.approx(-math.radians(450.0))


def test_shift_slows_turns():
    tool = begin("ROTATE")
    tool.hold(shift=True, ctrl=False)
    tool.drag(400.0, 400.0)
    assert math.degrees(tool.motion.angle) == pytest.approx(-9.0)


@pytest.mark.parametrize(("shift", "expected"), [(False, 25.0), (True, 3.0)])
def test_ctrl_snaps_turns(shift: bool, expected: float):
    tool = keys(begin("ROTATE"), "Y")
    tool.hold(shift, ctrl=True)
    angle = math.radians(-27.4)
    tool.drag(400.0 + 100.0 * math.cos(angle), 300.0 + 100.0 * math.sin(angle))
    assert math.degrees(tool.motion.angle) == pytest.approx(expected)


# Scale


@pytest.mark.parametrize(("right", "expected"), [(50, 1.5), (-50, 0.5), (-150, -0.5)])
def test_the_factor_is_the_distance_from_the_centre(right: float, expected: float):
    assert np.allclose(dragged(begin("RESIZE"), right, 0).motion.scale, expected)


@pytest.mark.parametrize(
    ("sequence", "expected"),
    [
        (["2"], (2.0, 2.0, 2.0)),
        (["2", "TAB", "5"], (2.0, 5.0, 2.0)),
        (["TAB", "5"], (1.0, 5.0, 1.0)),
        (["Z", "2"], (1.0, 1.0, 2.0)),
        (["+Z", "2"], (2.0, 2.0, 1.0)),
        (["+Z", "2", "TAB", "3"], (2.0, 3.0, 1.0)),
    ],
)
def test_typed_factors(sequence: list[str], expected: tuple[float, float, float]):
    assert np.allclose(keys(begin("RESIZE"), *sequence).motion.scale, expected)


@pytest.mark.parametrize(("shift", "expected"), [(False, 1.5), (True, 1.05)])
def test_ctrl_snaps_factors(shift: bool, expected: float):
    tool = begin("RESIZE")
    tool.hold(shift, ctrl=True)
    assert np.allclose(dragged(tool, 47, 0).motion.scale, expected)


def test_a_factor_from_the_very_centre_is_finite():
    tool = TypedMotion(Mode.RESIZE, FRONT, TILTED, FRONT.centre)
    tool.drag(450.0, 300.0)
    assert np.isfinite(tool.motion.scale).all()


def test_scaling_along_a_local_axis_keeps_the_others():
    matrix = whole(keys(begin("RESIZE"), "Z", "Z", "3"), pivot=(1.0, 2.0, 3.0))
    linear = matrix[:3, :3]
    assert np.allclose(linear @ TILTED, TILTED * (1.0, 1.0, 3.0))
    assert np.allclose(matrix @ (1.0, 2.0, 3.0, 1.0), (1.0, 2.0, 3.0, 1.0))


# Typed numbers


@pytest.mark.parametrize(
    ("characters", "expected"),
    [
        ("1.5", 1.5),
        (".5", 0.5),
        ("1-", -1.0),
        ("-1", -1.0),
        ("-1-", 1.0),
        ("1.2.3", 1.23),
        ("0,25", 0.25),
        ("-", 0.0),
        (".", 0.0),
    ],
)
def test_what_is_typed(characters: str, expected: float):
    assert keys(begin(), "X", *characters).motion.move == (pytest.approx(expected), 0.0, 0.0)


def test_typed_components_and_tab():
    assert np.allclose(keys(begin(), "1-", "TAB", "2").motion.move, (-1.0, 2.0, 0.0))
    assert np.allclose(keys(begin(), "^TAB", "3").motion.move, (0.0, 0.0, 3.0))
    assert np.allclose(keys(begin(), "+X", "1", "TAB", "2").motion.move, (0.0, 1.0, 2.0))


def test_backspace_to_the_end_gives_the_mouse_back():
    tool = keys(dragged(begin(), 50, 30), "X", "25")
    assert keys(tool, "BACK_SPACE").motion.move[0] == 2.0
    assert keys(tool, "BACK_SPACE").motion.move[0] == pytest.approx(0.5)
    assert keys(tool, "12", "^BACK_SPACE").motion.move[0] == pytest.approx(0.5)


def test_typed_lengths_are_in_the_units_of_the_scene():
    assert keys(begin(unit=0.01), "X", "5").motion.move[0] == pytest.approx(0.05)


def test_a_very_long_number_stays_finite():
    numbers = TypedNumbers(1)
    for _ in range(1000):
        numbers.type("9")
    assert math.isfinite(numbers.value(0))


def test_keys_that_mean_nothing_are_refused():
    tool = begin()
    assert not tool.press("DEL")
    assert not tool.press("Q", "q")
    assert not tool.press("ONE", "1", ctrl=True)
    assert not tool.press("X", ctrl=True)
    assert not tool.press("", "²")
    assert tool.motion == Motion()


# Modes


def test_another_mode_keeps_the_axis_and_where_the_mouse_began():
    """As in Blender: R after a drag turns at once by the angle between the first place and this one."""
    tool = keys(dragged(begin(), 50, 30), "Z", "R")
    assert tool.motion.axis == (0.0, 0.0, 1.0)
    assert tool.motion.angle == pytest.approx(math.atan2(30.0, 150.0))
    assert np.allclose(keys(tool, "S").motion.scale, (1.0, 1.0, math.hypot(150.0, 30.0) / 100.0))
    assert np.allclose(keys(tool, "G").motion.move, (0.0, 0.0, 0.3))


def test_another_mode_forgets_what_was_typed():
    tool = keys(begin(), "X", "5", "R")
    assert tool.motion.angle == 0.0
    assert "[" not in tool.header(metres)


def test_the_same_mode_again_changes_nothing():
    tool = keys(dragged(begin(), 50, 30), "G")
    assert np.allclose(tool.motion.move, (0.5, 0.0, 0.3))


def test_another_view_keeps_what_was_done():
    side = View(right=Y, up=Z, toward=X, pixel=0.02, centre=(410.0, 300.0))
    tool = dragged(begin(), 50, 30)
    tool.look(side, 900.0, 900.0)
    assert np.allclose(tool.motion.move, (0.5, 0.0, 0.3))
    tool.drag(910.0, 905.0)
    assert np.allclose(tool.motion.move, (0.5, 0.2, 0.4))
    scaled = dragged(begin("RESIZE"), 50, 0)
    scaled.look(side, 430.0, 300.0)
    assert np.allclose(scaled.motion.scale, 1.5)
    scaled.drag(450.0, 300.0)
    assert np.allclose(scaled.motion.scale, 3.0)


# What the header says, as Blender writes it


@pytest.mark.parametrize(
    ("mode", "sequence", "expected"),
    [
        ("TRANSLATE", [], "Dx: 0.5 m   Dy: 0 m   Dz: 0.3 m (0.5831 m)"),
        ("TRANSLATE", ["X"], "D: 0.5 m (0.5 m) along global X"),
        ("TRANSLATE", ["+Z", "+Z"], "locking local Z"),
        ("TRANSLATE", ["X", "0.5"], "D: [0.5|] = 0.5 m (0.5 m) along global X"),
        ("TRANSLATE", ["1-", "TAB", "2"], "Dx: -1 m   Dy: [2|] = 2 m   Dz: 0 m (2.236 m)"),
        ("ROTATE", ["X", "90"], "Rotation: [90|] = 90.00° along global X"),
        ("RESIZE", ["2", "TAB", "5"], "Scale X: 2.0000   Y: [5|] = 5.0000   Z: 2.0000"),
        ("RESIZE", ["+Z", "2"], "Scale: [2|] = 2.0000 : 2.0000 locking global Z"),
    ],
)
def test_header(mode: str, sequence: list[str], expected: str):
    tool = dragged(begin(mode), 50, 30)
    assert expected in keys(tool, *sequence).header(metres)


def test_what_properties_keep_is_rounded_once():
    motion = Motion(Mode.TRANSLATE, move=(0.1, 0.2, 0.3), angle=0.1).rounded
    assert motion.move[0] == float(np.float32(0.1))
    assert motion.rounded == motion
