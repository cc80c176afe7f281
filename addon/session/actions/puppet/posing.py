# SPDX-License-Identifier: GPL-3.0-or-later
"""Drags a bone of an armature, and lets the others follow. Main thread only."""

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np
from bpy.types import Depsgraph, Object, PoseBone
from mathutils import Euler, Matrix, Quaternion

from ....backend import Puppet, Solution, Targets
from ....core.errors import ConstraintError, SinewError
from ....core.geometry import frames
from ....core.sides import flip
from ...controls.movers import rotation_channel
from . import bones, limits

_PINNED = 1e3  # the weight of what holds the puppet, beside what is dragged
_FLIP = Matrix.Diagonal((-1.0, 1.0, 1.0, 1.0))  # to the mirror image in the frame of a bone
_TOLERANCE = 1e-6  # a support of less than three points apart is none; a share of the size of the bones
_CHANNELS = ("location", "rotation_quaternion", "rotation_axis_angle", "rotation_euler")


class Part(Enum):
    """Which point of a bone is dragged."""

    AUTO = "AUTO"  # the tail, or the whole bone if it has no parent
    TAIL = "TAIL"
    HEAD = "HEAD"
    WHOLE = "WHOLE"  # the bone as a rigid body: it does not turn about its length either


@dataclass(frozen=True)
class PuppetOptions:
    """How a puppet follows."""

    part: Part = Part.AUTO
    balance: bool = False  # the centre of mass stays over what is pinned
    from_rest: bool = False  # joints stay close to rest, and not to how they are at the start


class _Hold(NamedTuple):
    """A point of a bone that stays."""

    row: int
    point: np.ndarray  # (3,) at rest
    goal: np.ndarray  # (3,) in the frame of the armature
    is_end: bool  # whether it is the head or the tail of the bone


