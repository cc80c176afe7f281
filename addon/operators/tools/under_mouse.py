# SPDX-License-Identifier: GPL-3.0-or-later
"""What lies under the mouse in a 3D Viewport: a surface, a point, a bone, or a part of a control."""

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from bpy.types import Context, Object, SpaceView3D
from bpy_extras import view3d_utils

from ... import compat
from ...core.geometry import frames
from ...session.actions import control_drag
from ...session.controls import kinds
from ...session.datablocks import surface
from ...session.datablocks.surface import Hit

_BONE_WIDTH, _THINNEST_BONE = 0.1, 10.0  # of the length of a bone; pixels
_AS_NEAR = 10.0  # pixels: of places so much farther from the mouse, the first one is meant


def surface_under(context: Context, x: float, y: float) -> Hit | None:
    """The surface that a 3D Viewport shows at a pixel of the window; None if there is none."""
    origin, direction = sight(context, x, y)
    shows = partial(_is_shown_in, context.space_data)
    return surface.first_hit(context.evaluated_depsgraph_get(), np.array(origin), np.array(direction), shows)


def beside_ray(context: Context, origin: np.ndarray, direction: np.ndarray, radius: float) -> Hit | None:
    """The point of a curve, text, hair or cloud that is nearest to a line of sight, within a radius."""
    along = direction / np.linalg.norm(direction)

    def apart(places: np.ndarray) -> np.ndarray:
        away = places - origin
        depth = away @ along
        return np.where(depth > 0.0, np.linalg.norm(away - depth[:, None] * along, axis=1), np.inf)

    return _nearest(context, along, is_shown, apart, radius)


def beside_mouse(context: Context, x: float, y: float, pixels: float) -> Hit | None:
    """The point of a curve, text, hair or cloud that the viewport shows nearest to a pixel of the window."""

    def apart(places: np.ndarray) -> np.ndarray:
        return np.linalg.norm(on_screen(context, places)[:, :2] - (x, y), axis=1)

    direction = np.array(sight(context, x, y)[1])
    return _nearest(context, direction, partial(_is_shown_in, context.space_data), apart, pixels)


def anything_under(context: Context, x: float, y: float, pixels: float) -> Hit | None:
    """The surface under the mouse, or else the point of a curve, text, hair or cloud within some pixels."""
    return surface_under(context, x, y) or beside_mouse(context, x, y, pixels)


def on_screen(context: Context, places: np.ndarray) -> np.ndarray:
    """Where places (n, 3) of the world are shown: pixels of the window, and the depth, (n, 3).

    Pixels of what lies behind the viewer are infinite.
    """
    region, matrix = context.region, np.array(context.region_data.perspective_matrix)
    seen = np.column_stack((places, np.ones(len(places)))) @ matrix.T
    with np.errstate(divide="ignore", invalid="ignore"):
        at = (0.5 + 0.5 * seen[:, :2] / seen[:, 3:]) * (region.width, region.height)
    at[seen[:, 3] <= 0.0] = np.inf
    return np.column_stack((at + (region.x, region.y), seen[:, 3]))


class Bone(NamedTuple):
    """A pose bone, and its ``ends`` (2, 3) in the world."""

    armature: Object
    name: str
    ends: np.ndarray


def bone_under(context: Context, x: float, y: float) -> Bone | None:
    """The visible bone at a pixel of the window, of armatures in Pose Mode or else of all that are shown."""
    is_posing, found = context.mode == "POSE", []
    for armature in context.view_layer.objects:
        if armature.type != "ARMATURE" or not _is_shown_in(context.space_data, armature):
            continue
        bones = [bone for bone in armature.pose.bones if compat.is_bone_visible(armature, bone.name)]
        if (is_posing and armature.mode != "POSE") or not bones:
            continue
        world = np.array(armature.matrix_world, dtype=np.float64)
        ends = frames.transformed(
            world, np.array([(*bone.head, *bone.tail) for bone in bones]).reshape(-1, 3)
        )
        beyond = _beyond_bones(on_screen(context, ends)[:, :2].reshape(-1, 2, 2), np.array((x, y)))
        nearest = int(np.argmin(beyond))
        if beyond[nearest] <= 0.0:
            bone = Bone(armature, bones[nearest].name, ends[2 * nearest : 2 * nearest + 2])
            found.append((beyond[nearest], bone))
    return min(found, key=lambda row: row[0])[1] if found else None


def _beyond_bones(ends: np.ndarray, mouse: np.ndarray) -> np.ndarray:
    """How far the mouse is from bones (n, 2, 2) on the screen, less how wide they are drawn, (n,)."""
    heads, along = ends[:, 0], ends[:, 1] - ends[:, 0]
    with np.errstate(invalid="ignore", divide="ignore"):
        lengths = np.linalg.norm(along, axis=1)
        share = np.clip(((mouse - heads) * along).sum(axis=1) / lengths**2, 0.0, 1.0)
        nearest = heads + np.where(lengths > 0.0, share, 0.0)[:, None] * along
        beyond = np.linalg.norm(mouse - nearest, axis=1) - np.maximum(_BONE_WIDTH * lengths, _THINNEST_BONE)
    return np.where(np.isfinite(beyond), beyond, np.inf)


def grip_under(
    context: Context, obj: Object, x: float, y: float, limit: float = math.inf
) -> control_drag.Grip | None:
    """The part of the controls of the active deformer that is nearest to a pixel, within ``limit`` pixels."""
    depsgraph = context.evaluated_depsgraph_get()
    grips = [
        grip
        for grip in control_drag.grips(obj, obj.sinew.active, depsgraph)
        if _is_shown_in(context.space_data, grip.control)
    ]
    if not grips:
        return None
    at = on_screen(context, np.array([grip.place for grip in grips]))
    distances = np.linalg.norm(at[:, :2] - (x, y), axis=1)
    nearest = float(distances.min())
    if not nearest <= limit or not math.isfinite(nearest):
        return None
    return grips[int(np.argmin(np.where(distances <= nearest + _AS_NEAR, at[:, 2], np.inf)))]


def _nearest(
    context: Context,
    direction: np.ndarray,
    shows: Callable[[Object], bool],
    apart: Callable[[np.ndarray], np.ndarray],
    limit: float,
) -> Hit | None:
    """As ``session.nearest_point``; what controls a deformer, such as a wire, is no target."""
    return surface.nearest_point(
        context.evaluated_depsgraph_get(),
        direction,
        lambda obj: shows(obj) and kinds.posed_by(obj) is None,
        apart,
        limit,
    )


def is_shown(obj: Object) -> bool:
    return obj.visible_get()


def _is_shown_in(space: SpaceView3D, obj: Object) -> bool:
    return obj.visible_in_viewport_get(space)


def sight(context: Context, x: float, y: float) -> tuple[tuple, tuple]:
    """The line of sight at a pixel of the window: its origin and its direction."""
    region, view = context.region, context.region_data
    pixel = (x - region.x, y - region.y)
    direction = view3d_utils.region_2d_to_vector_3d(region, view, pixel)
    return tuple(view3d_utils.region_2d_to_origin_3d(region, view, pixel)), tuple(direction)
