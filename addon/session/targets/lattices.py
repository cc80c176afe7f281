# SPDX-License-Identifier: GPL-3.0-or-later
"""Lattice objects, on which shape keys show the deformers, since lattices take no node modifiers.

Each deformer has one relative key of its own. It holds the points of the key that it is relative to, mostly
the Basis, moved by what the hidden shape holds. So the points and keys of the artist stay as they are, and
Blender adds the deformation to them, before the modifiers of the lattice. Blender does not carry edits of the
Basis to other keys, so ``show`` compares the key with what it should hold whenever the lattice was evaluated.

See ``kinds``, and docs/developer/decisions/lattice-targets.md.
"""

from collections.abc import Sequence
from contextlib import nullcontext
from functools import partial

import bpy
import numpy as np
from bpy.types import Depsgraph, Mesh, Modifier, Object, Scene, ShapeKey

from ...compat import read_key, read_lattice, read_positions, write_key, write_lattice
from ...core.errors import OptionError
from ...core.memory import remember
from ...core.point_types import LATTICE, PointType
from ...ids import Datablocks, Keys
from ...mesh_io import weights_attribute
from ...properties import SinewDeformer, deformers_of
from ..state import render_writes, sessions

NOUN, DATA = "shape key", "lattice"
STAYS_UNBOUND = False  # Blender keeps the resolution of a lattice while it has keys
RENDERS_MAY_DIFFER = False  # deformers come before all modifiers, and those keep the points
READS_ALL_WEIGHTS = True
_SINGLE_USER = "make it single-user first (Object > Relations)"

_late: set[str] = remember(set())  # the lattices that viewports show after the render
# What keys held when the artist began to edit them in Edit Mode, float32 (n, 3), by the key of the deformer.
_edited: dict[str, np.ndarray] = remember({})


def stack(obj: Object) -> Sequence[ShapeKey]:
    """The shape keys of a lattice object, of which each bound deformer has one; none if it has none."""
    keys = obj.data.shape_keys
    return () if keys is None else keys.key_blocks


def shown_by(obj: Object, deformer: SinewDeformer) -> ShapeKey | None:
    """The key that shows the deformer; None if it was deleted, or is the Basis by now."""
    keys = obj.data.shape_keys
    if keys is None or not deformer.shape_key:
        return None
    key = keys.key_blocks.get(deformer.shape_key)
    return None if key == keys.reference_key else key


def mark_of(deformer: SinewDeformer) -> str:
    return deformer.shape_key


def mark(key: ShapeKey) -> str:
    return key.name


def follow_renamed(obj: Object) -> None:
    """Find the keys again that the artist has renamed: they still hold what the hidden shapes hold."""
    for deformer in deformers_of(obj):
        shape = deformer.shape("VIEWPORT")
        if not deformer.shape_key or shape is None or deformer.shape_key in stack(obj):
            continue
        claimed = {other.shape_key for other in deformers_of(obj)}
        held = read_positions(shape.data)
        for key in stack(obj)[1:]:
            if key.name not in claimed and np.array_equal(
                read_key(key), _placed(read_key(key.relative_key), held)
            ):
                deformer.shape_key = key.name
                break


def require(obj: Object) -> None:
    """Refuse a lattice whose points cannot be moved."""
    data = obj.data
    if data.library is not None:
        raise OptionError(
            f"The points of {obj.name} are linked - make its data local first (Object > Relations)"
        )
    if data.shape_keys is not None and not data.shape_keys.use_relative:
        raise OptionError(f"The shape keys of {obj.name} are absolute - switch on Relative beside them")
    leader = leader_of(obj)
    if leader != obj:
        raise OptionError(
            f"{obj.name} shares its points with {leader.name}, which moves both - {_SINGLE_USER}"
        )


def leader_of(obj: Object) -> Object:
    """Of the objects with deformers that share the points of a lattice object, the one that moves them."""
    if obj.data.users == 1:
        return obj
    return next((other for other in bpy.data.objects if other.data == obj.data and deformers_of(other)), obj)


