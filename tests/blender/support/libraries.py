# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that others link, append and override from."""

from pathlib import Path

import bpy
from inside import settle
from rigs.rig import new_file, save, update


def put_into_a_library(path: Path, *objects: bpy.types.Object) -> str:
    """In the collection ``Asset``; the open file is empty again."""
    collection = bpy.data.collections.new("Asset")
    bpy.context.scene.collection.children.link(collection)
    for obj in objects:
        collection.objects.link(obj)
    update()
    save(path)
    new_file()
    return str(path)


def read(path: str | Path, link: bool, kind: str = "collections", name: str = "Asset") -> bpy.types.ID:
    with bpy.data.libraries.load(str(path), link=link) as (_there, here):
        setattr(here, kind, [name])
    return getattr(here, kind)[0]


def add_collection(path: str, link: bool = False) -> bpy.types.Collection:
    collection = read(path, link)
    children = bpy.context.scene.collection.children
    if collection not in children.values():  # Blender 5 links a collection once
        children.link(collection)
    update()
    return collection


def override(path: str) -> bpy.types.Object:
    """A hierarchy override of the asset, as the outliner makes it; its target."""
    collection = add_collection(path, link=True)
    collection.override_hierarchy_create(bpy.context.scene, bpy.context.view_layer)
    settle()
    return overridden()


def overridden() -> bpy.types.Object:
    return next(obj for obj in bpy.data.objects if obj.override_library and obj.sinew.deformers)
