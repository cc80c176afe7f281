# SPDX-License-Identifier: GPL-3.0-or-later
"""The dragon with three regions: head, tail, and fixed feet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import bpy
import numpy as np

from .. import inside, materials
from ..lineup import POSE_FRAME, Handle, Lineup, Regions, there_and_back
from ..models import creature
from ..models.objects import mesh_object
from ..models.sculpt import ball
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


def posed(method: str, **parameters: object) -> Regions:
    return Regions(method, HANDLES, "Feet", parameters, pin=0.062, pads=FEET, pad=0.26)


REST = posed("")


def show_graph(dragons: Sequence[bpy.types.Object]) -> None:
    """The graph at rest, as bars and beads, in the place of the second dragon."""
    graph = inside.bound(dragons[-1], "EmbeddedDeformation", ("nodes",)).graph()
    nodes = np.asarray(graph["nodes"])
    start, end = (nodes[np.asarray(graph["edges"])[:, k]] for k in (0, 1))
    along = (end - start) / np.linalg.norm(end - start, axis=1, keepdims=True)
    across = np.cross(along, np.where(np.abs(along[:, 2:]) < 0.9, (0, 0, 1), (1, 0, 0)))
    across *= BAR / np.linalg.norm(across, axis=1, keepdims=True)
    beside = np.cross(along, across)
    ring = np.stack((across, beside, -across, -beside), axis=1)
    corners = np.concatenate((start[:, None] + ring, end[:, None] + ring), axis=1)
    sides = np.array([(k, (k + 1) % 4, 4 + (k + 1) % 4, 4 + k) for k in range(4)])
    bead, quads = ball((0.0, 0.0, 0.0), BEAD, 4)
    for name, points, faces, colour in (
        ("Bars", corners, sides, (0.10, 0.23, 0.55)),
        ("Beads", nodes[:, None] + bead, quads, materials.HANDLE_COLOUR),
    ):
        stacked = (faces + points.shape[1] * np.arange(len(points))[:, None, None]).reshape(-1, 4)
        surface = materials.plain_material(name, colour, roughness=0.4)
        put_in_place(mesh_object(name, points.reshape(-1, 3), stacked, materials=[surface]), dragons[1])


def show_cells(dragons: Sequence[bpy.types.Object]) -> None:
    """The cells at rest, a little smaller than they are, in the place of the second dragon."""
    cells = inside.bound(dragons[-1], "RigidCells", ("cells", "levels")).cells()
    cubes = cells["centres"][:, None] + 0.46 * cells["sides"][:, None, None] * CUBE
    faces = SIDES + 8 * np.arange(len(cubes))[:, None, None]
    kinds = (
        ("Free", (0.30, 0.42, 0.30)),
        ("Held", materials.HANDLE_COLOUR),
        ("Fixed", materials.FIXED_COLOUR),
    )
    which = np.where(cells["handles"] < 0, 0, np.where(cells["handles"] == 2, 2, 1))
    shown = mesh_object(
        "Cells",
        cubes.reshape(-1, 3),
        faces.reshape(-1, 4),
        slots=np.repeat(which, 6),
        materials=[materials.plain_material(f"{name} Cells", colour) for name, colour in kinds],
    )
    put_in_place(shown, dragons[1])


def put_in_place(shown: bpy.types.Object, hidden: bpy.types.Object) -> None:
    shown.matrix_world = hidden.matrix_world.copy()
    hidden.hide_render = True


SHOT = Shot(
    (-0.06, 0.0, 0.90), 8.6, 13.0, 26.0, light=10.0, picture=(1440, 540), text=0.22, front=-1.75, aside=0.12
)
# The dragons stand in a row and look to the front right.
Dragons = partial(Lineup, build=creature.build, spacing=2.75, heading=-49.0)

LINEUPS = {
    "creature": Dragons(
        about="A dragon with three regions (head, tail, fixed feet), posed alike by two methods.",
        title="Creature",
        row={"Rest": REST, "Thin Shell": posed("thin_shell"), "As-Rigid-As-Possible": posed("arap")},
        shot=SHOT,
    ),
    "embedded_deformation": Dragons(
        about="A dragon of 400 loose pieces, posed by embedded deformation, and the graph that moves it.",
        title="Embedded Deformation",
        build=creature.build_shattered,
        row={
            "Rest": REST,
            "Its Graph of 250 Nodes": REST,
            "Embedded Deformation": posed("embedded_deformation", nodes=250),
        },
        finish=show_graph,
        shot=replace(SHOT, samples=24, text=0.17),
    ),
    "rigid_cells": Dragons(
        about="A dragon filled with rigid cells: the cells at rest, and the pose that they give.",
        title="Rigid Cells",
        row={"Rest": REST, "Its 2,500 Cells": REST, "Rigid Cells": posed("rigid_cells", cells=2500)},
        finish=show_cells,
        shot=replace(SHOT, samples=24, text=0.2),
    ),
}
