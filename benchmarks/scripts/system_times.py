# SPDX-License-Identifier: GPL-3.0-or-later
"""Times of binds, solves and warps on this system: ``python system_times.py FILE.json VERTICES``.

It needs only NumPy and sinew_native, so it runs in Windows' Python under Wine as on Linux.
"""

import json
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

import sinew_native as sn

sys.path.append(str(Path(__file__).resolve().parents[1]))

from cases import bar, box
from timing import Timed, alternate

BUDGET = 0.7  # seconds for each work, which runs twice at least: rounds of processes repeat it
ITERATIONS = 10  # of Arap: the same work everywhere, as rounding does not decide when it stops
CAGES = ("MeanValue", "PositiveMeanValue", "Harmonic", "Green")


def best(run: Callable[[], object]) -> float:
    return alternate({"": Timed(run)}, budget=BUDGET, least=2, most=10)[""].best


def measured(vertices: int) -> dict[str, float]:
    """Seconds by method and what it does."""
    case = bar("bend 90", vertices)
    mesh = sn.SurfaceMesh(case.points, case.faces)
    found: dict[str, float] = {}
    # As in a frame of the add-on: no array is made. A new one costs more page faults than the warp of a cage.
    out = np.zeros((len(case.points), 3), np.float32)
    arap = {"max_iterations": ITERATIONS, "tolerance": 1e-300}
    for name, options in (("ThinShell", {}), ("Arap", arap)):
        method = getattr(sn, name)(mesh, **options)

        def bind(name: str = name, options: dict = options) -> None:
            getattr(sn, name)(mesh, **options).set_handles(case.handles)

        found[f"{name}, bind"] = best(bind)
        method.set_handles(case.handles)
        found[f"{name}, solve"] = best(lambda method=method: method.solve(case.poses, out=out))
    points, faces = box((44.0, 14.0, 14.0), 14 / 3)
    points -= (2.0, 0.0, 0.0)
    cage = sn.SurfaceMesh(points, faces)
    bent = points + np.column_stack([np.zeros((len(points), 2)), 0.01 * points[:, 0] ** 2])
    for name in CAGES:
        coordinates = getattr(sn, name)(cage)
        found[f"{name}, bind"] = best(lambda coordinates=coordinates: coordinates.bind(case.points))
        found[f"{name}, warp"] = best(lambda coordinates=coordinates: coordinates.warp(bent, out=out))
    found["automatic cage"] = best(lambda: sn.automatic_cage(mesh, 300))
    fine = sn.SubdivisionSurface(mesh, level=2)
    coarse, refined = (np.zeros((count, 3), np.float32) for count in (fine.control_count, fine.vertex_count))
    coarse[:] = case.points
    found["subdivision"] = best(lambda: fine.refine(coarse, refined))
    return found


if __name__ == "__main__":
    found = measured(int(sys.argv[2]))  # first, as an empty file would count as written
    with open(sys.argv[1], "w", encoding="utf-8") as out:
        json.dump(found, out)
