# SPDX-License-Identifier: GPL-3.0-or-later
"""Which rigs a rig reads: those whose shapes decide where its controls are, or what enters its modifiers.

Blender follows all this by itself, but cannot know that Sinew computes a shape from controls. So parents,
constraints, modifiers and drivers are followed here. Handlers and scripts may change them before any frame,
so nothing is kept from one evaluation to the next.
"""

import re
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from bpy.types import ID, Constraint, Driver, Modifier, Object, PoseBone
from bpy.utils import unescape_identifier

from ...ids import Keys
from ...properties import deformers_of
from ..controls import kinds
from ..controls.handles import riding
from ..datablocks import references
from ..datablocks.modifier_objects import objects_of
from ..targets import node_group, targets

PLACE = "PLACE"  # where an object is
POSE = "POSE"  # where a bone of an armature is, or where all of them are
SHAPE = "SHAPE"  # what the modifiers of an object make of it
CARRIED = "CARRIED"  # what a rig carries: controls that ride on the surface that enters

_BY_VERTEX = ("VERTEX", "VERTEX_3")
_ON_SHAPE = ("CLAMP_TO", "FOLLOW_PATH", "SHRINKWRAP", "SPLINE_IK")  # these constraints need no vertex group
_MOVES_PARENTS = ("IK", "SPLINE_IK")
# These modifiers ask where their objects are, and not for their shapes.
_BY_PLACE = frozenset(
    ("CAST", "DISPLACE", "HOOK", "MIRROR", "NORMAL_EDIT", "SCREW", "SIMPLE_DEFORM", "UV_WARP", "WARP", "WAVE")
)
_OF_SHAPE = ("dimensions", "bound_box")  # what a driver may read of an object that depends on its shape
_KEEPER = f'["{Keys.KEEP}"]'
_BONE = re.compile(r'pose\.bones\["((?:[^"\\]|\\.)*)"\]')  # in the path of what is driven


class Part(NamedTuple):
    """What may depend on the shape of a rig: a place, a shape or a pose. No ``bone`` means all of them."""

    what: str
    object: Object
    bone: str = ""


_Drivers = list[tuple[str, list[Part]]]  # by the path of what is driven


class Reads(NamedTuple):
    """The rigs that a rig reads, and those of them whose shapes may change what enters its modifiers."""

    rigs: frozenset[Object]
    entering: frozenset[Object]


