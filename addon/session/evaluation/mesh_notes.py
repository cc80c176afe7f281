# SPDX-License-Identifier: GPL-3.0-or-later
"""The lines in the panel about defects of a mesh."""

import numpy as np

from ...backend import Diagnosis
from ...core.elements import NO_ELEMENTS, Elements, Owner
from ...core.status import Level, Remedy, Status

NAMES = {  # per defect: the noun for one, and for several
    "not_finite": ("vertex without a finite position", "vertices without a finite position"),
    "coincident": ("coincident vertex", "coincident vertices"),
    "degenerate": ("face without area", "faces without area"),
    "duplicate": ("duplicate face", "duplicate faces"),
    "non_manifold": ("edge of three or more faces", "edges of three or more faces"),
    "loose": ("loose vertex", "loose vertices"),
}


def notes(diagnosis: Diagnosis, selectable: bool = True) -> tuple[Status, ...]:
    """Lines for the panel. ``selectable``: they name elements of the base mesh, which Select can show."""
    lines = []
    for what, elements in elements_by_defect(diagnosis).items():
        if len(elements):
            element = "face" if what in ("degenerate", "duplicate") else "vertex"
            shown = Elements(Owner.TARGET, element, np.unique(elements)) if selectable else NO_ELEMENTS
            lines.append(Status(Level.WARNING, counted(what, len(elements)), shown, Remedy.REPAIR))
    return tuple(lines)


def of_folded_rings(vertices: np.ndarray, selectable: bool) -> tuple[Status, ...]:
    """A line about vertices whose ring overlaps when it is projected, if there are any."""
    if not len(vertices):
        return ()
    text = "1 vertex lies" if len(vertices) == 1 else f"{len(vertices):,} vertices lie"
    shown = Elements(Owner.TARGET, "vertex", vertices) if selectable else NO_ELEMENTS
    return (Status(Level.INFO, f"{text} in a folded ring: weighted as a plain mean", shown),)


def elements_by_defect(diagnosis: Diagnosis) -> dict[str, np.ndarray]:
    """Index arrays per defect. Edges are given by the vertices at their ends, (k, 2)."""
    return {
        "not_finite": diagnosis.not_finite,
        "coincident": diagnosis.coincident_vertices,
        "degenerate": diagnosis.degenerate_faces,
        "duplicate": diagnosis.duplicate_faces,
        "non_manifold": diagnosis.non_manifold_edges,
        "loose": diagnosis.loose_vertices,
    }


def counted(what: str, count: int) -> str:
    """How many elements have a defect, in words."""
    return f"{count:,} {NAMES[what][count != 1]}"
