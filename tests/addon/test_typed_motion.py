# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys and mouse of a modal transform against what Blender 3.4 does with the same events.

The view is Blender's front view: x to the right, z up, the viewer at -y. A pixel is a centimetre. The mouse
begins a metre to the right of the pivot.
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
FROM_BEHIND = replace(FRONT, toward=Y, right=-X)
TILT = math.radians(30.0)
TILTED = np.column_stack(
    (X, math.cos(TILT) * Y + math.sin(TILT) * Z, -math.sin(TILT) * Y + math.cos(TILT) * Z)
)


def take(tool: TypedMotion, *steps) -> TypedMotion:
    """``(50, 30)`` moves the mouse so far from where it began; ``"G"`` is a key, ``"+X"`` with Shift,
    ``"^TAB"`` with Ctrl; ``"-1.5"`` is typed one character after another; ``"hold +^"`` holds Shift and
    Ctrl from then on.
    """
    for step in steps:
        if isinstance(step, tuple):
            tool.drag(500.0 + step[0], 300.0 + step[1])
        elif step.startswith("hold"):
            tool.hold(shift="+" in step, ctrl="^" in step)
        elif step[0].isdigit() or step[0] in ".-,":
            for character in step:
                assert tool.press("", character)
        else:
            assert tool.press(step.lstrip("+^"), "", shift=step[0] == "+", ctrl=step[0] == "^")
    return tool


def after(mode: str, *steps, view: View = FRONT, **keywords: float) -> TypedMotion:
    return take(TypedMotion(Mode(mode), view, TILTED, (500.0, 300.0), **keywords), *steps)


def around(degrees: float) -> tuple[float, float]:
    """The mouse on a circle around the pivot."""
    angle = math.radians(degrees)
    return 100.0 * math.cos(angle) - 100.0, 100.0 * math.sin(angle)


def metres(value: float) -> str:
    return f"{value:.4g} m"


ONE_PLACE = (0.0, 0.0, 0.0)


def whole(tool: TypedMotion, pivot: tuple[float, float, float] = ONE_PLACE) -> np.ndarray:
    return tool.motion.matrix(TILTED, np.array(pivot))


def table(*rows: tuple) -> pytest.MarkDecorator:
    """Rows of what is stated, steps, what is expected, and perhaps options of the tool."""
    filled = [pytest.param(*row[1:3], row[3] if len(row) > 3 else {}, id=row[0]) for row in rows]
    return pytest.mark.parametrize(("steps", "expected", "options"), filled)


MOUSE = (50, 30)


@table(
    ("along z", ["Z", MOUSE], (0.0, 0.0, 0.3)),
    ("in the plane without z", ["+Z", MOUSE], (0.5, 0.0, 0.0)),
    ("in the plane without y", ["+Y", MOUSE], (0.5, 0.0, 0.3)),
    ("the third press lets go", ["X", "X", "X", MOUSE], (0.5, 0.0, 0.3)),
    ("another letter is another axis", ["X", "Z", MOUSE], (0.0, 0.0, 0.3)),
    ("and global again", ["X", "X", "Z", MOUSE], (0.0, 0.0, 0.3)),
    ("Shift slows the mouse from where it is", [(50, 0), "hold +", (70, 10)], (0.52, 0.0, 0.01)),
    ("Ctrl snaps", ["hold ^", (66, 38)], (1.0, 0.0, 0.0)),
    ("Ctrl and Shift snap to tenths", ["hold +^", (66, 38)], (0.1, 0.0, 0.0)),
    ("Ctrl snaps to the grid", ["hold ^", (66, 38)], (0.5, 0.0, 0.5), {"grid": 0.5}),
    ("Ctrl let go gives the move back", ["hold ^", (66, 38), "hold"], (0.66, 0.0, 0.38)),
    ("a number", ["X", "1.5"], (1.5, 0.0, 0.0)),
    ("a number that begins with a point", ["X", ".5"], (0.5, 0.0, 0.0)),
    ("a minus behind it", ["X", "1-"], (-1.0, 0.0, 0.0)),
    ("a minus before it", ["X", "-1"], (-1.0, 0.0, 0.0)),
    ("two minuses", ["X", "-1-"], (1.0, 0.0, 0.0)),
    ("two points", ["X", "1.2.3"], (1.23, 0.0, 0.0)),
    ("a comma", ["X", "0,25"], (0.25, 0.0, 0.0)),
    ("a minus alone", ["X", "-"], (0.0, 0.0, 0.0)),
    ("a point alone", ["X", "."], (0.0, 0.0, 0.0)),
    ("Ctrl and Tab to the one before", ["^TAB", "3"], (0.0, 0.0, 3.0)),
    ("Tab passes over what is locked", ["+X", "1", "TAB", "2"], (0.0, 1.0, 2.0)),
    ("Backspace takes a digit", [MOUSE, "X", "25", "BACK_SPACE"], (2.0, 0.0, 0.0)),
    ("after the last digit the mouse is back", [MOUSE, "X", "2", "BACK_SPACE"], (0.5, 0.0, 0.0)),
    ("Ctrl and Backspace take all digits", [MOUSE, "X", "12", "^BACK_SPACE"], (0.5, 0.0, 0.0)),
    ("lengths are in the units of the scene", ["X", "5"], (0.05, 0.0, 0.0), {"unit": 0.01}),
    ("the same mode again changes nothing", [MOUSE, "G"], (0.5, 0.0, 0.3)),
)
def test_moves(steps: list, expected: tuple, options: dict):
    motion = after("TRANSLATE", *steps, **options).motion
    assert np.allclose(motion.move, expected)
    assert not motion.local


