# SPDX-License-Identifier: GPL-3.0-or-later
"""Flat, noise-free pictures of a scene by NumPy: quicker than Cycles where a picture has a hundred objects.

The camera is orthographic and looks along y. Each object is drawn on a tile of its own with a depth buffer,
with several samples per pixel, and then laid over the picture; objects do not cross each other.
"""

from __future__ import annotations

import bpy
import numpy as np

from ..materials import FIXED_COLOUR, HANDLE_COLOUR

PAPER = np.array((0.90, 0.90, 0.885), np.float32)
INK = np.array((0.012, 0.012, 0.015))
PLAIN, INSIDE = np.array((0.70, 0.66, 0.58)), np.array((0.30, 0.10, 0.22))
KEY = np.array((-0.62, -0.52, 0.59)) / np.linalg.norm((-0.62, -0.52, 0.59))
SAMPLES = 3  # across a pixel


def draw(scene: bpy.types.Scene) -> np.ndarray:
    """What the camera sees: linear light (height, width, 3), the lowest line first as in Blender's images."""
    width, height = scene.render.resolution_x, scene.render.resolution_y
    camera = scene.camera
    unit = max(width, height) / camera.data.ortho_scale
    corner = np.array(camera.location)[[0, 2]] - 0.5 * np.array((width, height)) / unit
    picture = np.tile(PAPER, (height, width, 1))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for obj in scene.objects:
        if obj.type not in {"MESH", "FONT"} or obj.name.startswith("Wall"):
            continue
        mesh = obj.evaluated_get(depsgraph).to_mesh()
        mesh.calc_loop_triangles()
        points, corners, normals = _arrays(mesh)
        if len(corners):
            points = points @ np.array(obj.matrix_world)[:3, :3].T + np.array(obj.matrix_world)[:3, 3]
            seen = np.column_stack(((points[:, [0, 2]] - corner) * unit, points[:, 1]))
            inside = (seen[:, :2].max(0) > 0).all() and (seen[:, :2].min(0) < (width, height)).all()
            if inside:
                colours = None if obj.type == "FONT" else _colours(mesh)
                _draw_tile(picture, seen, corners, normals, colours)
        obj.evaluated_get(depsgraph).to_mesh_clear()
    return picture


def _arrays(mesh: bpy.types.Mesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points (n, 3), corners of triangles (t, 3) and the normals of these corners (t, 3, 3)."""
    points = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    corners = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", corners)
    loops = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("loops", loops)
    mesh.calc_normals_split()
    normals = np.empty(3 * len(mesh.loops), np.float32)
    mesh.loops.foreach_get("normal", normals)
    split = normals.reshape(-1, 3)[loops].reshape(-1, 3, 3)
    return points.reshape(-1, 3).astype(float), corners.reshape(-1, 3), split


def _colours(mesh: bpy.types.Mesh) -> np.ndarray:
    """What is painted, (n, 3): how far in the fixed region, how far in the handle, and a height for lines."""
    found = np.empty((3, len(mesh.vertices)), np.float32)
    for row, name in zip(found, ("fixed", "handle")):
        mesh.attributes[name].data.foreach_get("value", row)
    rest = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.attributes["rest"].data.foreach_get("vector", rest)
    found[2] = rest[0::3]
    return found.T


def _draw_tile(
    picture: np.ndarray,
    seen: np.ndarray,
    corners: np.ndarray,
    normals: np.ndarray,
    painted: np.ndarray | None,
) -> None:
    """Lay one object over the picture. ``seen`` (n, 3): pixels to the right, pixels upwards, depth."""
    samples = SAMPLES if painted is not None else SAMPLES + 1
    low = np.clip(np.floor(seen[:, :2].min(0)).astype(int), 0, None)
    high = np.minimum(np.ceil(seen[:, :2].max(0)).astype(int) + 1, picture.shape[1::-1])
    width, height = (high - low) * samples
    if width <= 0 or height <= 0:
        return
    place = (seen[:, :2] - low) * samples
    triangle, across, up, share = fragments(place[corners], width, height)
    depth = (share * seen[corners, 2][triangle]).sum(1)
    order = np.argsort(-depth, kind="stable")  # the nearest is written last
    owner = np.full(width * height, -1)
    owner[(up * width + across)[order]] = order
    covered = owner >= 0
    front = owner[covered]
    tile = np.zeros((width * height, 3))
    tile[covered] = (
        INK
        if painted is None
        else _shaded(
            np.einsum("fk,fkc->fc", share[front], normals[triangle[front]]),
            np.einsum("fk,fkc->fc", share[front], painted[corners][triangle[front]]),
        )
    )
    shape = (height // samples, samples, width // samples, samples)
    cover = covered.reshape(shape).mean((1, 3))[..., None]
    light = tile.reshape(*shape, 3).mean((1, 3))
    window = picture[low[1] : high[1], low[0] : high[0]]
    window *= 1.0 - cover
    window += light


def fragments(
    place: np.ndarray, width: int, height: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """The samples in triangles ``place`` (t, 3, 2), in samples: of which triangle, where, and its shares.

    Triangles (f,), columns (f,), lines (f,), and barycentric coordinates (f, 3).
    """
    low = np.clip(np.ceil(place.min(1) - 0.5).astype(int), 0, (width, height))
    high = np.clip(np.floor(place.max(1) - 0.5).astype(int) + 1, low, (width, height))
    size = high - low
    count = size[:, 0] * size[:, 1]
    triangle = np.repeat(np.arange(len(place)), count)
    within = np.arange(len(triangle)) - np.repeat(np.cumsum(count) - count, count)
    across = low[triangle, 0] + within % size[triangle, 0]
    up = low[triangle, 1] + within // size[triangle, 0]
    point = np.stack((across, up), 1) + 0.5
    a, b, c = (place[triangle, k] for k in range(3))
    area = _cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.stack((_cross(b - point, c - point), _cross(c - point, a - point)), 1) / area[:, None]
    share = np.column_stack((share, 1.0 - share.sum(1)))
    hit = (share >= -1e-9).all(1)
    return triangle[hit], across[hit], up[hit], share[hit]


def _cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]


def _shaded(normal: np.ndarray, painted: np.ndarray) -> np.ndarray:
    """Light (f, 3) of samples with normals (f, 3); the inner side of a surface is dark red."""
    normal = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-9)[:, None]
    behind = normal[:, 1] > 0.0  # seen along y
    normal = np.where(behind[:, None], -normal, normal)
    colour = np.where(behind[:, None], INSIDE, PLAIN)
    colour[(painted[:, 0] > 0.0) & ~behind] = FIXED_COLOUR
    colour[(painted[:, 1] > 0.0) & ~behind] = HANDLE_COLOUR
    line = np.abs(painted[:, 2] / 0.5 - np.round(painted[:, 2] / 0.5)) < 0.045
    colour = np.where(line[:, None], 0.45 * colour, colour)
    key, sky = np.maximum(normal @ KEY, 0.0), 0.5 + 0.5 * normal[:, 2]
    facing = 0.55 + 0.45 * np.minimum(1.0, -1.6 * normal[:, 1])  # darker towards the outline
    return colour * ((0.12 + 0.20 * sky + 0.85 * key**1.3) * facing)[:, None]
