# SPDX-License-Identifier: GPL-3.0-or-later
"""The Mesh Cache modifier that plays a file instead of a deformer."""

from typing import NamedTuple

import numpy as np
from bpy.types import Modifier, Object, Scene

from .. import compat
from ..core.errors import SinewError
from ..properties import SinewDeformer
from ..session.datablocks.shapes import baked
from ..session.targets import modified
from .stretching import stretch, times

_SNAP = 1e-4  # in samples: if a frame is at most this far after a sample, Blender does not interpolate
_ROUNDINGS = (0, 1, -1, 2, -2)  # by how many last bits the scale may differ from the nearest number


class Timing(NamedTuple):
    """``frame_scale`` and ``frame_start`` of a modifier."""

    scale: float
    start: float


def timing(scene: Scene, frames: range) -> Timing:
    """Lets a modifier play sample k at frame ``frames[k]`` of the scene, to the last bit.

    Blender computes the sample in float32, as time * scale - start. It interpolates between two samples
    unless the result is a whole number, or very little more. So the start is the largest with which none is
    less.
    """
    at, wanted = times(scene, frames), np.arange(len(frames), dtype=np.float32)
    nearest = 1.0 / (frames.step * float(stretch(scene)))
    for bits in _ROUNDINGS:
        scale = np.float32(nearest * (1.0 + bits * np.finfo(np.float32).eps))
        scaled = scale * at
        most = (scaled.astype(np.float64) - wanted).min()
        start = np.float32(most)
        if start > most:
            start = np.nextafter(start, np.float32(-np.inf))
        samples = scaled - start
        if np.array_equal(np.floor(samples), wanted) and (samples - wanted <= _SNAP).all():
            return Timing(float(scale), float(start))
    if stretch(scene) != 1.0:
        raise SinewError(
            f"The Mesh Cache modifier cannot play frame {frames.start} to {frames[-1]} exactly with this "
            "Time Stretching - bake fewer frames, bake to shape keys, or stretch by 50, 200 or 400"
        )
    raise SinewError(
        f"The Mesh Cache modifier cannot play every {frames.step}th frame exactly from frame {frames.start} "
        f"to {frames[-1]} - use a step of 1, 2 or 4"
    )


def insert(obj: Object, deformer: SinewDeformer) -> str:
    """Add a modifier right after the deformer's, which does nothing yet, and return its name."""
    modifier = obj.modifiers.new(f"{deformer.name} Cache", "MESH_CACHE")
    modifier.show_viewport = modifier.show_render = False
    place = list(obj.modifiers).index(modified.shown_by(obj, deformer)) + 1
    if not compat.move_modifier(obj, modifier.name, place):
        obj.modifiers.remove(modifier)
        raise SinewError(
            f"Blender allows no Mesh Cache modifier right after {deformer.name} - move {deformer.name} down "
            "first"
        )
    return modifier.name


def play(
    obj: Object, deformer: SinewDeformer, modifier: Modifier, target: str, filepath: str, timed: Timing
) -> None:
    """Let the modifier play a file wherever the deformer's modifier was shown."""
    play_file(modifier, target, filepath, timed)
    replaced = modified.shown_by(obj, deformer)
    for flag in ("show_viewport", "show_render", "show_in_editmode", "show_on_cage"):
        setattr(modifier, flag, getattr(replaced, flag))
    deformer.bake.modifier = modifier.name


def play_file(modifier: Modifier, target: str, filepath: str, timed: Timing) -> None:
    """Let the modifier replace all vertices by those of a file, exactly at each of its frames."""
    modifier.cache_format, modifier.filepath = target, filepath
    modifier.frame_scale, modifier.frame_start = timed
    modifier.deform_mode, modifier.interpolation = "OVERWRITE", "LINEAR"
    modifier.play_mode, modifier.time_mode = "SCENE", "FRAME"
    for name in ("forward_axis", "up_axis", "flip_axis", "factor", "vertex_group"):
        modifier.property_unset(name)


def remove(obj: Object, deformer: SinewDeformer) -> None:
    """Remove the modifier."""
    modifier = baked.find_cache(obj, deformer)
    if modifier is not None:
        obj.modifiers.remove(modifier)
    deformer.bake.modifier = ""
