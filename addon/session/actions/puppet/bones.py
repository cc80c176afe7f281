# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads an armature as a skeleton: its bones at rest, where they are now, and what holds them."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from bpy.types import Bone, Constraint, Depsgraph, Object, PoseBone

from ....backend import Bones
from ....core.errors import ConstraintError, SinewError
from . import limits

_SCALED = 1e-3  # a bone is scaled if its axes are longer or shorter than 1 by more than this


@dataclass(frozen=True)
class Skeleton:
    """The bones of an armature in its own frame, parents first, as they are now.

    What moves a bone against its parent without turning it belongs to the rest: only turns are solved for,
    and moves of bones without a parent.
    """

    names: list[str]
    bones: Bones
    rotations: np.ndarray  # (k, 3, 3) of the joints, as shown now
    moves: np.ndarray  # (k, 3) of bones without a parent

    def row(self, name: str) -> int:
        """The number of a bone."""
        return self.names.index(name)

    def chain(self, row: int) -> Iterator[int]:
        """A bone, its parent, and so on."""
        while row >= 0:
            yield row
            row = int(self.bones.parents[row])


def require_bones(armature: Object | None) -> Object:
    """Refuse what is no armature with bones that may be posed."""
    if armature is None or armature.type != "ARMATURE":
        raise SinewError("Select an armature - a puppet is posed by its bones")
    if not armature.data.bones:
        raise ConstraintError(f"{armature.name} has no bones - add some in Edit Mode")
    if armature.library is not None:
        raise SinewError(f"{armature.name} is linked - make a library override first")
    if armature.mode == "EDIT":
        raise SinewError(f"{armature.name} is in Edit Mode - go to Pose Mode to pose its bones")
    return armature


def read_skeleton(armature: Object, depsgraph: Depsgraph) -> Skeleton:
    """The skeleton as it is shown."""
    evaluated = armature.evaluated_get(depsgraph)
    bones = [bone for root in armature.data.bones if root.parent is None for bone in _below(root)]
    names = [bone.name for bone in bones]
    rows = {name: row for row, name in enumerate(names)}
    count = len(bones)
    heads, tails, axes = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros((count, 3, 3))
    rotations, moves, shifts = np.zeros((count, 3, 3)), np.zeros((count, 3)), np.zeros((count, 3))
    parents = np.full(count, -1, dtype=np.int32)
    angles, stiffness = {}, np.ones(count)
    for row, bone in enumerate(bones):
        rest = _matrix(bone.matrix_local)
        shown = _matrix(evaluated.pose.bones[bone.name].matrix)
        if bone.parent is not None:
            parents[row] = rows[bone.parent.name]
            shown = (
                _matrix(bone.parent.matrix_local)
                @ np.linalg.inv(_matrix(evaluated.pose.bones[bone.parent.name].matrix))
                @ shown
            )
            shifts[row] = shifts[parents[row]]
        local = np.linalg.inv(rest) @ shown
        move = rest[:3, :3] @ local[:3, 3]
        if bone.parent is None:
            moves[row] = move
        else:
            shifts[row] += move
        axes[row] = _rotation(rest[:3, :3])  # Blender stores it in single precision
        rotations[row] = _rotation(local[:3, :3])
        heads[row] = np.array(bone.head_local) + shifts[row]
        tails[row] = np.array(bone.tail_local) + shifts[row]
        posed = armature.pose.bones[bone.name]
        stiffness[row] = limits.stiffness_of(posed)
        if (joint := limits.angles_of(posed)) is not None:
            angles[row] = joint
    return Skeleton(names, Bones(heads, tails, parents, axes, angles, stiffness), rotations, moves)


def require_plain(armature: Object, names: list[str]) -> None:
    """Refuse to turn bones that are scaled, or that do not turn with their parents."""
    scaled = [
        name
        for name in names
        if np.abs(np.array(armature.pose.bones[name].matrix.to_scale()) - 1.0).max() > _SCALED
    ]
    if scaled:
        raise ConstraintError(f"Scaled bones cannot be posed: {_some(scaled)} - clear their scale")
    apart = [
        name
        for name in names
        if armature.data.bones[name].parent is not None and not armature.data.bones[name].use_inherit_rotation
    ]
    if apart:
        raise ConstraintError(
            f"Bones that do not inherit rotation cannot be posed: {_some(apart)} - switch Inherit Rotation on"
        )


def follows_target(bone: PoseBone) -> Constraint | None:
    """The constraint of inverse kinematics that pulls a bone to a target, if any."""
    for constraint in bone.constraints:
        if constraint.type == "IK" and constraint.target is not None and limits.in_use(constraint):
            return constraint
    return None


def place_of_target(constraint: Constraint, armature: Object, depsgraph: Depsgraph) -> np.ndarray:
    """Where a constraint of inverse kinematics wants its bone (3,), in the frame of the armature."""
    target = constraint.target.evaluated_get(depsgraph)
    place = target.matrix_world
    if constraint.subtarget and target.pose is not None and constraint.subtarget in target.pose.bones:
        place = place @ target.pose.bones[constraint.subtarget].matrix
    return np.array(armature.matrix_world.inverted_safe() @ place.translation, dtype=np.float64)


def _below(bone: Bone) -> Iterator[Bone]:
    """A bone and all that hang on it, parents first."""
    waiting = [bone]
    while waiting:
        yield (found := waiting.pop())
        waiting.extend(found.children)


def _matrix(matrix) -> np.ndarray:
    return np.array(matrix, dtype=np.float64)


def _rotation(matrix: np.ndarray) -> np.ndarray:
    """The rotation closest to a matrix (3, 3)."""
    u, _s, v = np.linalg.svd(matrix)
    return u @ np.diag((1.0, 1.0, np.linalg.det(u @ v))) @ v


def _some(names: list[str]) -> str:
    more = f" and {len(names) - 4} more" if len(names) > 4 else ""
    return ", ".join(names[:4]) + more
