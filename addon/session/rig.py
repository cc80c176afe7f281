# SPDX-License-Identifier: GPL-3.0-or-later
"""The datablocks of a deformer: shape meshes, modifier, and the driver that keeps controls evaluated.

Only operators, scripts and timers on the main thread may call this. The tie between settings and modifier
is the shape object, never a name.
"""

import uuid

import bpy
import numpy as np
from bpy.types import Mesh, NodesModifier, Object

from .. import compat
from ..ids import Datablocks, Inputs, Keys
from ..mesh_io import shape_mesh, write_shape
from ..properties import SinewDeformer
from . import node_group, state

_REST = ("rest",)


def new_key() -> str:
    """A key that no other deformer has, also in other files."""
    return uuid.uuid4().hex[:16]


def find_modifier(obj: Object, deformer: SinewDeformer) -> NodesModifier | None:
    """The modifier that shows this deformer."""
    if deformer.proxy is None:
        return None
    for modifier in obj.modifiers:
        if (
            modifier.type == "NODES"
            and compat.modifier_input(modifier, Inputs.PROXY_VIEWPORT) == deformer.proxy
        ):
            return modifier
    return None


def attribute_names(key: str) -> tuple[str, str]:
    """Where the node group keeps incoming positions and indices of this deformer."""
    return f".sinew_in_{key}", f".sinew_index_{key}"


def ensure(obj: Object, deformer: SinewDeformer, vertex_count: int) -> NodesModifier:
    """Shape meshes of the right size, in a modifier with the right inputs.

    Changes nothing that is right already.
    """
    modifier = find_modifier(obj, deformer)
    deformer.proxy = _shape_object(deformer.proxy, Datablocks.PROXY_VIEWPORT, vertex_count)
    deformer.proxy_render = _shape_object(deformer.proxy_render, Datablocks.PROXY_RENDER, vertex_count)
    if modifier is None:
        modifier = obj.modifiers.new(Datablocks.MODIFIER, "NODES")
        _discard_default_group(modifier)
        modifier.node_group = node_group.ensure()
    connect(modifier, deformer)
    return modifier


def _discard_default_group(modifier: NodesModifier) -> None:
    """Blender 3.x gives a new modifier an empty group of its own."""
    group = modifier.node_group
    if group is not None:
        modifier.node_group = None
        bpy.data.node_groups.remove(group)


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


def connect_mask(obj: Object, modifier: NodesModifier, deformer: SinewDeformer) -> bool:
    """Pass the mask on to the modifier; True where it changed. A group that is gone masks nothing."""
    mask = deformer.mask_group if deformer.mask_group in obj.vertex_groups else ""
    if compat.modifier_input(modifier, Inputs.MASK) == mask:
        return False
    compat.set_modifier_input(modifier, Inputs.MASK, mask)
    return True


def is_linked(proxy: Object | None) -> bool:
    """Blender ignores writes to this shape: it, or its mesh, comes from a library."""
    return proxy is not None and (proxy.library is not None or proxy.data.library is not None)


def _shape_object(proxy: Object | None, name: str, vertex_count: int) -> Object:
    if proxy is None or is_linked(proxy):
        return bpy.data.objects.new(name, shape_mesh(name, vertex_count))
    if len(proxy.data.vertices) != vertex_count + 1:
        outgrown: Mesh = proxy.data
        proxy.data = shape_mesh(name, vertex_count)
        if outgrown.users == 0:
            bpy.data.meshes.remove(outgrown)
    return proxy


def show_rest(deformer: SinewDeformer, mode: str) -> None:
    """Let the incoming shape through. An array write only, so handlers may call it."""
    proxy = deformer.proxy_render if mode == "RENDER" else deformer.proxy
    shown = state.of(deformer.uid).view(mode)
    if proxy is None or shown.signature == _REST:
        return
    zeros = np.zeros((len(proxy.data.vertices) - 1, 3), dtype=np.float32)
    write_shape(proxy.data, zeros, 0.0, False)
    shown.signature, shown.positions, shown.converged = _REST, None, True


def keep_evaluated(obj: Object) -> None:
    """One SUM driver, one variable a control: Blender then evaluates hidden and unlinked controls too.

    It has no Python expression, so it also works in files that are not trusted.
    """
    path = f'["{Keys.KEEP}"]'
    if obj.animation_data is not None:
        for curve in [curve for curve in obj.animation_data.drivers if curve.data_path == path]:
            obj.animation_data.drivers.remove(curve)
    controls = dict.fromkeys(
        (handle.control, handle.bone)
        for deformer in obj.sinew.deformers
        for handle in deformer.handles
        if handle.kind == "HANDLE" and handle.control is not None
    )
    if not controls:
        if Keys.KEEP in obj:
            del obj[Keys.KEEP]
        return
    obj[Keys.KEEP] = 0.0
    driver = obj.driver_add(path).driver
    driver.type = "SUM"
    for control, bone in controls:
        variable = driver.variables.new()
        variable.type = "TRANSFORMS"
        target = variable.targets[0]
        target.id = control
        if bone:
            target.bone_target = bone


def remove(obj: Object, deformer: SinewDeformer) -> None:
    """Take the modifier off and free what only this deformer used."""
    modifier = find_modifier(obj, deformer)
    if modifier is not None:
        obj.modifiers.remove(modifier)
    release_rest(deformer)
    for proxy in (deformer.proxy, deformer.proxy_render):
        free_shape(proxy)


def free_shape(proxy: Object | None) -> None:
    """Remove a shape object unless a copy of the target still shows it."""
    if proxy is None or is_linked(proxy):
        return
    if _shape_owners(proxy) > 1:
        return
    mesh = proxy.data
    bpy.data.objects.remove(proxy)
    if mesh.users == 0:
        bpy.data.meshes.remove(mesh)


def _shape_owners(proxy: Object) -> int:
    return sum(
        proxy in (deformer.proxy, deformer.proxy_render)
        for obj in bpy.data.objects
        for deformer in obj.sinew.deformers
    )


def release_rest(deformer: SinewDeformer) -> None:
    """Forget the rest mesh; a copy of the target may still hold it."""
    mesh, deformer.rest = deformer.rest, None
    if mesh is not None and mesh.library is None and mesh.users == 0:
        bpy.data.meshes.remove(mesh)
