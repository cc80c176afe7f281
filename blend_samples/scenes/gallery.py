# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison gallery: every surface method on four hard edits, with its measured distortion."""

from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np

from .. import posing, studio
from ..comparison import (
    CASES,
    Matrix,
    igl_arap,
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
PAGE = Path(__file__).resolve().parents[2] / "docs" / "methods" / "comparison.md"
BEGIN, END = "<!-- figures: written by blend_samples/run --publish gallery -->", "<!-- end of figures -->"
_made: list = []


def make() -> bpy.types.Scene:
    scene = studio.empty_scene()
    matrix = compared()
    matrix.write(OUTPUT / "gallery.json")
    studio.progress("drawing the sheets")
    sheets = [
        picture.of_matrix(matrix, OVERVIEW, "gallery", lines=1, rest="At rest"),
        *picture.paged(matrix, 6, "gallery"),
    ]
    picture.show(scene, sheets)
    _made[:] = [matrix, sheets]
    return scene


def compared() -> Matrix:
    matrix = Matrix(refusals=(posing.native().Error,), progress=studio.progress)
    for name, case in CASES.items():
        matrix.compare(name, case())
    for rows in (registry_rows, space_rows):
        for name, solve in rows(posing.registry(), posing.native()):
            matrix.compare(name, solve)
    matrix.compare("Laplacian Deform of Blender", picture.laplacian_deform)
    arap = igl_arap()
    if arap is None:
        studio.progress("no row of libigl: this Blender has no package igl")
    else:
        matrix.compare("As-Rigid-As-Possible of libigl", arap)
    return matrix


def pictures(scene: bpy.types.Scene) -> Iterator[tuple[str, np.ndarray]]:
    return picture.rendered(scene, _made[1])


def table(matrix: Matrix) -> str:
    """One line per row; of each case the rms, the least edge ratio, the ratio of areas and of volumes."""
    names = [case.name for case in matrix.columns.values()]
    lines = ["| | " + " | ".join(names) + " |", "|---|" + "---|" * len(names)]
    for row in matrix.rows:
        cells = []
        for column in matrix.columns:
            found = matrix.cells[row, column].distortion
            if found is None:
                cells.append("refused")
                continue
            volume = "" if found.volume is None else f", {found.volume:.2f}"
            cells.append(f"{found.edge_rms:.3f}, {found.edge_least:.2f}, {found.area:.2f}{volume}")
        lines.append(f"| {row} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def publish() -> None:
    """Write the table of all rows, and the pictures, between the marks of the page of the comparison."""
    matrix, every = _made
    names = [sheet.name for sheet in every[1:]]
    words = "![Rows of the matrix, sheet {} of {}](../manual/images/{}.jpg)"
    shown = [words.format(number, len(names), name) for number, name in enumerate(names, 1)]
    before, _begin, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    _old, _end, after = rest.partition(END)
    part = "\n\n".join((table(matrix), *shown))
    PAGE.write_text(f"{before}{BEGIN}\n{part}\n{END}{after}", encoding="utf-8")
