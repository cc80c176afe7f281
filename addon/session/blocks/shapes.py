# SPDX-License-Identifier: GPL-3.0-or-later
"""The hidden meshes of a deformer and the modifier that shows them.

Only operators, scripts and timers on the main thread may call this. The tie between settings and modifier
is the shape object, never a name.
"""

import hashlib
import uuid

import bpy
import numpy as np
from bpy.types import Mesh, NodesModifier, Object, Scene

from ... import compat
from ...ids import Datablocks, Inputs
from ...mesh_io import replace_rest, resize_shape, shape_mesh, write_shape
from ...properties import SinewDeformer, deformers_of
from ..memory import render_writes, sessions
from . import node_group, references, targets

_KEY_LENGTH = 16
_REST = ("rest",)


def new_key() -> str:
    """A key that no other deformer has, also in other files."""
    return uuid.uuid4().hex[:_KEY_LENGTH]


def find_modifier(obj: Object, deformer: SinewDeformer) -> NodesModifier | None:
    """The modifier that shows this deformer, or did before somebody deleted its hidden shape."""
    nodes = [modifier for modifier in obj.modifiers if modifier.type == "NODES"]
    shape = deformer.shape("VIEWPORT")
    if shape is not None:
        for modifier in nodes:
            if compat.modifier_input(modifier, Inputs.PROXY_VIEWPORT) == shape:
                return modifier
    incoming, _index = attribute_names(deformer.uid)
    for modifier in nodes:
        if compat.modifier_input(modifier, Inputs.INCOMING) == incoming:
            return modifier
    return None


def _restore_names(obj: Object, deformer: SinewDeformer) -> bool:
    """Of a copied modifier that outlived the first one; True where it had others."""
    modifier = find_modifier(obj, deformer)
    incoming, index = attribute_names(deformer.uid)
    if modifier is None or compat.modifier_input(modifier, Inputs.INCOMING) == incoming:
        return False
    compat.set_modifier_input(modifier, Inputs.INCOMING, incoming)
    compat.set_modifier_input(modifier, Inputs.INDEX, index)
    return True


def attribute_names(key: str) -> tuple[str, str]:
    """Where the node group keeps incoming positions and indices of this deformer."""
    key = key if len(key) <= _KEY_LENGTH else hashlib.sha1(key.encode()).hexdigest()[:_KEY_LENGTH]
    return f".sinew_in_{key}", f".sinew_index_{key}"


def ensure(
    obj: Object, deformer: SinewDeformer, vertex_count: int, render_count: int | None = None
) -> NodesModifier:
    """Shape meshes of the right size, in a modifier with the right inputs.

    Changes nothing that is right already. ``render_count``: where renders have another number of vertices.
    """
    modifier = find_modifier(obj, deformer)
    deformer.proxy = _shape_object(deformer.shape("VIEWPORT"), Datablocks.PROXY_VIEWPORT, vertex_count)
    render_count = vertex_count if render_count is None else render_count
    deformer.proxy_render = _shape_object(deformer.shape("RENDER"), Datablocks.PROXY_RENDER, render_count)
    kind = targets.point_type(deformer)
    if modifier is None:
        modifier = obj.modifiers.new(Datablocks.MODIFIER, "NODES")
        modifier.show_expanded = False  # its inputs are ours to set
        node_group.attach(modifier, node_group.ensure(kind))
    elif not node_group.shows(modifier, kind):
        modifier.node_group = node_group.ensure(kind)
    connect(modifier, deformer)
    return modifier


def connect(modifier: NodesModifier, deformer: SinewDeformer) -> None:
    """Give the modifier this deformer's shapes and names."""
    incoming, index = attribute_names(deformer.uid)
    for name, value in (
        (Inputs.INCOMING, incoming),
        (Inputs.INDEX, index),
        (Inputs.PROXY_RENDER, deformer.proxy_render),
        (Inputs.PROXY_VIEWPORT, deformer.proxy),
    ):
        if compat.modifier_input(modifier, name) != value:
            compat.set_modifier_input(modifier, name, value)


def tell_copies_apart(obj: Object) -> bool:
    """A modifier copied by Blender's own button shows the same shape, and must not overwrite what entered.

    True where a copy got names of its own.
    """
    restored = [_restore_names(obj, deformer) for deformer in obj.sinew.deformers]
    renamed, seen = any(restored), set()
    for modifier in obj.modifiers:
        if modifier.type != "NODES":
            continue
        name = compat.modifier_input(modifier, Inputs.INCOMING)
        if name is not None and name in seen:
            compat.set_modifier_input(modifier, Inputs.INCOMING, f"{name}_copy")
            compat.set_modifier_input(modifier, Inputs.INDEX, f"{name}_copy_index")
            renamed = True
        seen.add(name)
    if renamed:
        obj.update_tag()
    return renamed