class Relations:
    """The relations of the scene as they are now. Each is followed when it is asked for, and once."""

    def __init__(self) -> None:
        self._next: dict[Part, tuple[Part, ...]] = {}
        self._reads: dict[Object, Reads] = {}
        self._drivers: dict[ID, _Drivers] = {}
        self._bones: dict[Object, _Bones] = {}
        self._carried: dict[Object, set[Object]] = {}

    def reads(self, rig: Object) -> Reads:
        """The rigs that a rig reads by itself."""
        found = self._reads.get(rig)
        if found is None:
            entering = self._reached(rig, self._entering(rig))
            found = self._reads[rig] = Reads(entering | self._reached(rig, self._controls(rig)), entering)
        return found

    def below(self, rig: Object) -> frozenset[Object]:
        """The rigs that a rig reads by itself or through others. It is one of them if it is in a circle."""
        found: set[Object] = set()
        waiting = [rig]
        while waiting:
            new = self.reads(waiting.pop()).rigs - found
            found |= new
            waiting.extend(new)
        return frozenset(found)

    def _reached(self, rig: Object, parts: Iterable[Part]) -> frozenset[Object]:
        """The rigs whose shapes these parts of a rig depend on, and the other rigs that carry them."""
        waiting = list(parts)
        known, found = set(waiting), set()
        while waiting:
            part = waiting.pop()
            if part.what == SHAPE and deformers_of(part.object):
                found.add(part.object)
            if part.what == CARRIED and part.object != rig:
                found.add(part.object)
            following = self._next.get(part)
            if following is None:
                following = self._next[part] = tuple(self._follow(part))
            new = [other for other in following if other not in known]
            known.update(new)
            waiting += new
        return frozenset(found)

    def _follow(self, part: Part) -> Iterator[Part]:
        """What a part depends on at once."""
        if part.what == PLACE:
            return self._place(part.object)
        if part.what == CARRIED:
            return self._entering(part.object)
        return self._pose(part) if part.what == POSE else self._shape(part.object)

    def _controls(self, rig: Object) -> Iterator[Part]:
        """What the poses of a rig depend on."""
        yield Part(PLACE, rig)
        for deformer in rig.sinew.deformers:
            for link in kinds.kind_in_use(deformer).links(deformer):
                yield Part(PLACE, link.object)
                if link.by_shape:
                    yield Part(SHAPE, link.object)
                if link.bone:
                    yield Part(POSE, link.object, link.bone)
            for other, by_shape in references.pointed(deformer):
                yield Part(PLACE, other)
                if by_shape:
                    yield Part(SHAPE, other)
        yield from self._driven(rig, "sinew.")

    def _entering(self, rig: Object) -> Iterator[Part]:
        """What the shape depends on that enters the last deformer of a rig."""
        modifiers = list(rig.modifiers)
        while modifiers and not node_group.is_ours(modifiers[-1]):
            modifiers.pop()
        yield from self._modifiers(rig, modifiers)

    def _place(self, obj: Object) -> Iterator[Part]:
        parent = obj.parent
        if parent is not None:
            yield Part(PLACE, parent)
            if obj in self._carried_by(parent):
                yield Part(CARRIED, parent)
            kind = obj.parent_type
            if kind in _BY_VERTEX or targets.is_path(parent):
                yield Part(SHAPE, parent)
            elif kind == "BONE":
                yield Part(POSE, parent, obj.parent_bone)
        for constraint in obj.constraints:
            yield from _constraint(constraint)
        yield from self._driven(obj, "", but=("sinew.", "modifiers[", "pose.", _KEEPER))

    def _carried_by(self, rig: Object) -> set[Object]:
        """The controls that ride on the surface of a rig, which are its children."""
        found = self._carried.get(rig)
        if found is None:
            handles = [handle for deformer in deformers_of(rig) for handle in deformer.handles]
            found = {handle.control for handle in handles if riding.is_carried(rig, handle)}
            self._carried[rig] = found
        return found

    def _pose(self, part: Part) -> Iterator[Part]:
        """Of one bone of an armature, or of all of them."""
        armature = part.object
        yield Part(PLACE, armature)
        if armature.pose is None:  # its library is missing
            return
        bones = self._bones.get(armature)
        if bones is None:
            bones = self._bones[armature] = _Bones(armature, self._drivers_of(armature))
        if not part.bone:
            yield from bones.all()
        elif (bone := armature.pose.bones.get(part.bone)) is not None:
            yield from bones.of(bone)

    def _shape(self, obj: Object) -> Iterator[Part]:
        yield from self._modifiers(obj, obj.modifiers)
        for name in ("bevel_object", "taper_object", "follow_curve"):
            other = getattr(obj.data, name, None)
            if other is not None:
                yield Part(SHAPE, other)
                yield Part(PLACE, other)

    def _modifiers(self, obj: Object, modifiers: Iterable[Modifier]) -> Iterator[Part]:
        """What the shape of an object depends on before and after these modifiers."""
        followed = set()
        for modifier in modifiers:
            if modifier.type == "ARMATURE":
                followed.add((POSE, modifier.object))
            elif modifier.type == "NODES":
                if not node_group.is_ours(modifier):
                    followed.update((SHAPE, other) for other in objects_of(modifier))
            else:
                what = PLACE if modifier.type in _BY_PLACE else SHAPE
                followed.update((what, other) for other in objects_of(modifier))
                bone, owner = getattr(modifier, "subtarget", ""), getattr(modifier, "object", None)
                if bone and owner is not None and targets.has_bones(owner):
                    yield Part(POSE, owner, bone)
        if obj.parent is not None and obj.parent_type in (
            "ARMATURE",
            "LATTICE",
        ):  # it deforms like a modifier
            followed.add((POSE if obj.parent_type == "ARMATURE" else SHAPE, obj.parent))
        followed = {(what, other) for what, other in followed if other is not None}
        if followed:
            yield Part(PLACE, obj)
        for what, other in followed:
            yield Part(PLACE, other)
            yield Part(what, other)
        yield from self._driven(obj, "modifiers[")
        keys = getattr(obj.data, "shape_keys", None)
        if keys is not None:
            yield from self._driven(keys, "")

    def _driven(self, datablock: ID, beginning: str, but: tuple[str, ...] = ()) -> Iterator[Part]:
        """What the drivers follow of the paths that begin so, ``but`` for some."""
        if datablock.animation_data is None:
            return
        for path, parts in self._drivers_of(datablock):
            if path.startswith(beginning) and not (but and path.startswith(but)):
                yield from parts

    def _drivers_of(self, datablock: ID) -> _Drivers:
        found = self._drivers.get(datablock)
        if found is None:
            found = self._drivers[datablock] = _drivers(datablock)
        return found


