# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirrors handles across the local X of the object: vertex groups with weights, and controls with their pose.

The other side is found by name. A handle without a side in its name lies on the centre and is made even: one
half takes the weights of the other. Blender's own Mirror does the same if one half is selected. If both are,
it swaps them, which leaves an uneven region uneven. The mean of both would lower weights of 1, which hold
vertices exactly.
"""

from dataclasses import dataclass, field

import bpy
import numpy as np
from bpy.types import Object

from ....core.elements import Elements, Owner
from ....core.errors import ConstraintError, SinewError
from ....core.methods import HANDLE_PARAMETERS
from ....core.sides import Side, flip, side_of
from ....mesh_io import RestShape, read_rest
from ....properties import SinewDeformer, SinewHandle
from ...blocks import capture, shapes, vertex_groups
from ...control import kinds
from ...memory import sessions
from . import mirror_controls
from .mirror_weights import MirrorPlane, images

_COPIED = ("kind", "weight", "colour", "enabled", "from_rest") + tuple(
    parameter.id for parameter in HANDLE_PARAMETERS
)


@dataclass(frozen=True)
class MirrorOptions:
    """``source`` is the side that is copied. ``tolerance`` is in object space."""

    source: Side = Side.LEFT
    tolerance: float = 1e-3
    weights_only: bool = False
    painted_groups: bool = False


@dataclass
class Mirrored:
    """What was done: pairs of names, handles that were made even, how many vertices have no image on the
    other side, and how many on the centre stay with the source."""

    pairs: list[tuple[str, str]] = field(default_factory=list)
    evened: list[str] = field(default_factory=list)
    unmatched: int = 0
    centre: int = 0


def handles_of_side(deformer: SinewDeformer, side: Side) -> list[str]:
    """The keys of the handles of one side, and of those on the centre."""
    return [handle.uid for handle in deformer.handles if side_of_handle(handle) in (side, None)]


def _sided_name(handle: SinewHandle) -> str:
    """The name that tells the side: that of the handle, or else of its group; empty on the centre."""
    return next((name for name in (handle.name, handle.vertex_group) if flip(name)), "")


def side_of_handle(handle: SinewHandle) -> Side | None:
    """The side of a handle; None on the centre."""
    return side_of(_sided_name(handle))


@sessions.suspended()
def mirror(obj: Object, deformer: SinewDeformer, keys: list[str], options: MirrorOptions) -> Mirrored:
    """Mirror the handles with these keys. The deformer is not bound again: see ``bind``."""
    if obj.data.library is not None:
        raise SinewError("The mesh is linked - make it local, or override it, before you change its groups")
    made = _missing_groups(obj, deformer, keys, options)
    try:
        rest, members = _rest(obj, deformer, keys)
        across = {key: images(rest.points, options.tolerance, members[key]) for key in keys if key in members}
        _refuse_lopsided(deformer, rest, members, across, options)
    except SinewError:
        for name in made:
            obj.vertex_groups.remove(obj.vertex_groups[name])
        raise
    plane = MirrorPlane(obj, options.tolerance)
    result = Mirrored(unmatched=sum(int((found < 0).sum()) for found in across.values()))
    for key in across:
        source = _by_key(deformer, key)
        if not _sided_name(source):
            plane.even_out(obj.vertex_groups[source.vertex_group], options.source)
            result.evened.append(source.name)
            continue
        target = _counterpart(deformer, source)
        is_new = target is None
        if is_new and options.weights_only:
            continue
        target_key = _add(deformer, source, made) if is_new else target.uid
        source, target = _by_key(deformer, key), _by_key(deformer, target_key)
        group = obj.vertex_groups[target.vertex_group]
        result.centre += plane.copy_across(source.vertex_group, group, source.weight)
        result.pairs.append((source.name, target.name))
        if not options.weights_only:
            for name in _COPIED:
                setattr(target, name, getattr(source, name))
            reached = np.unique(across[key][across[key] >= 0])
            mirror_controls.give(obj, deformer, source, target, rest, reached)
    if options.painted_groups:
        _even_out_painted(obj, deformer, plane, options.source)
    kinds.keep_evaluated(obj)
    obj.update_tag()
    return result


def _by_key(deformer: SinewDeformer, key: str) -> SinewHandle:
    """The handle with a key. Look it up again after handles were added, which moves them in memory."""
    return next(handle for handle in deformer.handles if handle.uid == key)


def _counterpart(deformer: SinewDeformer, source: SinewHandle) -> SinewHandle | None:
    """The handle of the other side, found by its name or else by the name of its group."""
    for name in ("name", "vertex_group"):
        wanted = flip(getattr(source, name))
        for handle in deformer.handles:
            if wanted and getattr(handle, name) == wanted:
                return handle
    return None


def _target_group(deformer: SinewDeformer, source: SinewHandle) -> str:
    """The vertex group of the other side."""
    target = _counterpart(deformer, source)
    return target.vertex_group if target else flip(source.vertex_group) or flip(source.name)


def _missing_groups(
    obj: Object, deformer: SinewDeformer, keys: list[str], options: MirrorOptions
) -> list[str]:
    """Make the missing vertex groups of the other side, which a Mirror modifier then fills; their names."""
    made = []
    for key in keys:
        source = _by_key(deformer, key)
        name = _target_group(deformer, source) if _sided_name(source) else ""
        is_wanted = not options.weights_only or _counterpart(deformer, source) is not None
        if name and is_wanted and name not in obj.vertex_groups:
            obj.vertex_groups.new(name=name)
            made.append(name)
    return made


def _rest(obj: Object, deformer: SinewDeformer, keys: list[str]) -> tuple[RestShape, dict[str, np.ndarray]]:
    """What enters the modifier, and the vertices of each handle in it. Handles without any are left out."""
    mesh = capture.rest_mesh(obj, deformer)
    try:
        rest = read_rest(mesh)
        vertex_groups.read_weights(rest, mesh, deformer)
    finally:
        bpy.data.meshes.remove(mesh)
    found = {}
    for key in keys:
        painted = rest.weights.get(_by_key(deformer, key).vertex_group)
        if painted is not None and (painted > 0.0).any():
            found[key] = np.flatnonzero(painted > 0.0)
    if not found:
        raise ConstraintError("There is nothing to mirror - the vertex groups of these handles are empty")
    return rest, found


def _refuse_lopsided(
    deformer: SinewDeformer,
    rest: RestShape,
    members: dict[str, np.ndarray],
    across: dict[str, np.ndarray],
    options: MirrorOptions,
) -> None:
    """Refuse regions that lie on one side without a side in their name, or without an image on the other."""
    is_alone = len(across) == 1
    for key in list(across):
        handle, x = _by_key(deformer, key), rest.points[members[key], 0]
        one_sided = (x > options.tolerance).all() or (x < -options.tolerance).all()
        message = ""
        if one_sided and not _sided_name(handle):
            message = f"{handle.name} lies on one side but its name has none - call it {handle.name}.L or .R"
        elif (across[key] < 0).all():
            message = (
                f"No vertex of {handle.name} has a mirror image across X - the mesh is not symmetrical "
                "there. Raise the tolerance if it nearly is"
            )
        elif (
            is_alone
            and options.weights_only
            and _sided_name(handle)
            and _counterpart(deformer, handle) is None
        ):
            message = f"{handle.name} has no counterpart {flip(_sided_name(handle))} yet - mirror all of it"
        if message and is_alone:
            raise ConstraintError(message, Elements(Owner.TARGET, "vertex", members[key]))
        if message:
            del across[key]
    if not across:
        raise ConstraintError("No handle can be mirrored - the mesh is not symmetrical across its local X")


def _add(deformer: SinewDeformer, source: SinewHandle, made: list[str]) -> str:
    """Add a handle for the other side; returns its key."""
    name = flip(source.name) or flip(source.vertex_group)
    group = _target_group(deformer, source)
    handle = deformer.handles.add()
    handle.uid = shapes.new_key()
    handle.name, handle.vertex_group = name, group
    handle.owns_group = group in made
    return handle.uid


def _even_out_painted(obj: Object, deformer: SinewDeformer, plane: MirrorPlane, source: Side) -> None:
    """Make the vertex groups of painted parameters and of the mask even."""
    for name in vertex_groups.painting_groups(deformer) | {deformer.mask_group}:
        if name in obj.vertex_groups:
            plane.even_out(obj.vertex_groups[name], source)
