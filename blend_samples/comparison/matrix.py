# SPDX-License-Identifier: GPL-3.0-or-later
"""The matrix of methods and cases, with one function that adds a row or a column."""

import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .cases import Case
from .measures import Distortion, distortion
from .rows import Solve


@dataclass(frozen=True)
class Cell:
    """A shape (n, 3) with its distortion, or why there is none."""

    shape: np.ndarray | None
    distortion: Distortion | None
    refusal: str = ""

    def numbers(self) -> dict[str, object]:
        if self.distortion is None:
            return {"refused": self.refusal}
        found = self.distortion.as_dict().items()
        return {key: None if value is None else float(f"{value:.4g}") for key, value in found}


@dataclass
class Matrix:
    """Methods down, cases across. ``refusals`` are the errors by which a method may decline a case."""

    refusals: tuple[type[Exception], ...] = ()
    progress: Callable[[str], None] = lambda _text: None
    rows: dict[str, Solve] = field(default_factory=dict)
    columns: dict[str, Case] = field(default_factory=dict)
    cells: dict[tuple[str, str], Cell] = field(default_factory=dict)

    def compare(self, name: str, entry: Solve | Case) -> None:
        """Add a row, ``entry(case) -> points`` (n, 3), or a column, a case; and compute its cells."""
        if isinstance(entry, Case):
            self.columns[name] = entry
            pairs = [(row, name) for row in self.rows]
        else:
            self.rows[name] = entry
            pairs = [(name, column) for column in self.columns]
        for row, column in pairs:
            self.progress(f"{row}: {column}")
            self.cells[row, column] = self._cell(self.rows[row], self.columns[column])

    def _cell(self, solve: Solve, case: Case) -> Cell:
        try:
            shape = np.asarray(solve(case), dtype=np.float64)
        except self.refusals as error:
            return Cell(None, None, str(error))
        if shape.shape != case.points.shape:
            return Cell(None, None, f"gave points {shape.shape}, not {case.points.shape}")
        if not np.isfinite(shape).all():
            return Cell(None, None, "gave points that are not finite")
        return Cell(shape, distortion(case, shape))

    def column(self, name: str) -> list[np.ndarray]:
        """The shapes of a case by all methods that gave one."""
        found = [cell.shape for (_row, at), cell in self.cells.items() if at == name]
        return [shape for shape in found if shape is not None]

    def write(self, path: Path) -> None:
        """What was measured, as JSON: of each row and case the figures, or why there are none."""
        columns = {
            name: {
                "edit": case.name,
                "vertices": len(case.points),
                "triangles": len(case.triangles),
                "free_vertices": int(case.free.sum()),
            }
            for name, case in self.columns.items()
        }
        rows = {row: {name: self.cells[row, name].numbers() for name in columns} for row in self.rows}
        path.write_text(json.dumps({"columns": columns, "rows": rows}, indent=1) + "\n", encoding="utf-8")


def filled(cases: Iterable[tuple[str, Case]], rows: Iterable[tuple[str, Solve]], **options: object) -> Matrix:
    """A matrix of these cases and rows."""
    matrix = Matrix(**options)
    for name, entry in (*cases, *rows):
        matrix.compare(name, entry)
    return matrix
