# SPDX-License-Identifier: GPL-3.0-or-later
"""The time that the add-on takes in updates of Blender that do not concern it, in a scene of many objects.

    blender -b --factory-startup -P benchmarks/handler_cost.py -- [--objects N] [--json FILE]

or, with Blender as a module, ``python benchmarks/handler_cost.py``. An unrelated object is moved again
and again; the rows say how long our handler took of each update, and how long the whole update took.
"""

import argparse
import json
import os
import sys
import time
from pathlib import Path

import bpy
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "tests" / "blender" / "support")]

from installed import enable  # noqa: E402
from rigs.rig import Rig, grid_object, make_active, update  # noqa: E402

GOAL = 0.1  # milliseconds per update


def crowd(count: int) -> bpy.types.Object:
    """Add objects that do not concern the add-on. Returns one of them."""
    for number in range(count):
        obj = bpy.data.objects.new(f"Unrelated {number}", None)
        bpy.context.scene.collection.objects.link(obj)
    update()
    return obj


def measure(addon: str, objects: int, deformers: int, cells: int, moves: int) -> dict[str, object]:
    """Medians and 95th percentiles over ``moves`` updates, in milliseconds."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    vertices = 0
    for number in range(deformers):
        rig = Rig(grid_object(f"Plate {number}", cells)).bind()
        rig.lift(0.5)
        vertices += len(rig.obj.data.vertices)
    other = crowd(objects)
    make_active(other)
    module = sys.modules[f"{addon}.handlers.evaluation"]
    handlers, ours, spent = bpy.app.handlers.depsgraph_update_post, module.on_depsgraph_update, []

    def timed(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
        begin = time.perf_counter()
        ours(scene, depsgraph)
        spent.append(time.perf_counter() - begin)

    handlers.remove(ours)
    handlers.append(timed)
    whole = []
    for move in range(moves + 10):
        other.location.x = 0.001 * move
        begin = time.perf_counter()
        update()
        whole.append(time.perf_counter() - begin)
    handlers.remove(timed)
    handlers.append(ours)
    handler, updates = np.array(spent[10:]) * 1000.0, np.array(whole[10:]) * 1000.0
    return {
        "blender": bpy.app.version_string,
        "unrelated_objects": objects,
        "deformers": deformers,
        "vertices": vertices,
        "handler_ms": float(np.median(handler)),
        "handler_ms_95": float(np.percentile(handler, 95)),
        "update_ms": float(np.median(updates)),
    }


def main() -> None:
    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--objects", type=int, default=1000)
    parser.add_argument("--moves", type=int, default=300)
    parser.add_argument("--small", action="store_true", help="each row once, in a small scene")
    parser.add_argument("--json", type=Path, help="where to store the rows")
    options = parser.parse_args(arguments if bpy.app.binary_path else sys.argv[1:])
    addon = enable()
    objects, moves = (10, 1) if options.small else (options.objects, options.moves)
    rows = [
        measure(addon, objects, deformers, 10 if options.small else cells, moves)
        for deformers, cells in ((1, 10), (1, 200), (10, 30))
    ]
    print(f"{'deformers':>9} {'vertices':>9} {'handler ms':>11} {'95 %':>8} {'update ms':>10}")
    for row in rows:
        mark = "" if row["handler_ms"] <= GOAL else f"  over {GOAL} ms"
        counts = f"{row['deformers']:9} {row['vertices']:9,}"
        times = f"{row['handler_ms']:11.4f} {row['handler_ms_95']:8.4f} {row['update_ms']:10.3f}"
        print(f"{counts} {times}{mark}")
    if options.json:
        options.json.write_text(json.dumps({"rows": rows}, indent=1) + "\n", encoding="utf-8")
    sys.stdout.flush()
    os._exit(0)  # Blender as a module may hang or crash when it ends


main()
