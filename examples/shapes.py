# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes 200 shapes of one model on all cores: python shapes.py in.obj FOLDER [SCHEDULER].

The lowest tenth stays. The highest tenth moves by one of 20 lengths and turns by one of 10 angles, as if to
find the best shape of a hull or a handle. What is in the folder already is not made again.
"""

import sys
from pathlib import Path

import numpy as np
from bend import read
from dask.distributed import Client

from sinew_farm.sweep import Mesh, Sweep


def shapes(source: str, folder: str) -> Sweep:
    points, faces = read(source)
    mesh = np.array([len(face) for face in faces]), np.concatenate(faces)
    height, size = points[:, 2], np.ptp(points[:, 2])
    foot = np.flatnonzero(height < height.min() + 0.1 * size)
    head = np.flatnonzero(height > height.max() - 0.1 * size)

    poses = {}
    for length in np.linspace(-0.2, 0.2, 20):
        for angle in np.linspace(0.0, np.pi / 4, 10):
            cos, sin, centre = np.cos(angle), np.sin(angle), points[head].mean(axis=0)
            turn = np.array([(cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)])
            moved = np.column_stack([turn, centre - turn @ centre + (0.0, 0.0, length * size)])
            poses[f"{length:+.3f},{np.degrees(angle):.0f}"] = np.array([np.eye(3, 4), moved])
    return Sweep({Path(source).stem: Mesh(points, mesh, [foot, head])}, poses, Path(folder), format="obj")


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit("usage: shapes.py in.obj FOLDER [SCHEDULER]")
    with Client(*sys.argv[3:]) as client:
        print(len(shapes(*sys.argv[1:3]).run(client)), "shapes are in", sys.argv[2])
