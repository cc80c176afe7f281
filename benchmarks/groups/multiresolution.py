# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of the multiresolution deformation around a thin shell, next to those of the thin shell itself.

The base gets an incoming shape in every frame, so the thin shell beside it does without its affine basis.
"""

from cases import bar
from record import Row
from timing import Work, alternate, rounds

import sinew_native

from . import Options, Task

DETAILS = ("displacement_vectors", "normal_displacements", "deformation_transfer", "displacement_volumes")


def plan(options: Options) -> list[Task]:
    size = 10_000 if options.quick else 100_000
    keywords = {"size": size, "threads": options.threads}
    return [
        Task("multiresolution", (f"multiresolution_{details}",), {**keywords, "details": details})
        for details in DETAILS
    ]


def measure(size: int, threads: list[int], details: str) -> list[Row]:
    case = bar("bend 90", size)
    mesh = sinew_native.SurfaceMesh(case.points, case.faces)
    base, peer = (sinew_native.ThinShell(mesh, affine_basis=False) for _ in range(2))
    methods = {"ours": sinew_native.Multiresolution(mesh, base, details=details), "peer": peer}
    for method in methods.values():
        method.set_handles(case.handles)
    rows: list[Row] = []
    for count in threads:
        frames = {
            name: Work(
                lambda method=method: method.solve(case.poses),
                lambda count=count: sinew_native.limit_threads(count),
            )
            for name, method in methods.items()
        }
        alternate(frames, least=rounds(size))
        best = {name: frames[name].best for name in methods}
        common = {"size": size, "threads": count, "vertices": mesh.vertex_count, "unit": "s"}
        rows.append({"work": f"multiresolution_{details}", "case": details, **best, **common})
    return rows