class PuppetDrag:
    """A bone that is dragged. ``move`` poses the armature, and ``restore`` puts everything back.

    Every pose is solved from the posture at the start, so it depends on the place of the mouse alone. Only
    names and numbers are kept, so that undo may come in between.
    """

    def __init__(self, armature: Object, bone: str, depsgraph: Depsgraph, options: PuppetOptions) -> None:
        """Raises a ``SinewError`` before anything changes."""
        bones.require_bones(armature)
        if bone not in armature.pose.bones:
            raise ConstraintError(f"{armature.name} has no bone '{bone}' - choose one of its pose bones")
        held_by = bones.follows_target(armature.pose.bones[bone])
        if held_by is not None:
            raise ConstraintError(
                f"{bone} follows its target {held_by.subtarget or held_by.target.name} - move that instead"
            )
        self.name = bone
        self._world = np.array(armature.matrix_world, dtype=np.float64)
        self._to_armature = frames.inverse(self._world, armature.name)
        self._skeleton = skeleton = bones.read_skeleton(armature, depsgraph)
        self._puppet = Puppet(skeleton.bones)
        self._turns, self._moves = self._puppet.turns(skeleton.rotations), skeleton.moves
        row = skeleton.row(bone)
        part = options.part
        if part is Part.AUTO:
            part = Part.TAIL if skeleton.bones.parents[row] >= 0 else Part.WHOLE
        self._row, self._points = row, _points(skeleton, row, part)
        self._shown = _shown(skeleton)
        self._held = self._find_held(armature, depsgraph)
        self._choose_moving(armature)
        if options.from_rest:
            self._turns = np.where(self._locked[:, None], self._turns, 0.0)
            self._moves = np.where(self._moving_roots[:, None], 0.0, self._moves)
        self._up = self._to_armature[:3, :3] @ (0.0, 0.0, 1.0)
        self._support = self._find_support() if options.balance else None
        self._images = self._find_images(armature)
        touched = (*self.moving, *self._images.values())
        self._before = {name: _channels(armature.pose.bones[name]) for name in touched}
        self.gap = self.overhang = 0.0  # in the world: how far the bone is behind, and the centre of mass off
        self.ignored = [name for name in self.moving if _has_other_constraints(armature.pose.bones[name])]

    @property
    def moving(self) -> list[str]:
        """The names of the bones that may turn or move."""
        return [self._skeleton.names[row] for row in np.flatnonzero(~self._locked)]

    @property
    def place(self) -> np.ndarray:
        """Where the dragged point was at the start (3,), in the world."""
        points = frames.transformed(self._shown[self._row], self._points)
        return frames.transformed(self._world, points.mean(axis=0)[None])[0]

    @property
    def frame(self) -> np.ndarray:
        """The dragged bone at the start, in the world (4, 4)."""
        bones_at_rest, frame = self._skeleton.bones, np.eye(4)
        frame[:3, :3], frame[:3, 3] = bones_at_rest.axes[self._row], bones_at_rest.heads[self._row]
        return self._world @ self._shown[self._row] @ frame

    def move(self, armature: Object, motion: np.ndarray) -> None:
        """Move the dragged point by a motion (4, 4) of the world, from where it was at the start."""
        if not np.isfinite(motion).all():
            raise ConstraintError("The motion is not a finite number - type another one")
        moved = self._to_armature @ motion @ self._world @ self._shown[self._row]
        count = len(self._points)
        targets = Targets(
            np.array([self._row] * count + [hold.row for hold in self._held]),
            np.array([*self._points, *(hold.point for hold in self._held)]),
            np.array([*frames.transformed(moved, self._points), *(hold.goal for hold in self._held)]),
            np.array([1.0] * count + [_PINNED] * len(self._held)),
        )
        found = self._puppet.solve(
            targets,
            self._turns,
            self._moves,
            locked=self._locked,
            moving_roots=self._moving_roots,
            support=self._support,
            up=self._up,
        )
        scale = abs(float(np.linalg.det(self._world[:3, :3]))) ** (1.0 / 3.0)
        self.gap = float(found.gaps[:count].max()) * scale
        self.overhang = found.overhang * scale
        self._write(armature, found)

    def restore(self, armature: Object) -> None:
        """Put everything back."""
        for name, channels in self._before.items():
            bone = armature.pose.bones.get(name)
            if bone is not None:
                for channel, values in channels.items():
                    setattr(bone, channel, values)

    def key(self, armature: Object) -> None:
        """Insert keyframes for all bones that may move, so that the next drag does not change this frame."""
        for name in self.moving:
            for touched in filter(None, (name, self._images.get(name))):
                bone = armature.pose.bones[touched]
                bone.keyframe_insert(rotation_channel(bone), group=touched)
                if self._moving_roots[self._skeleton.row(name)]:
                    bone.keyframe_insert("location", group=touched)

    def _find_images(self, armature: Object) -> dict[str, str]:
        """The bones of the other side that follow with Mirror, by those that move.

        Those that move themselves, or are pinned, do not follow.
        """
        if not armature.pose.use_mirror_x:
            return {}
        images = {name: armature.pose.bones.get(flip(name)) for name in self.moving}
        return {
            name: image.name
            for name, image in images.items()
            if image is not None and image.name not in images and not image.sinew.pin
        }

    def _find_held(self, armature: Object, depsgraph: Depsgraph) -> list[_Hold]:
        """What stays, and where: pinned bones, and ends of bones with targets."""
        skeleton = self._skeleton
        held = []
        for row, name in enumerate(skeleton.names):
            bone = armature.pose.bones[name]
            constraint = bones.follows_target(bone)
            if constraint is not None:
                part = Part.TAIL if constraint.use_tail else Part.HEAD
                place = bones.place_of_target(constraint, armature, depsgraph)
                held.append(_Hold(row, _points(skeleton, row, part)[0], place, True))
            elif bone.sinew.pin and row != self._row:
                points = _points(skeleton, row, Part.WHOLE)
                goals = frames.transformed(self._shown[row], points)
                held += [
                    _Hold(row, point, goal, k < 2)
                    for k, (point, goal) in enumerate(zip(points, goals, strict=True))
                ]
        return held

    def _choose_moving(self, armature: Object) -> None:
        """Let all bones turn that move something dragged or held, and roots move whose bones are held."""
        skeleton = self._skeleton
        count = len(skeleton.names)
        ends = {self._row, *(hold.row for hold in self._held)}
        active = sorted({row for end in ends for row in skeleton.chain(end)})
        self._locked = np.ones(count, dtype=bool)
        self._locked[active] = False
        held_roots = {list(skeleton.chain(hold.row))[-1] for hold in self._held}
        self._moving_roots = np.zeros(count, dtype=bool)
        for row in active:
            is_root = skeleton.bones.parents[row] < 0
            free = not any(armature.pose.bones[skeleton.names[row]].lock_location)
            self._moving_roots[row] = is_root and free and (row in held_roots or row == self._row)
        bones.require_plain(armature, self.moving)

    def _find_support(self) -> np.ndarray:
        """What the figure stands on: the ends of held bones."""
        points = np.array([hold.goal for hold in self._held if hold.is_end]).reshape(-1, 3)
        if len(points) >= 3:
            across = points - points.mean(axis=0)
            across -= np.outer(across @ self._up, self._up) / (self._up @ self._up)
            spread = np.linalg.svd(across, compute_uv=False)
            if spread[1] > _TOLERANCE * spread[0]:
                return points
        raise SinewError("Balance needs something to stand on - pin the bones of both feet first")

    def _write(self, armature: Object, found: Solution) -> None:
        skeleton = self._skeleton
        for name in self.moving:
            row, bone = skeleton.row(name), armature.pose.bones[name]
            joint = skeleton.bones.angles.get(row)
            if joint is not None and joint[2] == bone.rotation_mode:
                bone.rotation_euler = found.turns[row]
            else:
                _turn(bone, Matrix(found.rotations[row].tolist()), self._before[name])
            if self._moving_roots[row]:
                move = found.moves[row]
                if bone.bone.use_local_location:
                    move = skeleton.bones.axes[row].T @ move
                bone.location = move
            if name in self._images:
                image = armature.pose.bones[self._images[name]]
                _turn(image, _FLIP @ bone.matrix_basis @ _FLIP, self._before[image.name])
                image.location = (-bone.location.x, bone.location.y, bone.location.z)


