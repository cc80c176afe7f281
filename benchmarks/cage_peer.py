# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a cage by Blender's own modifiers: voxel remesh, displace along the normals, decimate.

blender -b --factory-startup -P benchmarks/cage_peer.py -- TARGET.npz FACES --json FILE
"""

import argparse
import json
import os
import sys
import time
from pathlib import Path

import bpy
import numpy as np

MARGIN = 1.0 / 60.0  # share of the diagonal: the size of a voxel, and the displacement of the surface


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("target", type=Path)
    parser.add_argument("faces", type=int)
    parser.add_argument("--json", type=Path, required=True)
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1 :])
    with np.load(options.target) as stored:
        points, faces = stored["points"], stored["faces"]
    mesh = bpy.data.meshes.new("Target")
    mesh.from_pydata(points.tolist(), [], faces.tolist())
    obj = bpy.data.objects.new("Target", mesh)
    bpy.context.scene.collection.objects.link(obj)
    margin = MARGIN * float(np.linalg.norm(np.ptp(points, axis=0)))

    begin = time.perf_counter()
    remesh = obj.modifiers.new("Remesh", "REMESH")
    remesh.mode, remesh.voxel_size = "VOXEL", margin
    displace = obj.modifiers.new("Displace", "DISPLACE")
    displace.strength, displace.mid_level = margin, 0.0
    obj.modifiers.new("Triangulate", "TRIANGULATE")
    bpy.context.view_layer.update()
    count = len(obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.polygons)
    decimate = obj.modifiers.new("Decimate", "DECIMATE")
    decimate.ratio = min(1.0, options.faces / max(count, 1))
    bpy.context.view_layer.update()
    cage = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    seconds = time.perf_counter() - begin

    cage.calc_loop_triangles()
    found = [
        [list(vertex.co) for vertex in cage.vertices],
        [list(triangle.vertices) for triangle in cage.loop_triangles],
    ]
    rows = [{"cage": found, "seconds": seconds}]
    options.json.write_text(json.dumps({"rows": rows}), encoding="utf-8")
    os._exit(0)


main()
