# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames in Blender with wires and with a tool, without their warp, next to writing a shape alone.

blender -b --factory-startup -P benchmarks/curves_frame.py -- [--small] --json FILE
"""

import json
import os
import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parent)]

import bpy  # noqa: E402
from blender_frame import SIDE, Bare, Frames, make_active, medians, plate, silent  # noqa: E402


def wires(obj: bpy.types.Object) -> bpy.types.Object:
    """Three wires across the plate, with 61 places each; the last one is moved."""
    for number, y in enumerate((-0.6, 0.0, 0.6)):
        data = bpy.data.curves.new(f"Wire {number}", "CURVE")
        data.dimensions = "3D"
        spline = data.splines.new("BEZIER")
        spline.bezier_points.add(5)
        for index, point in enumerate(spline.bezier_points):
            point.co = (-1.0 + 0.4 * index, y, 0.0)
            point.handle_left_type = point.handle_right_type = "AUTO"
        wire = bpy.data.objects.new(data.name, data)
        bpy.context.scene.collection.objects.link(wire)
        make_active(obj)
        bpy.ops.sinew.wire_add(curve=wire.name, radius=0.7)
    return wire


def tool(obj: bpy.types.Object) -> bpy.types.Object:
    """A drag in the middle of the plate."""
    make_active(obj)
    bpy.ops.sinew.tool_add(tool="drag", location=(0.0, 0.0, 0.0), outer=0.8)
    return obj.sinew.active.controls[0].object


def overhead(add) -> dict[str, float]:
    """Seconds of a frame without its warp, and of writing and evaluating a shape."""
    obj = plate(SIDE)
    ours = Frames(obj, add(obj))
    bare = Bare(obj, obj.sinew.active)

    def unheard(number: int) -> None:
        with silent():
            bare(number)

    found = medians({"ours": ours, "bare": unheard}, 41)
    if ours.moved() < 0.1:
        raise RuntimeError("nothing moved")
    return {"ours": found["around_ms"] / 1000.0, "peer": found["bare_ms"] / 1000.0}


def main() -> None:
    row = {"vertices": SIDE * SIDE, "case": "3.4", "blender": bpy.app.version_string}
    rows = [
        {"work": "overhead_wires", **row, **overhead(wires)},
        {"work": "overhead_field", **row, **overhead(tool)},
    ]
    out = Path(sys.argv[sys.argv.index("--json") + 1])
    out.write_text(json.dumps({"rows": rows}, indent=1) + "\n", encoding="utf-8")
    os._exit(0)


main()
