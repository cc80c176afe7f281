# SPDX-License-Identifier: GPL-3.0-or-later
"""Renames a vertex group together with everything that names it. Main thread only.

Blender stores these names as plain text, and follows a renamed group nowhere.
"""

from collections.abc import Iterator

import bpy
from bpy.types import Constraint, Mesh, Object

from ... import compat
from ...core.methods import METHODS, group_property
from ...ids import Keys
from ...mesh_io import group_names
from ...properties import SinewDeformer, deformers_of
from ..state import sessions


def rename(obj: Object, old: str, new: str) -> None:
    """Rename a vertex group of a mesh object to ``new``, a name that no other group of the mesh has.

    What names the group goes on using it: modifiers, shape keys, particles, constraints, and Sinew's own
    regions, masks and painted parameters, on every object that has this mesh.
    """
    obj.vertex_groups[old].name = new
    users = [other for other in bpy.data.objects if other.data == obj.data]
    for owner in (owner for user in users for owner in _owners(user)):
        for text in owner.bl_rna.properties:
            if text.type == "STRING" and "vertex_group" in text.identifier:
                _replace(owner, text.identifier, old, new)
    for constraint in _constraints():
        if getattr(constraint, "target", None) in users:
            _replace(constraint, "subtarget", old, new)
    for user in users:
        for modifier in user.modifiers:
            if modifier.type == "NODES":
                compat.rename_attribute_inputs(modifier, old, new)
        for deformer in deformers_of(user):
            _rename_in_deformer(deformer, old, new)


def _replace(owner: object, name: str, old: str, new: str) -> None:
    """Set a text if it is ``old``. Each assignment makes Blender evaluate again, so others are left alone."""
    if getattr(owner, name, None) == old:
        setattr(owner, name, new)


def _owners(obj: Object) -> Iterator[bpy.types.bpy_struct]:
    """What names vertex groups in properties of its own."""
    for modifier in obj.modifiers:
        yield modifier
        for name in ("settings", "collision_settings", "flow_settings"):  # of cloth, soft bodies, fluids
            part = getattr(modifier, name, None)
            if part is not None:
                yield part
    yield from obj.particle_systems
    keys = getattr(obj.data, "shape_keys", None)
    yield from () if keys is None else keys.key_blocks


def _constraints() -> Iterator[Constraint]:
    for obj in bpy.data.objects:
        yield from obj.constraints
        for bone in () if obj.pose is None else obj.pose.bones:
            yield from bone.constraints


def _rename_in_deformer(deformer: SinewDeformer, old: str, new: str) -> None:
    for handle in deformer.handles:
        _replace(handle, "vertex_group", old, new)
    for method in METHODS:
        for parameter in method.paintable:
            _replace(getattr(deformer, method.id), group_property(parameter), old, new)
    _replace(deformer, "mask_group", old, new)
    for name in ("rest", "rest_render"):
        mesh = getattr(deformer, name)
        if isinstance(mesh, Mesh) and mesh.library is None and old in group_names(mesh):
            own = mesh.copy() if mesh.users > 1 else mesh  # copies of the object share it until they bind
            own[Keys.REST_GROUPS] = [new if group == old else group for group in group_names(mesh)]
            setattr(deformer, name, own)
    session = sessions.find(deformer.uid)
    if session is not None:
        session.rest = None  # it knows its weights by the old name
