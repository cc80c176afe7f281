# SPDX-License-Identifier: GPL-3.0-or-later
"""All that is seen and listed of a file, to tell what a button, undo, or a refusal has changed."""

from collections.abc import Iterable, Iterator

import bpy
import numpy as np
from editing import edited
from rigs.rig import base_points, evaluated_points, update

BLOCKS = ("objects", "meshes", "curves", "lattices", "node_groups", "actions", "collections")
NEAR = 1e-5  # a pose that is solved once more


def plain(value: object) -> str:
    """Undo makes other Python objects of the same datablocks."""
    return value.name if isinstance(value, bpy.types.ID) else str(value)


def own_names(blocks: Iterable[bpy.types.ID]) -> Iterator[str]:
    """Of those in use, which a file keeps; the numbers of hidden ones may differ."""
    for block in blocks:
        if block.users:
            yield block.name.partition(".0")[0] if block.name.startswith(".Sinew") else block.name


def words() -> list[object]:
    """What the panel lists, and what there is in the file besides shapes."""
    update()
    found: list[object] = [sorted(own_names(getattr(bpy.data, kind))) for kind in BLOCKS]
    scene = bpy.context.scene
    found += [plain(bpy.context.view_layer.objects.active), scene.render.use_lock_interface]
    for obj in scene.objects:
        keys = getattr(obj.data, "shape_keys", None)
        found += [
            obj.name,
            obj.mode,
            obj.select_get(),
            [group.name for group in obj.vertex_groups],
            obj.vertex_groups.active_index,
            list(obj.modifiers.keys()),
            keys.key_blocks.keys() if keys else [],
            [layer.name for layer in getattr(obj.data, "color_attributes", ())],
            len(obj.animation_data.drivers) if obj.animation_data else 0,
        ]
        for row in obj.sinew.deformers:
            values = [plain(getattr(row.parameters, each.id)) for each in row.definition.parameters]
            found += [row.name, row.uid, row.method, row.is_bound and row.status_level, values]
            found += [(each.name, each.kind, each.vertex_group, plain(each.control)) for each in row.handles]
            found += [(plain(each.object), each.rest and len(each.rest.vertices)) for each in row.controls]
            found += [row.bake.result, [each.frame for each in row.keys]]
    return found


def shapes() -> Iterator[np.ndarray]:
    for obj in bpy.context.scene.objects:
        yield np.array(obj.matrix_world)
        if obj.mode == "EDIT":
            yield edited(obj)
        elif obj.type in ("MESH", "CURVE", "LATTICE"):
            yield evaluated_points(obj)
        if obj.type == "MESH":
            yield base_points(obj)
        for bone in obj.pose.bones if obj.pose else ():
            yield np.array(bone.matrix)


def seen() -> tuple[list, list]:
    return words(), list(shapes())


def assert_seen(expected: tuple[list, list]) -> None:
    assert words() == expected[0]
    for found, shape in zip(shapes(), expected[1], strict=True):
        np.testing.assert_allclose(found, shape, rtol=0.0, atol=NEAR)