def ensure(obj: Object, deformer: SinewDeformer) -> ShapeKey:
    """The key of the deformer, made if it is missing. What is there already stays as it is."""
    require(obj)
    others = [other.name for other in bpy.data.objects if other.data == obj.data and other != obj]
    if others:
        raise OptionError(f"{obj.name} shares its points with {others[0]} - {_SINGLE_USER}")
    key = shown_by(obj, deformer)
    if key is not None:
        return key
    if obj.mode == "EDIT":
        raise OptionError(f"{obj.name} is in Edit Mode, where it gets no shape key - leave it, then Rebind")
    active = obj.active_shape_key_index
    if obj.data.shape_keys is None:
        obj.shape_key_add(name=Datablocks.BASIS, from_mix=False)
        obj.data[Keys.MADE_BASIS] = True
    key = obj.shape_key_add(name=Datablocks.SHAPE_KEY, from_mix=False)
    key.relative_key = obj.data.shape_keys.reference_key
    write_key(key, read_key(key.relative_key))
    key.value = 1.0
    if hasattr(key, "lock_shape"):  # Blender 4.2 and later
        key.lock_shape = True
    deformer.shape_key = key.name
    obj.active_shape_key_index = active
    return key


def connect(_key: ShapeKey, _deformer: SinewDeformer) -> None:
    """``show`` writes what the hidden shapes hold into the key."""


def remove(obj: Object, deformer: SinewDeformer) -> None:
    """Remove the key of the deformer, and the Basis if it was made for it."""
    key = shown_by(obj, deformer)
    deformer.shape_key = ""
    _edited.pop(deformer.uid, None)
    if key is None or obj.data.library is not None or leader_of(obj) not in (obj, None):
        return
    active = obj.active_shape_key
    name = "" if active is None or active == key else active.name
    obj.shape_key_remove(key)
    rest = stack(obj)
    names = [block.name for block in rest]
    obj.active_shape_key_index = names.index(name) if name in names else 0
    if Keys.MADE_BASIS in obj.data and len(rest) == 1:
        points = read_key(rest[0])
        obj.shape_key_remove(rest[0])
        write_lattice(obj.data, points)
    if Keys.MADE_BASIS in obj.data and not _moved(obj):
        del obj.data[Keys.MADE_BASIS]
    obj.data.update_tag()


def _moved(obj: Object) -> bool:
    """Whether a deformer still has a key."""
    return any(shown_by(obj, deformer) is not None for deformer in deformers_of(obj))


def hidden_by(obj: Object, deformer: SinewDeformer) -> str:
    """Why Blender does not show the key now, for the panel; empty if it does."""
    if obj.mode == "EDIT":
        return (
            "Blender shows a lattice in Edit Mode without its other shape keys, and so without this deformer"
        )
    if obj.show_only_shape_key and obj.active_shape_key != shown_by(obj, deformer):
        return "Blender shows the active shape key alone - switch off the pin beside the shape keys"
    return ""


def own_data(obj: Object) -> None:
    """Give a library override points and keys of its own, since Blender ignores writes to linked ones."""
    if obj.override_library is not None and obj.data.library is not None:
        obj.data = obj.data.copy()


def connect_mask(key: ShapeKey, group: str) -> bool:
    if key.vertex_group == group:
        return False
    key.vertex_group = group
    return True


def show(obj: Object, mode: str, scene: Scene) -> None:
    """Let the keys show what the hidden shapes of this mode hold. It only writes arrays that changed.

    While a thread renders, the keys belong to the render, and the viewport waits: there is one set of them.
    """
    if mode == "VIEWPORT" and bpy.app.is_job_running("RENDER"):
        _late.add(obj.name)
        return
    if obj.data.library is not None or leader_of(obj) != obj:
        return
    for deformer in deformers_of(obj):
        key, shape = shown_by(obj, deformer), deformer.shape(mode)
        if key is None or shape is None:
            continue
        if mode == "VIEWPORT" and _is_edited(obj, deformer, key):
            continue
        wanted = _placed(read_key(key.relative_key), read_positions(shape.data))
        if np.array_equal(wanted, read_key(key), equal_nan=True):
            continue
        session = sessions.open_session(deformer.uid)
        with session.lock:
            render_writes.write(scene, partial(_write, obj, key, wanted), session.lock)


def show_late() -> None:
    """After a render, let keys show again what viewports show. Main thread only."""
    if _late and not bpy.app.is_job_running("RENDER"):
        for name in sorted(_late):
            obj = bpy.data.objects.get(name)
            if obj is not None and obj.type == "LATTICE":
                show(obj, "VIEWPORT", bpy.context.scene)
            _late.discard(name)  # once it is shown, as Blender may refuse that for now


def _placed(base: np.ndarray, held: np.ndarray) -> np.ndarray:
    """Where the points ``base`` (n, 3) are moved to by a shape mesh, which holds one vertex more."""
    if len(held) != len(base) + 1:
        return base
    factor, displacement = held[-1, :2]
    if not factor > 0.0:
        return base
    return base + factor * (held[:-1] if displacement > 0.5 else held[:-1] - base)


