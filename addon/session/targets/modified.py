# SPDX-License-Identifier: GPL-3.0-or-later
"""The objects on which a node modifier shows a deformer: meshes, curves, text, hair and point clouds.

A modifier belongs to the deformer whose shape object it shows, whatever its name is. See ``kinds``.
"""

import hashlib
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext

import bpy
import numpy as np
from bpy.types import Depsgraph, Mesh, Modifier, NodesModifier, Object, Scene

from ... import compat
from ...ids import Datablocks, Inputs
from ...properties import SinewDeformer, deformers_of
from . import control_points, node_group, targets

NOUN, DATA = "modifier", "mesh"
STAYS_UNBOUND = True
RENDERS_MAY_DIFFER = True
READS_ALL_WEIGHTS = False
KEY_LENGTH = 16  # of the keys of deformers

take_point_type = control_points.take_point_type


def require(_obj: Object) -> None:
    """Blender lets modifiers move the points of all such objects."""


def stack(obj: Object) -> Sequence[Modifier]:
    return obj.modifiers


def shown_by(obj: Object, deformer: SinewDeformer) -> NodesModifier | None:
    """The modifier that shows this deformer, or did before its hidden shape was deleted."""
    nodes = [modifier for modifier in obj.modifiers if modifier.type == "NODES"]
    shape = deformer.shape("VIEWPORT")
    if shape is not None:
        for modifier in nodes:
            if mark(modifier) == shape:
                return modifier
    incoming, _index = attribute_names(deformer.uid)
    for modifier in nodes:
        if compat.modifier_input(modifier, Inputs.INCOMING) == incoming:
            return modifier
    return None


def mark_of(deformer: SinewDeformer) -> Object | None:
    return deformer.shape("VIEWPORT")


def mark(modifier: Modifier) -> Object | None:
    return compat.modifier_input(modifier, Inputs.PROXY_VIEWPORT) if modifier.type == "NODES" else None


def ensure(obj: Object, deformer: SinewDeformer) -> NodesModifier:
    modifier, point_type = shown_by(obj, deformer), targets.point_type(deformer)
    if modifier is None:
        modifier = obj.modifiers.new(Datablocks.MODIFIER, "NODES")
        modifier.show_expanded = False  # Sinew sets its inputs
        node_group.attach(modifier, node_group.ensure(point_type))
    elif not node_group.shows(modifier, point_type):
        modifier.node_group = node_group.ensure(point_type)
    return modifier


def connect(modifier: NodesModifier, deformer: SinewDeformer) -> None:
    """Set the inputs of the modifier to the shapes and attribute names of this deformer."""
    incoming, index = attribute_names(deformer.uid)
    for name, value in (
        (Inputs.INCOMING, incoming),
        (Inputs.INDEX, index),
        (Inputs.PROXY_RENDER, deformer.proxy_render),
        (Inputs.PROXY_VIEWPORT, deformer.proxy),
    ):
        if compat.modifier_input(modifier, name) != value:
            compat.set_modifier_input(modifier, name, value)


def connect_mask(modifier: NodesModifier, group: str) -> bool:
    if compat.modifier_input(modifier, Inputs.MASK) == group:
        return False
    compat.set_modifier_input(modifier, Inputs.MASK, group)
    return True


def remove(obj: Object, deformer: SinewDeformer) -> None:
    modifier = shown_by(obj, deformer)
    if modifier is not None:
        obj.modifiers.remove(modifier)


def own_data(_obj: Object) -> None:
    """A copied object has modifiers of its own."""


def follow_renamed(_obj: Object) -> None:
    """Modifiers are known by their inputs, not by name."""


def show(_obj: Object, _mode: str, _scene: Scene) -> None:
    """The node group reads the hidden shapes itself."""


def hidden_by(_obj: Object, _deformer: SinewDeformer) -> str:
    return ""


def attribute_names(key: str) -> tuple[str, str]:
    """The attributes in which the node group stores incoming positions and indices for this deformer."""
    key = key if len(key) <= KEY_LENGTH else hashlib.sha1(key.encode()).hexdigest()[:KEY_LENGTH]
    return f".sinew_in_{key}", f".sinew_index_{key}"


