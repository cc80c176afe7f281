# SPDX-License-Identifier: GPL-3.0-or-later
"""Animation follows its deformer, handle or control when the lists are reordered.

Blender's paths hold the index of a row: ``sinew.deformers[0].handles[1].weight``. An order ``{old: new}``
renumbers them. If new is None, the row was removed, and its curves and drivers are removed too.
"""

import re
from collections.abc import Callable, Iterator, Mapping

import bpy
from bpy.types import ID, Object

from ... import compat
from ...properties import SinewDeformer

Order = Mapping[int, int | None]

_DEFORMER = re.compile(r"^(sinew\.deformers\[)(\d+)(\].*)$")


def moved(count: int, source: int, target: int) -> dict[int, int]:
    """The order after ``collection.move(source, target)``."""
    rows = list(range(count))
    rows.insert(target, rows.pop(source))
    return {old: new for new, old in enumerate(rows)}


def removed(count: int, index: int) -> Order:
    """The order after ``collection.remove(index)``."""
    return {old: None if old == index else old - (old > index) for old in range(count)}


def deformers_reordered(obj: Object, order: Order) -> None:
    """Renumber every path to the object's deformers."""
    _renumber(obj, lambda path: _new_path(_DEFORMER, path, order))


def rows_reordered(obj: Object, deformer: SinewDeformer, collection: str, order: Order) -> None:
    """Renumber every path to the rows of a collection of a deformer: its handles or its controls."""
    index = next(row for row, other in enumerate(obj.sinew.deformers) if other.uid == deformer.uid)
    rows = re.compile(rf"^(sinew\.deformers\[{index}\]\.{collection}\[)(\d+)(\].*)$")
    _renumber(obj, lambda path: _new_path(rows, path, order))


def _new_path(pattern: re.Pattern, path: str, order: Order) -> str | None:
    """The renumbered path; None if the row that it names was removed."""
    found = pattern.match(path)
    if found is None:
        return path
    number = int(found[2])
    new = order.get(number, number)
    return None if new is None else f"{found[1]}{new}{found[3]}"


def _renumber(obj: Object, new_path: Callable[[str], str | None]) -> None:
    changed = set()
    for action, curve in compat.action_curves(obj):
        path = new_path(curve.data_path)
        if path == curve.data_path or action.library is not None:
            continue
        changed.add(action)
        if path is None:
            compat.remove_action_curve(action, curve)
        else:
            curve.data_path = path
    for action in changed:
        action.update_tag()
    for curve in list(obj.animation_data.drivers) if obj.animation_data else ():
        path = new_path(curve.data_path)
        if path is None:
            obj.animation_data.drivers.remove(curve)
        elif path != curve.data_path:
            curve.data_path = path
    for target in _targets(obj):
        path = new_path(target.data_path)
        if path is not None and path != target.data_path:
            target.data_path = path


def _targets(obj: Object) -> Iterator:
    """All driver targets in the file that read a property of the object."""
    for owner in _animated():
        for curve in owner.animation_data.drivers:
            for variable in curve.driver.variables:
                if variable.type == "SINGLE_PROP":
                    yield from (target for target in variable.targets if target.id == obj)


def _animated() -> Iterator[ID]:
    """Local IDs that have animation data, including hidden shape keys and node trees."""
    for owner in bpy.data.user_map():
        if owner.library is None and getattr(owner, "animation_data", None) is not None:
            yield owner
        tree = getattr(owner, "node_tree", None)
        if tree is not None and owner.library is None and tree.animation_data is not None:
            yield tree
