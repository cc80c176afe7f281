# SPDX-License-Identifier: GPL-3.0-or-later
"""A mode of Blender in which nothing is posed, such as Sculpt Mode."""

from bpy.types import Context, UILayout

from ...operators import target_of
from ...properties import deformers_of
from ...session.targets import targets
from ..status_box import draw_status, draw_troubles
from ..text import draw_text

_OURS = ("OBJECT", "POSE")


def is_there(context: Context) -> bool:
    """Whether the mode has to be left first. Regions are made in Edit Mode, and painted in Weight Paint."""
    obj = target_of(context)
    if obj.mode == "EDIT":
        return not targets.is_mesh(obj) and not deformers_of(obj)
    return obj.mode not in (*_OURS, "WEIGHT_PAINT")


def page(_context: Context) -> str:
    """How to begin."""
    return "start"


def draw(context: Context, layout: UILayout) -> None:
    """Draw the button that leaves the mode, and what the deformer does meanwhile."""
    obj = target_of(context)
    mode = obj.bl_rna.properties["mode"].enum_items[obj.mode].name
    draw_text(context, layout, f"Leave {mode} to pose", "INFO")
    layout.operator("object.mode_set", text="Object Mode", icon="OBJECT_DATAMODE").mode = "OBJECT"
    deformer = obj.sinew.active
    if deformer is not None:
        draw_troubles(context, layout, deformer)
        draw_status(context, layout, deformer)
