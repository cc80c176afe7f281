# SPDX-License-Identifier: GPL-3.0-or-later
"""The pillar whose grooves and studs show how details turn, and a hose: bent by one handle at the top."""

from functools import partial
from math import cos, pi, sin

import bmesh
import bpy
from mathutils import Vector

from .. import posing
from ..lineup import POSE_FRAME, Handle, Lineup, Regions, there_and_back
from ..models import pillar
from ..posing import Move
from ..studio import Shot

# The axis between foot and head becomes an arc of its own length.
BEND = Move(shift=(0.94, 0.0, -0.61), turn=(0.0, 100.0, 0.0), pivot=(0.0, 0.0, pillar.HEAD))
HEAD_MOVES = there_and_back((POSE_FRAME, BEND), (52, BEND), (76, Move(turn=(0.0, 0.0, 135.0))))
HEAD = Handle("Head", HEAD_MOVES, (0, 0, 2.25), (0, 0, 2.0))
# The same of the hose, by 120 degrees.
FREE, ANGLE = pillar.LONG - 2 * pillar.HELD, 2 * pi / 3
SHIFT = (FREE / ANGLE * (1 - cos(ANGLE)), 0.0, FREE / ANGLE * sin(ANGLE) - FREE)
ARC = Move(SHIFT, turn=(0.0, 120.0, 0.0), pivot=(0.0, 0.0, pillar.LONG - pillar.HELD))
TOP = (0, 0, pillar.LONG)
END = Handle("Head", there_and_back((POSE_FRAME, ARC), (52, ARC)), (0, 0, pillar.LONG + 0.25), TOP)


def bent(method: str, **parameters: object) -> Regions:
    return Regions(method, (HEAD,), "Foot", parameters)


def hose_of(thickness: float) -> Regions:
    return Regions("thin_shell_nonlinear", (END,), "Foot", {"thickness": thickness})


def tool(kind: str, height: float, move: Move, **reach: float):
    """Poses a pillar by a tool at a height of its axis; ``reach`` says how far it acts."""

    def pose(obj: bpy.types.Object) -> None:
        place = obj.matrix_world @ Vector((0.0, 0.0, height))
        added = posing.operate(obj, "tool_add", tool=kind, location=place, outer=reach["outer"])
        row = added.controls[-1]
        for name, value in reach.items():
            setattr(row, name, value)
        about = Move(move.shift, move.turn, pivot=(0.0, 0.0, height))
        posing.animate(row.object, there_and_back((POSE_FRAME, about)), obj)
        posing.check_posed(obj)

    return pose


def volume(obj: bpy.types.Object) -> float:
    shape = bmesh.new()
    shape.from_object(obj, bpy.context.evaluated_depsgraph_get())
    enclosed = shape.calc_volume()
    shape.free()
    return enclosed


def share_of_volume(obj: bpy.types.Object, first: bpy.types.Object) -> str:
    return f"{100 * volume(obj) / volume(first):.1f} % of the volume"


def drift_of_volume(obj: bpy.types.Object, first: bpy.types.Object) -> str:
    drift = f"{100 * (volume(obj) / volume(first) - 1):+.3f}"
    return f"{'100' if obj == first else drift} % of the volume"


# Bent, they reach to the right, where their labels stand.
Photo = partial(Shot, aside=0.2)
WIDE = partial(Photo, (0.55, 0.0, 0.84), samples=32, picture=(1680, 460), text=0.13)
Pillars = partial(Lineup, build=pillar.build, spacing=2.2)

LINEUPS = {
    "pillars": Pillars(
        about="One pillar, bent by each linear surface method: which of them turn the grooves and studs.",
        row={
            "Rest": None,
            "Thin Shell": bent("thin_shell"),
            "Gradient Editing": bent("gradient_editing"),
            "Rotation-Invariant": bent("rotation_invariant_coordinates"),
            "Laplacian Editing": bent("laplacian_editing"),
            "Hierarchical": bent("hierarchical_smoothing"),
            "Subdivision": bent("subdivision_editing"),
            "Propagation": bent("propagation"),
        },
        spacing=2.04,
        shot=Photo((0.55, 0.0, 0.92), 16.6, distance=28.0, picture=(1920, 352)),
    ),
    "multiresolution": Pillars(
        about="One pillar, bent by the thin shell alone, and with multiresolution, which turns its studs.",
        row={
            "Rest": None,
            "Thin Shell": bent("thin_shell"),
            # The wavelength is in mean edge lengths: about the distance between two grooves.
            "Multiresolution, Thin Shell": bent("multiresolution", wavelength=45.0),
        },
        shot=Photo((0.55, 0.0, 0.92), 7.0, picture=(1280, 460)),
    ),
    "space_details": Pillars(
        about="One pillar, bent by a space method alone, and with its details put back on a smooth base.",
        row={
            "Rest": None,
            "Radial Basis Functions": bent("rbf"),
            "Multiresolution in Space": bent("multiresolution_space"),
            "Moving Least Squares": bent("mls"),
        },
        spacing=2.3,
        shot=WIDE(width=9.8),
    ),
    "volume": Pillars(
        about="One pillar, bent by methods of its surface and one of its inside: the volume that they keep.",
        row={
            "Rest": None,
            "Thin Shell": bent("thin_shell"),
            "Laplacian Editing, From Handles": bent("laplacian_editing", transforms="explicit"),
            "Volumetric Graph Laplacian": bent("volumetric_graph_laplacian"),
        },
        note=share_of_volume,
        shot=WIDE(width=9.2),
    ),
    "reduced": Pillars(
        about="One pillar, bent by surface methods with few unknowns: those of bands, and those of a cage.",
        row={
            "Rest": None,
            "As-Rigid-As-Possible": bent("arap"),
            "Handle-Aware Isolines": bent("handle_aware_isolines"),
            "Subspace Laplacian, Volume Free": bent("subspace_laplacian", keep_volume=False),
            "Subspace Laplacian": bent("subspace_laplacian"),
        },
        note=share_of_volume,
        shot=WIDE(width=11.4, picture=(1680, 400)),
    ),
    "vector_field": Pillars(
        about="One pillar, twisted, bent and dragged by vector fields: its volume stays.",
        build=pillar.build_striped,
        row={
            "Rest": None,
            "Twist": tool("twist", 1.0, Move(turn=(0, 0, 200)), inner=-0.75, outer=0.75, width=1.0),
            "Bend": tool("bend", 1.0, Move(turn=(0, 80, 0)), inner=-0.75, outer=0.75, width=0.45),
            "Drag": tool("drag", 1.5, Move(shift=(0.55, 0.0, -0.05)), inner=0.3, outer=1.2),
        },
        note=drift_of_volume,
        shot=Shot((0.1, 0.0, 0.9), 8.6, samples=32, picture=(1680, 520), text=0.13),
    ),
    "sheets": Lineup(
        about="One hose, bent by the nonlinear thin shell: a thin wall kinks, a thick one keeps its round.",
        build=pillar.build_hose,
        row={"Rest": None, "Thickness 0.5 %": hose_of(0.005), "2 %": hose_of(0.02), "8 %": hose_of(0.08)},
        spacing=2.3,
        shot=Photo((0.5, 0, 1), 10.0, distance=28.0, samples=32, picture=(1600, 480), text=0.2),
    ),
}