def _write(obj: Object, key: ShapeKey, places: np.ndarray) -> bool:
    write_key(key, places)
    obj.data.update_tag()
    return True


def _is_edited(obj: Object, deformer: SinewDeformer, key: ShapeKey) -> bool:
    """Whether the artist edits this very key in Edit Mode: then it is left alone.

    Afterwards the edit is moved to the key that it is relative to, which this deformer moves on from there.
    """
    if obj.mode == "EDIT" and obj.active_shape_key == key:
        _edited.setdefault(deformer.uid, read_key(key))
        return True
    before = _edited.pop(deformer.uid, None)
    if before is not None:
        now, base = read_key(key), read_key(key.relative_key)
        if before.shape == now.shape and not np.array_equal(before, now):
            write_key(key.relative_key, base + (now - before))
            obj.data.update_tag()
    return False


def forget_edits() -> None:
    """Call after undo and redo, which may have changed the keys."""
    for obj in bpy.data.objects:
        if obj.type == "LATTICE" and obj.mode != "EDIT":
            for deformer in deformers_of(obj):
                _edited.pop(deformer.uid, None)


def position(obj: Object, deformer: SinewDeformer | None) -> int:
    """How many deformers come before this one, or before a new one."""
    uids = [other.uid for other in obj.sinew.deformers]
    return len(uids) if deformer is None or deformer.uid not in uids else uids.index(deformer.uid)


def modifiers_before(_obj: Object, _deformer: SinewDeformer | None) -> list[Modifier]:
    return []


def keep_first(copy: Object, obj: Object, count: int) -> None:
    """Give a copy points of its own, which the later deformers and the modifiers do not move."""
    copy.data = obj.data.copy()
    copy.show_only_shape_key = False
    for deformer in list(obj.sinew.deformers)[count:]:
        key = shown_by(copy, deformer)
        if key is not None:
            key.mute = True
    copy.modifiers.clear()


showing_points = nullcontext


def new_mesh(evaluated: Object, _depsgraph: Depsgraph) -> Mesh:
    """A new mesh with the points of an evaluated lattice object as loose vertices, and all its weights."""
    mesh = bpy.data.meshes.new(Datablocks.REST)
    points = read_lattice(evaluated.data)
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set("co", points.ravel())
    weights = np.zeros((len(evaluated.vertex_groups), len(points)), dtype=np.float32)
    if len(weights):
        for number, point in enumerate(evaluated.data.points):
            for element in point.groups:
                weights[element.group, number] = element.weight
    for index, row in enumerate(weights):
        mesh.attributes.new(weights_attribute(index), "FLOAT", "POINT").data.foreach_set("value", row)
    return mesh


def take_point_type(_mesh: Mesh) -> PointType:
    return LATTICE


def points_shown(obj: Object, depsgraph: Depsgraph) -> np.ndarray:
    return read_lattice(obj.evaluated_get(depsgraph).data)


def edges_shown(obj: Object, _depsgraph: Depsgraph) -> np.ndarray:
    """The lines of the grid."""
    counts = obj.data.points_w, obj.data.points_v, obj.data.points_u
    grid = np.arange(np.prod(counts), dtype=np.int32).reshape(counts)
    lines = [np.moveaxis(grid, axis, 0) for axis in range(3)]
    return np.concatenate([np.stack((line[:-1], line[1:]), -1).reshape(-1, 2) for line in lines])


def has_keys(obj: Object) -> bool:
    """Whether the artist has made shape keys, even if it is the Basis alone."""
    own = {deformer.shape_key for deformer in deformers_of(obj)}
    made = 1 if Keys.MADE_BASIS in obj.data else 0
    return any(key.name not in own for key in stack(obj)[made:])


def name_of_key(_key: ShapeKey, deformer: SinewDeformer) -> str:
    return deformer.name


def applied(obj: Object, deformer: SinewDeformer) -> tuple[np.ndarray, np.ndarray]:
    """The Basis, and the Basis moved by this deformer alone, as its key shows it."""
    basis, key = read_key(obj.data.shape_keys.reference_key), shown_by(obj, deformer)
    moved = key.value * (read_key(key) - read_key(key.relative_key))
    if key.vertex_group in obj.vertex_groups:
        index = obj.vertex_groups[key.vertex_group].index
        share = [
            next((element.weight for element in point.groups if element.group == index), 0.0)
            for point in obj.data.points
        ]
        moved = moved * np.array(share, dtype=np.float32)[:, None]
    return basis, basis + moved
