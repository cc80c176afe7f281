# SPDX-License-Identifier: GPL-3.0-or-later
"""The dragon with three regions (head, tail, and fixed feet), or in a cage that bones carry."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise

import bpy
import numpy as np

from .. import markers, materials, posing
from ..lineup import POSE_FRAME, Handle, Lineup, Regions, there_and_back
from ..models import creature
from ..models.objects import mesh_object
from ..models.sculpt import ball
from ..models.shapes import bars
from ..posing import Move
from ..studio import Shot

# in the dragon's own frame: x ahead, y to its left
NECK, RUMP = (0.62, 0.0, 1.00), (-0.95, 0.0, 0.50)
TURN = Move(shift=(-0.05, -0.10, 0.16), turn=(14.0, -12.0, -34.0), pivot=NECK)
DROP = Move(shift=(0.04, 0.05, -0.16), turn=(-12.0, 14.0, 20.0), pivot=NECK)
RAISE = Move(shift=(0.04, 0.0, 0.02), turn=(0.0, 64.0, 22.0), pivot=RUMP)
SWING = Move(turn=(0.0, 14.0, -32.0), pivot=RUMP)
HEAD = there_and_back((POSE_FRAME, TURN), (56, TURN), (76, DROP))
TAIL = there_and_back((POSE_FRAME, RAISE), (56, RAISE), (76, SWING))
HANDLES = (
    Handle("Head", HEAD, (1.06, 0, 2.05), (1.06, 0, 1.6)),
    Handle("Tail", TAIL, (-2.19, 0, 1.33), (-2.13, 0, 1.0)),
)
FEET = ((0.52, 0.375), (0.52, -0.375), (-0.50, 0.43), (-0.50, -0.43))
BAR, BEAD = 0.006, 0.017  # radii of what is drawn of a graph
CUBE = np.array([(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)])
SIDES = np.array([(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)])
CELLS = {"Free": (0.30, 0.42, 0.30), "Held": materials.HANDLE_COLOUR, "Fixed": materials.FIXED_COLOUR}

# Chains of bones: what they hang from, and their joints. The legs are those of the left side.
CHAINS = {
    "body": ("", [(-0.60, 0.0, 0.62), (0.36, 0.0, 0.76)]),
    "neck": ("body", [(0.36, 0.0, 0.76), (0.66, 0.0, 0.97), (0.92, 0.0, 1.24)]),
    "head": ("neck.002", [(0.92, 0.0, 1.24), (1.55, 0.0, 1.30)]),
    "tail": (
        "body",
        [(-0.6, 0, 0.62), (-1.08, 0, 0.42), (-1.52, 0, 0.35), (-1.86, 0, 0.5), (-2.08, 0, 0.95)],
    ),
    "foreleg": ("body", [(0.40, 0.30, 0.55), (0.45, 0.37, 0.05)]),
    "hindleg": ("body", [(-0.56, 0.36, 0.44), (-0.58, 0.43, 0.05)]),
}
# Bone -> turns in degrees about the dragon's own axes at POSE_FRAME and at 64, between rests
TURNS = {
    "neck.001": ((0, -6, -10), (0, 6, 10)),
    "neck.002": ((0, -8, -12), (0, 6, 12)),
    "head": ((14, -2, -16), (-12, 6, 14)),
    "tail.001": ((0, 10, 10), (0, 4, -14)),
    "tail.002": ((0, 16, 14), (0, 6, -20)),
    "tail.003": ((0, 22, 16), (0, 8, -24)),
    "tail.004": ((0, 20, 14), (0, 8, -20)),
}


def posed(method: str, **parameters: object) -> Regions:
    return Regions(method, HANDLES, "Feet", parameters, pin=0.062, pads=FEET, pad=0.26)


REST = posed("")


def show_graph(dragons: Sequence[bpy.types.Object]) -> None:
    """The graph at rest, as bars and beads, in the place of the second dragon."""
    graph = posing.bound(dragons[-1], "EmbeddedDeformation", ("nodes",)).graph()
    nodes = np.asarray(graph["nodes"])
    start, end = (nodes[np.asarray(graph["edges"])[:, k]] for k in (0, 1))
    corners, sides = bars(start, end, BAR)
    bead, quads = ball((0.0, 0.0, 0.0), BEAD, 4)
    show_in_place("Bars", corners, sides, {"Bars": (0.10, 0.23, 0.55)}, dragons[1], 0.4)
    show_in_place("Beads", nodes[:, None] + bead, quads, {"Beads": materials.HANDLE_COLOUR}, dragons[1], 0.4)


def show_cells(dragons: Sequence[bpy.types.Object]) -> None:
    """The cells at rest, a little smaller than they are, in the place of the second dragon."""
    cells = posing.bound(dragons[-1], "RigidCells", ("cells", "levels")).cells()
    cubes = cells["centres"][:, None] + 0.46 * cells["sides"][:, None, None] * CUBE
    which = np.where(cells["handles"] < 0, 0, np.where(cells["handles"] == 2, 2, 1))
    paints = {f"{name} Cells": colour for name, colour in CELLS.items()}
    show_in_place("Cells", cubes, SIDES, paints, dragons[1], slots=np.repeat(which, 6))


def show_in_place(
    name: str,
    copies: np.ndarray,
    faces: np.ndarray,
    paints: dict[str, tuple],
    hidden: bpy.types.Object,
    roughness: float = 0.5,
    slots: np.ndarray | None = None,
) -> None:
    """Copies (k, n, 3) of a shape of quads as one object, where another is hidden."""
    stacked = faces + copies.shape[1] * np.arange(len(copies))[:, None, None]
    surfaces = [materials.plain_material(paint, colour, roughness) for paint, colour in paints.items()]
    shown = mesh_object(name, copies.reshape(-1, 3), stacked.reshape(-1, 4), slots=slots, materials=surfaces)
    shown.matrix_world = hidden.matrix_world.copy()
    hidden.hide_render = True


def pose_by_bones(dragon: bpy.types.Object) -> None:
    cage = posing.add_cage(dragon, "harmonic", faces=500)
    rig = posing.add_armature("Dragon Rig", bones(), dragon, side=(0, 1, 0))
    rig.show_in_front, rig.hide_render = True, True
    posing.carry_cage(cage, rig)
    for bone, (first, second) in TURNS.items():
        posing.key_turns(rig.pose.bones[bone], {1: (0, 0, 0), POSE_FRAME: first, 64: second, 96: (0, 0, 0)})
    markers.add_cage_edges(cage, 0.006)
    posing.check_posed(dragon)


def bones() -> Iterator[tuple[str, tuple, tuple, str]]:
    """One for each piece of the chains, in the frame of the dragon; legs on both sides."""
    for chain, (parent, joints) in CHAINS.items():
        for suffix, side in ((".L", 1), (".R", -1)) if chain.endswith("leg") else (("", 1),):
            above = parent
            for k, ends in enumerate(pairwise(joints), 1):
                name = chain + (f".{k:03}" if len(joints) > 2 else "") + suffix
                yield name, *((x, side * y, z) for x, y, z in ends), above
                above = name


SHOT = Shot((-0.06, 0, 0.9), 8.6, 13, 26, light=10, picture=(1440, 540), text=0.22, front=-1.75, aside=0.12)
# The dragons stand in a row and look to the front right.
Dragons = partial(Lineup, build=creature.build, spacing=2.75, heading=-49.0)

LINEUPS = {
    "creature": Dragons(
        about="A dragon with three regions (head, tail, fixed feet), posed alike by two methods.",
        row={"Rest": REST, "Thin Shell": posed("thin_shell"), "As-Rigid-As-Possible": posed("arap")},
        shot=SHOT,
    ),
    "embedded_deformation": Dragons(
        about="A dragon of 400 loose pieces, posed by embedded deformation, and the graph that moves it.",
        build=creature.build_shattered,
        row={"Rest": REST, "Its Graph of 250 Nodes": REST}
        | {"Embedded Deformation": posed("embedded_deformation", nodes=250)},
        finish=show_graph,
        shot=replace(SHOT, samples=24, text=0.17),
    ),
    "rigid_cells": Dragons(
        about="A dragon filled with rigid cells: the cells at rest, and the pose that they give.",
        row={"Rest": REST, "Its 2,500 Cells": REST, "Rigid Cells": posed("rigid_cells", cells=2500)},
        finish=show_cells,
        shot=replace(SHOT, samples=24, text=0.2),
    ),
    "rig": Dragons(
        about="A dragon whose armature carries a cage of 500 faces instead of a mesh of 88,000 vertices.",
        row={"Rest": None, "Armature, Cage, Harmonic": pose_by_bones},
        spacing=3.0,
        shot=replace(SHOT, width=6.6, light=8.0, picture=(1080, 520), text=0.17, front=-1.55),
    ),
}
