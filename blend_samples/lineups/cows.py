# SPDX-License-Identifier: GPL-3.0-or-later
"""Spot the cow, and a locomotive of thousands of loose parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import bpy
import numpy as np
from mathutils import Vector

from .. import markers, posing
from ..lineup import POSE_FRAME, Handle, Lineup, Regions, there_and_back
from ..models import harness, locomotive, spot
from ..models.shapes import smoothstep
from ..posing import Move
from ..studio import Shot

CHEST, HOOF = (0.05, 0.0, 0.95), (0.18, -0.2, 0.10)  # about which the head and the right foreleg turn
NOD = Move(shift=(0.02, -0.06, 0.07), turn=(22.0, -14.0, -16.0), pivot=CHEST)
LOOK = Move(shift=(0.02, 0.06, 0.07), turn=(-18.0, -10.0, 14.0), pivot=CHEST)
WAVE = Move(shift=(0.30, -0.12, 0.38), turn=(0.0, -52.0, -10.0), pivot=HOOF)
HIGH = Move(shift=(0.34, -0.18, 0.48), turn=(0.0, -66.0, -10.0), pivot=HOOF)
HEAD_MOVES = there_and_back((POSE_FRAME, NOD), (56, LOOK), (72, NOD))
HOOF_MOVES = there_and_back((POSE_FRAME, WAVE), (48, HIGH), (56, WAVE), (64, HIGH), (72, WAVE))
LIFT_A_HOOF = Regions(
    "arap",
    (
        Handle("Head", HEAD_MOVES, (0.10, 0, 1.88), (0.14, 0, 1.5)),
        Handle("Hoof", HOOF_MOVES, (0.52, -0.2, 0.10), (0.2, -0.2, 0.08)),
    ),
    "Hooves",
    pin=0.05,
    pads=((-0.02, 0.235), (-0.79, 0.20), (-0.79, -0.20)),
    pad=0.23,
)


def loose_parts(choice: str):
    def pose(cow: bpy.types.Object) -> None:
        LIFT_A_HOOF(cow)
        cow.sinew.active.loose_parts = choice

    return pose


def check_harness(cows: Sequence[bpy.types.Object]) -> None:
    """The parts that follow are elsewhere than those that stay."""
    bpy.context.scene.frame_set(POSE_FRAME)
    stays, follows = (posing.shape(cow)[-cow[harness.COUNT] :] for cow in cows[1:])
    if np.abs(follows - stays).max() < 0.05:
        raise posing.SampleError("The harness does not follow")


# The tags of the four kinds of coordinates, and their labels.
COORDINATES = {
    "mean_value": "Mean Value",
    "positive_mean_value": "Positive Mean Value",
    "harmonic": "Harmonic",
    "green": "Green",
}
BOW = Move(shift=(0.02, 0.0, 0.05), turn=(24.0, -16.0, -20.0), pivot=CHEST)
STEP = Move(shift=(0.3, -0.16, 0.12), turn=(0.0, -70.0, 0.0), pivot=(0.14, -0.2, 0.58))


def pose_in_cages(cows: Sequence[bpy.types.Object]) -> None:
    """One automatic cage with two shape keys: the head nods aside, the right foreleg steps up."""
    first, *others = zip(cows, COORDINATES)
    cages = [posing.add_cage(*first, faces=240)]
    cages += [posing.share_cage(cages[0], cow, method) for cow, method in others]
    points = posing.vertices(cages[0])
    x, y, z = points.T
    head = smoothstep(0.92, 1.22, z + 0.5 * x)
    leg = smoothstep(0.66, 0.40, z) * smoothstep(-0.22, -0.14, x) * smoothstep(0.04, -0.04, y)
    if not (np.any(head > 0.9) and np.any(leg > 0.9)):
        raise posing.SampleError("The cage has no vertices at the head or at the leg")
    nod = {1: 0.0, POSE_FRAME: 1.0, 56: 0.35, 72: 1.0, 96: 0.0}
    posing.add_pose(cages[0], "Nod", posing.blended(BOW, points, head), nod)
    step = {1: 0.0, POSE_FRAME: 1.0, 48: 0.7, 56: 1.0, 64: 0.7, 72: 1.0, 96: 0.0}
    posing.add_pose(cages[0], "Step", posing.blended(STEP, points, leg), step)
    for cow, cage in zip(cows, cages):
        markers.add_cage_edges(cage, 0.006)
        posing.check_posed(cow, 1, POSE_FRAME)


# Where one looks along the cow's own axes, from a place outside, and how far the surface is dragged there.
DRAGS = (
    ((-3.0, 0.0, 1.02), (1.0, 0.0, 0.0), (-0.22, 0.0, 0.22)),
    ((0.25, 0.0, 3.0), (0.0, 0.0, -1.0), (0.0, 0.0, 0.28)),
    ((-0.2, 0.0, -3.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)),
)


def dragged(resolution: int, farther: float = 1.0):
    """Press on the surface in three places, and animate the handles that this makes."""

    def pose(cow: bpy.types.Object) -> None:
        deformer = posing.add_deformer(cow, "inverse_ffd", resolution=resolution)
        world = cow.matrix_world
        for origin, direction, shift in DRAGS:
            posing.make_active(cow)
            sight = {"origin": world @ Vector(origin), "direction": world.to_3x3() @ Vector(direction)}
            posing.expect(bpy.ops.sinew.drag(**sight, radius=0.06), f"{cow.name}: drag")
            control = deformer.handles[-1].control
            markers.add_pin(control, control.matrix_world.translation, 0.03)
            move = Move(shift=[farther * step for step in shift])
            posing.animate(control, there_and_back((POSE_FRAME, move), (70, move)), cow)
        posing.check_posed(cow, 1, POSE_FRAME)

    return pose


def say_parts(obj: bpy.types.Object) -> None:
    obj["label"] = f"{obj[locomotive.PARTS]:,} Loose Parts"


def stretched(method: str) -> Regions:
    """The boiler becomes longer, and the chimney leans."""
    handles = []
    for group, tip, foot, move in (
        ("Bogie", (1.22, -0.75, 0.18), (1.22, -0.40, 0.18), Move(shift=(0.75, 0.0, 0.0))),
        (
            "Chimney",
            (1.12, 0.0, 2.05),
            (1.12, 0.0, 1.72),
            Move(shift=(0.42, 0.0, 0.62), turn=(0.0, 24.0, 0.0), pivot=(1.12, 0.0, 1.4)),
        ),
        (
            "Cab",
            (-1.12, 0.0, 1.85),
            (-1.12, 0.0, 1.55),
            Move(shift=(-0.18, 0.0, 0.12), turn=(0.0, -14.0, 0.0), pivot=(-1.1, 0.0, 0.6)),
        ),
    ):
        handles.append(Handle(group, there_and_back((POSE_FRAME, move), (60, move)), tip, foot))
    return Regions(method, handles, "Drivers", pin=0.07)


Cows = partial(Lineup, build=spot.build, spacing=2.30, heading=-52.0)
SHOT = Shot((0.05, 0.0, 0.88), 7.2, 12.0, lit=0.8, light=7.0, picture=(1280, 460), front=-1.30)
FOUR = Shot(
    (-0.12, 0.0, 0.84),
    width=7.15,
    elevation=9.0,
    lit=0.8,
    picture=(1440, 480),
    text=0.15,
    front=-1.25,
    aside=-0.17,
    nearer=0.95,
)

LINEUPS = {
    "spot": Cows(
        about="Spot lifts a hoof: a coarse mesh, as rigid as possible, with a Subdivision below.",
        title="Spot",
        row={"Rest": None, "As-Rigid-As-Possible": LIFT_A_HOOF},
        spacing=2.35,
        smooth=True,
        shot=replace(SHOT, width=5.1, distance=20.0, light=6.0, picture=(1080, 520)),
    ),
    "loose_parts": Cows(
        about="Spot in harness: its studs, bands and belt are loose parts, which follow or stay behind.",
        title="Loose parts",
        build=harness.build,
        row={
            "Rest": None,
            "Loose Parts: Stay": loose_parts("STAY"),
            "Loose Parts: Follow": loose_parts("FOLLOW"),
        },
        finish=check_harness,
        shot=SHOT,
    ),
    "coordinates": Cows(
        about="Spot in an automatic cage: one pose of it, followed by four kinds of coordinates.",
        title="Coordinates",
        row=dict.fromkeys(COORDINATES.values()),
        spacing=1.72,
        heading=-38.0,
        active=0,
        smooth=True,
        finish=pose_in_cages,
        shot=FOUR,
    ),
    "inverse_ffd": Cows(
        about="Spot dragged at the head and the back; finer hidden lattices let a drag reach less far.",
        title="Inverse Free-Form Deformation",
        row={
            "Rest": None,
            "4 x 4 x 4 points": dragged(4),
            "7 x 7 x 7 points": dragged(7),
            "12 x 12 x 12 points": dragged(12),
        },
        spacing=1.72,
        heading=-38.0,
        active=1,
        smooth=True,
        shot=FOUR,
    ),
    "machine": Lineup(
        about="A locomotive of thousands of loose parts: its boiler stretches, its wheels stay round.",
        title="Machine",
        build=locomotive.build,
        row={
            "Rest": say_parts,
            "Radial Basis Functions": stretched("rbf"),
            "Moving Least Squares": stretched("mls"),
            "Space Propagation": stretched("space_propagation"),
        },
        spacing=4.3,
        heading=-24.0,
        active=1,
        shot=Shot(
            (0.1, 0.0, 0.86), 18.0, 12.0, 34.0, light=11.0, picture=(1920, 400), text=0.22, front=-1.75
        ),
    ),
}
