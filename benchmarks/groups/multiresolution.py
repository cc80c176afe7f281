# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames and binds of the multiresolution deformation around a thin shell, next to those of the thin shell.

Neither side has an affine basis, which makes a frame of both a product. The wavelength is twice that of the
bumps.
"""

import numpy as np
from cases import bumpy_plate
from record import Row
from timing import Work, alternate, rounds

import sinew_native

from . import Options, Task

DETAILS = ("displacement_vectors", "normal_displacements", "deformation_transfer", "displacement_volumes")


def plan(options: Options) -> list[Task]:
    sizes = (10_000,) if options.quick else (40_000, 100_000)
    return [
        Task(
            "multiresolution",
            (f"multiresolution_{details}", f"multiresolution_bind_{details}"),
            {"size": size, "threads": options.threads, "details": details},
        )
        for details in DETAILS
        for size in sizes
    ]


def measure(size: int, threads: list[int], details: str) -> list[Row]:
    case = bumpy_plate(size)
    mesh = sinew_native.SurfaceMesh(case.points, case.faces)
    wavelength = 4 / 3 / np.linalg.norm(case.points[1] - case.points[0])

    def bound(name: str) -> sinew_native.SurfaceMethod:
        method: sinew_native.SurfaceMethod = sinew_native.ThinShell(mesh, affine_basis=False)
        if name == "ours":
            method = sinew_native.Multiresolution(mesh, method, details=details, wavelength=wavelength)
        method.set_handles(case.handles)
        return method

    methods = {name: bound(name) for name in ("ours", "peer")}
    rows: list[Row] = []
    for count in threads:
        works = {
            f"multiresolution_{details}": lambda name: methods[name].solve(case.poses),
            f"multiresolution_bind_{details}": bound,
        }
        for work, run in works.items():
            timed = {
                name: Work(
                    lambda name=name, run=run: run(name),
                    lambda count=count: sinew_native.limit_threads(count),
                )
                for name in methods
            }
            alternate(timed, least=rounds(size))
            best = {name: timed[name].best for name in methods}
            common = {"size": size, "threads": count, "vertices": mesh.vertex_count, "unit": "s"}
            rows.append({"work": work, **best, **common})
    return rows
