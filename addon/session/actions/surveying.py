# SPDX-License-Identifier: GPL-3.0-or-later
"""Counts what is unusual about a base mesh, and measures how it bends. Main thread only."""

from dataclasses import dataclass

import numpy as np
from bpy.types import Mesh, Object

from ... import backend
from ...compat import read_faces, read_positions
from ...core.elements import Elements, Owner
from ...core.errors import SinewError
from ...core.memory import remember
from ..evaluation import mesh_notes

NAMES = {  # per finding: the noun for one, and for several
    **mesh_notes.NAMES,
    "border": ("open border", "open borders"),
    "pinched": ("vertex between separate fans", "vertices between separate fans"),
    "flipped": ("flipped face", "flipped faces"),
    "slit": ("edge of a slit", "edges of slits"),
    "crossing": ("crossing face", "crossing faces"),
}
_OF_FACES = ("degenerate", "duplicate", "flipped", "crossing")
_LOW, _NEUTRAL, _HIGH = np.array(((0.03, 0.12, 0.55), (0.6, 0.6, 0.58), (0.6, 0.07, 0.02)))
_SHARE = (
    95  # per cent of the vertices whose colours differ: the sharpest corners would leave grey for all others
)


@dataclass(frozen=True)
class Counts:
    """What a mesh consisted of when it was looked at last."""

    size: tuple[int, int]  # its vertices and faces then
    parts: int
    one_sided: int
    euler_characteristic: int
    found: dict[str, int]  # by the names of the findings; those without any are left out


_last: dict[str, Counts] = remember({})  # by the name of the mesh


def survey(obj: Object, crossings: bool = True) -> backend.Survey:
    """Look at the base mesh as it is now, also in Edit Mode, and remember the counts."""
    mesh = _current(obj)
    found = backend.survey(read_positions(mesh).astype(np.float64), read_faces(mesh), crossings)
    counts = {what: len(elements) for what, elements in found.found.items()} | {"border": found.borders}
    kept = {what: count for what, count in counts.items() if count}
    _last[mesh.name] = Counts(_size(mesh), found.parts, found.one_sided, found.euler_characteristic, kept)
    return found


def last_counts(obj: Object) -> Counts | None:
    """What the last look found; None if there was none, or if the mesh has other vertices or faces now."""
    counts = _last.get(obj.data.name)
    return counts if counts is not None and counts.size == _size(obj.data) else None


def counted(what: str, count: int) -> str:
    """How many elements there are, in words."""
    return f"{count:,} {NAMES[what][count != 1]}"


def elements_of(obj: Object, what: str) -> Elements:
    """The vertices or faces of the base mesh that are unusual in this way now."""
    found = survey(obj, crossings=what == "crossing").found[what]
    return Elements(Owner.TARGET, "face" if what in _OF_FACES else "vertex", np.unique(found))


def measure_curvature(obj: Object, rings: int, shown: str, vectors: bool) -> tuple[float, float, float]:
    """Store the curvatures of the base mesh as named attributes, outside Edit Mode.

    ``shown`` is the name of one of them, which the colours show that become active, or nothing. ``vectors``:
    also store the directions. Returns the least and the largest value of the one that is shown, or else of
    the mean curvature, and where its colours end.
    """
    mesh = obj.data
    if mesh.library is not None:
        raise SinewError("The mesh is linked - make it local, or override it, before you measure it")
    points = read_positions(mesh).astype(np.float64)
    found = backend.curvature(points, read_faces(mesh), rings)
    values = {
        "mean": found.mean,
        "gaussian": found.gaussian,
        "smallest": found.principal[:, 0],
        "largest": found.principal[:, 1],
    }
    for name, numbers in values.items():
        _store(mesh, f"curvature_{name}", "FLOAT", "value", numbers)
    if vectors:
        for name, directions in zip(("smallest", "largest"), found.directions.swapaxes(0, 1), strict=True):
            _store(mesh, f"curvature_{name}_direction", "FLOAT_VECTOR", "vector", directions)
    chosen = values.get(shown, found.mean)
    end = float(np.percentile(abs(chosen), _SHARE)) if len(chosen) else 0.0
    if shown in values:
        _store(mesh, "curvature", "FLOAT_COLOR", "color", _colours(chosen, end))
        mesh.color_attributes.active_color = mesh.color_attributes["curvature"]
    mesh.update_tag()
    ends = (float(chosen.min()), float(chosen.max())) if len(chosen) else (0.0, 0.0)
    return *ends, end


def _colours(values: np.ndarray, end: float) -> np.ndarray:
    """Scene-linear colours (n, 4): blue at ``-end`` and below, grey at 0, red at ``end`` and above."""
    share = np.clip(values / end if end > 0.0 else 0.0 * values, -1.0, 1.0)[:, None]
    mixed = _NEUTRAL + np.where(share < 0.0, -share * (_LOW - _NEUTRAL), share * (_HIGH - _NEUTRAL))
    return np.column_stack([mixed, np.ones(len(values))])


def _store(mesh: Mesh, name: str, sort: str, field: str, values: np.ndarray) -> None:
    """Replace an attribute of the vertices."""
    old = mesh.attributes.get(name)
    if old is not None and (old.data_type, old.domain) != (sort, "POINT"):
        mesh.attributes.remove(old)
        old = None
    if old is None:
        mesh.attributes.new(name, sort, "POINT")
    flat = np.ascontiguousarray(values, dtype=np.float32).ravel()
    mesh.attributes[name].data.foreach_set(field, flat)


def _current(obj: Object) -> Mesh:
    if obj.mode == "EDIT":
        obj.update_from_editmode()
    return obj.data


def _size(mesh: Mesh) -> tuple[int, int]:
    return len(mesh.vertices), len(mesh.polygons)
