# SPDX-License-Identifier: GPL-3.0-or-later
"""What the sessions work on, and what the window shows of it."""

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
from rigs.rig import add_group, linked

MODELS = Path(__file__).resolve().parents[2] / "blend_samples" / "models"

Regions = dict[str, tuple[str, Callable[[np.ndarray], bool]]]  # by name: the kind, and which points


def empty_scene() -> None:
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)


def new_camera(resolution: int) -> bpy.types.Object:
    scene = bpy.context.scene
    scene.camera = linked(bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera")))
    scene.render.resolution_x = scene.render.resolution_y = resolution
    return scene.camera


def only_head(size: float = 2.0) -> bpy.types.Object:
    empty_scene()
    bpy.ops.mesh.primitive_monkey_add(size=size)
    bpy.context.object.name = "Head"
    return bpy.context.object


def smooth_head(levels: int, regions: Regions | None = None) -> None:
    """A smooth head alone in the scene, three units wide, subdivided."""
    obj = only_head(3.0)
    obj.modifiers.new("Subdivision", "SUBSURF").levels = levels
    bpy.ops.object.modifier_apply(modifier="Subdivision")
    bpy.ops.object.shade_smooth()
    for name, (kind, where) in (regions or {}).items():
        add_group(obj, name, where)
        bpy.context.view_layer.objects.active = obj
        bpy.ops.sinew.handle_add(kind=kind, vertex_group=name)
    bpy.context.view_layer.objects.active = obj
    bpy.ops.ed.undo_push(message="Head")


def head() -> bpy.types.Object:
    return bpy.data.objects["Head"]


def deformer():
    return head().sinew.active


def heavy_grid(method: str, size: float) -> bpy.types.Object:
    """160,801 vertices in a plane as the head, fixed at the right, with a group for a handle at the left."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=400, y_subdivisions=400, size=size)
    obj = bpy.context.object
    obj.name = "Head"
    add_group(obj, "Left", lambda point: point[0] < -0.4 * size)
    add_group(obj, "Right", lambda point: point[0] > 0.4 * size)
    bpy.ops.sinew.deformer_add(method=method)
    bpy.ops.sinew.handle_add(kind="FIXED", vertex_group="Right")
    return obj


def shown(obj: bpy.types.Object | None = None) -> np.ndarray:
    """What the window shows of a mesh, or of the head, (n, 3), in its own space, as it was evaluated last."""
    evaluated = (obj or head()).evaluated_get(bpy.context.evaluated_depsgraph_get())
    flat = np.empty(len(evaluated.data.vertices) * 3, dtype=np.float32)
    evaluated.data.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)
