# SPDX-License-Identifier: GPL-3.0-or-later
"""What artists move and key of controls: objects and bones."""

from collections.abc import Mapping, Sequence

from bpy.types import Object, PoseBone
from mathutils import Matrix

from ..datablocks import own_shape
from ..datablocks.transforms import put
from .locks import hold_locked

CHANNELS = ("location", "rotation_euler", "rotation_quaternion", "rotation_axis_angle", "scale")


def mover_of(control: Object, bone: str) -> Object | PoseBone:
    """The object, or its bone of this name."""
    return control.pose.bones[bone] if bone else control


def channels_of(mover: Object | PoseBone) -> dict[str, tuple[float, ...]]:
    """What a mover is transformed by now."""
    return {name: tuple(getattr(mover, name)) for name in CHANNELS}


def move_to(
    control: Object, bone: str, place: Matrix, before: Mapping[str, Sequence[float]] | None = None
) -> None:
    """Move an object or its bone to a ``place`` in the world.

    Locked channels stay as they were ``before``, which is now if nothing else is given.
    """
    mover = mover_of(control, bone)
    before = channels_of(mover) if before is None else before
    if bone:
        mover.matrix = control.matrix_world.inverted_safe() @ place
    else:
        mover.matrix_world = place
    put(mover, mover.matrix_basis.copy())
    hold_locked(mover, before)


def move_by_itself(mover: Object | PoseBone, basis: Matrix) -> None:
    """Give a mover a transform of its own. Locked channels stay."""
    before = channels_of(mover)
    put(mover, basis)
    hold_locked(mover, before)


def rotation_channel(mover: Object | PoseBone) -> str:
    """The channel that turns it, by its rotation mode."""
    mode = mover.rotation_mode
    return f"rotation_{mode.lower()}" if mode in ("QUATERNION", "AXIS_ANGLE") else "rotation_euler"


def insert_keyframes(control: Object, bone: str) -> None:
    """Key an object or its bone where it is in this frame; of an object also the values of its shape keys."""
    mover = mover_of(control, bone)
    for channel in ("location", rotation_channel(mover), "scale"):
        mover.keyframe_insert(channel, group=bone)
    for key in () if bone else own_shape.keys_of(control):
        key.keyframe_insert("value")
