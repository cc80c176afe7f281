# SPDX-License-Identifier: GPL-3.0-or-later
"""Spot the cow, and a locomotive of thousands of loose parts."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from math import pi, radians

import bpy
import numpy as np
from mathutils import Matrix, Vector

from .. import markers, materials, posing
from ..lineup import POSE_FRAME, Handle, Lineup, Regions, there_and_back
from ..models import locomotive, spot
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
HEAD = Handle("Head", HEAD_MOVES, (0.10, 0, 1.88), (0.14, 0, 1.5))
HANDLES = (HEAD, Handle("Hoof", HOOF_MOVES, (0.52, -0.2, 0.10), (0.2, -0.2, 0.08)))
PADS = ((-0.02, 0.235), (-0.79, 0.20), (-0.79, -0.20))
LIFT_A_HOOF = Regions("arap", HANDLES, "Hooves", pin=0.05, pads=PADS, pad=0.23)


def loose_parts(choice: str):
    def pose(cow: bpy.types.Object) -> None:
        LIFT_A_HOOF(cow)
        cow.sinew.active.loose_parts = choice

    return pose


def check_harness(cows: Sequence[bpy.types.Object]) -> None:
    """The parts that follow are elsewhere than those that stay."""
    bpy.context.scene.frame_set(POSE_FRAME)
    stays, follows = (posing.shape(cow)[-cow[spot.HARNESS] :] for cow in cows[1:])
    if np.abs(follows - stays).max() < 0.05:
        raise posing.SampleError("The harness does not follow")


COORDINATES = {
    "Mean Value": "mean_value",
    "Positive Mean Value": "positive_mean_value",
    "Harmonic": "harmonic",
    "Green": "green",
}
BOW = Move(shift=(0.02, 0.0, 0.05), turn=(24.0, -16.0, -20.0), pivot=CHEST)
STEP = Move(shift=(0.3, -0.16, 0.12), turn=(0.0, -70.0, 0.0), pivot=(0.14, -0.2, 0.58))


def pose_in_cages(cows: Sequence[bpy.types.Object]) -> None:
    """One automatic cage with two shape keys: the head nods aside, the right foreleg steps up."""
    first, *others = zip(cows, COORDINATES.values())
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
        posing.check_posed(cow)


# Where one looks along the cow's own axes, from a place outside, and how far the surface is dragged there.
DRAGS = (
    ((-3.0, 0.0, 1.02), (1.0, 0.0, 0.0), (-0.22, 0.0, 0.22)),
    ((0.25, 0.0, 3.0), (0.0, 0.0, -1.0), (0.0, 0.0, 0.28)),
    ((-0.2, 0.0, -3.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)),
)


def dragged(resolution: int, farther: float = 1.0):
    """Press on the surface in three places, and animate the handles that this makes."""

    def pose(cow: bpy.types.Object) -> None:
        posing.add_deformer(cow, "inverse_ffd", resolution=resolution)
        world = cow.matrix_world
        for origin, direction, shift in DRAGS:
            sight = {"origin": world @ Vector(origin), "direction": world.to_3x3() @ Vector(direction)}
            control = posing.operate(cow, "drag", **sight, radius=0.06).handles[-1].control
            markers.add_pin(control, control.matrix_world.translation, 0.03)
            move = Move(shift=[farther * step for step in shift])
            posing.animate(control, there_and_back((POSE_FRAME, move), (70, move)), cow)
        posing.check_posed(cow)

    return pose


# Half-way to a twisted cow
MIDDLE_FRAME, LAST_FRAME = 48, 96
TWIST = 150.0  # degrees between the rump and the chest
RUMP_TO_CHEST, AXIS_HEIGHT = (-0.75, 0.15), 0.95


def twist(cows: Sequence[bpy.types.Object]) -> None:
    rest, straight, morphed, target = cows
    target.data = twisted(rest.data)
    straight.data = rest.data.copy()
    for vertex, other in zip(straight.data.vertices, target.data.vertices):
        vertex.co = 0.5 * (vertex.co + other.co)
    morph(morphed, target)


def twisted(mesh: bpy.types.Mesh) -> bpy.types.Mesh:
    """A copy whose front is turned about the body's axis."""
    found = mesh.copy()
    axis = Vector((0.0, 0.0, AXIS_HEIGHT))
    for vertex in found.vertices:
        turn = Matrix.Rotation(radians(TWIST) * smoothstep(*RUMP_TO_CHEST, vertex.co.x), 3, "X")
        vertex.co = axis + turn @ (vertex.co - axis)
    return found


