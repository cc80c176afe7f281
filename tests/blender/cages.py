# SPDX-License-Identifier: GPL-3.0-or-later
"""Targets and cages that the tests of cages share."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import bpy


def new_object(
    name: str, points: Iterable[Sequence[float]], faces: Iterable = (), edges: Iterable = ()
) -> bpy.types.Object:
    """A mesh object in the scene."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(list(points), list(edges), list(faces))
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def ball(name: str = "Ball", levels: int = 3) -> bpy.types.Object:
    """A small sphere at the origin."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=levels, radius=0.6)
    bpy.context.object.name = name
    return bpy.context.object


def add_raising_key(cage: bpy.types.Object, height: float) -> bpy.types.ShapeKey:
    """A shape key that raises all vertices, not on yet."""
    cage.shape_key_add(name="Basis")
    key = cage.shape_key_add(name="Up")
    for point in key.data:
        point.co.z += height
    key.value = 0.0  # new keys are on from Blender 5.0
    return key
