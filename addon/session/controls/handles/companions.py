# SPDX-License-Identifier: GPL-3.0-or-later
"""The shape that a method builds a graph or a grid around: the target, and all that shares its handles.

So a handle takes hold of what is nearest to it of all, and not of the nearest part of each object.
"""

import numpy as np
from bpy.types import Mesh

from ....backend import Around, Shape
from ....core.methods import Posed
from ....ids import Keys
from ....mesh_io import RestShape, read_rest
from ....properties import SinewDeformer
from ...datablocks import rest_frame


def counts(settings: SinewDeformer) -> bool:
    """Whether the method is built around shapes."""
    return settings.definition.posed is Posed.POSES


def key(settings: SinewDeformer) -> tuple:
    """What a factor depends on, as far as other objects are concerned."""
    if not counts(settings):
        return ()
    return tuple(
        (row.is_target, row.rest.get(Keys.REST_TOKEN, "") if isinstance(row.rest, Mesh) else "", *row.frame)
        for row in settings.companions
    )


def around(settings: SinewDeformer, rest: RestShape) -> Around | None:
    """The rest shapes of the target and of those that share its handles, in their common frame; None if none
    do. All of these objects have the same order of points and the same frame, so their graphs are the same.
    """
    own = next((row for row in settings.companions if row.is_target), None)
    if own is None or not counts(settings):
        return None
    frame = frame_of(own.frame) @ np.linalg.inv(rest_frame.matrix(settings))
    placed = rest.moved(frame, "")
    shapes = [
        placed if row.is_target else read_rest(row.rest).moved(frame_of(row.frame), "")
        for row in settings.companions
        if row.is_target or isinstance(row.rest, Mesh)
    ]
    starts = np.cumsum([0, *(len(shape.points) for shape in shapes[:-1])])
    whole = Shape(
        np.concatenate([shape.points for shape in shapes]),
        (
            np.concatenate([shape.counts for shape in shapes]),
            np.concatenate([shape.corners + start for shape, start in zip(shapes, starts, strict=True)]),
        ),
    )
    return Around(whole, frame, placed.points)


def frame_of(values: object) -> np.ndarray:
    """The matrix (4, 4) that a row stores."""
    return np.array(values, dtype=np.float64).reshape(4, 4, order="F")
