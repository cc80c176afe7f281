# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of new regions: a handle is called after the bone beside it, or after the side that it is on."""

import numpy as np
from bpy.types import Object

from ....core.names import numbered, spoken
from ...datablocks.movers import armatures_of

NAMES = {"HANDLE": "Handle", "FIXED": "Still", "SUPPORT": "Free Area"}  # by role
_MIDDLE = 0.1  # what lies nearer to the middle than this has no side; a share of the half width
_LOPSIDED = 1.5  # a mesh that reaches so many times farther to one side than to the other has no sides


def name_of_region(obj: Object, role: str, points: np.ndarray, members: np.ndarray) -> str:
    """A name for a new region and its vertex group, which no other group or bone has.

    ``members`` is a mask (n,) of the vertices ``points`` (n, 3) of the mesh.
    """
    name, armatures = NAMES[role], armatures_of(obj)
    if role == "HANDLE" and members.any():
        place = points[members].mean(axis=0)
        name = _nearest_bone(obj, armatures, place) or f"{name}{_side(points, place)}"
    taken = {group.name for group in obj.vertex_groups}
    taken |= {bone.name for armature in armatures for bone in armature.data.bones}
    return numbered(name, taken)


def _nearest_bone(obj: Object, armatures: list[Object], place: np.ndarray) -> str:
    """The bone nearest to a place of the mesh, both at rest; empty without bones that deform."""
    world = np.array(obj.matrix_world, dtype=np.float64) @ (*place, 1.0)
    found = []
    for armature in armatures:
        matrix = np.array(armature.matrix_world, dtype=np.float64)
        for bone in armature.data.bones:
            if bone.use_deform:
                head, tail = (
                    (matrix @ (*end, 1.0))[:3] - world[:3] for end in (bone.head_local, bone.tail_local)
                )
                along = tail - head
                share = np.clip(-(head @ along) / max(along @ along, 1e-30), 0.0, 1.0)
                found.append((np.linalg.norm(head + share * along), bone.name))
    return spoken(min(found)[1]) if found else ""


def _side(points: np.ndarray, place: np.ndarray) -> str:
    """The side that a place is on, as the end of a name; empty in the middle, and on a mesh without sides."""
    low, high = -float(points[:, 0].min()), float(points[:, 0].max())
    if min(low, high) <= 0.0 or max(low, high) > _LOPSIDED * min(low, high):
        return ""
    share = place[0] / max(low, high)
    if not np.isfinite(share):
        return ""
    return "" if abs(share) < _MIDDLE else " L" if share > 0.0 else " R"
