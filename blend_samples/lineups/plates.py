# SPDX-License-Identifier: GPL-3.0-or-later
"""The plate of the tutorial's figure 9: lifted by its handle, or by the points of a lattice."""

from dataclasses import replace
from functools import partial

import bpy
import numpy as np

from .. import markers, posing
from ..lineup import POSE_FRAME, Handle, Lineup, Regions, add_thickness, there_and_back
from ..models import plate
from ..posing import Move
from ..studio import Shot

DARK = (0.30, 0.27, 0.235)
SHOT = Shot((0, 0, 0.31), 7.5, 19.0, 24.0, 0.3, 11.0, (1440, 450), tint=DARK, text=0.165, front=-1.52)
LIFT = Move(shift=(0.0, 0.0, 0.72), turn=(10.0, -9.0, 0.0))
TILT = Move(shift=(0.0, 0.0, 0.6), turn=(25.0, -30.0, 0.0))
SPIN = Move(shift=(0.0, 0.0, 0.40), turn=(-16.0, 20.0, 45.0))


def lifted(method: str, move: Move = LIFT, thickness: float = 0.035, **parameters: object) -> Regions:
    moves = there_and_back((POSE_FRAME, move), (52, move), (76, SPIN))
    handle = Handle("Handle", moves, (0, 0, 0.42), (0, 0, 0))
    return Regions(method, (handle,), "Frame", parameters, thickness=thickness)


def prisms(height: float) -> Regions:
    return lifted("primo", TILT, 0.0, height=height, max_iterations=400)


def ridge(count: int, ball: float, **settings: object):
    """The lattice points in an oval that lies across the grid rise together, as an artist selects them."""

    def pose(obj: bpy.types.Object) -> None:
        lattice = posing.add_lattice(obj, (count, count, 2), **settings)
        points = posing.lattice_points(lattice)
        x, y = (points[:, :2] / (0.5 * (count - 1))).T  # from -1 to 1
        along, across = 0.8 * x + 0.6 * y, 0.8 * y - 0.6 * x
        inside = (along / 0.86) ** 2 + (across / 0.36) ** 2 < 1.0
        raised = points + np.outer(inside, (0.0, 0.0, 0.4 / lattice.matrix_world.to_scale().z))
        posing.add_pose(lattice, "Ridge", raised, {1: 0.0, POSE_FRAME: 1.0, 60: 1.0, 80: -0.4, 96: 0.0})
        markers.add_lattice_points(lattice, ball, POSE_FRAME)
        add_thickness(obj, 0.035)
        posing.check_posed(obj)

    return pose


Plates = partial(Lineup, build=plate.build, spacing=2.45, shot=SHOT, active=1)

LINEUPS = {
    "plate": Plates(
        about="The plate of the tutorial's figure 9: three ratios of stretching (k_s) to bending (k_b).",
        row={
            "Membrane   k_s = 1, k_b = 0": lifted("thin_shell", stretching=1.0, bending=0.0),
            "Blend   k_s = 1, k_b = 0.005": lifted("thin_shell", stretching=1.0, bending=0.005),
            "Thin plate   k_s = 0, k_b = 1": lifted("thin_shell", stretching=0.0, bending=1.0),
        },
    ),
    "prisms": Plates(
        about="A plate lifted and tilted by its handle, by PriMo with prisms of three heights.",
        row={f"PriMo   height {height}": prisms(height) for height in (0.002, 0.02, 0.1)},
    ),
    "spline_surface": Plates(
        about="One plate and one pose, displaced by spline surfaces of other degrees and grids.",
        row={
            f"Degree {degree}, {n} x {n} points": lifted("spline_surface", degree=degree, columns=n, rows=n)
            for degree, n in ((1, 8), (3, 8), (3, 20))
        },
    ),
    "ffd": Plates(
        about="One oval ridge by lattices of rising resolution, whose rows show as steps in the surface.",
        build=plate.build_plain,
        row={
            "8 x 8 points": ridge(8, 0.03, degree=3),
            "16 x 16 points, degree 1": ridge(16, 0.03, degree=1),
            "32 x 32 points, degree 3": ridge(32, 0.014, degree=3),
        },
        shot=replace(SHOT, elevation=24.0, samples=32, front=-1.55),
    ),
}
