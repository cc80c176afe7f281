# SPDX-License-Identifier: GPL-3.0-or-later
"""The files that an animation is read from, and the frames that are missing in them.

Blender shows the nearest frame that there is, or the shape before the modifier, and says nothing.
"""

import os
import re
import struct
from collections.abc import Iterable, Iterator

import bpy
from bpy.types import Modifier, Object, Scene

from ..properties import SinewDeformer
from ..session.targets import modified
from .stretching import times

_MAGIC = b"POINTCACHE2\0"
_NUMBER = re.compile(r"(\d+)(?=\D*$)")  # of a file in a sequence of files


def missing_frames(
    scene: Scene, obj: Object, deformer: SinewDeformer, frames: Iterable[int]
) -> tuple[str, ...]:
    """A line per file of an animation that is missing, or lacks some of these frames of the scene.

    None where the method of the deformer edits no animations.
    """
    if not deformer.definition.keyed:
        return ()
    ours = modified.shown_by(obj, deformer)
    lines: list[str] = []
    timed = dict(zip(frames, times(scene, frames).tolist(), strict=True))
    for modifier in obj.modifiers:
        if modifier == ours:
            break
        if modifier.show_viewport or modifier.show_render:
            lines += _lacks(modifier, timed)
    return tuple(lines)


def _lacks(modifier: Modifier, timed: dict[int, float]) -> Iterator[str]:
    """``timed`` has the time of each frame."""
    if modifier.type == "MESH_CACHE":
        yield from _of_point_cache(modifier, timed)
    elif modifier.type == "MESH_SEQUENCE_CACHE":
        yield from _of_alembic(modifier, timed)


def _of_point_cache(modifier: Modifier, timed: dict[int, float]) -> Iterator[str]:
    path = bpy.path.abspath(modifier.filepath)
    name = os.path.basename(path)
    if not os.path.isfile(path):
        yield f"{modifier.name}: {_there_is_no(name)}, so nothing moves the mesh - choose the file there"
        return
    count = _samples(path)
    if count is None:
        yield f"{modifier.name}: {name} is no PC2 or MDD file - choose another one there"
        return
    if modifier.play_mode != "SCENE" or modifier.time_mode != "FRAME":
        return  # it says itself which frame is shown, or the file is spread over the time
    missing = [
        frame
        for frame, time in timed.items()
        if not 0 <= modifier.frame_scale * time - modifier.frame_start <= count - 1
    ]
    if missing:
        yield f"{modifier.name}: {name} has no {_listed(missing)} - its nearest frame is edited there"


def _samples(path: str) -> int | None:
    """How many frames a point cache holds; None if it is none."""
    try:
        with open(path, "rb") as file:
            head = file.read(32)
    except OSError:
        return None
    if path.lower().endswith(".mdd"):
        return struct.unpack(">i", head[:4])[0] if len(head) >= 8 else None
    return struct.unpack("<i", head[28:32])[0] if head.startswith(_MAGIC) and len(head) == 32 else None


def _of_alembic(modifier: Modifier, timed: dict[int, float]) -> Iterator[str]:
    cache = modifier.cache_file
    if cache is None:
        yield f"{modifier.name}: no file is chosen, so nothing moves the mesh - choose one there"
        return
    path = bpy.path.abspath(cache.filepath)
    folder, name = os.path.split(path)
    if not cache.is_sequence:
        if not os.path.isfile(path):
            yield f"{modifier.name}: {_there_is_no(name)}, so nothing moves the mesh - choose the file there"
        return
    digits = _NUMBER.search(name)
    if digits is None or cache.override_frame:
        return
    there = set(os.listdir(folder)) if os.path.isdir(folder) else set()

    def file_of(time: float) -> str:
        number = f"{int(time) - round(cache.frame_offset):0{len(digits[0])}d}"
        return name[: digits.start()] + number + name[digits.end() :]

    missing = [frame for frame, time in timed.items() if file_of(time) not in there]
    if missing:
        first = file_of(timed[missing[0]])
        yield f"{modifier.name}: {first} is missing, for {_listed(missing)} - put the files there"


def _there_is_no(name: str) -> str:
    return f"the file {name} is missing" if name else "no file is chosen"


def _listed(frames: Iterable[int]) -> str:
    """ "frame 5" or "frames 61 to 250, 260": runs of frames, at most three of them."""
    runs: list[list[int]] = []
    for frame in frames:
        if runs and frame == runs[-1][1] + 1:
            runs[-1][1] = frame
        else:
            runs.append([frame, frame])
    texts = [str(first) if first == last else f"{first} to {last}" for first, last in runs[:3]]
    several = len(runs) > 1 or runs[0][0] != runs[0][1]
    return ("frames " if several else "frame ") + ", ".join(texts) + (" and more" if len(runs) > 3 else "")
