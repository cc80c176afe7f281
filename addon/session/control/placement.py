# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads where controls are."""

import numpy as np
from bpy.types import Depsgraph, Object
from mathutils import Matrix

from ...compat import read_positions
from ..blocks.capture import evaluated_mesh
from ..blocks.libraries import is_lost
from ..memory.evaluation import NO_VERTICES, Place


def read_place(
    control: Object | None, depsgraph: Depsgraph, bone: str = "", by_shape: bool = False
) -> Place | None:
    """Where an object, or its bone, is; None if it is not there. ``by_shape``: its vertices count too.

    An object of a missing library is not there, and where vertices count, no object without them is.
    """
    if control is None or (by_shape and control.type != "MESH"):
        return None
    data = control.data
    if (control.library is not None or (data is not None and data.library is not None)) and is_lost(control):
        return None
    evaluated = control.evaluated_get(depsgraph)
    world = evaluated.matrix_world.copy().freeze()
    if by_shape:
        vertices = read_vertices(control, depsgraph)
        return Place((hash(world), hash(vertices.tobytes())), (world,), vertices)
    if not bone:
        return Place((hash(world),), (world,))
    posed = evaluated.pose.bones.get(bone) if evaluated.pose else None
    if posed is None:
        return None
    in_object = posed.matrix.copy().freeze()
    return Place((hash(world), hash(in_object)), (world, in_object))


def read_vertices(control: Object, depsgraph: Depsgraph) -> np.ndarray:
    """The vertices of an object after its modifiers, float32 (c, 3) in its own frame."""
    with evaluated_mesh(control, depsgraph) as mesh:
        return NO_VERTICES if mesh is None else read_positions(mesh)


def fingerprint(matrix: Matrix) -> int:
    """A number that changes with the matrix, to 64 bits."""
    return hash(matrix.copy().freeze())
