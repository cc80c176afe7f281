# SPDX-License-Identifier: GPL-3.0-or-later
"""The matrix of methods and cases, with one function that adds a row or a column.

How much a shape is distorted is measured by NumPy alone, so that no method is judged by its own library.
"""

import json
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from .cases import Case
from .rows import Solve


@dataclass(frozen=True)
class Distortion:
    """What is measured of one shape. Edges and faces of which every corner is held are left out: no method
    decides about them. Edge ratios and area ratios are those of lengths and areas to the ones at rest. Angles
    are changes of the corners of faces, in degrees. The volume is None for a mesh with a border."""

    edge_rms: float  # root of the mean square of the edge ratio less 1
    edge_least: float
    edge_largest: float
    angle_mean: float
    angle_max: float
    area: float  # of the whole surface
    face_area_mean: float  # of the faces, each with the weight of its area at rest, of |ratio - 1|
    face_area_max: float  # the largest ratio of one face
    volume: float | None
    handle_error: float  # how far a handle is from its target, as a share of the size of the mesh

    def as_dict(self) -> dict[str, float | None]:
        return asdict(self)


def distortion(case: Case, shape: np.ndarray) -> Distortion:
    """The distortion of a shape (n, 3) of a case."""
    rest, faces, free = case.points, case.triangles, case.free
    edges = edges_of(faces)
    edges = edges[free[edges].any(1)]
    ratio = lengths(shape, edges) / lengths(rest, edges)
    moving = faces[free[faces].any(1)]
    turned = np.degrees(np.abs(angles(shape, moving) - angles(rest, moving)))
    before, after = areas(rest, moving), areas(shape, moving)
    stretched = after / before
    whole = areas(shape, faces).sum() / areas(rest, faces).sum()
    gap = np.linalg.norm((shape - case.targets)[case.held], axis=1).max() / np.ptp(rest, axis=0).max()
    rms, mean = np.sqrt(np.mean((ratio - 1.0) ** 2)), np.average(np.abs(stretched - 1.0), weights=before)
    edges_found, angles_found = (rms, ratio.min(), ratio.max()), (turned.mean(), turned.max())
    areas_found = whole, mean, stretched.max()
    enclosed = volume(shape, faces) / volume(rest, faces) if case.closed else None
    return Distortion(*map(float, (*edges_found, *angles_found, *areas_found)), enclosed, float(gap))


def edges_of(faces: np.ndarray) -> np.ndarray:
    """Each edge of triangles (t, 3) once, (e, 2)."""
    pairs = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    return np.unique(np.sort(pairs, axis=1), axis=0)


def lengths(points: np.ndarray, edges: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)


def areas(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    a, b, c = (points[faces[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def angles(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The corners of triangles (t, 3) in radians; 0 where two corners coincide."""
    found = []
    for k in range(3):
        here = points[faces[:, k]]
        u, v = points[faces[:, (k + 1) % 3]] - here, points[faces[:, (k + 2) % 3]] - here
        found.append(np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), (u * v).sum(1)))
    return np.stack(found, 1)


def volume(points: np.ndarray, faces: np.ndarray) -> float:
    a, b, c = (points[faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


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
    matrix = Matrix(**options)
    for name, entry in (*cases, *rows):
        matrix.compare(name, entry)
    return matrix