def circle(rig: Object) -> tuple[str, ...]:
    """The line in the panel about the circle that a rig is in; none if it is in no circle."""
    relations = Relations()
    below = relations.below(rig)
    if rig not in below:
        return ()
    names = sorted(other.name for other in below if rig in relations.below(other))
    if len(names) == 1:
        return (
            f"{names[0]} follows its own shape, by a control or a modifier - let that follow another object",
        )
    listed = f"{', '.join(names[:-1])} and {names[-1]}"
    return (f"{listed} follow each other in a circle - let one of them follow another object",)


class _Bones:
    """What the bones of an armature follow by themselves: read once, as many parts may ask for it."""

    def __init__(self, armature: Object, drivers: _Drivers) -> None:
        self._followed: dict[str, list[Part]] = {}
        self._chains: list[
            tuple[set[str], list[Part]]
        ] = []  # bones that a constraint further down moves, too
        for bone in armature.pose.bones:
            if not bone.constraints:
                continue
            followed = self._followed[bone.name] = []
            for constraint in bone.constraints:
                parts = list(_constraint(constraint))
                followed += parts
                if constraint.type in _MOVES_PARENTS:
                    moved = bone.parent_recursive[: constraint.chain_count or None]
                    self._chains.append(({other.name for other in moved}, parts))
        for path, parts in drivers:
            name = _BONE.match(path)
            if name is not None:
                self._followed.setdefault(unescape_identifier(name[1]), []).extend(parts)

    def all(self) -> Iterator[Part]:
        """What any of them follows."""
        for parts in self._followed.values():
            yield from parts

    def of(self, bone: PoseBone) -> Iterator[Part]:
        """What decides where a bone is."""
        upwards = {bone.name, *(other.name for other in bone.parent_recursive)}
        for name in upwards & self._followed.keys():
            yield from self._followed[name]
        for moved, parts in self._chains:
            if not moved.isdisjoint(upwards):
                yield from parts


def _constraint(constraint: Constraint) -> Iterator[Part]:
    on_shape = constraint.type in _ON_SHAPE
    if constraint.type == "ARMATURE":
        for row in constraint.targets:
            yield from _followed(row.target, row.subtarget, on_shape)
        return
    for name, group in (("target", "subtarget"), ("pole_target", "pole_subtarget")):
        yield from _followed(getattr(constraint, name, None), getattr(constraint, group, ""), on_shape)


def _followed(target: Object | None, subtarget: str, on_shape: bool) -> Iterator[Part]:
    """What a constraint follows: an object, one of its bones, a vertex group, or its surface."""
    if target is None:
        return
    yield Part(PLACE, target)
    if subtarget and targets.has_bones(target):
        yield Part(POSE, target, subtarget)
    elif subtarget or on_shape:
        yield Part(SHAPE, target)


def _drivers(datablock: ID) -> _Drivers:
    """The paths that drivers drive, with what each of them follows."""
    animation = datablock.animation_data
    return [
        (curve.data_path, list(_variables(curve.driver)))
        for curve in (animation.drivers if animation is not None else ())
    ]


def _variables(driver: Driver) -> Iterator[Part]:
    for variable in driver.variables:
        for target in variable.targets:
            other = target.id
            if not isinstance(other, Object):
                continue
            yield Part(PLACE, other)
            if target.bone_target and targets.has_bones(other):
                yield Part(POSE, other, target.bone_target)
            elif variable.type == "SINGLE_PROP" and target.data_path.startswith(_OF_SHAPE):
                yield Part(SHAPE, other)
