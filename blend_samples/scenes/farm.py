# SPDX-License-Identifier: GPL-3.0-or-later
"""Eight frames of a shot that four workers baked side by side: each worker has a colour."""

import json
import os
import subprocess
import tempfile
from pathlib import Path

import bpy
import numpy as np

from .. import posing
from ..materials import plain_material
from ..models import pillar
from ..studio import Shot, empty_scene, open_at

ROOT = Path(__file__).resolve().parents[2]
FARM = (
    f"{ROOT}/.build/venv-farm/bin/python -m sinew_farm dask shot.blend --workers 4 --json --out . --chunk 4"
)
COLOURS = ((0.55, 0.16, 0.10), (0.10, 0.30, 0.50), (0.55, 0.38, 0.06), (0.14, 0.38, 0.12))
SHOT = Shot((0.0, 0.0, 0.92), 13.0, distance=26.0, picture=(1600, 380))


def make() -> bpy.types.Scene:
    scene, live = empty_scene(), pillar.build()
    posing.add_deformer(live, "arap")
    control = posing.add_region(live, "HANDLE", "Head").control
    posing.add_region(live, "FIXED", "Foot")
    bend = posing.Move((0.5, 0.0, -0.7), (0.0, 100.0, 0.0), (0.0, 0.0, 1.8))
    posing.animate(control, {1: posing.REST, 32: bend})
    posing.check_posed(live, 1, 32)
    words = [*FARM.split(), "--frames", "1-32", "--objects", "Pillar", "--blender", bpy.app.binary_path]
    env = os.environ | {"PYTHONPATH": f"{ROOT}/native/python"}
    with tempfile.TemporaryDirectory() as folder:
        bpy.ops.wm.save_as_mainfile(filepath=f"{folder}/shot.blend", copy=True)
        told = map(json.loads, subprocess.check_output(words, cwd=folder, env=env).splitlines())
        by = {event["part"]: event["worker"] for event in told if event["sinew"] == "ended"}
        baked = np.fromfile(f"{folder}/Pillar.pc2", "<f4", offset=32).reshape(32, -1)
    labels, workers = [], sorted(set(by.values()))
    for last, x in zip(range(4, 33, 4), posing.places(8, 1.55)):
        shown = posing.add_object(f"Frame {last}", live.data.copy())
        shown.location.x = x
        shown.data.vertices.foreach_set("co", baked[last - 1])
        worker = workers.index(by[f"{last - 3}-{last}"])
        shown.data.materials[0] = plain_material(f"Worker {worker + 1}", COLOURS[worker])
        labels.append((shown.name, x))
    live.location.y, live.hide_render = 6.0, True  # behind what the picture shows, to play with
    SHOT.set_up(scene, labels)
    open_at(scene, 32, live)
    return scene
