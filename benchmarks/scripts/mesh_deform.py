# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the time and the weights of a bind of Blender's Mesh Deform. Blender runs it:

    blender -b --factory-startup -P benchmarks/scripts/mesh_deform.py -- CASE.npz OUT

CASE holds ``cage`` (c, 3), ``faces`` (m, 3 or 4) and ``points`` (n, 3); OUT gets ``seconds`` and ``weights``
(n, c): how far each point follows each cage vertex that is moved on its own.
"""

import sys
import time

import bpy
import numpy as np


def mesh_object(name: str, points: np.ndarray, faces: np.ndarray) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], faces.tolist())
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def evaluated(obj: bpy.types.Object) -> np.ndarray:
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    flat = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3).astype(float)


def main(case_path: str, out_path: str) -> None:
    case = np.load(case_path)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    cage = mesh_object("Cage", case["cage"], case["faces"])
    target = mesh_object("Target", case["points"], np.zeros((0, 3), int))
    modifier = target.modifiers.new("Mesh Deform", "MESH_DEFORM")
    modifier.object, modifier.precision = cage, 5
    bpy.context.view_layer.update()
    begin = time.perf_counter()
    with bpy.context.temp_override(object=target, active_object=target):
        bpy.ops.object.meshdeform_bind(modifier=modifier.name)
    bpy.context.view_layer.update()
    seconds = time.perf_counter() - begin
    if not modifier.is_bound:
        raise RuntimeError("Mesh Deform is not bound")

    weights = np.empty((len(case["points"]), len(case["cage"])))
    rest = evaluated(target)
    for vertex in range(len(case["cage"])):
        cage.data.vertices[vertex].co.z += 1.0
        cage.data.update()
        bpy.context.view_layer.update()
        weights[:, vertex] = evaluated(target)[:, 2] - rest[:, 2]
        cage.data.vertices[vertex].co.z -= 1.0
    with open(out_path, "wb") as out:
        np.savez(out, seconds=seconds, weights=weights)


main(*sys.argv[sys.argv.index("--") + 1 :])
