# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison gallery: every surface method on four hard edits, with its measured distortion."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np

from .. import denoise, inside, studio
from ..comparison import (
    CASES,
    Matrix,
    Solve,
    all_figures,
    igl_arap,
    native_solve,
    page,
    picture,
    registry_rows,
    space_rows,
)

# The rows of the overview, which are those of the tutorial's figure 17 and its first line.
OVERVIEW = (
    "As-Rigid-As-Possible",
    "Multiresolution: Deformation Transfer",
    "Gradient Editing",
    "Laplacian Editing: Implicit",
)
OUTPUT = Path(__file__).parents[1] / "output"
_made: list = []


def make() -> bpy.types.Scene:
    scene = studio.empty_scene("Gallery")
    matrix = compared()
    matrix.write(OUTPUT / "gallery.json")
    studio.progress("drawing the sheets")
    sheets = [
        picture.of_matrix(matrix, OVERVIEW, "gallery", lines=1, rest="At rest"),
        *picture.paged(matrix, 6, "gallery"),
        picture.of_figures(list(all_figures(ours)), "gallery-figures"),
    ]
    picture.add_camera(scene)
    picture.add_sheets(scene, sheets)
    picture.set_up_render(scene)
    picture.look_at(scene, sheets, 0)
    studio.look_through_camera()
    _made[:] = [matrix, sheets]
    return scene


def compared() -> Matrix:
    """Every row on every case."""
    matrix = Matrix(refusals=(inside.native().Error,), progress=studio.progress)
    for name, case in CASES.items():
        matrix.compare(name, case())
    for rows in (registry_rows, space_rows):
        for name, solve in rows(inside.registry(), inside.native()):
            matrix.compare(name, solve)
    matrix.compare("Laplacian Deform of Blender", picture.laplacian_deform)
    arap = igl_arap()
    if arap is None:
        studio.progress("no row of libigl: this Blender has no package igl")
    else:
        matrix.compare("As-Rigid-As-Possible of libigl", arap)
    return matrix


def ours(name: str, **options: object) -> Solve:
    """A row of the registry, with its defaults but for these options."""
    return native_solve(inside.registry(), inside.native(), name, **options)


def pictures(scene: bpy.types.Scene) -> Iterator[tuple[str, np.ndarray]]:
    """One picture per sheet: its name and its light (height, width, 3)."""
    _matrix, every = _made
    for number, sheet in enumerate(every):
        picture.look_at(scene, every, number)
        bpy.context.view_layer.update()
        yield sheet.name, denoise.render_passes(scene, ("Image",))["Image"]


def publish() -> None:
    """Write the figures of all rows into the page of the comparison."""
    matrix, every = _made
    page.write(matrix, [sheet.name for sheet in every[1:-1]])
