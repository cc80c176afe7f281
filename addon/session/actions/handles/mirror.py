# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirrors handles across the local X of the object: vertex groups with weights, and controls with their pose.

The other side is found by name. A handle without a side in its name is named by the side that its region lies
on. If the region reaches the centre, it stays one handle and is made even: one half takes the weights of the
other. Blender's own Mirror does the same if one half is selected. If both are, it swaps them, which leaves an
uneven region uneven. The mean of both would lower weights of 1, which hold vertices exactly.
"""

from dataclasses import dataclass, field

import bpy
import numpy as np
from bpy.types import Object

from ....core.elements import Elements, Owner
from ....core.errors import ConstraintError, SinewError
from ....core.methods import HANDLE_PARAMETERS
from ....core.sides import Side, flip
from ....mesh_io import RestShape, read_rest
from ....properties import SinewDeformer, SinewHandle
from ...controls import kinds
from ...controls.handles.sides import counterpart, side_of_handle, sided_name
from ...datablocks import vertex_groups
from ...datablocks.shapes import capture, shapes
from ...evaluation import mirroring
from ...state import sessions
from . import mirror_controls
from .mirror_weights import MirrorPlane, images
from .naming import give_name, name_of_side, side_of_points

_COPIED = ("kind", "weight", "colour", "enabled", "from_rest", "stands_on", "stood_on") + tuple(
    parameter.id for parameter in HANDLE_PARAMETERS
)


@dataclass(frozen=True)
class MirrorOptions:
    """``source`` is the side that is copied; None is the side of the first handle, left on the centre.

    ``tolerance`` is in object space.
    """

    source: Side | None = None
    tolerance: float = 1e-3
    weights_only: bool = False
    painted_groups: bool = False


@dataclass
class Mirrored:
    """What was done: pairs of names; old and new names of handles that were named by their side; handles on
    the centre that were made even; how many vertices have no image on the other side; and how many on the
    centre stay with the source."""

    pairs: list[tuple[str, str]] = field(default_factory=list)
    named: list[tuple[str, str]] = field(default_factory=list)
    evened: list[str] = field(default_factory=list)
    unmatched: int = 0
    centre: int = 0


def handles_of_side(deformer: SinewDeformer, side: Side) -> list[str]:
    """The keys of the handles of one side, and of those on the centre."""
    return [handle.uid for handle in deformer.handles if side_of_handle(handle) in (side, None)]


@sessions.suspended()
def mirror(obj: Object, deformer: SinewDeformer, keys: list[str], options: MirrorOptions) -> Mirrored:
    """Mirror the handles with these keys. The deformer is not bound again: see ``bind``."""
    if obj.data.library is not None:
        raise SinewError("The mesh is linked - make it local, or override it, before you change its groups")
    made = _missing_groups(obj, deformer, keys, options)
    try:
        rest, members = _rest(obj, deformer, keys)
        if options.source is None:
            members |= _supports(deformer, rest, members, options)
        sides = _sides(deformer, rest, members, options)
        across = {key: images(rest.points, options.tolerance, members[key]) for key in sides}
        names = _names(obj, deformer, rest, sides, across)
        _refuse_lopsided(deformer, members, across, names, options)
    except SinewError:
        for name in made:
            obj.vertex_groups.remove(obj.vertex_groups[name])
        raise
    result = Mirrored(unmatched=sum(int((found < 0).sum()) for found in across.values()))
    for key, name in names.items():
        handle = _by_key(deformer, key)
        result.named.append((handle.name, name))
        give_name(obj, handle, name)
    made += _missing_groups(obj, deformer, list(across), options)
    plane = MirrorPlane(obj, options.tolerance)
    source_side = options.source or next(iter(sides.values())) or Side.LEFT
    for key in across:
        source = _by_key(deformer, key)
        if not sided_name(source):
            plane.even_out(obj.vertex_groups[source.vertex_group], source_side)
            result.evened.append(source.name)
            continue
        target = counterpart(deformer, source)
        target_key = _add(deformer, source, made) if target is None else target.uid
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
        _even_out_painted(obj, deformer, plane, source_side)
    kinds.keep_evaluated(obj)
    obj.update_tag()
    mirroring.note_seen()  # what was placed here was moved by no artist
    return result


def _by_key(deformer: SinewDeformer, key: str) -> SinewHandle:
    """The handle with a key. Look it up again after handles were added, which moves them in memory."""
    return next(handle for handle in deformer.handles if handle.uid == key)


def _target_group(deformer: SinewDeformer, source: SinewHandle) -> str:
    """The vertex group of the other side."""
    target = counterpart(deformer, source)
    return target.vertex_group if target else flip(source.vertex_group) or flip(source.name)


def _missing_groups(
    obj: Object, deformer: SinewDeformer, keys: list[str], options: MirrorOptions
) -> list[str]:
    """Make the missing vertex groups of the other side, which a Mirror modifier then fills; their names."""
    made = []
    for key in keys:
        source = _by_key(deformer, key)
        name = _target_group(deformer, source) if sided_name(source) else ""
        is_wanted = not options.weights_only or counterpart(deformer, source) is not None
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


def _supports(
    deformer: SinewDeformer, rest: RestShape, members: dict[str, np.ndarray], options: MirrorOptions
) -> dict[str, np.ndarray]:
    """The supports around handles, on the same side: without them the other side would take another shape."""
    found = {}
    for key, vertices in members.items():
        handle = _by_key(deformer, key)
        side = _side(handle, rest, vertices, options)
        if handle.kind != "HANDLE" or side is None:
            continue
        for other in deformer.handles:
            painted = rest.weights.get(other.vertex_group)
            is_wanted = not options.weights_only or counterpart(deformer, other) is not None
            if other.kind != "SUPPORT" or painted is None or not is_wanted:
                continue
            around = np.flatnonzero(painted > 0.0)
            if (painted[vertices] > 0.0).all() and _side(other, rest, around, options) is side:
                found[other.uid] = around
    return found


def _side(handle: SinewHandle, rest: RestShape, vertices: np.ndarray, options: MirrorOptions) -> Side | None:
    """The side of a handle: by its name, else by its place; None on the centre."""
    return side_of_handle(handle) or side_of_points(rest.points[vertices], options.tolerance)


def _sides(
    deformer: SinewDeformer, rest: RestShape, members: dict[str, np.ndarray], options: MirrorOptions
) -> dict[str, Side | None]:
    """The side of each handle.

    Handles that lie on the side that receives are left out: their names are theirs to keep.
    """
    found = {}
    for key, vertices in members.items():
        side = _side(_by_key(deformer, key), rest, vertices, options)
        if side is None or options.source in (None, side):
            found[key] = side
    if not found:
        raise ConstraintError("There is nothing to mirror on this side - no handle lies on it")
    return found


def _names(
    obj: Object,
    deformer: SinewDeformer,
    rest: RestShape,
    sides: dict[str, Side | None],
    across: dict[str, np.ndarray],
) -> dict[str, str]:
    """The new names, by key, of handles that lie on a side but do not say so in their names.

    If another such handle holds most of the mirror image already, it is the counterpart, and named too.
    """
    names: dict[str, str] = {}
    for key, side in sides.items():
        handle = _by_key(deformer, key)
        if side is None or sided_name(handle):
            continue
        names[key] = name_of_side(obj, deformer, handle, side, list(names.values()))
        reached = across[key][across[key] >= 0]
        for other in deformer.handles:
            painted = rest.weights.get(other.vertex_group)
            is_nameless = other.uid not in names and not sided_name(other)
            if is_nameless and painted is not None and (painted[reached] > 0.0).sum() * 2 > len(across[key]):
                names[other.uid] = flip(names[key])
                break
    return names


def _refuse_lopsided(
    deformer: SinewDeformer,
    members: dict[str, np.ndarray],
    across: dict[str, np.ndarray],
    names: dict[str, str],
    options: MirrorOptions,
) -> None:
    """Refuse regions without an image on the other side, and take them out of ``across`` and ``names``.

    ``names`` are those that handles are to get.
    """
    is_alone = len(across) == 1 or options.source is None
    for key in list(across):
        handle = _by_key(deformer, key)
        other = flip(names.get(key, "")) or flip(sided_name(handle))
        exists = counterpart(deformer, handle) is not None or other in names.values()
        exists = exists or any(found.name == other for found in deformer.handles)
        message = ""
        if (across[key] < 0).all():
            message = (
                f"No vertex of {handle.name} has a mirror image across X - the mesh is not symmetrical "
                "there. Raise the tolerance if it nearly is"
            )
        elif options.weights_only and other and not exists:
            message = f"{handle.name} has no counterpart {other} yet - mirror all of it"
        if message and is_alone:
            raise ConstraintError(message, Elements(Owner.TARGET, "vertex", members[key]))
        if message:
            del across[key]
            for named in [named for named, name in names.items() if named == key or name == other]:
                del names[named]
    if not across:
        raise ConstraintError(
            "No handle can be mirrored - the mesh is not symmetrical across its local X, or the other side "
            "has no handles yet"
        )


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
