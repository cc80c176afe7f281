# SPDX-License-Identifier: GPL-3.0-or-later
"""Mend the base mesh, as far as it is safe, and say what is unusual about a mesh. Main thread only.

Vertex groups, shape keys and UVs stay: all is done by Blender's own mesh operations.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import bmesh
import numpy as np
from bmesh.types import BMesh
from bpy.types import Mesh, Object

from ..backend import Diagnosis
from ..core.errors import SinewError
from ..core.status import Level, Remedy, Status
from . import mending, state

_NAMES = {  # what is counted: one of it, several
    "not_finite": ("vertex without a finite position", "vertices without a finite position"),
    "coincident": ("coincident vertex", "coincident vertices"),
    "degenerate": ("face without area", "faces without area"),
    "duplicate": ("duplicate face", "duplicate faces"),
    "non_manifold": ("edge of three or more faces", "edges of three or more faces"),
    "loose": ("loose vertex", "loose vertices"),
}


@dataclass(frozen=True)
class Cures:
    """What to mend. Vertices of open borders merge within ``distance``, in object space."""

    not_finite: bool = True
    coincident: bool = True
    degenerate: bool = True
    duplicate: bool = True
    non_manifold: bool = True
    loose: bool = True
    distance: float = 0.0


def notes(diagnosis: Diagnosis, selectable: bool = True) -> tuple[Status, ...]:
    """Lines for the panel. ``selectable``: elements are those of the base mesh, so Select can show them."""
    lines = []
    for what, elements in _elements(diagnosis).items():
        if len(elements):
            kind = "face" if what in ("degenerate", "duplicate") else "vertex"
            shown = tuple(int(element) for element in np.unique(elements)) if selectable else ()
            text = _counted(what, len(elements))
            lines.append(Status(Level.WARNING, text, shown, kind if shown else "", Remedy.REPAIR))
    return tuple(lines)


def _elements(diagnosis: Diagnosis) -> dict[str, np.ndarray]:
    """Index arrays; edges as the (k, 2) vertices at their ends."""
    return {
        "not_finite": diagnosis.not_finite,
        "coincident": diagnosis.coincident_vertices,
        "degenerate": diagnosis.degenerate_faces,
        "duplicate": diagnosis.duplicate_faces,
        "non_manifold": diagnosis.non_manifold_edges,
        "loose": diagnosis.loose_vertices,
    }


def _counted(what: str, count: int) -> str:
    return f"{count:,} {_NAMES[what][count != 1]}"


def summary(mended: dict[str, int], left: dict[str, int]) -> str:
    """One line: what was mended, and what stays because no cure is safe."""
    done = ", ".join(_counted(what, count) for what, count in mended.items() if count)
    rest = ", ".join(_counted(what, count) for what, count in left.items() if count)
    if not done:
        return f"Nothing to mend; these stay as they are: {rest}" if rest else "Nothing to mend"
    return f"Mended {done}" + (f"; these stay as they are: {rest}" if rest else "")


@state.suspended()
def repair(obj: Object, cures: Cures) -> tuple[dict[str, int], dict[str, int]]:
    """Mend the base mesh in Object or Edit Mode; how many of each were mended, and how many are left."""
    if obj.data.library is not None:
        raise SinewError("The mesh is linked - make it local, or override it, before you repair it")
    mended = dict.fromkeys(_NAMES, 0)
    with _editing(obj) as edit:
        if cures.not_finite:
            mended["not_finite"] = mending.give_positions(edit)
        found = mending.diagnosis_of(edit)
        for what, cure in mending.STEPS.items():
            within = cures.distance if what == "coincident" else 0.0
            needed = _elements(found)[what]
            if not getattr(cures, what) or (len(needed) == 0 and within == 0.0):
                continue
            before = len(edit.verts)
            cure(edit, needed, within)
            found = mending.diagnosis_of(edit)
            fell = before - len(edit.verts) if within else len(needed) - len(_elements(found)[what])
            mended[what] = max(fell, 0)
    left = {what: len(elements) for what, elements in _elements(found).items()}
    obj.update_tag()
    return mended, left


@contextmanager
def _editing(obj: Object) -> Iterator[BMesh]:
    """The base mesh, in either mode; written back unless something is raised."""
    mesh: Mesh = obj.data
    if obj.mode == "EDIT":
        edit = bmesh.from_edit_mesh(mesh)
        yield edit
        edit.normal_update()
        bmesh.update_edit_mesh(mesh)
        return
    edit = bmesh.new()
    try:
        edit.from_mesh(mesh)
        yield edit
        edit.normal_update()
        edit.to_mesh(mesh)
    finally:
        edit.free()
    mesh.update()
