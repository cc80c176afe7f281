# SPDX-License-Identifier: GPL-3.0-or-later
"""A whole frame in a Blender that is a Python module: ``python system_frame.py --json FILE [--small]``.

Without a peer: the same Blender on another system is compared with it. ``bare write`` is a frame without
Sinew's handlers, which writes a shape and shows it: what Blender itself costs there.
"""

import json
import os
import sys

import bpy
from blender_frame import SIDE, Bare, CageFrames, Frames, box_around, deformer_on, medians, plate, silent


def measured() -> dict[str, float]:
    """Seconds by method."""
    found = {}
    for method in ("thin_shell", "arap"):
        obj = plate(SIDE)
        deformer = deformer_on(obj, method)
        frames = Frames(obj, deformer.handles[1].control)
        found[method] = medians({"ours": frames}, 9)["ours_ms"] / 1000.0
        if method == "thin_shell":
            bare = Bare(obj, deformer)
            with silent():
                found["bare write"] = medians({"ours": bare}, 21)["ours_ms"] / 1000.0
    obj = plate(SIDE)
    cage = box_around(obj)
    bpy.ops.sinew.cage_add(source="OBJECT", cage=cage.name, method="mean_value")
    frames = CageFrames(obj, cage)
    found["mean_value"] = medians({"ours": frames}, 21)["ours_ms"] / 1000.0
    if frames.moved() < 0.1:
        raise RuntimeError("nothing moved")
    return found


if __name__ == "__main__":
    found = measured()  # first, as an empty file would count as written
    with open(sys.argv[sys.argv.index("--json") + 1], "w", encoding="utf-8") as out:
        json.dump(found, out)
    os._exit(0)  # Blender as a module may hang or crash when it ends