def stray_modifiers(obj: Object) -> list[str]:
    """The modifiers that show the shape of another object's deformer: Copy Modifiers copies no settings."""
    own = {shape for deformer in deformers_of(obj) for shape in (deformer.proxy, deformer.proxy_render)}
    own |= {None}
    return [
        modifier.name
        for modifier in obj.modifiers
        if node_group.is_ours(modifier) and mark(modifier) not in own
    ]


def tell_copies_apart(obj: Object) -> bool:
    """Give copies of a modifier, made by Blender's own button, attribute names of their own.

    They show the same shape, and would overwrite the incoming positions. Returns whether there were any.
    """
    restored = [_restore_names(obj, deformer) for deformer in obj.sinew.deformers]
    renamed, known = any(restored), set()
    for modifier in obj.modifiers:
        if modifier.type != "NODES":
            continue
        name = compat.modifier_input(modifier, Inputs.INCOMING)
        if name is not None and name in known:
            compat.set_modifier_input(modifier, Inputs.INCOMING, f"{name}_copy")
            compat.set_modifier_input(modifier, Inputs.INDEX, f"{name}_copy_index")
            renamed = True
        known.add(name)
    if renamed:
        obj.update_tag()
    return renamed


def _restore_names(obj: Object, deformer: SinewDeformer) -> bool:
    """Give a copied modifier the names of attributes that the removed original had; whether it had others."""
    modifier = shown_by(obj, deformer)
    incoming, index = attribute_names(deformer.uid)
    if modifier is None or compat.modifier_input(modifier, Inputs.INCOMING) == incoming:
        return False
    compat.set_modifier_input(modifier, Inputs.INCOMING, incoming)
    compat.set_modifier_input(modifier, Inputs.INDEX, index)
    return True


def position(obj: Object, deformer: SinewDeformer | None) -> int:
    """How many modifiers come before the deformer, or would before a new one at the end of the stack."""
    modifier = None if deformer is None else shown_by(obj, deformer)
    return len(obj.modifiers) if modifier is None else list(obj.modifiers).index(modifier)


def modifiers_before(obj: Object, deformer: SinewDeformer | None) -> list[Modifier]:
    return list(obj.modifiers)[: position(obj, deformer)]


def keep_first(copy: Object, obj: Object, count: int) -> None:
    """Remove the later modifiers from a copy; in Edit Mode it gets a mesh of its own, too."""
    if obj.mode == "EDIT":
        copy.data = obj.data.copy()
    for modifier in list(copy.modifiers)[count:]:
        copy.modifiers.remove(modifier)


def showing_points(obj: Object) -> AbstractContextManager[Object]:
    return nullcontext(obj) if targets.is_mesh(obj) else control_points.showing_points(obj)


def new_mesh(evaluated: Object, depsgraph: Depsgraph) -> Mesh:
    return bpy.data.meshes.new_from_object(evaluated, preserve_all_data_layers=True, depsgraph=depsgraph)


@contextmanager
def evaluated_mesh(obj: Object, depsgraph: Depsgraph) -> Iterator[Mesh | None]:
    """For a while, the mesh of an object after its modifiers, in object space; None if it has none."""
    evaluated = obj.evaluated_get(depsgraph)
    try:
        yield evaluated.to_mesh()
    finally:
        evaluated.to_mesh_clear()


def points_shown(obj: Object, depsgraph: Depsgraph) -> np.ndarray:
    if targets.is_cloud(obj):
        return compat.read_cloud(obj.evaluated_get(depsgraph).data)
    if not targets.has_points(obj):
        return np.zeros((0, 3), dtype=np.float32)
    with evaluated_mesh(obj, depsgraph) as mesh:
        return np.zeros((0, 3), dtype=np.float32) if mesh is None else compat.read_positions(mesh)


def edges_shown(obj: Object, depsgraph: Depsgraph) -> np.ndarray:
    if targets.is_cloud(obj):
        return np.zeros((0, 2), dtype=np.int32)
    with evaluated_mesh(obj, depsgraph) as shown:
        return compat.read_edges(shown)


def has_keys(obj: Object) -> bool:
    return getattr(obj.data, "shape_keys", None) is not None


def name_of_key(modifier: NodesModifier, _deformer: SinewDeformer) -> str:
    return modifier.name


def applied(_obj: Object, _deformer: SinewDeformer) -> None:
    """Other modifiers may act before the deformer."""
