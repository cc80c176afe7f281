# SPDX-License-Identifier: GPL-3.0-or-later
"""What a new control is made around, one object or several, and what it follows. Main thread only."""

from collections.abc import Sequence

import bpy
import numpy as np
from bpy.types import Object
from mathutils import Matrix

from ....mesh_io import RestShape, read_rest
from ....properties import SinewDeformer
from ...datablocks.shapes import capture
from ...datablocks.transforms import put
from ...targets import targets
from ...targets.kinds import kind_of

# An object and its deformer; None for a new one at the end of its stack.
Target = tuple[Object, SinewDeformer | None]


def shape_of(obj: Object, deformer: SinewDeformer | None) -> RestShape:
    """What enters the deformer, or would enter a new one, in the frame of the object."""
    mesh = capture.mesh_after(obj, kind_of(obj).position(obj, deformer))
    try:
        return read_rest(mesh)
    finally:
        bpy.data.meshes.remove(mesh)


def leader(objects: Sequence[Object]) -> Object | None:
    """What objects follow all together: the one object, or the nearest parent that they have in common."""
    first, *others = ([obj, *_parents(obj)] for obj in objects)
    return next((obj for obj in first if all(obj in chain for chain in others)), None)


def _parents(obj: Object) -> list[Object]:
    found = []
    while obj.parent is not None:
        obj = obj.parent
        found.append(obj)
    return found


def follow(control: Object, obj: Object | None, place: Matrix | None = None) -> None:
    """Make a control follow the object from a ``place`` in the world, as Ctrl P does; or stand there alone.

    Without a place it starts where the object is.

    So it stays in its place when it gets another parent, such as an armature. A child of a curve would
    follow its path, so a constraint makes the control follow a curve.
    """
    if obj is None:
        put(control, place or Matrix())
        return
    follows, place = None, place or obj.matrix_world.copy()
    if targets.is_path(obj):
        follows = control.constraints.new("CHILD_OF")
        follows.target = obj
    else:
        control.parent = obj
    world = obj.matrix_world.copy()
    put(control, place)
    sheared = np.abs(np.array(control.matrix_basis) - np.array(place)).max() > 1e-5 * max(
        place.median_scale, 1.0
    )
    if sheared or world.determinant() == 0.0:
        put(control, world.inverted_safe() @ place)
        return
    if follows is None:
        control.matrix_parent_inverse = world.inverted()
    else:
        follows.inverse_matrix = world.inverted()
