# SPDX-License-Identifier: GPL-3.0-or-later
"""Bind and frame of the linear surface methods, next to those of the thin shell without its affine basis.

A frame of propagation, which solves nothing, also next to memory bandwidth: it reads the rest points and a
field per handle but one, and writes the result. Bandwidth is that of a block which no cache holds.
"""

from collections.abc import Callable
from functools import partial

import numpy as np
import sinew_peers
from cases import SLAB, Case, bar
from record import Row
from timing import Work, alternate, rounds

import sinew_native

from . import Options, Task

Maker = Callable[[sinew_native.SurfaceMesh], sinew_native.SurfaceMethod]


def _laplacian(transforms: str) -> Maker:
    return partial(sinew_native.LaplacianEditing, transforms=transforms)


# Case -> how to make its method, and the works of its bind and its frame.
METHODS: dict[str, tuple[Maker, str, str]] = {
    "GradientEditing": (sinew_native.GradientEditing, "linear_bind", "linear_frame"),
    "RotationInvariantCoordinates": (
        sinew_native.RotationInvariantCoordinates,
        "linear_bind",
        "linear_frame",
    ),
    "Propagation": (sinew_native.Propagation, "linear_bind", "linear_frame"),
    "SplineSurface": (sinew_native.SplineSurface, "linear_bind", "linear_frame"),
    "HierarchicalSmoothing": (sinew_native.HierarchicalSmoothing, "linear_bind", "hierarchical_frame"),
    "SubdivisionEditing": (sinew_native.SubdivisionEditing, "linear_bind", "subdivision_editing_frame"),
    "LaplacianEditing, none": (_laplacian("none"), "linear_bind", "none_frame"),
    "LaplacianEditing, explicit": (_laplacian("explicit"), "linear_bind", "explicit_frame"),
    "LaplacianEditing, estimated": (_laplacian("estimated"), "linear_bind", "estimated_frame"),
    "VolumetricGraphLaplacian": (
        sinew_native.VolumetricGraphLaplacian,
        "volumetric_bind",
        "volumetric_frame",
    ),
    "LaplacianEditing, implicit": (_laplacian("implicit"), "implicit_bind", "implicit_frame"),
}


FURTHER = {"Propagation": ("propagation_bound",)}
UNCACHED = 500_000_000  # bytes


def plan(options: Options) -> list[Task]:
    size = 10_000 if options.quick else 100_000
    keywords = {"size": size, "threads": options.threads}
    return [
        Task("linear", (bind, frame, *FURTHER.get(name, ())), {**keywords, "method": name})
        for name, (_, bind, frame) in METHODS.items()
    ]


def measure(size: int, threads: list[int], method: str) -> list[Row]:
    make, bind_work, frame_work = METHODS[method]
    case = _subdivided(size) if method == "SubdivisionEditing" else bar("bend 90", size)
    mesh = sinew_native.SurfaceMesh(case.points, case.faces)
    makers = {
        "ours": lambda: make(mesh),
        "peer": lambda: sinew_native.ThinShell(mesh, affine_basis=False),
    }
    rows: list[Row] = []
    for count in threads:
        binders = {name: _Binder(make, case.handles, count) for name, make in makers.items()}
        binds = {name: Work(each.bind, each.prepare, repeatable=False) for name, each in binders.items()}
        alternate(binds, budget=6.0, least=rounds(size))
        frames = {
            name: Work(
                lambda made=each.made: made.solve(case.poses),
                lambda count=count: sinew_native.limit_threads(count),
            )
            for name, each in binders.items()
        }
        alternate(frames, least=rounds(size))
        common = {"size": size, "threads": count, "vertices": mesh.vertex_count, "unit": "s"}
        for work, times in ((bind_work, binds), (frame_work, frames)):
            best = {name: times[name].best for name in makers}
            rows.append({"work": work, "case": method, **best, **common})
        for work in FURTHER.get(method, ()):
            moved = 2 * case.points.nbytes + 8 * case.vertex_count * (len(case.handles) - 1)
            peer = moved / sinew_peers.read_bandwidth(UNCACHED, count)
            rows.append({"work": work, **common, "ours": frames["ours"].best, "peer": peer, "bytes": moved})
    return rows


def _subdivided(vertices: int) -> Case:
    """A coarser bar, subdivided three times by Loop's rules."""
    coarse = bar("bend 90", vertices // 64)
    mesh = sinew_native.SurfaceMesh(coarse.points, coarse.faces)
    surface = sinew_native.SubdivisionSurface(mesh, scheme="loop", level=3)
    points, faces = surface.refine(coarse.points), surface.faces
    assert isinstance(faces, np.ndarray)
    x = points[:, 0]
    handles = [np.flatnonzero(x <= SLAB), np.flatnonzero(x >= coarse.points[:, 0].max() - SLAB)]
    return Case(coarse.name, points, faces, handles, coarse.poses)


class _Binder:
    """Binds a new object in each turn."""

    def __init__(
        self, make: Callable[[], sinew_native.SurfaceMethod], handles: list[np.ndarray], threads: int
    ) -> None:
        self._make, self._handles, self._threads = make, handles, threads

    def prepare(self) -> None:
        sinew_native.limit_threads(self._threads)
        self.made = self._make()

    def bind(self) -> None:
        self.made.set_handles(self._handles)
