# SPDX-License-Identifier: GPL-3.0-or-later
"""Read and write Blender meshes as arrays. Only this room converts float32 to float64."""

from .attributes import Incoming, read_attributes, read_incoming
from .rest import (
    RestShape,
    group_names,
    group_weights,
    keep_lost_groups,
    keep_shape,
    known_groups,
    read_rest,
    read_uv_map,
    renumbered,
    replace_rest,
    same_topology,
    weights_attribute,
)
from .shape import copy_shape, read_shape, resize_shape, shape_array, shape_mesh, write_shape
