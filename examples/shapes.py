# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes 200 shapes of one model on all cores: python shapes.py in.obj FOLDER [SCHEDULER].

The lowest tenth stays, the highest tenth moves and turns. What is in the folder is not made again.
"""

import sys
from pathlib import Path

import numpy as np
from bend import read
from dask.distributed import Client

from sinew_farm.sweep import Mesh, Sweep


def shapes(source: str, folder: str) -> Sweep:
    points, faces = read(source)
    z, size = points[:, 2], np.ptp(points[:, 2])
    foot, head = np.flatnonzero(z < z.min() + 0.1 * size), np.flatnonzero(z > z.max() - 0.1 * size)
    mesh = Mesh(points, ([len(face) for face in faces], np.concatenate(faces)), [foot, head])
    poses = {}
    for length in np.linspace(-0.2, 0.2, 20):
        for angle in np.linspace(0.0, np.pi / 4, 10):
            cos, sin = np.cos(angle), np.sin(angle)
            moved = [(cos, -sin, 0, 0), (sin, cos, 0, 0), (0, 0, 1, length * size)]  # about the z axis
            poses[f"{length:+.3f},{np.degrees(angle):.0f}"] = np.array([np.eye(3, 4), moved])
    return Sweep({Path(source).stem: mesh}, poses, Path(folder), format="obj")


if __name__ == "__main__":
    with Client(*sys.argv[3:]) as client:
        print(len(shapes(*sys.argv[1:3]).run(client)), "shapes are in", sys.argv[2])
