# SPDX-License-Identifier: GPL-3.0-or-later
"""The motion that mouse and keys of a modal tool describe, with constraints, typed numbers and snapping.

Signs, increments and the order of constraints are those of Blender's own Move, Rotate and Scale. Lengths are
in world units, angles in radians, mouse positions in pixels.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import atan2, copysign, degrees, hypot, pi, radians, remainder, sin

import numpy as np

from .motion import Mode, Motion
from .typed_numbers import TypedNumbers

PRECISION = 0.1  # factor of the mouse motion while Shift is held
_EDGE_ON = sin(radians(5.0))  # an axis that is nearer to the line of sight cannot follow the mouse
_LETTERS = ("X", "Y", "Z")


_MODE_KEYS = {"G": Mode.TRANSLATE, "R": Mode.ROTATE, "S": Mode.RESIZE}
_INCREMENTS = {Mode.TRANSLATE: 1.0, Mode.ROTATE: radians(5.0), Mode.RESIZE: 0.1}
# Factors of the increments while Shift is held.
_FINE = {Mode.TRANSLATE: 0.1, Mode.ROTATE: 0.2, Mode.RESIZE: 0.1}


@dataclass(frozen=True)
class View:
    """The view of the pivot on the screen.

    ``right``, ``up`` and ``toward`` are directions (3,) in the world, and ``pixel`` is the length of a pixel
    in the world, at the depth of the pivot. ``centre`` is the pivot on the screen. ``eye`` is the position of
    the viewer relative to the pivot, or None for an orthographic view.
    """

    right: np.ndarray
    up: np.ndarray
    toward: np.ndarray
    pixel: float
    centre: tuple[float, float]
    eye: np.ndarray | None = None

    def same_as(self, other: "View") -> bool:
        """Whether the view was not rotated, moved or zoomed."""
        return self.centre == other.centre and self.pixel == other.pixel and np.array_equal(self.up, other.up)


@dataclass(frozen=True)
class _Constraint:
    """A constraint. ``letter`` is the axis that moves, or with ``plane`` the axis that is locked.

    Without a letter all axes move.
    """

    letter: str = ""
    plane: bool = False
    local: bool = False

    @property
    def rows(self) -> list[int]:
        """The numbers of the axes that move."""
        if not self.letter:
            return [0, 1, 2]
        chosen = _LETTERS.index(self.letter)
        return [row for row in range(3) if (row == chosen) != self.plane]

    def after(self, letter: str, plane: bool) -> "_Constraint":
        """The constraint after a key.

        The same axis again changes global to local to free; another starts global.
        """
        if letter != self.letter:
            return _Constraint(letter, plane)
        return _Constraint() if self.local else _Constraint(letter, plane, local=True)

    @property
    def text(self) -> str:
        """The text for the header."""
        if not self.letter:
            return ""
        return f" {'locking' if self.plane else 'along'} {'local' if self.local else 'global'} {self.letter}"


class TypedMotion:
    """The state of a modal tool. Call ``press``, ``drag`` and ``change_view`` for events, and read
    ``motion``.

    ``axes`` (3, 3) are the local axes as unit columns. Ctrl snaps moves to steps of ``grid``. A typed 1 means
    ``unit`` world units, or ``turn`` radians.
    """

    def __init__(
        self,
        mode: Mode,
        view: View,
        axes: np.ndarray,
        mouse: tuple[float, float],
        grid: float = 1.0,
        unit: float = 1.0,
        turn: float = pi / 180.0,
    ) -> None:
        self.mode = mode
        self.view = view
        self.snaps = self.precise = False
        self.numbers = TypedNumbers()
        self._axes, self._grid, self._unit, self._turn = axes, grid, unit, turn
        self._constraint = _Constraint()
        self._mouse_at_start = mouse
        self._start()

    def _start(self) -> None:
        """Start without a motion, with the mouse where it was when the tool started."""
        self._mouse = self._mouse_at_start
        self._base, self._dragged = np.zeros(3), np.zeros(3)
        self._turned = 0.0  # counterclockwise on the screen
        self._factor = 1.0
        # The mouse when scaling began, and now; Shift slows the latter.
        self._scale_start = self._scale_mouse = self._mouse
        self.numbers = TypedNumbers(self._components)

    @property
    def _components(self) -> int:
        return 1 if self.mode is Mode.ROTATE else len(self._constraint.rows)

    # Events

    def hold(self, shift: bool, ctrl: bool) -> None:
        """Note which modifier keys are held."""
        self.precise, self.snaps = shift, ctrl

    def press(self, key: str, character: str = "", shift: bool = False, ctrl: bool = False) -> bool:
        """Process a key, by Blender's name and the character that it types; False if it has no meaning."""
        if key in _MODE_KEYS and not ctrl:
            if self.mode is not _MODE_KEYS[key]:
                self.mode, mouse = _MODE_KEYS[key], self._mouse
                self._start()
                self.drag(*mouse)
        elif key in _LETTERS and not ctrl:
            self._constraint = self._constraint.after(key, shift)
            self.numbers.resize(self._components)
        elif key == "TAB":
            self.numbers.step(-1 if ctrl else 1)
        elif key == "BACK_SPACE":
            self.numbers.erase(everything=ctrl)
        else:
            return not ctrl and self.numbers.type(character)
        return True

    def drag(self, x: float, y: float) -> None:
        """Process a motion of the mouse to a position."""
        view, (cx, cy) = self.view, self.view.centre
        slow = PRECISION if self.precise else 1.0
        right, up = (x - self._mouse[0]) * slow, (y - self._mouse[1]) * slow
        self._dragged = self._dragged + (right * view.right + up * view.up) * view.pixel
        self._scale_mouse = (self._scale_mouse[0] + right, self._scale_mouse[1] + up)
        before = atan2(self._mouse[1] - cy, self._mouse[0] - cx)
        self._turned += remainder(atan2(y - cy, x - cx) - before, 2.0 * pi) * slow
        self._mouse = (x, y)

    def change_view(self, view: View, x: float, y: float) -> None:
        """Process a change of the view. The motion so far stays, and the mouse continues from here."""
        self._base = self._moved()
        self._dragged = np.zeros(3)
        self._factor = self._resized()
        self._mouse_at_start = self._mouse = self._scale_start = self._scale_mouse = (x, y)
        self.view = view

    # Results

    @property
    def motion(self) -> Motion:
        """The current motion."""
        local, values = self._constraint.local, self._values()
        if self.mode is Mode.ROTATE:
            axis = self._turning_axis()
            return Motion(self.mode, local, angle=values[0], axis=tuple(axis.tolist()))
        whole = [0.0 if self.mode is Mode.TRANSLATE else 1.0] * 3
        for row, value in zip(self._constraint.rows, values, strict=True):
            whole[row] = value
        x, y, z = whole
        if self.mode is Mode.TRANSLATE:
            return Motion(self.mode, local, move=(x, y, z))
        return Motion(self.mode, local, scale=(x, y, z))

    def header(self, length: Callable[[float], str]) -> str:
        """The text for the header. ``length`` formats a length in the units of the scene."""
        values, where = self._values(), self._constraint.text
        if self.mode is Mode.ROTATE:
            return f"Rotation: {self.numbers.shown(0, f'{degrees(values[0]):.2f}°')}{where}"
        write = length if self.mode is Mode.TRANSLATE else "{:.4f}".format
        texts = [self.numbers.shown(component, write(value)) for component, value in enumerate(values)]
        if self.mode is Mode.RESIZE:
            if where:
                return f"Scale: {' : '.join(texts)}{where}"
            return "Scale " + "   ".join(
                f"{name}: {text}" for name, text in zip(_LETTERS, texts, strict=True)
            )
        names = ("D",) * len(texts) if where else ("Dx", "Dy", "Dz")
        each = "   ".join(f"{name}: {text}" for name, text in zip(names, texts, strict=True))
        return f"{each} ({length(float(np.linalg.norm(values)))}){where}"

    def _values(self) -> list[float]:
        """One number per component: the typed numbers or, if there are none, those of the mouse, snapped."""
        if self.numbers:
            return self._typed()
        values = self._from_mouse()
        if not self.snaps:
            return values
        step = _INCREMENTS[self.mode] * (self._grid if self.mode is Mode.TRANSLATE else 1.0)
        step *= _FINE[self.mode] if self.precise else 1.0
        return [round(value / step) * step for value in values]

    def _typed(self) -> list[float]:
        """The typed numbers. A single factor scales all axes."""
        numbers = [self.numbers.value(component) for component in range(self._components)]
        if self.mode is Mode.RESIZE:
            other = 1.0 if numbers[0] is None else numbers[0]
            return [other if number is None else number for number in numbers]
        size = self._unit if self.mode is Mode.TRANSLATE else self._turn
        return [(number or 0.0) * size for number in numbers]

    def _from_mouse(self) -> list[float]:
        if self.mode is Mode.TRANSLATE:
            along = self._frame.T @ self._moved()
            return [float(along[row]) for row in self._constraint.rows]
        if self.mode is Mode.RESIZE:
            return [self._resized()] * self._components
        axis = self._frame @ self._turning_axis()
        return [-self._turned if axis @ self.view.toward < -1e-6 else self._turned]

    @property
    def _frame(self) -> np.ndarray:
        return self._axes if self._constraint.local else np.eye(3)

    def _turning_axis(self) -> np.ndarray:
        """The axis of the constraint; without one, away from the viewer, so that clockwise is positive."""
        if not self._constraint.letter:
            return -self.view.toward
        return np.eye(3)[_LETTERS.index(self._constraint.letter)]

    def _resized(self) -> float:
        """The scale: the mouse's distance from the centre now, divided by that at the start.

        It is negative if the mouse is on the other side of the centre.
        """
        cx, cy = self.view.centre
        then = (self._scale_start[0] - cx, self._scale_start[1] - cy)
        now = (self._scale_mouse[0] - cx, self._scale_mouse[1] - cy)
        side = copysign(1.0, then[0] * now[0] + then[1] * now[1])
        return self._factor * side * hypot(*now) / max(hypot(*then), 1.0)

    def _moved(self) -> np.ndarray:
        """The move in the world, (3,), before snapping: on the constraint, under the mouse."""
        letter, frame = self._constraint.letter, self._frame
        if not letter:
            return self._base + self._dragged
        axis = frame[:, _LETTERS.index(letter)]
        kept = axis * (axis @ self._base)
        if self._constraint.plane:
            return self._base - kept + self._on_plane(axis)
        return kept + axis * self._along(axis)

    def _sight(self, point: np.ndarray) -> np.ndarray:
        """The direction of sight (3,) at a point (3,) that is given relative to the pivot."""
        if self.view.eye is None:
            return -self.view.toward
        sight = point - self.view.eye
        return sight / np.linalg.norm(sight)

    def _along(self, axis: np.ndarray) -> float:
        """How far along an axis through the pivot the point under the mouse is."""
        dragged, sight = self._dragged, self._sight(np.zeros(3))
        aside = np.cross(sight, axis)
        if aside @ aside < _EDGE_ON**2:  # as in Blender: the mouse moves it up and down, slowly at first
            lift = 2.0 * float(dragged @ self.view.up)
            return -copysign(lift * lift, lift)
        dragged = dragged - aside * (aside @ dragged) / (aside @ aside)
        sight = self._sight(dragged)
        across = axis - sight * (sight @ axis)
        return float(dragged @ across / max(across @ across, 1e-12))

    def _on_plane(self, normal: np.ndarray) -> np.ndarray:
        """The point (3,) under the mouse, on a plane through the pivot."""
        sight = self._sight(self._dragged)
        slope = float(sight @ normal)
        height = float(self._dragged @ normal)
        if abs(slope) < _EDGE_ON:
            return self._dragged - normal * height
        return self._dragged - sight * (height / slope)
