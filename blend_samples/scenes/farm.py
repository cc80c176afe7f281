# SPDX-License-Identifier: GPL-3.0-or-later
"""Eight frames of a shot that four workers baked side by side: each worker has a colour."""

import json
import os
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

import bpy
import numpy as np

from .. import posing
from ..materials import plain_material
from ..models import pillar
from ..studio import Shot, empty_scene, open_at

ROOT = Path(__file__).resolve().parents[2]
FARM = f"{ROOT}/.build/venv-farm/bin/python -m sinew_farm dask a.blend --workers 4 --json --out . --chunk 4"
COLOURS = ((0.55, 0.16, 0.10), (0.10, 0.30, 0.50), (0.55, 0.38, 0.06), (0.14, 0.38, 0.12))
BEND = posing.Move((0.5, 0.0, -0.7), (0.0, 100.0, 0.0), (0.0, 0.0, 1.8))


def make() -> bpy.types.Scene:
    scene, live = empty_scene(), pillar.build()
    posing.add_deformer(live, "arap")
    posing.animate(posing.add_region(live, "HANDLE", "Head").control, {1: posing.REST, 32: BEND})
    posing.add_region(live, "FIXED", "Foot")
    words = [*FARM.split(), "--frames", "1-32", "--objects", "Pillar", "--blender", bpy.app.binary_path]
    with TemporaryDirectory() as folder:
        bpy.ops.wm.save_as_mainfile(filepath=f"{folder}/a.blend", copy=True)
        env = os.environ | {"PYTHONPATH": f"{ROOT}/native/python"}
        told = map(json.loads, subprocess.check_output(words, cwd=folder, env=env).splitlines())
        workers = {event["part"]: event["worker"] for event in told if event["sinew"] == "ended"}
        baked = np.fromfile(f"{folder}/Pillar.pc2", "<f4", offset=32).reshape(32, -1)
    row = {f"Frame {last}": x for last, x in zip(range(4, 33, 4), posing.places(8, 1.55))}
    for last, (name, x) in zip(range(4, 33, 4), row.items()):
        shown = posing.add_object(name, live.data.copy())
        shown.location.x = x
        shown.data.vertices.foreach_set("co", baked[last - 1])
        number = sorted(set(workers.values())).index(workers[f"{last - 3}-{last}"])
        shown.data.materials[0] = plain_material(f"Worker {number + 1}", COLOURS[number])
    live.location.y, live.hide_render = 6.0, True  # behind what the picture shows, to play with
    Shot((0.0, 0.0, 0.92), 13.0, distance=26.0, picture=(1600, 380)).set_up(scene, row.items())
    open_at(scene, 32, live)
    return scene
