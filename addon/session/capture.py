# SPDX-License-Identifier: GPL-3.0-or-later
"""Get what enters our modifier as a mesh of its own, without touching what the user set.

A short-lived copy of the object loses our modifier and the later ones and is evaluated where the user
works. The copy has its own mesh while the original is in Edit Mode, whose unsaved edits are written first.
"""

from collections.abc import Iterator
from contextlib import contextmanager

import bpy
from bpy.types import Mesh, Object

from ..core.errors import MeshError
from ..ids import Datablocks, Keys
from ..properties import SinewDeformer
from . import rig, state


@contextmanager
def _stand_in(obj: Object, last_modifier: int) -> Iterator[Object]:
    """A copy of the object with its first ``last_modifier`` modifiers, evaluated; gone afterwards."""
    with state.suspended():
        copy = obj.copy()
        own_mesh = None
        try:
            copy.sinew.deformers.clear()
            if obj.mode == "EDIT":
                obj.update_from_editmode()
                own_mesh = copy.data = obj.data.copy()
            for modifier in list(copy.modifiers)[last_modifier:]:
                copy.modifiers.remove(modifier)
            copy.hide_viewport = False
            bpy.context.scene.collection.objects.link(copy)
            bpy.context.view_layer.update()
            yield copy.evaluated_get(bpy.context.evaluated_depsgraph_get())
        finally:
            bpy.data.objects.remove(copy)
            if own_mesh is not None:
                bpy.data.meshes.remove(own_mesh)
            bpy.context.view_layer.update()


def evaluated_mesh(obj: Object, last_modifier: int) -> Mesh:
    """A new mesh: the object after its first ``last_modifier`` modifiers."""
    with _stand_in(obj, last_modifier) as evaluated:
        return bpy.data.meshes.new_from_object(
            evaluated, preserve_all_data_layers=True, depsgraph=bpy.context.evaluated_depsgraph_get()
        )


def rest_mesh(obj: Object, deformer: SinewDeformer) -> Mesh:
    """A new mesh: what enters the deformer's modifier now, or would enter one at the end of the stack."""
    modifier = rig.find_modifier(obj, deformer)
    position = len(obj.modifiers) if modifier is None else list(obj.modifiers).index(modifier)
    mesh = evaluated_mesh(obj, position)
    if len(mesh.vertices) == 0:
        bpy.data.meshes.remove(mesh)
        raise MeshError("The mesh has no vertices - add some, or check the modifiers before Sinew")
    mesh.name = Datablocks.REST
    mesh.materials.clear()
    mesh[Keys.REST_TOKEN] = rig.new_key()
    mesh[Keys.REST_GROUPS] = [group.name for group in obj.vertex_groups]
    return mesh
