# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether something before a deformer may move the mesh from frame to frame."""

from bpy.types import Object

from ...properties import SinewDeformer
from ..targets import targets
from ..targets.kinds import kind_of

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
