# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the answers of every method on known input, for another system to compare its own with.

``python -m tests.bindings.oracles.answers FILE.npz``, in the root of the checkout.
"""

import sys

import numpy as np

import sinew_native as sn

from ..cages import CUBE, QUADS
from ..meshes import BENT, STILL, ends, grid, shift, sphere
from ..methods import (
    CAGE_METHODS,
    EVERY_CAGE_METHOD,
    EVERY_SURFACE_METHOD,
    SPACE_METHODS,
    called,
    control,
    inside,
    made,
    required,
)

DETAILS = ("normal_displacements", "displacement_volumes", "deformation_transfer")  # beside the default


def given() -> dict[str, np.ndarray]:
    """The input. It is stored with the answers, since sines of two systems may differ in the last bit."""
    hill, hill_faces = grid(12)
    ball, ball_faces = sphere(2)
    cage, cage_faces = sphere(1)
    names = ("hill", "hill_faces", "ball", "ball_faces", "cage", "cage_faces", "poses", "points", "bent")
    bent = 1.5 * cage + 0.1 * cage[:, ::-1] ** 2
    values = (hill, hill_faces, ball, ball_faces, 1.5 * cage, cage_faces, BENT, inside(cage, 2000), bent)
    return dict(zip(names, values))


def answers(of: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The shapes that all methods give for this input, by a name for each."""
    found = {}
    for name in ("hill", "ball"):
        mesh = sn.SurfaceMesh(of[name], of[f"{name}_faces"])
        handles = ends(of[name], 0.3 if name == "ball" else 1.6)
        poses = of["poses"] if name == "hill" else np.stack([STILL, shift(0, 0.3, 0.1)])
        for method, options in EVERY_SURFACE_METHOD:
            surface = made(method, mesh, **options)
            surface.set_handles(handles)
            found[f"solve {called(method)} {called(options)} {name}"] = surface.solve(poses)[0]
        for details in DETAILS:
            surface = sn.Multiresolution(mesh, sn.ThinShell(mesh), details=details)
            surface.set_handles(handles)
            found[f"solve Multiresolution details={details} {name}"] = surface.solve(poses)[0]
        fine = sn.SubdivisionSurface(mesh, level=2)
        found[f"subdivision {name}"] = fine.refine(of[name])
        found |= sketched(of[name], mesh, name)
        transfer = sn.MeshTransfer(mesh, sn.SurfaceMesh(of[name] * (1.0, 1.5, 0.8), of[f"{name}_faces"]))
        found[f"solve MeshTransfer {name}"] = transfer.transfer(of[name] + 0.1 * of[name][:, ::-1] ** 2)
    cage = sn.SurfaceMesh(of["cage"], of["cage_faces"])
    for method, options in EVERY_CAGE_METHOD:
        coordinates = made(method, cage, **options)
        coordinates.bind(of["points"])
        found[f"warp {called(method)} {called(options)}"] = coordinates.warp(of["bent"])
    found |= by_quads_and_outlines(of)
    ball = sn.SurfaceMesh(of["ball"], of["ball_faces"])
    for method in (each for each in SPACE_METHODS if each not in CAGE_METHODS):
        rest = control(method, ball)[:20]  # at most some of its points, so that the others are not at handles
        words = {"mesh": ball, "points": rest, "base": sn.Rbf(rest)}
        moved = method(**{word: words[word] for word in required(method)})
        moved.bind(of["ball" if "mesh" in required(method) else "points"])
        found[f"warp {called(method)}"] = moved.warp(1.2 * rest + 0.1 * rest[:, ::-1] ** 2)
    for count in (60, 100, 300):
        found[f"automatic cage {count}"] = sn.automatic_cage(ball, count, 0.1)[0]
    return found


def by_quads_and_outlines(of: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Points that follow a cage of quads as patches, and those that follow the outline of a flat cage."""
    box = 2.0 * CUBE - 1.0 + 0.1 * CUBE[:, ::-1] ** 2
    green = sn.Green(sn.SurfaceMesh(box, QUADS), faces="quads")
    green.bind(of["points"])
    found = {"warp Green faces=quads box": green.warp(1.5 * box + 0.1 * box[:, ::-1] ** 2)}
    corners = np.array([(-2, -2, 0), (2, -2, 0), (2, 2, 0), (0, 0.5, 0), (-2, 2, 0)])
    for method in (sn.Green, sn.MeanValue):
        flat = method(sn.SurfaceMesh(corners, [[0, 1, 2, 3, 4]]))
        flat.bind(of["points"])
        found[f"warp {method.__name__} flat"] = flat.warp(corners + 0.1 * corners[:, [2, 0, 1]] ** 2)
    return found


def sketched(points: np.ndarray, mesh: sn.SurfaceMesh, name: str) -> dict[str, np.ndarray]:
    """The outline seen from above, how a stroke beside half of it fits it, and the shapes that follow it."""
    edges, shares, _closed = max(sn.silhouette_lines(mesh, np.eye(3)), key=lambda line: len(line[0]))
    on_it = points[edges[:, 0]] + shares[:, None] * (points[edges[:, 1]] - points[edges[:, 0]])
    size = np.ptp(points, axis=0).max()
    stroke = on_it[: len(on_it) // 2] + size * np.array([0.03, 0.05, 0.0])
    edges, shares, targets = sn.fit_stroke(mesh, stroke, np.eye(3))
    found = {f"outline {name}": on_it, f"stroke {name}": targets}
    held = np.flatnonzero(np.linalg.norm(points - stroke.mean(0), axis=1) > 0.8 * size)
    for laplacian in ("cotan_voronoi", "uniform"):
        sketch = sn.SilhouetteSketch(mesh, edges, shares, held, laplacian=laplacian)
        found[f"solve SilhouetteSketch laplacian={laplacian} {name}"] = sketch.solve(targets)
    return found


if __name__ == "__main__":
    np.savez(sys.argv[1], **{f"given {name}": value for name, value in given().items()}, **answers(given()))