def _points(skeleton: bones.Skeleton, row: int, part: Part) -> np.ndarray:
    """The points of a bone at rest (m, 3) that hold a part of it, its ends first.

    Two more beside its middle, as far from each other as its ends, hold a whole bone: nothing else would keep
    it from turning about its length.
    """
    data = skeleton.bones
    head, tail = data.heads[row], data.tails[row]
    aside = np.linalg.norm(tail - head) / 2.0 * data.axes[row][:, 0]
    middle = (head + tail) / 2.0
    whole = np.array((head, tail, middle - aside, middle + aside))
    return {Part.HEAD: whole[:1], Part.TAIL: whole[1:2], Part.WHOLE: whole}[part]


def _shown(skeleton: bones.Skeleton) -> list[np.ndarray]:
    """(k) matrices (4, 4) from the rest of each bone to where it is shown, in the frame of the armature."""
    shown: list[np.ndarray] = []
    data = skeleton.bones
    for row in range(len(skeleton.names)):
        own, head = np.eye(4), data.heads[row]
        own[:3, :3] = data.axes[row] @ skeleton.rotations[row] @ data.axes[row].T
        own[:3, 3] = head + skeleton.moves[row] - own[:3, :3] @ head
        shown.append(own if data.parents[row] < 0 else shown[data.parents[row]] @ own)
    return shown


def _has_other_constraints(bone: PoseBone) -> bool:
    """Whether Blender moves a bone by something that the solver does not know."""
    return any(
        limits.in_use(constraint) and constraint.type != "IK" and not limits.is_limit(constraint)
        for constraint in bone.constraints
    )


def _channels(bone: PoseBone) -> dict[str, tuple[float, ...]]:
    return {name: tuple(getattr(bone, name)) for name in _CHANNELS}


def _turn(bone: PoseBone, rotation: Matrix, before: dict[str, tuple[float, ...]]) -> None:
    """Write a rotation into the channels that the bone uses, close to what they said ``before``.

    Of equal rotations, the one that is closest to the last frame would depend on the way of the drag.
    """
    if bone.rotation_mode == "QUATERNION":
        turn = rotation.to_quaternion()
        turn.make_compatible(Quaternion(before["rotation_quaternion"]))
        bone.rotation_quaternion = turn
    elif bone.rotation_mode == "AXIS_ANGLE":
        axis, angle = rotation.to_quaternion().to_axis_angle()
        bone.rotation_axis_angle = (angle, *axis)
    else:
        mode = bone.rotation_mode
        bone.rotation_euler = rotation.to_euler(mode, Euler(before["rotation_euler"], mode))
