# SPDX-License-Identifier: GPL-3.0-or-later
"""Read and write Blender meshes as arrays. Only this room converts float32 to float64."""

from .attributes import (
    Incoming as Incoming,
    read_attributes as read_attributes,
    read_incoming as read_incoming,
)
from .rest import (
    RestShape as RestShape,
    group_names as group_names,
    group_weights as group_weights,
    keep_lost_groups as keep_lost_groups,
    keep_shape as keep_shape,
    known_groups as known_groups,
    read_rest as read_rest,
    read_uv_map as read_uv_map,
    renumbered as renumbered,
    replace_rest as replace_rest,
    same_topology as same_topology,
    weights_attribute as weights_attribute,
)
from .shape import (
    copy_shape as copy_shape,
    read_shape as read_shape,
    resize_shape as resize_shape,
    shape_array as shape_array,
    shape_mesh as shape_mesh,
    write_shape as write_shape,
)
