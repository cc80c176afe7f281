# SPDX-License-Identifier: GPL-3.0-or-later
"""Point types: what the points of a target are.

A target with a surface has vertices, others control points.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class PointType:
    """One type of points.

    ``component`` is the name that Blender's nodes give to the component of a geometry that holds the points.
    ``nouns`` are the words for one point and for several. ``points_per_element`` is how many points of the
    rest shape belong to one element of the component: the element itself, then its handles. The rest shape
    holds the elements first, then all left handles, then all right handles.
    """

    id: str
    component: str
    nouns: tuple[str, str]
    points_per_element: int = 1


_VERTICES, _POINTS = ("vertex", "vertices"), ("point", "points")
MESH = PointType("MESH", "MESH", _VERTICES)
SURFACE = PointType("SURFACE", "MESH", _VERTICES)  # of an extruded or filled curve or text
CURVE = PointType("CURVE", "CURVE", _POINTS)
BEZIER = PointType("BEZIER", "CURVE", ("point or handle", "points and handles"), 3)
POINTCLOUD = PointType("POINTCLOUD", "POINTCLOUD", _POINTS)
LATTICE = PointType("LATTICE", "", _POINTS)  # which no node reads

_BY_ID = {point_type.id: point_type for point_type in (MESH, SURFACE, CURVE, BEZIER, POINTCLOUD, LATTICE)}


def point_type_with_id(identifier: object) -> PointType:
    """The point type with this identifier. Files may hold any value; an unknown one counts as a mesh."""
    return _BY_ID.get(identifier, MESH) if isinstance(identifier, str) else MESH
