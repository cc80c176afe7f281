# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays in and out of Blender meshes. The only place where float32 is widened."""

from .attributes import Incoming, read_incoming
from .rest import RestShape, group_weights, read_rest
from .shape import read_shape, shape_mesh, write_shape

__all__ = (
    "Incoming",
    "RestShape",
    "group_weights",
    "read_incoming",
    "read_rest",
    "read_shape",
    "shape_mesh",
    "write_shape",
)
