# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the answers of every method on known input, for another system to compare its own with.

``python -m tests.bindings.answers FILE.npz``, in the root of the checkout.
"""

import sys

import numpy as np

import sinew_native as sn

from .meshes import BENT, STILL, ends, grid, shift, sphere
from .methods import EVERY_SPACE_METHOD, EVERY_SURFACE_METHOD, called, inside, made


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
        for method, options in EVERY_SURFACE_METHOD:
            surface = made(method, mesh, **options)
            surface.set_handles(ends(of[name], 0.3 if name == "ball" else 1.6))
            poses = of["poses"] if name == "hill" else np.stack([STILL, shift(0, 0.3, 0.1)])
            found[f"solve {called(method)} {called(options)} {name}"] = surface.solve(poses)[0]
        fine = sn.SubdivisionSurface(mesh, level=2)
        found[f"subdivision {name}"] = fine.refine(of[name])
    cage = sn.SurfaceMesh(of["cage"], of["cage_faces"])
    for method, options in EVERY_SPACE_METHOD:
        coordinates = made(method, cage, **options)
        coordinates.bind(of["points"])
        found[f"warp {called(method)} {called(options)}"] = coordinates.warp(of["bent"])
    ball = sn.SurfaceMesh(of["ball"], of["ball_faces"])
    for count in (60, 100, 300):
        found[f"automatic cage {count}"] = sn.automatic_cage(ball, count, 0.1)[0]
    return found


if __name__ == "__main__":
    np.savez(sys.argv[1], **{f"given {name}": value for name, value in given().items()}, **answers(given()))
