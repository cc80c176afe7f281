# SPDX-License-Identifier: GPL-3.0-or-later
"""What operators and scripts call for cages. Main thread only."""

import bpy
from bpy.types import Object

from ..core.errors import CageError
from ..properties import SinewDeformer
from . import binding, by_cage, rig, state


@state.suspended()
def set_cage(obj: Object, deformer: SinewDeformer, cage: Object) -> None:
    """Let a mesh object move the deformer. It is drawn as wire, and rests where it is now; see ``bind``."""
    if cage == obj:
        raise CageError(f"{obj.name} cannot be its own cage - choose another mesh")
    if cage.type != "MESH":
        raise CageError(f"{cage.name} is no mesh - a cage is a closed mesh around the target")
    if _leads_to(cage, obj):
        raise CageError(f"{cage.name} follows {obj.name} itself - choose a cage that does not depend on it")
    deformer.cage = cage
    if cage.library is None:
        cage.display_type = "WIRE"
        cage.hide_render = True
    rig.keep_evaluated(obj)


def _leads_to(cage: Object, obj: Object) -> bool:
    """A deformer of the cage, or one behind that, has ``obj`` for its own cage."""
    waiting, known = [cage], set()
    while waiting:
        for deformer in waiting.pop().sinew.deformers:
            if deformer.cage == obj:
                return True
            if deformer.cage is not None and deformer.cage not in known:
                known.add(deformer.cage)
                waiting.append(deformer.cage)
    return False


@state.suspended()
def set_rest_cage(obj: Object, deformer: SinewDeformer) -> None:
    """The cage rests as it is now, so the mesh is at rest too; see ``bind``."""
    by_cage.take_rest(obj, deformer)
    binding.abandon(deformer.uid)


def release_cage(deformer: SinewDeformer) -> None:
    """Remove the cage made for a deformer, unless another deformer uses it."""
    cage, deformer.cage = deformer.cage, None
    if cage is None or not deformer.owns_cage or cage.library is not None or cage.sinew.deformers:
        return
    if any(other.cage == cage for obj in bpy.data.objects for other in obj.sinew.deformers):
        return
    mesh = cage.data
    bpy.data.objects.remove(cage)
    if mesh.users == 0:
        bpy.data.meshes.remove(mesh)
