# SPDX-License-Identifier: GPL-3.0-or-later
"""Times frames of a sheet with a million vertices, by Blender's modifier and by SubdivisionSurface.

blender -b --factory-startup -P benchmarks/subdivision_frame.py -- [--small] --json FILE
"""

import argparse
import json
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "tests" / "blender" / "support")]

from installed import enable  # noqa: E402

SIDE, LEVEL = 128, 3


def native():
    """The module that the installed add-on uses."""
    return sys.modules[f"{enable()}.backend.loader"].load().module


def sheet(side: int) -> tuple[np.ndarray, np.ndarray]:
    y, x = np.meshgrid(*[np.linspace(-1.0, 1.0, side + 1)] * 2, indexing="ij")
    points = np.stack((x, y, 0.1 * np.sin(9.0 * x) * np.cos(7.0 * y)), axis=-1)
    number = np.arange((side + 1) ** 2, dtype=np.int32).reshape(side + 1, side + 1)
    quads = np.stack((number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]), axis=-1)
    return points.reshape(-1, 3).astype(np.float32), quads.reshape(-1, 4)


def shown(name: str, points: np.ndarray, quads: np.ndarray) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set("co", points.ravel())
    mesh.loops.add(quads.size)
    mesh.loops.foreach_set("vertex_index", quads.ravel())
    mesh.polygons.add(len(quads))
    mesh.polygons.foreach_set("loop_start", np.arange(0, quads.size, 4, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(len(quads), 4, dtype=np.int32))
    mesh.update(calc_edges=True)
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def write(obj: bpy.types.Object, points: np.ndarray) -> None:
    """Write new positions, evaluate the mesh, and read it back."""
    obj.data.vertices.foreach_set("co", points.ravel())
    obj.data.update_tag()
    bpy.context.view_layer.update()
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    found = np.empty(3 * len(evaluated.vertices), np.float32)
    evaluated.vertices.foreach_get("co", found)


def medians(calls: dict[str, Callable[[np.ndarray], object]], points: np.ndarray) -> dict[str, float]:
    times: dict[str, list[float]] = {name: [] for name in calls}
    for number in range(10):
        moved = points + np.float32(0.01 * number)
        for name, call in calls.items():
            begin = time.perf_counter()
            call(moved)
            if number >= 3:
                times[name].append(time.perf_counter() - begin)
    return {name: float(np.median(values)) for name, values in times.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--small", action="store_true", help="a sheet of 8 x 8 faces")
    parser.add_argument("--json", type=Path, required=True, help="where to store the rows")
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1 :])
    sn = native()
    points, quads = sheet(8 if options.small else SIDE)
    surface = sn.SubdivisionSurface(sn.SurfaceMesh(points, quads), level=LEVEL)
    out = np.empty((surface.vertex_count, 3), np.float32)

    def refine(moved: np.ndarray) -> np.ndarray:
        return surface.refine(moved, out)

    peer = shown("Peer", points, quads)
    modifier = peer.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.use_limit_surface = LEVEL, False
    fine = shown("Fine", refine(points), surface.faces)
    calls = {
        "refine": refine,
        "frame": lambda moved: write(fine, refine(moved)),
        "peer": lambda moved: write(peer, moved),
    }
    found = medians(calls, points)
    row = {"vertices": surface.vertex_count, "case": "3.4", "blender": bpy.app.version_string}
    rows = [
        {"work": "subdivision_blender", **row, "ours": found["refine"], "peer": found["peer"]},
        {"work": "subdivision_frame", **row, "ours": found["frame"], "peer": found["peer"]},
    ]
    options.json.write_text(json.dumps({"rows": rows}, indent=1) + "\n", encoding="utf-8")
    os._exit(0)


main()
