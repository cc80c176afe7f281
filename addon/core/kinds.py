# SPDX-License-Identifier: GPL-3.0-or-later
"""What of an object a deformer moves: vertices where it has a surface, else control points."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Kind:
    """``component`` is its geometry as Blender's nodes name it.

    ``parts``: how many points of the rest shape belong to one of the component: itself, then its handles. The
    points of all come first, then all left handles, then all right ones.
    """

    id: str
    component: str
    noun: str
    parts: int = 1


MESH = Kind("MESH", "MESH", "vertices")
SURFACE = Kind("SURFACE", "MESH", "vertices")  # of a curve or text that is filled, extruded or bevelled
CURVE = Kind("CURVE", "CURVE", "points")
BEZIER = Kind("BEZIER", "CURVE", "points and handles", 3)
POINTCLOUD = Kind("POINTCLOUD", "POINTCLOUD", "points")

BY_ID = {kind.id: kind for kind in (MESH, SURFACE, CURVE, BEZIER, POINTCLOUD)}
