# SPDX-License-Identifier: GPL-3.0-or-later
"""The inverse kinematics of the native module, and the regions of bones."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .native import _module as native_module, _translated as translated


@dataclass(frozen=True)
class Bones:
    """Bones at rest, parents first, with the limits of their joints. Angles are radians.

    ``angles`` holds the bones that turn by angles about their own axes: lower and upper angles (3,), and an
    order such as 'XYZ'. All others turn freely.
    """

    heads: np.ndarray  # (k, 3)
    tails: np.ndarray  # (k, 3)
    parents: np.ndarray  # (k,) -1 for none
    axes: np.ndarray  # (k, 3, 3) rotations whose columns are the bones' own axes
    angles: dict[int, tuple[np.ndarray, np.ndarray, str]] = field(default_factory=dict)
    stiffness: np.ndarray | None = None  # (k,)


@dataclass(frozen=True)
class Targets:
    """Points on bones at rest, and where they are wanted."""

    bones: np.ndarray  # (t,)
    points: np.ndarray  # (t, 3)
    goals: np.ndarray  # (t, 3)
    weights: np.ndarray  # (t,)


@dataclass(frozen=True)
class Solution:
    """The posture that a solve found: rotations (k, 3, 3) in the bones' own axes, their turns and moves."""

    rotations: np.ndarray
    turns: np.ndarray
    moves: np.ndarray
    gaps: np.ndarray  # (t,) how far from its goal each point is
    overhang: float  # how far the centre of mass is outside of the support


class Puppet:
    """A native skeleton."""

    def __init__(self, bones: Bones) -> None:
        """Raises a ``ConstraintError`` or an ``OptionError`` that names a bone by its number."""
        native = native_module()
        with translated(native):
            self._native: Any = native.Skeleton(
                bones.heads,
                bones.tails,
                bones.parents,
                axes=bones.axes,
                angles=bones.angles,
                stiffness=bones.stiffness,
            )

    def turns(self, rotations: np.ndarray) -> np.ndarray:
        """The turns (k, 3) that give ``rotations`` (k, 3, 3)."""
        with translated(native_module()):
            return self._native.turns(rotations)

    def solve(
        self,
        targets: Targets,
        turns: np.ndarray,
        moves: np.ndarray,
        *,
        locked: np.ndarray,
        moving_roots: np.ndarray,
        support: np.ndarray | None = None,
        up: np.ndarray | None = None,
    ) -> Solution:
        """Bring the targets to their goals. ``turns`` and ``moves`` (k, 3) are the posture to stay close to.

        ``support`` (m, 3): the centre of mass stays above these points, along ``up`` (3,).
        """
        with translated(native_module()):
            turned, moved, report = self._native.solve(
                targets.bones,
                targets.points,
                targets.goals,
                weights=targets.weights,
                turns=turns,
                moves=moves,
                locked=locked,
                moving_roots=moving_roots,
                support=support,
                up=(0.0, 0.0, 1.0) if up is None else up,
            )
            return Solution(
                self._native.rotations(turned), turned, moved, report.gaps, float(report.overhang)
            )

    def regions(
        self, points: np.ndarray, faces: tuple[np.ndarray, np.ndarray], margin: float
    ) -> list[np.ndarray]:
        """The vertices that each bone holds, of a mesh around the bones at rest."""
        native = native_module()
        with translated(native):
            return self._native.regions(native.SurfaceMesh(points, faces), margin)
