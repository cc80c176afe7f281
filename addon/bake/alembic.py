# SPDX-License-Identifier: GPL-3.0-or-later
"""Export to Alembic by Blender's own exporter: the result that renders show, with all modifiers."""

import contextlib
from collections.abc import Iterator

import bpy
from bpy.types import Context, Object

from ..core.errors import SinewError
from ..session.targets import targets
from . import files, paths


def can_write_alembic() -> bool:
    """Whether this Blender can write Alembic files; some Linux distributions leave this out."""
    return bool(bpy.app.build_options.alembic)


def require_exportable(objects: list[Object], frames: range) -> None:
    """Raise an error if Blender cannot export these objects as they are shown."""
    if not can_write_alembic():
        raise SinewError("This Blender was built without Alembic - bake to PC2 or MDD instead")
    if frames.step != 1:
        raise SinewError("Alembic files hold every frame - set Step to 1")
    for obj in objects:
        if not targets.is_exported(obj):
            raise SinewError(
                f"Blender exports a {targets.label(obj)} object without its modifiers - convert {obj.name} "
                "to a mesh"
            )
        if not obj.visible_get():
            raise SinewError(f"{obj.name} is hidden - show the object and its collection to export it")
        if obj.hide_render or obj.hide_select:
            raise SinewError(
                f"{obj.name} is hidden in renders, or cannot be selected - allow both to export it"
            )


def export_alembic(context: Context, objects: list[Object], frames: range, chosen: str) -> str:
    """Write the objects into one file, and return its path."""
    require_exportable(objects, frames)
    path = paths.absolute(paths.choose(objects[0], objects[0].sinew.active, "ALEMBIC", chosen))
    with files.replacing(path) as part, _only_selected(context, objects):
        bpy.ops.wm.alembic_export(
            filepath=str(part),
            start=frames[0],
            end=frames[-1],
            selected=True,
            apply_subdiv=True,
            as_background_job=False,
            check_existing=False,
        )
    return str(path)


@contextlib.contextmanager
def _only_selected(context: Context, objects: list[Object]) -> Iterator[None]:
    """Select only these objects, which the exporter then writes; restore selection and frame afterwards."""
    scene, layer = context.scene, context.view_layer
    before = {obj.name: obj.select_get() for obj in layer.objects}
    frame, subframe = scene.frame_current, scene.frame_subframe
    try:
        for obj in layer.objects:
            obj.select_set(obj in objects)
        yield
    finally:
        for obj in layer.objects:
            obj.select_set(before.get(obj.name, False))
        scene.frame_set(frame, subframe=subframe)