def connect_mask(obj: Object, modifier: NodesModifier, deformer: SinewDeformer) -> bool:
    """Pass the mask on to the modifier; True where it changed. A group that is gone masks nothing."""
    mask = deformer.mask_group if deformer.mask_group in obj.vertex_groups else ""
    if compat.modifier_input(modifier, Inputs.MASK) == mask:
        return False
    compat.set_modifier_input(modifier, Inputs.MASK, mask)
    return True


def is_linked(proxy: Object | None) -> bool:
    """Blender ignores writes to this shape: it, or its mesh, comes from a library."""
    return isinstance(proxy, Object) and (
        proxy.library is not None or (proxy.data is not None and proxy.data.library is not None)
    )


def _shape_object(proxy: Object | None, name: str, vertex_count: int) -> Object:
    if proxy is None or is_linked(proxy):
        return bpy.data.objects.new(name, shape_mesh(name, vertex_count))
    if len(proxy.data.vertices) != vertex_count + 1:
        if proxy.data.users == 1:
            resize_shape(proxy.data, vertex_count)
        else:
            proxy.data = shape_mesh(name, vertex_count)
    return proxy


def session_of(deformer: SinewDeformer, mode: str) -> sessions.Session:
    """The session of a deformer. Renders have one of their own where other vertices enter there."""
    session = sessions.open_session(deformer.uid)
    if mode == "RENDER" and deformer.renders_differ:
        return sessions.open_render_session(deformer.uid)
    return session


def show_rest(deformer: SinewDeformer, mode: str, scene: Scene | None = None) -> None:
    """Let the incoming shape through. An array write only, so handlers may call it.

    A handler names its ``scene`` and holds the session's lock.
    """
    proxy = deformer.shape(mode)
    session = session_of(deformer, mode)
    shown = session.view(mode)
    if proxy is None or shown.signature == _REST:
        return
    zeros = np.zeros((len(proxy.data.vertices), 3), dtype=np.float32)
    mesh = proxy.data
    if scene is None:
        write_shape(mesh, zeros, 0.0, False)
    else:
        render_writes.write(scene, lambda: write_shape(mesh, zeros, 0.0, False), session.lock)
    shown.signature, shown.converged = _REST, True
    shown.hold(None)


def remove(obj: Object, deformer: SinewDeformer) -> None:
    """Take the modifier off and free what only this deformer used."""
    modifier = find_modifier(obj, deformer)
    if modifier is not None:
        obj.modifiers.remove(modifier)
    release_rest(deformer)
    references.release_curves(deformer)
    for proxy in (deformer.shape("VIEWPORT"), deformer.shape("RENDER")):
        free_shape(proxy)


def free_shape(proxy: Object | None) -> None:
    """Remove a shape object unless a copy of the target still shows it, or somebody put it into a scene."""
    if proxy is None or is_linked(proxy) or _shape_owners(proxy) > 1 or proxy.users_scene:
        return
    mesh = proxy.data
    bpy.data.objects.remove(proxy)
    if mesh.users == 0:
        bpy.data.meshes.remove(mesh)


def _shape_owners(proxy: Object) -> int:
    return sum(
        proxy in (deformer.proxy, deformer.proxy_render)
        for obj in bpy.data.objects
        for deformer in deformers_of(obj)
    )


def hold_rest(deformer: SinewDeformer, meshes: tuple[Mesh, Mesh | None]) -> None:
    """Store what entered, in the datablocks held already; ``meshes`` are used up.

    Blender's undo leaves an object as it is where two steps agree on it. Had a timer let the object point to
    a new mesh since, which no step knows, the pointer would outlive the mesh.
    """
    shown, rendered = meshes
    deformer.rest = put_mesh(deformer.rest, shown)
    deformer.rest_render = put_mesh(deformer.rest_render, rendered or bpy.data.meshes.new(Datablocks.REST))


def put_mesh(held: Mesh | None, new: Mesh) -> Mesh:
    """``new`` in the place of ``held``, unless a copy of the target or a library holds that too."""
    if not isinstance(held, Mesh) or held.library is not None or held.users != 1:
        return new
    replace_rest(held, new)
    bpy.data.meshes.remove(new)
    return held


def release_rest(deformer: SinewDeformer) -> None:
    """Forget the rest meshes; a copy of the target may still hold them."""
    meshes, deformer.rest, deformer.rest_render = (deformer.rest, deformer.rest_render), None, None
    free_meshes(*meshes)


def free_meshes(*meshes: Mesh | None) -> None:
    """Remove hidden meshes that nobody uses any more."""
    for mesh in meshes:
        if isinstance(mesh, Mesh) and mesh.library is None and mesh.users == 0:
            bpy.data.meshes.remove(mesh)
