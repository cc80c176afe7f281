# SPDX-License-Identifier: GPL-3.0-or-later
"""Bends a mesh: python bend.py in.obj out.obj. The lowest tenth stays, the highest turns by 60 degrees."""

import sys
from pathlib import Path

import numpy as np

import sinew_native as sn


def read(path: str) -> tuple[np.ndarray, list[list[int]]]:
    """The vertices (n, 3) and the faces of an OBJ file."""
    points, faces = [], []
    for line in Path(path).read_text(encoding="utf-8").splitlines():
        kind, *words = line.split() or [""]
        if kind == "v":
            x, y, z, *_colours = map(float, words)
            points.append((x, y, z))
        elif kind == "f":
            faces.append([int(word.split("/")[0]) - 1 for word in words])
    if not points:
        raise ValueError(f"{path}: the mesh has no vertices")
    return np.array(points), faces


def write(path: str, positions: np.ndarray, faces: list[list[int]]) -> None:
    lines = ["v {} {} {}".format(*point) for point in positions.tolist()]
    lines += ["f " + " ".join(str(corner + 1) for corner in face) for face in faces]
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")


def bend(source: str, target: str) -> None:
    points, faces = read(source)
    mesh = [len(face) for face in faces], [corner for face in faces for corner in face]
    height = points[:, 2]
    low, size = height.min(), np.ptp(height)
    handles = [np.flatnonzero(height < low + 0.1 * size), np.flatnonzero(height > low + 0.9 * size)]

    cos, sin, centre = np.cos(np.pi / 3), np.sin(np.pi / 3), points.mean(axis=0)
    turn = np.array([(cos, 0.0, sin), (0.0, 1.0, 0.0), (-sin, 0.0, cos)])
    poses = np.tile(np.eye(3, 4), (2, 1, 1))
    poses[1] = np.column_stack([turn, centre - turn @ centre])  # about the centre of the mesh

    write(target, sn.deform(points, mesh, handles, poses, method="arap"), faces)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: bend.py in.obj out.obj")
    try:
        bend(*sys.argv[1:])
    except (OSError, ValueError, sn.Error) as error:
        sys.exit(str(error))
