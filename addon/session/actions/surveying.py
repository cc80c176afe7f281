# SPDX-License-Identifier: GPL-3.0-or-later
"""Counts what is unusual about a base mesh, and measures how it bends. Main thread only."""

from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
from bpy.types import Mesh, Object

from ... import backend
from ...compat import read_faces, read_positions, session_key
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
# Per cent of the vertices whose colours differ: the sharpest corners would leave grey for all others.
_SHARE = 95


@dataclass(frozen=True)
class Counts:
    """What a mesh consisted of when it was looked at last."""

    size: tuple[int, int]  # its vertices and faces then
    parts: int
    one_sided: int
    euler_characteristic: int
    found: dict[str, int]  # by the names of the findings; those without any are left out


_last: dict[Hashable, Counts] = remember({})  # by the mesh


def survey(obj: Object, crossings: bool = True) -> backend.Survey:
    """Look at the base mesh as it is now, also in Edit Mode, and remember the counts.

    Without ``crossings``, their count stays as it was.
    """
    mesh = _current(obj)
    found = backend.survey(read_positions(mesh).astype(np.float64), read_faces(mesh), crossings)
    counts = {what: len(elements) for what, elements in found.found.items()} | {"border": found.borders}
    former = last_counts(obj)
    if former is not None and not crossings:
        counts["crossing"] = former.found.get("crossing", 0)
    kept = {what: count for what, count in counts.items() if count}
    _last[session_key(mesh)] = Counts(
        _size(mesh), found.parts, found.one_sided, found.euler_characteristic, kept
    )
    return found


def last_counts(obj: Object) -> Counts | None:
    """What the last look found; None if there was none, or if the mesh has other vertices or faces now."""
    counts = _last.get(session_key(obj.data))
    return counts if counts is not None and counts.size == _size(obj.data) else None


def forget_counts() -> None:
    """Forget what every look found, because undo or redo may have changed the meshes."""
    _last.clear()


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
    stored = [(f"curvature_{name}", "FLOAT", "value", numbers) for name, numbers in values.items()]
    if vectors:
        for name, directions in zip(("smallest", "largest"), found.directions.swapaxes(0, 1), strict=True):
            stored.append((f"curvature_{name}_direction", "FLOAT_VECTOR", "vector", directions))
    chosen = values.get(shown, found.mean)
    end = float(np.percentile(abs(chosen), _SHARE)) if len(chosen) else 0.0
    if shown in values:
        stored.append(("curvature", "FLOAT_COLOR", "color", _colours(chosen, end)))
    for name, sort, *_rest in stored:
        _refuse_others(obj, name, sort)
    for each in stored:
        _store(mesh, *each)
    if shown in values:
        mesh.color_attributes.active_color = mesh.color_attributes["curvature"]
    mesh.update_tag()
    ends = (float(chosen.min()), float(chosen.max())) if len(chosen) else (0.0, 0.0)
    return *ends, end


def _colours(values: np.ndarray, end: float) -> np.ndarray:
    """Scene-linear colours (n, 4): blue at ``-end`` and below, grey at 0, red at ``end`` and above."""
    share = np.clip(values / end if end > 0.0 else 0.0 * values, -1.0, 1.0)[:, None]
    mixed = _NEUTRAL + np.where(share < 0.0, -share * (_LOW - _NEUTRAL), share * (_HIGH - _NEUTRAL))
    return np.column_stack([mixed, np.ones(len(values))])


def _refuse_others(obj: Object, name: str, sort: str) -> None:
    """Refuse a name under which the mesh holds anything but such an attribute of the vertices."""
    old = obj.data.attributes.get(name)
    if name in obj.vertex_groups:
        taken = "a vertex group"
    elif name in obj.data.uv_layers:
        taken = "a UV map"
    elif old is not None and (old.data_type, old.domain) != (sort, "POINT"):
        taken = "another attribute"
    else:
        return
    raise SinewError(f"{obj.name} has {taken} called {name} - rename it before you measure")


def _store(mesh: Mesh, name: str, sort: str, field: str, values: np.ndarray) -> None:
    """Give the vertices an attribute, or new values to the one that they have."""
    attribute = mesh.attributes.get(name) or mesh.attributes.new(name, sort, "POINT")
    attribute.data.foreach_set(field, np.ascontiguousarray(values, dtype=np.float32).ravel())


def _current(obj: Object) -> Mesh:
    if obj.mode == "EDIT":
        obj.update_from_editmode()
    return obj.data


def _size(mesh: Mesh) -> tuple[int, int]:
    return len(mesh.vertices), len(mesh.polygons)
