# SPDX-License-Identifier: GPL-3.0-or-later
"""What is cheap to know of a selected object, so that a panel can ask for it in each redraw.

Parts and borders are counted once per mesh, in a pause; until then it is a plain mesh.
"""

from collections.abc import Iterable

import numpy as np
from bpy.types import Mesh, Object

from ...backend import availability, connected_parts
from ...compat import read_faces
from ...core.errors import SinewError
from ...core.memory import remember
from ...core.traits import Trait
from ..targets import targets
from ..targets.kinds import kind_of
from . import movers

_CACHES = ("MESH_CACHE", "MESH_SEQUENCE_CACHE")
_LOOSE = 8  # parts, up to which a mesh is one thing
_OPEN = 3.0  # of a sheet: the square of its border edges, by all its edges; of a square grid it is 8
_HEAVY = 2_000_000  # vertices from which nobody wants to wait for a count

_counted: dict[tuple, frozenset[Trait]] = remember({})


def traits_of(obj: Object, selected: Iterable[Object]) -> frozenset[Trait]:
    """What can be said of an object and of what is selected with it."""
    if not targets.is_mesh(obj):
        return frozenset({Trait.POINTS})
    found = {Trait.SURFACE}
    modifiers = kind_of(obj).modifiers_before(obj, None)
    if movers.is_moved_before(obj, None):
        found.add(Trait.MOVED)
    if any(modifier.type in _CACHES and modifier.show_viewport for modifier in modifiers):
        found.add(Trait.CACHED)
    armatures = [modifier.object for modifier in modifiers if modifier.type == "ARMATURE"]
    others = [other for other in selected if other != obj]
    if obj.parent is not None and obj.parent_type == "ARMATURE":
        found.add(Trait.BONES)
    if any(armatures) or any(map(targets.has_bones, others)):
        found.add(Trait.BONES)
    if sum(_are_twins(obj, other) for other in others) == 1:
        found.add(Trait.TWIN)
    counted = _counted.get(_key(obj.data), frozenset())
    return frozenset(found | (counted - {Trait.LOOSE} if Trait.BONES in found else counted))


def is_uncounted(obj: Object | None) -> bool:
    """Whether the parts and borders of an object are still to be counted."""
    if obj is None or obj.mode == "EDIT" or not targets.is_mesh(obj) or availability().module is None:
        return False
    return len(obj.data.vertices) < _HEAVY and _key(obj.data) not in _counted


def count(mesh: Mesh) -> None:
    """Count the parts and the borders of a mesh."""
    found: set[Trait] = set()
    edges = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("edge_index", edges)
    border = np.count_nonzero(np.bincount(edges) == 1)
    if border**2 > _OPEN * max(len(mesh.edges), 1):
        found.add(Trait.SHEET)
    try:
        if len(np.unique(connected_parts(len(mesh.vertices), read_faces(mesh)))) > _LOOSE:
            found.add(Trait.LOOSE)
    except SinewError:
        pass  # an odd mesh is a plain one
    _counted[_key(mesh)] = frozenset(found)


def _are_twins(obj: Object, other: Object) -> bool:
    """Whether two meshes may have the same faces; the task itself looks at them."""
    if not targets.is_mesh(other) or other.data == obj.data:
        return False
    ours, theirs = obj.data, other.data
    return (len(ours.vertices), len(ours.loops)) == (len(theirs.vertices), len(theirs.loops))


def _key(mesh: Mesh) -> tuple:
    return mesh.name_full, len(mesh.vertices), len(mesh.loops)
