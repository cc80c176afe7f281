# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a shape permanent, as Blender applies a modifier: in the mesh itself, or as a shape key.

Main thread only.
"""

from collections.abc import Iterator
from contextlib import contextmanager

import bpy
import numpy as np
from bpy.types import Modifier, Object, ShapeKey

from ...compat import read_key, read_positions, write_key
from ...core.errors import SinewError
from ...core.status import Level
from ...ids import Datablocks
from ...mesh_io import read_incoming
from ...properties import SinewDeformer
from ..datablocks.shapes import capture
from ..evaluation import evaluate
from ..state import sessions
from ..state.evaluation import is_shown
from ..targets import modified, targets
from ..targets.kinds import kind_of
from . import deformers, driving


def apply(obj: Object, index: int, as_shape_key: bool = False, keep: bool = False) -> list[str]:
    """Give the mesh, or a new shape key of it, the shape shown now. Removes the deformer unless ``keep``.

    As when Blender applies a modifier, the mesh itself is changed. The modifiers before the deformer stay,
    and act on the result. Their names are returned.
    """
    deformer = obj.sinew.deformers[index]
    kind = kind_of(obj)
    shows = kind.shown_by(obj, deformer)
    _refuse(obj, deformer, shows, as_shape_key)
    before = [other for other in kind.modifiers_before(obj, deformer) if other.show_viewport]
    names = [other.name for other in before]
    with _switched_off(before):
        entered, left = _shapes(obj, deformer, names)
    with sessions.suspended():
        if as_shape_key:
            key = _add_key(obj, kind.name_of_key(shows, deformer), entered, left)
            driving.take_driver(obj, index, key)
        else:
            targets.write_points(obj, left)
        if not keep:
            deformers.remove_deformer(obj, index)
        obj.update_tag()
    return names


def _refuse(
    obj: Object, deformer: SinewDeformer, shows: Modifier | ShapeKey | None, as_shape_key: bool
) -> None:
    """Refuse what Blender refuses to apply too, and a deformer without a shape."""
    kind = kind_of(obj)
    kind.require(obj)
    if as_shape_key:
        if not targets.has_groups_and_keys(obj):
            targets.require_mesh(obj, "Shape keys are made on")
    elif not targets.holds_points(obj, targets.point_type(deformer)):
        raise SinewError(f"Blender makes what the cage moves of {obj.name} - convert it to a mesh")
    if obj.data.users > 1:
        raise SinewError(
            f"Other objects share this {kind.DATA} - make it single-user first (Object > Relations)"
        )
    if obj.data.library is not None or obj.data.override_library is not None:
        raise SinewError("The mesh is linked - make it local first (Object > Relations)")
    if kind.has_keys(obj) and not as_shape_key:
        raise SinewError(f"The {kind.DATA} has shape keys, which keep its shape - use Apply as Shape Key")
    if deformer.bake.is_baked:
        raise SinewError(f"{deformer.name} is baked - Unbake it first")
    if shows is None:
        button = "Rebind" if deformer.is_bound else "Bind"
        raise SinewError(f"{deformer.name} has no {kind.NOUN} any more - press {button} first")
    if not is_shown(shows, "VIEWPORT"):
        raise SinewError(f"The {kind.NOUN} {shows.name} is switched off - switch it on first")


@contextmanager
def _switched_off(modifiers: list[Modifier]) -> Iterator[None]:
    """For a while, the mesh itself enters the deformer, without these modifiers."""
    for modifier in modifiers:
        modifier.show_viewport = False
    try:
        yield
    finally:
        for modifier in modifiers:
            modifier.show_viewport = True


def _shapes(obj: Object, deformer: SinewDeformer, before: list[str]) -> tuple:
    """The shapes before and after the deformer, float32 (n, 3). Without a mesh both are the one after it."""
    expected = targets.point_count(obj, targets.point_type(deformer))
    if deformer.rest is not None and len(deformer.rest.vertices) != expected and before:
        raise SinewError(
            f"The deformer works on vertices that {', '.join(before)} made - apply those first, or move the "
            "deformer before them"
        )
    bpy.context.view_layer.update()
    evaluate.update(bpy.context.evaluated_depsgraph_get())
    if deformer.status_level == Level.ERROR.value:
        raise SinewError(deformer.status)
    kind = kind_of(obj)
    applied = kind.applied(obj, deformer)
    if applied is not None:
        return applied
    mesh = capture.mesh_after(obj, kind.position(obj, deformer) + 1)
    try:
        left = read_positions(mesh)
        entered: np.ndarray | None = left
        if targets.is_mesh(obj):
            entered = read_incoming(mesh, *modified.attribute_names(deformer.uid), len(left)).points
    finally:
        bpy.data.meshes.remove(mesh)
    if entered is None or len(left) != expected:
        raise SinewError("Topology changed - Rebind before you apply")
    return entered, left


def _add_key(obj: Object, name: str, entered: np.ndarray, left: np.ndarray) -> ShapeKey:
    """Add a shape key with value 0, as Blender's own Apply as Shape Key does."""
    if obj.data.shape_keys is None:
        obj.shape_key_add(name=Datablocks.BASIS, from_mix=False)
    basis = read_key(obj.data.shape_keys.reference_key)
    active = obj.active_shape_key_index
    key = obj.shape_key_add(name=name, from_mix=False)
    key.relative_key = obj.data.shape_keys.reference_key
    key.value = 0.0  # new keys are on from Blender 5.0
    write_key(key, np.where(entered == basis, left, basis + (left - entered)))
    obj.active_shape_key_index = active
    return key
