# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether something before a deformer may move the mesh from frame to frame."""

from collections.abc import Iterable

from bpy.types import ID, Modifier, Object

from ...properties import SinewDeformer
from ..targets import refined_group, targets
from ..targets.kinds import kind_of
from .modifier_objects import objects_of

DEFORMING = {  # modifiers of Blender that neither add nor remove vertices
    "ARMATURE",
    "CAST",
    "CORRECTIVE_SMOOTH",
    "CURVE",
    "DISPLACE",
    "HOOK",
    "LAPLACIANDEFORM",
    "LAPLACIANSMOOTH",
    "LATTICE",
    "MESH_CACHE",
    "MESH_DEFORM",
    "SHRINKWRAP",
    "SIMPLE_DEFORM",
    "SMOOTH",
    "SURFACE_DEFORM",
    "WARP",
    "WAVE",
}
_CHANGING = {"CLOTH", "MESH_SEQUENCE_CACHE", "NODES", "SOFT_BODY"}  # the same, or they may be such
_PLAYED = {"CLOTH", "MESH_CACHE", "MESH_SEQUENCE_CACHE", "SOFT_BODY", "WAVE"}  # another shape in each frame


def is_moved_before(obj: Object, deformer: SinewDeformer | None) -> bool:
    """Whether a modifier, a shape key or a parent that deforms may move a mesh before a deformer, or before a
    new one.
    """
    if not targets.is_mesh(obj):
        return False
    shape_keys = obj.data.shape_keys
    if shape_keys is not None and len(shape_keys.key_blocks) > 1:
        return True
    if obj.parent is not None and obj.parent_type in ("ARMATURE", "LATTICE"):
        return True
    before = kind_of(obj).modifiers_before(obj, deformer)
    return any(
        modifier.type in DEFORMING | _CHANGING and (modifier.show_viewport or modifier.show_render)
        for modifier in before
    )


def armatures_of(obj: Object) -> list[Object]:
    """The armatures that move an object, by modifiers or as its parent."""
    found = [modifier.object for modifier in obj.modifiers if modifier.type == "ARMATURE"]
    if obj.parent_type == "ARMATURE":
        found.append(obj.parent)
    return [armature for armature in dict.fromkeys(found) if armature is not None]


def is_animated_before(obj: Object, deformer: SinewDeformer | None) -> bool:
    """Whether what moves a mesh before a deformer, or before a new one, is keyed, driven or cached."""
    before = kind_of(obj).modifiers_before(obj, deformer)
    if any(modifier.type in _PLAYED for modifier in before):
        return True
    moving = [other for modifier in before for other in objects_of(modifier)]
    if obj.parent is not None and obj.parent_type in ("ARMATURE", "LATTICE"):
        moving.append(obj.parent)
    if any(modifier.type in DEFORMING for modifier in before):
        moving.append(obj)  # whose settings of modifiers may be keyed
    owners = [obj.data.shape_keys, *moving, *(other.data for other in moving)]
    return any(map(_is_animated, owners))


def _is_animated(owner: ID | None) -> bool:
    animation = getattr(owner, "animation_data", None)
    return animation is not None and bool(animation.action or animation.nla_tracks or animation.drivers)


def place_behind(modifiers: Iterable[Modifier]) -> int:
    """The place in a stack behind all that moves a mesh, and before what only divides its faces then.

    Blender lets no such modifier stand before a Multiresolution.
    """
    types = ["SUBSURF" if refined_group.is_refining(other) else other.type for other in modifiers]
    movers = [place for place, kind in enumerate(types) if kind in DEFORMING | _CHANGING]
    first = movers[-1] + 1 if movers else 0
    return next((place for place in range(first, len(types)) if types[place] == "SUBSURF"), len(types))
