# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of the page ``docs/methods/comparison.md`` that a matrix fills: its table and its pictures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from .matrix import Matrix

PAGE = Path(__file__).resolve().parents[2] / "docs" / "methods" / "comparison.md"
BEGIN, END = "<!-- figures: written by blend_samples/run --publish gallery -->", "<!-- end of figures -->"


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


def write(matrix: Matrix, pictures: Sequence[str], path: Path = PAGE) -> None:
    """Put the table and the pictures, by name, between the marks of the page."""
    shown = [
        f"![Rows of the matrix, sheet {number} of {len(pictures)}](../manual/images/{name}.jpg)"
        for number, name in enumerate(pictures, 1)
    ]
    before, _begin, rest = path.read_text(encoding="utf-8").partition(BEGIN)
    _old, _end, after = rest.partition(END)
    part = "\n\n".join((table(matrix), *shown))
    path.write_text(f"{before}{BEGIN}\n{part}\n{END}{after}", encoding="utf-8")