def test_shift_after_the_plain_letter_locks_the_local_axis():
    tool = after("TRANSLATE", "Z", "+Z", MOUSE)
    assert tool.motion.local
    assert whole(tool)[:3, 3] @ TILTED[:, 2] == pytest.approx(0.0, abs=1e-12)
    assert np.allclose(whole(tool)[[0, 2], 3], (0.5, 0.3))


def test_perspective_keeps_the_axis_under_the_mouse():
    """The viewer 5 away; an axis that comes towards the viewer: similar triangles give the point."""
    view = replace(FRONT, eye=np.array((0.0, -5.0, 0.0)))
    axes = np.column_stack(((1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (0.0, 0.0, math.sqrt(2.0)))) / math.sqrt(2.0)
    tool = take(TypedMotion(Mode.TRANSLATE, view, axes, (500.0, 300.0)), "X", "X", (100, 0))
    t = tool.motion.move[0] / math.sqrt(2.0)  # the point (t, -t, 0) is seen at 5 t / (5 - t) = 1
    assert 5.0 * t / (5.0 - t) == pytest.approx(1.0)


def test_perspective_meets_the_plane_under_the_mouse():
    view = replace(FRONT, eye=np.array((0.0, -5.0, 2.0)), toward=np.array((0.0, -5.0, 2.0)) / math.sqrt(29.0))
    view = replace(view, up=np.cross(view.toward, X))
    tool = take(TypedMotion(Mode.TRANSLATE, view, np.eye(3), (500.0, 300.0)), "+Z", (30, 20))
    under_the_mouse = 0.3 * X + 0.2 * view.up
    moved = np.array(tool.motion.move)
    assert moved[2] == pytest.approx(0.0, abs=1e-12)
    assert np.allclose(np.cross(moved - view.eye, under_the_mouse - view.eye), 0.0)


@table(
    # Blender: R 90 in front view takes x to -z.
    ("an unconstrained turn is positive clockwise", ["90"], (X, -Z)),
    ("the turn follows the mouse", [around(90)], (X, Z)),
    ("a constrained turn does too", ["Y", around(90)], (X, Z)),
    ("and one that locks the axis", ["+Y", around(90)], (X, Z)),
    # x points left on this screen.
    ("an axis towards the viewer turns with the mouse", ["Y", around(90)], (X, -Z), {"view": FROM_BEHIND}),
    ("typed turns go by the right hand", ["X", "90"], (Y, Z)),
    ("typed turns in radians", ["Z", "1"], (X, math.cos(1.0) * X + math.sin(1.0) * Y), {"turn": 1.0}),
)
def test_turns_take_one_direction_to_another(steps: list, expected: tuple, options: dict):
    before, turned = expected
    assert np.allclose(whole(after("ROTATE", *steps, **options))[:3, :3] @ before, turned)


@table(
    ("more than a full turn", ["Y", *map(around, range(0, 451, 30))], -450.0),
    ("Shift slows turns", ["hold +", around(90)], -9.0),
    ("Ctrl snaps turns", ["Y", "hold ^", around(-27.4)], 25.0),
    ("Ctrl and Shift snap to degrees", ["Y", "hold +^", around(-27.4)], 3.0),
)
def test_turns_by_angle(steps: list, expected: float, options: dict):
    motion = after("ROTATE", *steps, **options).motion
    assert math.degrees(motion.angle) == pytest.approx(expected)


@table(
    ("the factor is the distance from the centre", [(50, 0)], (1.5, 1.5, 1.5)),
    ("closer to it", [(-50, 0)], (0.5, 0.5, 0.5)),
    ("beyond it", [(-150, 0)], (-0.5, -0.5, -0.5)),
    ("a typed factor", ["2"], (2.0, 2.0, 2.0)),
    ("a second one", ["2", "TAB", "5"], (2.0, 5.0, 2.0)),
    ("the second one alone", ["TAB", "5"], (1.0, 5.0, 1.0)),
    ("along z", ["Z", "2"], (1.0, 1.0, 2.0)),
    ("without z, two factors", ["+Z", "2", "TAB", "3"], (2.0, 3.0, 1.0)),
    ("Ctrl snaps factors", ["hold ^", (47, 0)], (1.5, 1.5, 1.5)),
    ("Ctrl and Shift snap to twentieths", ["hold +^", (47, 0)], (1.05, 1.05, 1.05)),
)
def test_factors(steps: list, expected: tuple, options: dict):
    assert np.allclose(after("RESIZE", *steps, **options).motion.scale, expected)


def test_a_factor_from_the_very_centre_is_finite():
    tool = TypedMotion(Mode.RESIZE, FRONT, TILTED, FRONT.centre)
    tool.drag(450.0, 300.0)
    assert np.isfinite(tool.motion.scale).all()


def test_scaling_along_a_local_axis_keeps_the_others():
    matrix = whole(after("RESIZE", "Z", "Z", "3"), pivot=(1.0, 2.0, 3.0))
    linear = matrix[:3, :3]
    assert np.allclose(linear @ TILTED, TILTED * (1.0, 1.0, 3.0))
    assert np.allclose(matrix @ (1.0, 2.0, 3.0, 1.0), (1.0, 2.0, 3.0, 1.0))


def test_a_very_long_number_stays_finite():
    numbers = TypedNumbers(1)
    for _ in range(1000):
        numbers.type("9")
    assert math.isfinite(numbers.value(0))


def test_keys_that_mean_nothing_are_refused():
    tool = after("TRANSLATE")
    assert not tool.press("DEL")
    assert not tool.press("Q", "q")
    assert not tool.press("ONE", "1", ctrl=True)
    assert not tool.press("X", ctrl=True)
    assert not tool.press("", "²")
    assert tool.motion == Motion()


def test_another_mode_keeps_the_axis_and_where_the_mouse_began():
    """As in Blender: R after a drag turns at once by the angle between the first place and this one."""
    tool = after("TRANSLATE", MOUSE, "Z", "R")
    assert tool.motion.axis == (0.0, 0.0, 1.0)
    assert tool.motion.angle == pytest.approx(math.atan2(30.0, 150.0))
    assert np.allclose(take(tool, "S").motion.scale, (1.0, 1.0, math.hypot(150.0, 30.0) / 100.0))
    assert np.allclose(take(tool, "G").motion.move, (0.0, 0.0, 0.3))


def test_another_mode_forgets_what_was_typed():
    tool = after("TRANSLATE", "X", "5", "R")
    assert tool.motion.angle == 0.0
    assert "[" not in tool.header(metres)


def test_another_view_keeps_what_was_done():
    side = View(right=Y, up=Z, toward=X, pixel=0.02, centre=(410.0, 300.0))
    tool = after("TRANSLATE", MOUSE)
    tool.change_view(side, 900.0, 900.0)
    assert np.allclose(tool.motion.move, (0.5, 0.0, 0.3))
    tool.drag(910.0, 905.0)
    assert np.allclose(tool.motion.move, (0.5, 0.2, 0.4))
    scaled = after("RESIZE", (50, 0))
    scaled.change_view(side, 430.0, 300.0)
    assert np.allclose(scaled.motion.scale, 1.5)
    scaled.drag(450.0, 300.0)
    assert np.allclose(scaled.motion.scale, 3.0)


AXES = np.array(
    (0.9751703, -0.0795999, 0.206656, 0.0978434, 0.9920134, -0.0795999, -0.1986693, 0.0978434, 0.9751703)
)
AXES = AXES.reshape(3, 3)
PIVOT = np.array((1.83568, 0.817786, 0.063903))
SIDE = np.array((0.7386934, 0.6733669, 0.0301508))
ABOVE = np.array((-0.2311558, 0.2110552, 0.9497488))
VIEWS = {
    "front": replace(FRONT, pixel=0.009536424, centre=(471.53312, 226.22871)),
    "slanted": View(SIDE, ABOVE, np.cross(SIDE, ABOVE), 0.009536424, (486.76768, 207.82093)),
}
EYE = np.array((2.896481, -5.777584, 2.317001))
VIEWS["perspective"] = replace(VIEWS["slanted"], pixel=0.009058919, centre=(496.05893, 206.09838), eye=EYE)
AS_IT_IS = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
ABOUT_Y = ((0.78023, 0.0, -0.62549), (0.0, 1.0, 0.0), (0.62549, 0.0, 0.78023))
ABOUT_Z = ((0.78023, -0.62549, 0.0), (0.62549, 0.78023, 0.0), (0.0, 0.0, 1.0))
SLANTED_Z = ((0.88246, -0.47039, 0.0), (0.47039, 0.88246, 0.0), (0.0, 0.0, 1.0))


@pytest.mark.parametrize(
    ("view", "mode", "steps", "move", "linear"),
    [
        ("front", "TRANSLATE", [(60, 40)], (0.57219, 0.0, 0.38146), AS_IT_IS),
        ("front", "TRANSLATE", ["X", (60, 40)], (0.57219, 0.0, 0.0), AS_IT_IS),
        ("front", "TRANSLATE", ["Z", "Z", (60, 40)], (0.10196, -0.03927, 0.48111), AS_IT_IS),
        ("front", "TRANSLATE", ["+X", (60, 40)], (0.0, 0.0, 0.38146), AS_IT_IS),
        ("front", "TRANSLATE", ["Y", (30, 40)], (0.0, -0.58204, 0.0), AS_IT_IS),
        ("front", "TRANSLATE", ["1-", "TAB", "2"], (-1.0, 2.0, 0.0), AS_IT_IS),
        ("front", "ROTATE", [(-90, 120)], ONE_PLACE, ABOUT_Y),
        ("front", "ROTATE", ["X", "90"], ONE_PLACE, ((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0))),
        ("front", "ROTATE", ["Z", (-90, 120)], ONE_PLACE, ABOUT_Z),
        ("front", "RESIZE", [(70, 20)], ONE_PLACE, np.diag((1.71959, 1.71959, 1.71959))),
        ("front", "RESIZE", ["+Z", "2"], ONE_PLACE, np.diag((2.0, 2.0, 1.0))),
        ("front", "TRANSLATE", ["Z", (60, 40), "R", (-90, 120)], ONE_PLACE, ABOUT_Z),
        ("slanted", "TRANSLATE", ["X", (60, 40)], (0.55833, 0.0, 0.0), AS_IT_IS),
        ("slanted", "TRANSLATE", ["+X", (60, 40)], (0.0, 0.84011, 0.21495), AS_IT_IS),
        ("slanted", "ROTATE", ["Z", (-90, 120)], ONE_PLACE, SLANTED_Z),
        ("perspective", "TRANSLATE", [(60, 40)], (0.31774, 0.44248, 0.36054), AS_IT_IS),
        ("perspective", "TRANSLATE", ["X", (60, 40)], (0.42741, 0.0, 0.0), AS_IT_IS),
    ],
)
def test_the_same_events_move_as_blender_does(view: str, mode: str, steps: list, move: tuple, linear):
    """Blender 3.4's own transforms in a window: where they took a selection, to the fifth decimal."""
    tool = take(TypedMotion(Mode(mode), VIEWS[view], AXES, (500.0, 300.0)), *steps)
    matrix = tool.motion.rounded.matrix(AXES, PIVOT)
    assert np.abs(matrix[:3, :3] - linear).max() < 1e-4
    assert np.abs(matrix[:3, :3] @ PIVOT + matrix[:3, 3] - PIVOT - move).max() < 1e-4


@pytest.mark.parametrize(
    ("mode", "steps", "expected"),
    [
        ("TRANSLATE", [], "Dx: 0.5 m   Dy: 0 m   Dz: 0.3 m (0.5831 m)"),
        ("TRANSLATE", ["X"], "D: 0.5 m (0.5 m) along global X"),
        ("TRANSLATE", ["+Z", "+Z"], "locking local Z"),
        ("TRANSLATE", ["X", "0.5"], "D: [0.5|] = 0.5 m (0.5 m) along global X"),
        ("TRANSLATE", ["1-", "TAB", "2"], "Dx: -1 m   Dy: [2|] = 2 m   Dz: 0 m (2.236 m)"),
        ("ROTATE", [around(90)], "Rotation: -90.00°"),
        ("ROTATE", ["X", "90"], "Rotation: [90|] = 90.00° along global X"),
        ("RESIZE", ["2", "TAB", "5"], "Scale X: 2.0000   Y: [5|] = 5.0000   Z: 2.0000"),
        ("RESIZE", ["+Z", "2"], "Scale: [2|] = 2.0000 : 2.0000 locking global Z"),
    ],
)
def test_the_header_is_as_blender_writes_it(mode: str, steps: list, expected: str):
    assert expected in after(mode, MOUSE, *steps).header(metres)


def test_what_properties_keep_is_rounded_once():
    motion = Motion(Mode.TRANSLATE, move=(0.1, 0.2, 0.3), angle=0.1).rounded
    assert motion.move[0] == float(np.float32(0.1))
    assert motion.rounded == motion
