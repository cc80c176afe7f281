# SPDX-License-Identifier: GPL-3.0-or-later
"""Lets the bones of an armature move a mesh: a handle for each. Main thread only."""

import bpy
import numpy as np
from bpy.types import Object

from ....backend import Puppet
from ....core.errors import ConstraintError, SinewError
from ....core.geometry import frames
from ....mesh_io import group_names, group_weights, read_rest
from ....properties import SinewDeformer
from ...datablocks.shapes import capture
from ...state import sessions
from ...targets import targets
from ..deformers import add_deformer, remove_deformer
from ..handles import empties
from ..handles.bones import is_moved_by_control
from ..handles.handles import NewRegion, add_region
from ..rigging import try_bind
from . import bones


@sessions.suspended()
def rig_puppet(
    obj: Object,
    armature: Object,
    method: str,
    margin: float = 0.25,
    automatic: bool = False,
    wait: bool = True,
) -> tuple[SinewDeformer, int, SinewError | None]:
    """A new deformer with a handle for each bone that deforms; and the error if it is not bound.

    A bone holds the vertex group of its name. If the mesh has none of these groups, or if ``automatic``, each
    bone holds the middle of its limb, in a new group: all but ``margin`` of its length at each joint. Bones
    whose groups have no vertices are left out; returns how many.
    """
    bones.require_bones(armature)
    targets.require_mesh(obj, "Bones hold the vertices of a mesh")
    names = [bone.name for bone in armature.data.bones if bone.use_deform]
    named = [] if automatic else [name for name in names if name in obj.vertex_groups]
    deformer = add_deformer(obj, method)
    made: list[str] = []
    try:
        painted = _with_vertices(obj, deformer, named)
        groups = {name: name for name in painted} or _make_groups(obj, armature, deformer, margin, made)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        for name, group in groups.items():
            handle = add_region(obj, deformer, NewRegion("HANDLE", group, owns_group=group in made))
            empties.assign(obj, handle, armature, name, depsgraph=depsgraph)
            handle.from_rest = is_moved_by_control(obj, deformer, handle)
    except SinewError:
        remove_deformer(obj, list(obj.sinew.deformers).index(deformer))
        for group in made:
            if group in obj.vertex_groups:
                obj.vertex_groups.remove(obj.vertex_groups[group])
        raise
    left_out = len(named) - len(painted) if painted else 0
    return deformer, left_out, try_bind(obj, deformer, wait)


def _with_vertices(obj: Object, deformer: SinewDeformer, names: list[str]) -> list[str]:
    """Those of the vertex groups that hold vertices of the mesh as it enters: importers leave empty ones."""
    if not names:
        return []
    mesh = capture.rest_mesh(obj, deformer)
    try:
        found = group_weights(mesh, group_names(mesh), set(names))
    finally:
        bpy.data.meshes.remove(mesh)
    return [name for name in names if (found[name] > 0.0).any()]


def _make_groups(
    obj: Object, armature: Object, deformer: SinewDeformer, margin: float, made: list[str]
) -> dict[str, str]:
    """New vertex groups by the names of bones, which ``made`` gets, too."""
    mesh = capture.rest_mesh(obj, deformer)
    try:
        rest = read_rest(mesh)
    finally:
        bpy.data.meshes.remove(mesh)
    skeleton = bones.read_skeleton(armature, bpy.context.evaluated_depsgraph_get())
    to_mesh = frames.inverse(np.array(obj.matrix_world, dtype=np.float64), obj.name)
    to_armature = frames.inverse(np.array(armature.matrix_world, dtype=np.float64), armature.name)
    shape = rest.moved(to_armature @ np.linalg.inv(to_mesh), rest.token)
    regions = Puppet(skeleton.bones).regions(shape.points, (shape.counts, shape.corners), margin)
    groups = {}
    for name, vertices in zip(skeleton.names, regions, strict=True):
        if len(vertices) and armature.data.bones[name].use_deform:
            group = obj.vertex_groups.new(name=name)
            group.add(vertices.tolist(), 1.0, "REPLACE")
            made.append(group.name)
            groups[name] = group.name
    if not groups:
        raise ConstraintError(
            f"No bone of {armature.name} lies inside of {obj.name} - move the armature into the mesh first"
        )
    return groups
