# SPDX-License-Identifier: GPL-3.0-or-later
"""Shared by the kinds of control that are whole objects, such as a cage.

A row is a ``SinewControl`` or a ``StoredCage``: an object, the mesh it had at bind, and whether it was made
for the deformer.
"""

from collections.abc import Iterable, Iterator

import bpy
from bpy.types import Mesh, Object

from ...properties import SinewControl, StoredCage, deformers_of
from ..blocks import shapes
from ..blocks.keeper import Link

Row = SinewControl | StoredCage


def links(rows: Iterable[Row]) -> Iterator[Link]:
    """The objects of these rows, whose vertices count too."""
    for row in rows:
        if row.object is not None:
            yield Link(row.object, by_shape=True)


def hold_rest(row: Row, mesh: Mesh) -> None:
    """Store the rest mesh of an object; ``mesh`` is used up."""
    row.rest = shapes.put_mesh(row.rest, mesh)


def forget_rest(rows: Iterable[Row]) -> None:
    """Forget the rest meshes of the objects."""
    for row in rows:
        mesh, row.rest = row.rest, None
        shapes.free_meshes(mesh)


def release(rows: Iterable[Row]) -> None:
    """Remove the objects that were made for a deformer, unless another deformer uses them."""
    for row in rows:
        forget_rest((row,))
        obj, row.object = row.object, None
        if obj is None or not row.owned or obj.library is not None or deformers_of(obj) or _is_used(obj):
            continue
        data = obj.data
        bpy.data.objects.remove(obj)
        if data.users == 0:
            bpy.data.batch_remove((data,))


def _is_used(control: Object) -> bool:
    return any(
        row.object == control
        for obj in bpy.data.objects
        for deformer in deformers_of(obj)
        for row in deformer.all_controls
    )
