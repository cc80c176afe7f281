# SPDX-License-Identifier: GPL-3.0-or-later
"""Small meshes of triangles with vertex groups, and settings, for random sequences: there are formulas for
triangles only.
"""

from itertools import product

import bpy
import numpy as np
from registry import BY_ID, WITH_HANDLES

from rigs.rig import make_active, new_object

GROUPS = ("Far", "Near", "Middle", "Soft", "Nobody")


def wall(across: int, along: int, closed: bool = False) -> list:
    """The triangles of a wall of points, row after row; a closed one meets its first column again."""
    faces = []
    for j, i in product(range(along - 1), range(across if closed else across - 1)):
        a, b = j * across + i, j * across + (i + 1) % across
        faces += [(a, b, a + across), (b, b + across, a + across)]
    return faces


def sheet(columns: int, rows: int) -> tuple[list, list]:
    """A wavy strip of triangles along y, from -1 to 1."""
    points = [
        (0.5 * (2 * i / (columns - 1) - 1), 2 * j / (rows - 1) - 1, 0.1 * ((3 * i + 2 * j) % 5))
        for j, i in product(range(rows), range(columns))
    ]
    return points, wall(columns, rows)


def two_parts() -> tuple[list, list]:
    """A strip and a loose tetrahedron that lies in no handle at the ends."""
    points, faces = sheet(4, 8)
    n = len(points)
    points += [(0.0, 0.0, 1.0), (0.3, 0.0, 1.0), (0.0, 0.3, 1.0), (0.1, 0.1, 1.3)]
    return points, faces + [(n, n + 2, n + 1), (n, n + 1, n + 3), (n + 1, n + 2, n + 3), (n + 2, n, n + 3)]


def tube() -> tuple[list, list]:
    """Closed around y."""
    angles = 2.0 * np.pi * np.arange(6) / 6
    points = [(0.4 * np.cos(a), 2 * j / 8 - 1, 0.4 * np.sin(a)) for j in range(9) for a in angles]
    return points, wall(6, 9, closed=True)


SHAPES = {"strip": lambda: sheet(4, 9), "two_parts": two_parts, "tube": tube}


def new_target(shape: str) -> bpy.types.Object:
    """A mesh of 36 to 54 vertices with the groups of ``GROUPS``."""
    points, faces = SHAPES[shape]()
    obj = new_object(shape, points, faces)
    groups = {name: obj.vertex_groups.new(name=name) for name in GROUPS}
    for index, (_x, y, _z) in enumerate(points):
        for name, weight in (
            ("Far", float(y > 0.7)),
            ("Near", float(y < -0.7)),
            ("Middle", float(abs(y) < 0.6)),
            ("Soft", max(0.0, 0.9 - abs(y - 0.3))),
        ):
            if weight > 0.0:
                groups[name].add([index], weight, "REPLACE")
    make_active(obj)
    return obj


PAINT = ("Soft", "Far", "Nobody", "")


def values_of(parameter) -> tuple:
    """What a sequence sets a parameter to."""
    if hasattr(parameter, "items"):
        return tuple(item[0] for item in parameter.items)
    if isinstance(parameter.default, bool):
        return (True, False)
    if not hasattr(parameter, "minimum"):
        return ()
    if not parameter.rebinds:  # how far a solve goes: a loose end is no answer to compare with
        return (3,) if isinstance(parameter.default, int) else ()
    half = 0.5 * parameter.span.soft
    return (parameter.span.minimum, int(half) if isinstance(parameter.default, int) else half)


SETTINGS = tuple(
    (method, name, value)
    for method in WITH_HANDLES
    for parameter in BY_ID[method].parameters
    for name, values in (
        (parameter.id, values_of(parameter)),
        (f"{parameter.id}_group", PAINT if parameter in BY_ID[method].paintable else ()),
    )
    for value in values
)
