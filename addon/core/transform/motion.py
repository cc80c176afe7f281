# SPDX-License-Identifier: GPL-3.0-or-later
"""A move, a rotation or a scaling about a pivot, as a matrix."""

from dataclasses import dataclass
from enum import Enum
from math import isfinite, sin

import numpy as np

Triple = tuple[float, float, float]


class Mode(Enum):
    """The type of a motion."""

    TRANSLATE = "TRANSLATE"
    ROTATE = "ROTATE"
    RESIZE = "RESIZE"


@dataclass(frozen=True)
class Motion:
    """A motion along the axes of the world or along local axes. Only the fields for its ``mode`` count."""

    mode: Mode = Mode.TRANSLATE
    local: bool = False
    move: Triple = (0.0, 0.0, 0.0)
    angle: float = 0.0
    axis: Triple = (0.0, 0.0, 1.0)
    scale: Triple = (1.0, 1.0, 1.0)

    @property
    def rounded(self) -> "Motion":
        """The motion in float32, as Blender's properties store it, so that repeating it gives the same
        result.
        """

        def stored(values: Triple) -> Triple:
            x, y, z = np.asarray(values, np.float32).tolist()
            return x, y, z

        return Motion(
            self.mode,
            self.local,
            stored(self.move),
            float(np.float32(self.angle)),
            stored(self.axis),
            stored(self.scale),
        )

    def matrix(self, axes: np.ndarray, pivot: np.ndarray) -> np.ndarray:
        """The motion of points in the world, (4, 4). ``axes`` (3, 3) are the local axes as unit columns."""
        frame = axes if self.local else np.eye(3)
        linear, offset = np.eye(3), np.zeros(3)
        if self.mode is Mode.TRANSLATE:
            offset = frame @ self.move
        elif self.mode is Mode.RESIZE:
            linear = frame @ np.diag(self.scale) @ frame.T
        else:
            linear = rotation(frame @ self.axis, self.angle)
        whole = np.eye(4)
        whole[:3, :3] = linear
        whole[:3, 3] = pivot + offset - linear @ pivot
        return whole


def rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rodrigues' formula, (3, 3); the identity for an axis without length, NaN for an infinite angle."""
    length = np.linalg.norm(axis)
    if length == 0.0:
        return np.eye(3)
    x, y, z = axis / length
    K = np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
    if not isfinite(angle):
        return np.full((3, 3), np.nan)
    return np.eye(3) + sin(angle) * K + 2.0 * sin(0.5 * angle) ** 2 * (K @ K)
