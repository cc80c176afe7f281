# SPDX-License-Identifier: GPL-3.0-or-later
"""Small meshes of triangles with vertex groups, and settings, for random sequences: there are formulas for
triangles only.
"""

from __future__ import annotations

import bpy
import numpy as np
from registry import BY_ID, WITH_HANDLES

from rigs.rig import linked, make_active

GROUPS = ("Far", "Near", "Middle", "Soft", "Nobody")


def sheet(columns: int, rows: int) -> tuple[list, list]:
    """A wavy strip of triangles along y, from -1 to 1."""
    points = [
        (0.5 * (2 * i / (columns - 1) - 1), 2 * j / (rows - 1) - 1, 0.1 * ((3 * i + 2 * j) % 5))
        for j in range(rows)
        for i in range(columns)
    ]
    faces = []
    for j in range(rows - 1):
        for i in range(columns - 1):
            a = j * columns + i
            faces += [(a, a + 1, a + columns), (a + 1, a + columns + 1, a + columns)]
    return points, faces


def strip() -> tuple[list, list]:
    return sheet(4, 9)


def two_parts() -> tuple[list, list]:
    """A strip and a loose tetrahedron that lies in no handle at the ends."""
    points, faces = sheet(4, 8)
    n = len(points)
    points += [(0.0, 0.0, 1.0), (0.3, 0.0, 1.0), (0.0, 0.3, 1.0), (0.1, 0.1, 1.3)]
    return points, faces + [(n, n + 2, n + 1), (n, n + 1, n + 3), (n + 1, n + 2, n + 3), (n + 2, n, n + 3)]


def tube() -> tuple[list, list]:
    """Closed around y."""
    around, along = 6, 9
    points = [
        (0.4 * np.cos(6.283185 * i / around), 2 * j / (along - 1) - 1, 0.4 * np.sin(6.283185 * i / around))
        for j in range(along)
        for i in range(around)
    ]
    faces = []
    for j in range(along - 1):
        for i in range(around):
            a, b = j * around + i, j * around + (i + 1) % around
            faces += [(a, b, a + around), (b, b + around, a + around)]
    return points, faces


SHAPES = {"strip": strip, "two_parts": two_parts, "tube": tube}


def new_target(shape: str) -> bpy.types.Object:
    """A mesh of 36 to 54 vertices with the groups of ``GROUPS``."""
    points, faces = SHAPES[shape]()
    mesh = bpy.data.meshes.new(shape)
    mesh.from_pydata(points, [], faces)
    obj = linked(bpy.data.objects.new(shape, mesh))
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
