# SPDX-License-Identifier: GPL-3.0-or-later
"""A cage of 300 faces around a scan, next to a cage by Blender's remesh, displace and decimate.

The time is compared with two seconds. For both cages, the faces of the target that cross the cage are
counted.
"""

import tempfile
from pathlib import Path

import numpy as np
from cases import OWN_MODEL, read_mesh
from record import Row
from timing import Work, alternate

import sinew_native

from . import Options, Task

FACES = 300
LONGEST = 2.0  # seconds
SCRIPT = Path(__file__).resolve().parents[1] / "cage_peer.py"


def plan(options: Options) -> list[Task]:
    works = ("cage_time", "cage_poking")
    if options.smallest:
        return [Task("automatic_cage", works, {"mesh": str(OWN_MODEL)})]
    if options.quick or options.meshes is None:
        return []
    return [Task("automatic_cage", works, {"mesh": str(options.meshes / "armadillo.obj")})]


def measure(mesh: str) -> list[Row]:
    from .blender import run_in

    points, faces = read_mesh(Path(mesh))
    target = sinew_native.SurfaceMesh(points, faces)
    works = {"ours": Work(lambda: sinew_native.automatic_cage(target, FACES), repeatable=False)}
    alternate(works, budget=6.0)
    cage, triangles, report = sinew_native.automatic_cage(target, FACES)
    row = {"size": round(len(points), -3), "vertices": len(points), "threads": None}
    with tempfile.TemporaryDirectory() as folder:
        given = Path(folder) / "target.npz"
        np.savez(given, points=points, faces=faces)
        (peer,) = run_in("3.4", SCRIPT, [str(given), str(FACES)])
    ours, theirs = poking(cage, triangles, points, faces), poking(*map(np.array, peer["cage"]), points, faces)
    return [
        {"work": "cage_time", **row, "unit": "s", "ours": works["ours"].best, "peer": LONGEST,
         "faces": report.faces},
        {"work": "cage_poking", **row, "unit": "faces", "ours": ours, "peer": theirs,
         "peer_seconds": peer["seconds"], "peer_faces": len(peer["cage"][1])},
    ]  # fmt: skip


def poking(cage: np.ndarray, triangles: np.ndarray, points: np.ndarray, faces: np.ndarray) -> int:
    """The number of faces of the target that cross the cage."""
    whole = sinew_native.SurfaceMesh(
        np.vstack((cage, points)), np.vstack((triangles, np.asarray(faces) + len(cage)))
    )
    pairs = sinew_native.diagnose_cage(whole).crossing_faces
    mixed = pairs[(pairs < len(triangles)).sum(axis=1) == 1]
    return len(np.unique(mixed.max(axis=1)))
