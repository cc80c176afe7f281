# SPDX-License-Identifier: GPL-3.0-or-later
"""The Bake sub-panel: where the shapes are written, which frames are baked, and Unbake."""

import bpy
from bpy.types import Context, Object, Panel, UILayout
from bpy.utils import register_classes_factory

from .. import bake
from ..ids import Operators
from ..operators import target_of
from ..properties import BAKE_TARGETS, SinewDeformer
from ..session.targets.targets import can_be_converted, is_exported, is_mesh, label
from .layouts import fields
from .places import ROOT, SidebarPanel
from .text import draw_text

_LABELS = {identifier: label for identifier, label, *_rest in BAKE_TARGETS}
_BYTES = 12  # per vertex of a shape key or of a cached frame


class SINEW_PT_bake(SidebarPanel, Panel):
    """Store shapes that play without the add-on"""

    bl_label = "Bake"
    bl_parent_id = ROOT
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 30

    @classmethod
    def poll(cls, context: Context) -> bool:
        obj = target_of(context)
        return obj is not None and obj.library is None and obj.sinew.active is not None

    def draw(self, context: Context) -> None:
        obj = target_of(context)
        deformer = obj.sinew.active
        layout = fields(context, self.layout)
        if not is_mesh(obj):
            _draw_export(context, layout, obj, deformer)
            return
        if deformer.bake.is_baked:
            _draw_baked(context, layout, deformer)
        _draw_settings(context, layout, obj, deformer)
        _draw_buttons(context, layout, obj, deformer)


def _draw_baked(context: Context, layout: UILayout, deformer: SinewDeformer) -> None:
    """Draw what is baked, and Unbake."""
    settings = deformer.bake
    box = layout.box().column()
    draw_text(context, box, f"{settings.summary} to {_LABELS[settings.result]}", "CHECKMARK")
    if settings.result in ("PC2", "MDD"):
        path = box.row()
        path.active = False
        path.label(text=bpy.path.basename(settings.filepath), icon="BLANK1")
    box.operator(Operators.UNBAKE, icon="LOOP_BACK")


def _draw_export(context: Context, layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
    """Draw the panel for an object that is not a mesh, which can be baked to Alembic at most."""
    text = f"Only meshes can be baked, and this is a {label(obj)} object - convert it to a mesh first"
    if not can_be_converted(obj):
        text = "Only meshes can be baked - export what the lattice moves, or apply shapes as shape keys"
    if is_exported(obj) and bake.can_write_alembic():
        text = f"A {label(obj)} object can be baked to Alembic only"
        _bake(context, layout, deformer, "Bake to Alembic", "RENDER_ANIMATION").target = "ALEMBIC"
    draw_text(context, layout, text, "INFO")


def _draw_settings(context: Context, layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
    settings = deformer.bake
    targets = layout.grid_flow(columns=2, row_major=True, even_columns=True, align=True)
    targets.use_property_split = False
    for identifier in _LABELS:
        button = targets.row(align=True)
        button.enabled = identifier != "ALEMBIC" or bake.can_write_alembic()
        button.prop_enum(settings, "target", identifier)
    source = settings if settings.custom_range else context.scene
    layout.prop(settings, "custom_range")
    frames = layout.column(align=True)
    frames.enabled = settings.custom_range
    frames.prop(source, "frame_start", text="Start")
    frames.prop(source, "frame_end", text="End")
    if settings.wanted != "ALEMBIC":
        layout.prop(settings, "step")
    if settings.wanted == "SHAPE_KEYS":
        layout.prop(settings, "exact_keys")
        vertices = len(obj.data.vertices)
        draw_text(
            context, layout, f"{_count(source, settings.step):,} keys, {_size(source, settings, vertices)}"
        )
    elif bpy.data.filepath:
        draw_text(context, layout, "Written to the folder sinew_cache beside the file", "FILE_FOLDER")
    else:
        draw_text(context, layout, "Save the file first, or choose a path", "INFO")


def _count(frames: object, step: int) -> int:
    return len(range(frames.frame_start, frames.frame_end + 1, max(step, 1)))


def _size(frames: object, settings: object, vertices: int) -> str:
    return f"{_count(frames, settings.step) * vertices * _BYTES / 1e6:,.1f} MB"


def _draw_buttons(context: Context, layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
    settings = deformer.bake
    column = layout.column(align=True)
    row = column.row(align=True)
    text = "Bake Again" if settings.is_baked else "Bake"
    _bake(context, row, deformer, text=text, icon="RENDER_ANIMATION")
    if settings.wanted != "SHAPE_KEYS":
        _bake(context, row, deformer, text="", icon="FILE_FOLDER").choose_path = True
    if len(obj.sinew.deformers) > 1:
        _bake(context, column, deformer, text="Bake All Deformers", icon="NONE").all_deformers = True


def _bake(context: Context, layout: UILayout, deformer: SinewDeformer, text: str, icon: str):
    """Draw a button that bakes with the settings of the panel."""
    settings = deformer.bake
    button = layout.operator(Operators.BAKE, text=text, icon=icon)
    source = settings if settings.custom_range else context.scene
    button.target = settings.wanted
    button.frame_start, button.frame_end = source.frame_start, source.frame_end
    button.step = 1 if settings.wanted == "ALEMBIC" else settings.step
    button.exact_keys = settings.exact_keys
    return button


PANELS = (SINEW_PT_bake,)

register, unregister = register_classes_factory(PANELS)
