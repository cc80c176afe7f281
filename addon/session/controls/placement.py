# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads where controls are."""

from collections.abc import Callable

import numpy as np
from bpy.types import Depsgraph, Object
from mathutils import Matrix

from ...compat import read_positions
from ...core.memory import remember
from ..datablocks.libraries import is_lost
from ..datablocks.shapes import render_settings
from ..datablocks.shapes.capture import viewport_points
from ..datablocks.shapes.carried import AttachedPoints
from ..state.evaluation import NO_VERTICES, Place
from ..targets import targets
from ..targets.modified import evaluated_mesh

ReadPoints = Callable[[Object, Depsgraph], np.ndarray]

# By object: its settings when it was looked at, and the points that viewports show, on what renders show.
_in_renders: dict[str, tuple[tuple, AttachedPoints | None]] = remember({})


def read_place(
    control: Object | None,
    depsgraph: Depsgraph,
    bone: str = "",
    read_points: ReadPoints | None = None,
    expected: int | None = None,
) -> Place | None:
    """Where an object, or its bone, is; None if it is not there, as an object of a missing library.

    ``read_points`` reads its points (c, 3) float32, where these count too. If a number is ``expected`` and
    renders show another one, they are those that viewports show, on the surface that renders show.
    """
    if control is None:
        return None
    data = control.data
    if (control.library is not None or (data is not None and data.library is not None)) and is_lost(control):
        return None
    evaluated = control.evaluated_get(depsgraph)
    world = evaluated.matrix_world.copy().freeze()
    if read_points is not None:
        vertices = read_points(control, depsgraph)
        if depsgraph.mode == "RENDER" and expected not in (None, len(vertices)):
            _settings, attached = _in_renders.get(control.name_full, ((), None))
            if attached is not None and attached.count == len(vertices):
                vertices = attached.at(vertices).astype(np.float32)
        return Place((fingerprint(world), hash(vertices.tobytes())), (world,), vertices)
    if not bone:
        return Place((fingerprint(world),), (world,))
    posed = evaluated.pose.bones.get(bone) if evaluated.pose else None
    if posed is None:
        return None
    in_object = posed.matrix.copy().freeze()
    return Place((fingerprint(world), fingerprint(in_object)), (world, in_object))


def read_vertices(control: Object, depsgraph: Depsgraph) -> np.ndarray:
    """The vertices of an object after its modifiers, float32 (c, 3) in its own frame."""
    with evaluated_mesh(control, depsgraph) as mesh:
        return NO_VERTICES if mesh is None else read_positions(mesh)


def look_at_renders(control: Object) -> None:
    """Find the points that viewports show of a control on what renders show, if its settings have changed.

    A control is not seen in renders, where it is to move the target as it does in viewports. This makes
    datablocks.
    """
    settings = targets.size(control), *render_settings.both(control, control.modifiers)
    last, _attached = _in_renders.get(control.name_full, (None, None))
    if settings != last:
        _in_renders[control.name_full] = settings, viewport_points(control)


def fingerprint(matrix: Matrix) -> int:
    """A number that changes with the matrix, to 64 bits.

    Blender's own is the same for a coordinate of -1 and of -2, and before and after some moves.
    """
    numbers = np.array(matrix.copy()) + 0.0  # by which -0 becomes 0; what is frozen cannot be read
    return hash(numbers.tobytes())
