# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of earlier builds keep the sizes and the defaults of their time."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from mathutils import Matrix, Vector
from rigs.rig import (
    add_group,
    add_regions,
    evaluated_points,
    move_world,
    new_object,
    reopen,
    update,
)

MOTION = Matrix.Translation((0.2, 0.5, 0.4)) @ Matrix.Rotation(0.6, 4, (0.2, 1.0, 0.3))


def egg(change: str) -> bpy.types.Object:
    """An uneven body, with a loose vertex far away or without."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 17)[:-1], np.linspace(0.05, np.pi - 0.05, 9))
    radius = 1 + 0.2 * np.sin(3 * v) * np.cos(u + 0.4)
    points = np.stack(
        (3 * np.cos(v), radius * np.sin(v) * np.cos(u), 0.7 * radius * np.sin(v) * np.sin(u)), -1
    )
    index = np.arange(points[..., 0].size).reshape(points.shape[:2])
    right = np.roll(index, -1, axis=1)
    faces = np.stack((index[:-1], right[:-1], right[1:], index[1:]), -1).reshape(-1, 4)
    rows = points.reshape(-1, 3).tolist() + [(9.0, 40.0, -7.0)] * (change == "loose")
    obj = new_object("Egg", [tuple(row) for row in rows], [tuple(map(int, face)) for face in faces])
    for name, side in (("Fixed", -1), ("Moved", 1)):
        add_group(obj, name, lambda point, side=side: point[0] * side > 2.2 and abs(point[1]) < 5)
    return obj


def posed(obj: bpy.types.Object, method: str) -> np.ndarray:
    deformer = add_regions(obj, method, {"Fixed": "FIXED", "Moved": "HANDLE"})
    assert bpy.ops.sinew.bind() == {"FINISHED"}
    move_world(deformer.handles[1].control, MOTION)
    return evaluated_points(obj)


@pytest.mark.parametrize("change", ["", "loose"])
def test_a_file_of_an_earlier_build_keeps_its_looks(scene, change: str) -> None:
    """Its thickness is a share of the diagonal of the box; a file that says nothing is one of those."""
    obj = egg(change)
    new = posed(obj, "thin_shell_nonlinear")
    deformer = obj.sinew.active
    values = deformer.thin_shell_nonlinear
    values.tolerance, values.max_iterations = 1e-9, 1000
    deformer.property_unset("sizes")
    old = evaluated_points(obj)
    assert np.abs(old - new).max() > 1e-3
    corners = [Vector(vertex.co) for vertex in obj.data.vertices]
    box = np.ptp(np.array(corners), axis=0)
    values.thickness, values.measure = values.thickness * float(np.linalg.norm(box)), "length"
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
    scene, tmp_path: Path, method: str, parameter: str, former: float, without: tuple[str, ...]
) -> None:
    """``without``: what deformers of that build did not store."""
    rows = {}
    for name in ("New", "Old"):
        obj = egg("")
        obj.name = name
        rows[name] = posed(obj, method)
    for name in without:
        bpy.data.objects["Old"].sinew.active.property_unset(name)
    reopen(tmp_path / "old.blend")
    update()
    new, old = (bpy.data.objects[name].sinew.active for name in ("New", "Old"))
    assert np.array_equal(evaluated_points(new.id_data), rows["New"])
    assert getattr(getattr(old, method), parameter) == former
    setattr(getattr(new, method), parameter, former)
    for deformer in (new, old):
        deformer.property_unset("sizes")
    assert np.array_equal(evaluated_points(old.id_data), evaluated_points(new.id_data))
    assert np.abs(evaluated_points(old.id_data) - rows["Old"]).max() > 1e-3
