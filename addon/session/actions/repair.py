# SPDX-License-Identifier: GPL-3.0-or-later
"""Repairs the base mesh, as far as that is safe. Main thread only.

Vertex groups, shape keys and UVs stay, because Blender's own mesh operations are used.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import bmesh
import bpy
from bmesh.types import BMesh
from bpy.types import Mesh, Object

from ...core.errors import SinewError
from ..evaluation.mesh_notes import NAMES, counted, elements_by_defect
from ..state import sessions
from . import surveying
from .mesh_repair import CHOSEN, STEPS, diagnosis_of, give_positions

# What can be mended by itself: for each finding, what an artist does about it.
REMEDIES = {
    "not_finite": "Move Lost Vertices",
    "border": "Fill Holes",
    "non_manifold": "Remove Fins and Inner Walls",
    "pinched": "Split Vertices",
    "degenerate": "Collapse Faces without Area",
    "duplicate": "Remove Duplicate Faces",
    "flipped": "Turn Flipped Faces",
    "slit": "Close Slits",
    "coincident": "Merge Border Vertices",
    "loose": "Remove Loose Vertices",
}


@dataclass(frozen=True)
class RepairOptions:
    """Which defects to repair. Vertices of open borders merge within ``distance``, in object space."""

    not_finite: bool = True
    coincident: bool = True
    degenerate: bool = True
    duplicate: bool = True
    non_manifold: bool = True
    loose: bool = True
    distance: float = 0.0


def summary(mended: dict[str, int], left: dict[str, int]) -> str:
    """One line: what was repaired, and what stays because no repair is safe."""
    done = ", ".join(counted(what, count) for what, count in mended.items() if count)
    rest = ", ".join(counted(what, count) for what, count in left.items() if count)
    if not done:
        return f"Nothing to mend; these stay as they are: {rest}" if rest else "Nothing to mend"
    return f"Mended {done}" + (f"; these stay as they are: {rest}" if rest else "")


@sessions.suspended()
def repair(obj: Object, wanted: RepairOptions) -> tuple[dict[str, int], dict[str, int]]:
    """Repair the base mesh in Object or Edit Mode; how many of each defect were repaired, and are left."""
    require_editable(obj, "repair")
    mended = dict.fromkeys(NAMES, 0)
    with _editing(obj) as edit:
        if wanted.not_finite:
            mended["not_finite"] = give_positions(edit)
        found = diagnosis_of(edit)
        for what, cure in STEPS.items():
            within = wanted.distance if what == "coincident" else 0.0
            needed = elements_by_defect(found)[what]
            if not getattr(wanted, what) or (len(needed) == 0 and within == 0.0):
                continue
            before = len(edit.verts)
            cure(edit, needed, within)
            found = diagnosis_of(edit)
            fell = before - len(edit.verts) if within else len(needed) - len(elements_by_defect(found)[what])
            mended[what] = max(fell, 0)
    left = {what: len(elements) for what, elements in elements_by_defect(found).items()}
    obj.update_tag()
    return mended, left


def cure(obj: Object, what: str) -> None:
    """Mend what a survey names so, in Object or Edit Mode, and nothing else."""
    if what in CHOSEN:
        require_editable(obj, "repair")
        elements = surveying.survey(obj, crossings=False).found[what]
        with sessions.suspended(), _editing(obj) as edit:
            diagnosis_of(edit)  # numbers the elements
            CHOSEN[what](edit, elements, 0.0)
        obj.update_tag()
    else:
        wanted = "coincident" if what == "slit" else what
        repair(obj, RepairOptions(**{name: name == wanted for name in ("not_finite", *STEPS)}))


def users_of(mesh: Mesh) -> list[Object]:
    """All objects with this mesh."""
    return [obj for obj in bpy.data.objects if obj.data == mesh]


def require_editable(obj: Object, purpose: str) -> None:
    """Refuse what would change the vertices where that cannot be, or where a bake counts on them."""
    if obj.data.library is not None:
        raise SinewError(f"The mesh is linked - make it local, or override it, before you {purpose} it")
    if obj.data.is_editmode and obj.mode != "EDIT":
        raise SinewError("Another object with this mesh is in Edit Mode - leave it first")
    for user in users_of(obj.data):
        for deformer in user.sinew.deformers:
            if deformer.bake.is_baked:
                raise SinewError(f"{deformer.name} is baked - Unbake it first")


@contextmanager
def _editing(obj: Object) -> Iterator[BMesh]:
    """The base mesh in either mode. It is written back at the end, unless an error is raised."""
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
