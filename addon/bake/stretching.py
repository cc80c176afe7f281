# SPDX-License-Identifier: GPL-3.0-or-later
"""The times at which Blender plays the frames of a scene: Time Stretching, in the Format panel, scales them.

Keyframes, caches and sequences of files are read at these times. Without stretching they are the frames.
"""

from collections.abc import Iterable

import numpy as np
from bpy.types import Scene


def stretch(scene: Scene) -> np.float32:
    """How much time passes from one frame to the next."""
    return np.float32(scene.render.frame_map_old) / np.float32(scene.render.frame_map_new)


def frame_at(scene: Scene, time: float) -> tuple[int, float]:
    """The frame of the scene that plays at a time, and how much of the next frame."""
    frame, subframe = divmod(round(time / float(stretch(scene)), 4), 1.0)
    return int(frame), subframe


def times(scene: Scene, frames: Iterable[int]) -> np.ndarray:
    """The time of each frame, float32 (n,), with the last bit as Blender has it."""
    return np.fromiter(frames, dtype=np.float32) * stretch(scene)
