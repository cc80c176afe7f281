# SPDX-License-Identifier: GPL-3.0-or-later
"""The names and weights of the vertex groups that a deformer uses, and the UV maps."""

from collections.abc import Iterator
from contextlib import contextmanager

import bpy
import numpy as np
from bpy.types import Mesh, Object

from ... import compat
from ...core.methods import group_property
from ...ids import Datablocks, Keys
from ...mesh_io import RestShape, group_names, group_weights, known_groups, read_uv_map
from ...properties import SinewDeformer, deformers_of
from ..targets.node_group import attach
from ..targets.nodes import Builder
from . import references


def groups_in_use(settings: SinewDeformer) -> set[str]:
    """The names of the vertex groups of regions and painted parameters."""
    wanted = {handle.vertex_group for handle in settings.handles}
    return (wanted | painting_groups(settings)) - {""}


def painting_groups(settings: SinewDeformer) -> set[str]:
    """The names of the vertex groups of painted parameters; an empty name for a parameter without one."""
    return {
        getattr(values, group_property(parameter))
        for method, values in settings.methods
        for parameter in method.paintable
    }


def follow_renamed_groups(obj: Object, deformer: SinewDeformer) -> bool:
    """Take over the new names of vertex groups in use; returns whether there were any.

    Blender changes names in its own modifiers only. A renamed group is found by its index in the list.
    """
    rest = deformer.rest_in("VIEWPORT")
    known = group_names(rest) if rest is not None else []
    used = groups_in_use(deformer) | ({deformer.mask_group} - {""})
    gone = [name for name in used if name not in obj.vertex_groups and name in known]
    if not gone or len(known) != len(obj.vertex_groups) or rest.library is not None:
        return False
    renamed = {name: new for name in gone if (new := obj.vertex_groups[known.index(name)].name) not in known}
    if not renamed:
        return False
    for mesh in {rest, deformer.rest_in("RENDER")}:
        if mesh is not None:
            mesh[Keys.REST_GROUPS] = [group.name for group in obj.vertex_groups]
    deformer.take_group_names(renamed)
    return True


def fixed_vertices(obj: Object, mesh: Mesh) -> np.ndarray:
    """Which vertices of a mesh of an object belong to fixed regions of its deformers, bool (n,)."""
    groups = {
        handle.vertex_group
        for deformer in deformers_of(obj)
        for handle in deformer.handles
        if handle.kind == "FIXED" and handle.enabled
    }
    fixed = np.zeros(len(mesh.vertices), dtype=bool)
    for weights in group_weights(mesh, [group.name for group in obj.vertex_groups], groups).values():
        fixed |= weights > 0.0
    return fixed


def read_weights(rest: RestShape, mesh: Mesh, settings: SinewDeformer) -> None:
    """Read the vertex groups and UV maps in use that have not been read yet."""
    wanted = groups_in_use(settings) - rest.weights.keys()
    if wanted:
        rest.weights.update(group_weights(mesh, known_groups(mesh), wanted))
    for name in references.uv_maps(settings).keys() - rest.uv_maps.keys():
        places = read_uv_map(mesh, name)
        if places is not None:
            rest.uv_maps[name] = places


@contextmanager
def keeping_weights(obj: Object, groups: dict[str, str]) -> Iterator[None]:
    """For a while, a last modifier of the object stores vertex groups as attributes.

    ``groups`` has the name of a vertex group per attribute. Reading attributes is a hundred times faster than
    reading the groups of each vertex.
    """
    if not groups:
        yield
        return
    group = bpy.data.node_groups.new(Datablocks.NODE_GROUP, "GeometryNodeTree")
    try:
        compat.add_group_input(group, "NodeSocketGeometry", "Geometry")
        compat.add_group_output(group, "NodeSocketGeometry", "Geometry")
        build = Builder(group)
        kept = build.add("NodeGroupInput").outputs["Geometry"]
        for attribute, name in groups.items():
            weights = build.add("GeometryNodeInputNamedAttribute", {"data_type": "FLOAT"}, Name=name)
            kept = build.store(kept, "FLOAT", attribute, build.out(weights, "Attribute"))
        build.feed(build.add("NodeGroupOutput").inputs["Geometry"], kept)
        attach(obj.modifiers.new(Datablocks.MODIFIER, "NODES"), group)
        yield
    finally:
        bpy.data.node_groups.remove(group)
