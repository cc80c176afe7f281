# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of earlier builds keep the sizes and the defaults of their time."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from rigs.rig import add_group, add_regions, base_points, evaluated_points, linked, move_world, reopen

MOTION = Matrix.Translation((0.2, 0.5, 0.4)) @ Matrix.Rotation(0.6, 4, (0.2, 1.0, 0.3))


def posed_egg(method: str, name: str = "Egg", loose: bool = False) -> bpy.types.Object:
    """An uneven body, with a loose vertex far away or without, whose end has been moved."""
    if "Sphere" not in bpy.data.meshes:  # Blender orders the faces of each new one in another way
        bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=9)
    obj = linked(bpy.data.objects.new(name, bpy.data.meshes["Sphere"].copy()))
    for vertex in obj.data.vertices:
        x, y, z = vertex.co
        vertex.co = 3.0 * z, (1.0 + 0.2 * np.sin(3.0 * z + x)) * y, 0.7 * x
    if loose:
        obj.data.vertices.add(1)
        obj.data.vertices[-1].co = 9.0, 40.0, -7.0
    for group, side in (("Fixed", -1), ("Moved", 1)):
        add_group(obj, group, lambda point, side=side: point[0] * side > 2.2 and abs(point[1]) < 5)
    deformer = add_regions(obj, method, {"Fixed": "FIXED", "Moved": "HANDLE"})
    assert bpy.ops.sinew.bind() == {"FINISHED"}
    move_world(deformer.handles[1].control, MOTION)
    return obj


@pytest.mark.parametrize("loose", [False, True])
def test_a_file_of_an_earlier_build_keeps_its_looks(loose: bool) -> None:
    """Its thickness is a share of the diagonal of the box; a file that says nothing is one of those."""
    obj = posed_egg("thin_shell_nonlinear", loose=loose)
    new, deformer = evaluated_points(obj), obj.sinew.active
    values = deformer.thin_shell_nonlinear
    values.tolerance, values.max_iterations = 1e-9, 1000
    deformer.property_unset("sizes")
    old = evaluated_points(obj)
    assert np.abs(old - new).max() > 1e-3
    values.thickness *= np.linalg.norm(np.ptp(base_points(obj), axis=0))
    values.measure = "length"
    assert np.abs(evaluated_points(obj) - old).max() < 1e-4


@pytest.mark.parametrize(
    ("method", "parameter", "former", "without"),
    [
        ("mls", "alpha", 1.0, ("sizes", "defaults")),
        ("subspace_laplacian", "cage_faces", 160, ("sizes", "defaults")),
        ("subspace_laplacian", "cage_faces", 160, ("defaults",)),
    ],
)
def test_a_file_of_an_earlier_build_keeps_the_default_of_its_time(
    tmp_path: Path, method: str, parameter: str, former: float, without: tuple[str, ...]
) -> None:
    """``without``: what deformers of that build did not store."""
    names = ("New", "Old")
    before = [evaluated_points(posed_egg(method, name)) for name in names]
    for name in without:
        bpy.data.objects["Old"].sinew.active.property_unset(name)
    reopen(tmp_path / "old.blend")
    new, old = (bpy.data.objects[name] for name in names)
    assert np.array_equal(evaluated_points(new), before[0])
    assert getattr(getattr(old.sinew.active, method), parameter) == former
    setattr(getattr(new.sinew.active, method), parameter, former)
    for obj in (new, old):
        obj.sinew.active.property_unset("sizes")
    assert np.array_equal(evaluated_points(old), evaluated_points(new))
    assert np.abs(evaluated_points(old) - before[1]).max() > 1e-3
