# SPDX-License-Identifier: GPL-3.0-or-later
"""A subdivided lighthouse in a leaning cage: mean values shear it, Green coordinates turn its parts."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from .. import posing
from ..lineup import POSE_FRAME, Lineup, share_pose
from ..models import lighthouse
from ..models.objects import stack_of_boxes
from ..studio import Shot

LABELS = {"Mean Value": "mean_value", "Green": "green"}
STOREYS = ((0.0, 0.60), (0.62, 0.52), (1.18, 0.47), (1.74, 0.47), (2.34, 0.47))  # height, half the width
LEAN = (0.0, 0.10, 0.42, 0.86, 1.22)  # how far each floor of the cage moves sideways
SWAY = {1: 0.0, POSE_FRAME: 1.0, 52: 1.0, 72: -0.8, 96: 0.0}


def make() -> bpy.types.Scene:
    return Lineup(
        title="Lighthouse",
        build=lighthouse.build,
        row=dict.fromkeys(("Rest", *LABELS)),
        spacing=2.1,
        finish=lean,
        shot=Shot((0.35, 0.0, 1.06), 7.2, 9.0, 26.0, lit=1.0, picture=(1440, 560), text=0.19, front=-1.5),
    ).make()


def lean(towers: Sequence[bpy.types.Object]) -> None:
    for tower in towers:
        posing.subdivide(tower, 3, 3)
    rest = stack_of_boxes("Storeys", [(half, z - 0.04) for z, half in STOREYS], towers[0])
    aside = np.outer(np.repeat(LEAN, 4), (1.0, 0.0, 0.0))
    share_pose(rest, zip(towers[1:], LABELS.values()), "Lean", lambda points: points + aside, SWAY, 0.014)
