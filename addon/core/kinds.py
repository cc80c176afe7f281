# SPDX-License-Identifier: GPL-3.0-or-later
"""What of an object a deformer moves: vertices where it has a surface, else control points."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Kind:
    """``component``: of a geometry, as Blender's nodes call it. ``nouns``: one, and several of what is moved.

    ``parts``: how many points of the rest shape belong to one of the component: itself, then its handles. The
    points of all come first, then all left handles, then all right ones.
    """

    id: str
    component: str
    nouns: tuple[str, str]
    parts: int = 1


_VERTICES, _POINTS = ("vertex", "vertices"), ("point", "points")
MESH = Kind("MESH", "MESH", _VERTICES)
SURFACE = Kind("SURFACE", "MESH", _VERTICES)  # of a curve or text that is filled, extruded or bevelled
CURVE = Kind("CURVE", "CURVE", _POINTS)
BEZIER = Kind("BEZIER", "CURVE", ("point or handle", "points and handles"), 3)
POINTCLOUD = Kind("POINTCLOUD", "POINTCLOUD", _POINTS)

_BY_ID = {kind.id: kind for kind in (MESH, SURFACE, CURVE, BEZIER, POINTCLOUD)}


def named(name: object) -> Kind:
    """By id; files may hold anything, and what is unknown counts as a mesh."""
    return _BY_ID.get(name, MESH) if isinstance(name, str) else MESH