def morph(cow: bpy.types.Object, target: bpy.types.Object) -> None:
    """Morph by the operator, and key it: there and back."""
    posing.operate(cow, "morph", target=target.name)
    settings = cow.sinew.active.pyramid_coordinates
    posing.key(settings, "morph", {1: 0.0, MIDDLE_FRAME: 0.5, LAST_FRAME: 1.0})
    for frame, end in ((1, cow), (LAST_FRAME, target)):
        bpy.context.scene.frame_set(frame)
        if np.abs(posing.shape(cow) - posing.vertices(end)).max() > 1e-4:
            raise posing.SampleError(f"frame {frame} is not the shape at that end: {cow.sinew.active.status}")
    bpy.context.scene.frame_set(MIDDLE_FRAME)


SIDE = Matrix.Rotation(0.5 * pi, 4, "X")  # a camera that looks along y
INK = (0.85, 0.20, 0.02)
# Points (x, z) of the outline of the back, from the tail to the neck, and of a longer muzzle
BACK = ((-0.95, 0.84), (-0.9, 0.9), (-0.8, 0.945), (-0.5, 0.97), (-0.3, 1.05), (-0.2, 1.06), (-0.12, 1.18))
MUZZLE = ((0.5, 1.45), (0.7, 1.31), (0.93, 1.18), (1.04, 1.05), (1.0, 0.93), (0.8, 0.88), (0.42, 0.84))
HUMP = 0.27


def sketch(cows: Sequence[bpy.types.Object]) -> None:
    cow = cows[-1]
    cow.data = cow.data.copy()  # shape keys belong to the mesh
    for each in cows:
        posing.subdivide(each)
    before = posing.shape(cow)
    for name, line, reach in (("Back", humps(), 0.22), ("Muzzle", MUZZLE, 0.25)):
        add_stroke(f"{name} Stroke", line, cows[0])
        stroke = add_stroke(name, line, cow)
        posing.operate(cow, "silhouette_sketch", stroke=stroke.name, view=SIDE, reach=reach)
        stroke.hide_render = True
    bpy.context.view_layer.update()
    travel = np.linalg.norm(posing.shape(cow) - before, axis=1).max()
    if not 0.2 < travel < 1.0:
        raise posing.SampleError(f"the strokes move vertices by {travel:.3g}")


def humps() -> np.ndarray:
    """The outline of the back with two humps, (n, 2)."""
    share = np.linspace(0.0, 1.0, 80)
    x = BACK[0][0] + share * (BACK[-1][0] - BACK[0][0])
    return np.column_stack((x, np.interp(x, *np.transpose(BACK)) + HUMP * np.sin(2.0 * pi * share) ** 2))


def add_stroke(name: str, line: Sequence[Sequence[float]], cow: bpy.types.Object) -> bpy.types.Object:
    """A curve through points (n, 2) in the plane before the cow; a "Stroke" is drawn in ink."""
    places = [(cow.location.x + x, -0.55, z) for x, z in line]
    stroke = posing.add_lines(name, [places], bevel=0.012 if name.endswith("Stroke") else 0.0)
    stroke.data.materials.append(materials.plain_material("Stroke", INK, roughness=0.6))
    return stroke


def say_parts(obj: bpy.types.Object) -> None:
    obj["label"] = f"{obj[locomotive.PARTS]:,} Loose Parts"


