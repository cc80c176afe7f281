# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender: ``blender --background --python make.py -- SAMPLE [--publish]`` makes one sample.

Lines for people start with ``> ``, so that ``run`` can tell them from Blender's own.
"""

import argparse
import importlib
import sys
from pathlib import Path

import bpy

FOLDER = Path(__file__).resolve().parent
OUTPUT = FOLDER / "output"
PICTURES = FOLDER.parent / "docs" / "manual" / "images"
sys.path.insert(0, str(FOLDER.parent))


def main() -> None:
    words = sys.argv[sys.argv.index("--") + 1 :]
    parser = argparse.ArgumentParser(prog="make.py", description=__doc__)
    parser.add_argument("sample")
    parser.add_argument("--publish", action="store_true", help="also write the picture that the README shows")
    wanted = parser.parse_args(words)
    if not hasattr(bpy.types.Object, "sinew"):
        raise SystemExit(
            "The Sinew add-on is not enabled in this Blender: run blend_samples/run, which installs it."
        )

    rows = importlib.import_module("blend_samples.lineups").LINEUPS
    sample = rows.get(wanted.sample) or importlib.import_module(f"blend_samples.scenes.{wanted.sample}")
    studio = importlib.import_module("blend_samples.studio")
    denoise = importlib.import_module("blend_samples.denoise")
    OUTPUT.mkdir(exist_ok=True)
    scene = sample.make()
    scene.name = wanted.sample
    bpy.context.preferences.filepaths.save_version = 0  # no .blend1 beside it
    scene.render.filepath = f"//{wanted.sample}.png"
    bpy.ops.wm.save_as_mainfile(filepath=str(OUTPUT / f"{wanted.sample}.blend"), compress=True)
    studio.progress(f"rendering {scene.render.resolution_x} x {scene.render.resolution_y} pixels")
    if hasattr(sample, "pictures"):  # by its own means
        pictures = sample.pictures(scene)
    else:
        pictures = [(wanted.sample, denoise.render_clean(scene))]
    for name, light in pictures:
        scene = bpy.context.scene  # of samples that make several, that of the last one
        denoise.write_picture(scene, light, OUTPUT / f"{name}.png")
        if wanted.publish:
            denoise.write_picture(scene, light, PICTURES / f"{name}.jpg")
    if wanted.publish and hasattr(sample, "publish"):
        sample.publish()


main()
