# SPDX-License-Identifier: GPL-3.0-or-later
"""Bends a mesh: python bend.py in.obj out.obj. The lowest tenth stays, the highest one turns by 60 degrees."""

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
            points.append([float(word) for word in words[:3]])
        elif kind == "f":
            faces.append([int(word.split("/")[0]) - 1 for word in words])
    return np.array(points), faces


def main(source: str, target: str) -> None:
    points, faces = read(source)
    height = (points[:, 2] - points[:, 2].min()) / np.ptp(points[:, 2])
    handles = [np.flatnonzero(height < 0.1), np.flatnonzero(height > 0.9)]

    turn = np.radians(60.0)
    poses = np.tile(np.eye(3, 4), (2, 1, 1))
    poses[1, :, :3] = [[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]]
    centre = points.mean(axis=0)
    poses[1, :, 3] = centre - poses[1, :, :3] @ centre  # about the centre of the mesh

    corners = ([len(face) for face in faces], [corner for face in faces for corner in face])
    positions = sn.deform(points, corners, handles, poses, method="arap")
    with open(target, "w", encoding="utf-8") as file:
        file.writelines("v {} {} {}\n".format(*point) for point in positions)
        file.writelines("f {}\n".format(" ".join(str(corner + 1) for corner in face)) for face in faces)


if __name__ == "__main__":
    main(*sys.argv[1:3])