def stretched(method: str) -> Regions:
    """The boiler becomes longer, and the chimney leans."""
    up = Move(shift=(0.42, 0.0, 0.62), turn=(0.0, 24.0, 0.0), pivot=(1.12, 0.0, 1.4))
    back = Move(shift=(-0.18, 0.0, 0.12), turn=(0.0, -14.0, 0.0), pivot=(-1.1, 0.0, 0.6))
    rows = (
        ("Bogie", Move(shift=(0.75, 0.0, 0.0)), (1.22, -0.75, 0.18), (1.22, -0.40, 0.18)),
        ("Chimney", up, (1.12, 0.0, 2.05), (1.12, 0.0, 1.72)),
        ("Cab", back, (-1.12, 0.0, 1.85), (-1.12, 0.0, 1.55)),
    )
    keys = [there_and_back((POSE_FRAME, row[1]), (60, row[1])) for row in rows]
    handles = [Handle(group, moves, tip, foot) for (group, _move, tip, foot), moves in zip(rows, keys)]
    return Regions(method, handles, "Drivers", pin=0.07)


Cows = partial(Lineup, build=spot.build, spacing=2.30, heading=-52.0)
SHOT = Shot((0.05, 0.0, 0.88), 7.2, 12.0, lit=0.8, light=7.0, picture=(1280, 460), front=-1.30)
FOUR = Shot((-0.12, 0, 0.84), 7.15, 9, lit=0.8, picture=(1440, 480), text=0.15, front=-1.25, aside=-0.17)
FourCows = partial(Cows, spacing=1.72, heading=-38.0, smooth=True, shot=replace(FOUR, nearer=0.95))

LINEUPS = {
    "spot": Cows(
        about="Spot lifts a hoof: a coarse mesh, as rigid as possible, with a Subdivision below.",
        row={"Rest": None, "As-Rigid-As-Possible": LIFT_A_HOOF},
        spacing=2.35,
        smooth=True,
        shot=replace(SHOT, width=5.1, distance=20.0, light=6.0, picture=(1080, 520)),
    ),
    "loose_parts": Cows(
        about="Spot in harness: its studs, bands and belt are loose parts, which follow or stay behind.",
        build=spot.build_harnessed,
        row={"Rest": None}
        | {f"Loose Parts: {choice}": loose_parts(choice.upper()) for choice in ("Stay", "Follow")},
        finish=check_harness,
        shot=SHOT,
    ),
    "coordinates": FourCows(
        about="Spot in an automatic cage: one pose of it, followed by four kinds of coordinates.",
        row=dict.fromkeys(COORDINATES),
        active=0,
        finish=pose_in_cages,
    ),
    "inverse_ffd": FourCows(
        about="Spot dragged at the head and the back; finer hidden lattices let a drag reach less far.",
        row={"Rest": None} | {f"{count} x {count} x {count} points": dragged(count) for count in (4, 7, 12)},
        active=1,
    ),
    "pyramid_coordinates": Cows(
        about="Half-way to a twisted Spot: pyramid coordinates keep the body, straight lines shrink it.",
        row=dict.fromkeys(("Rest", "Half, straight lines", "Half, Pyramid Coordinates", "Target shape")),
        spacing=2.35,
        frame=MIDDLE_FRAME,
        active=2,
        smooth=True,
        finish=twist,
        shot=replace(SHOT, width=9.8, distance=30.0, light=9.0, picture=(1400, 420), samples=24),
    ),
    "silhouette": Cows(
        about="Spot gets two humps and a longer muzzle: strokes redraw the outline, and the surface follows.",
        row=dict.fromkeys(("Strokes", "Draw Outline")),
        spacing=2.75,
        heading=0.0,
        frame=1,
        finish=sketch,
        shot=Shot((0.05, 0, 0.8), 5.4, 4, 26, 0.8, 6, (1080, 430), text=0.15, front=-1.30, aside=-0.15),
    ),
    "machine": Lineup(
        about="A locomotive of thousands of loose parts: its boiler stretches, its wheels stay round.",
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
        shot=Shot((0.1, 0, 0.86), 18.0, 12.0, 34.0, light=11.0, picture=(1920, 400), text=0.22, front=-1.75),
    ),
}
