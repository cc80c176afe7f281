# SPDX-License-Identifier: GPL-3.0-or-later
"""An object with a deformer: what it is, its controls, its main settings, its status."""

from bpy.types import Context, Object, UILayout

from ...core.labels import label_of
from ...core.tasks import Task, task_for
from ...ids import Menus, Operators
from ...operators import target_of
from ...properties import SinewDeformer
from ...session.targets import targets
from ..browser.pictures import beside_picture
from ..control import drawing_of
from ..layouts import fields, unless_baked
from ..parameters import draw_main
from ..status_box import draw_status, draw_troubles, has_troubles
from .start import draw_selection
from .strays import draw_strays

_ON_PANEL = 2.2  # the height of the picture, in buttons


def is_there(context: Context) -> bool:
    """Whether there is a deformer."""
    return target_of(context).sinew.active is not None


def page(context: Context) -> str:
    """About what is wrong, about bakes, or about the task."""
    deformer = target_of(context).sinew.active
    if has_troubles(deformer):
        return "troubles"
    return "bake" if deformer.bake.is_baked else _task(deformer).page


def draw(context: Context, layout: UILayout) -> None:
    """Draw the active deformer of the object."""
    obj = target_of(context)
    deformer = obj.sinew.active
    _draw_mode(context, layout, obj)
    draw_deformer(context, layout, obj, deformer)


def draw_deformer(context: Context, layout: UILayout, obj: Object, deformer: SinewDeformer) -> None:
    """Draw a deformer, without what depends on the mode."""
    draw_strays(context, layout, obj)
    if len(obj.sinew.deformers) > 1:
        _draw_list(layout, obj)
    draw_troubles(context, layout, deformer)
    settings = unless_baked(layout, deformer)
    _draw_method(settings, deformer)
    drawing_of(deformer.definition).draw(context, settings, obj, deformer)
    draw_main(context, fields(context, settings.column(align=True)), deformer)
    draw_status(context, layout, deformer)


def _task(deformer: SinewDeformer) -> Task:
    """What it is for; of a method that keeps the details of another one, what that is for."""
    return task_for(deformer.methods[-1][0], deformer.name)


def _draw_mode(context: Context, layout: UILayout, obj: Object) -> None:
    """Draw what the mode adds: buttons for the selection, the group that is painted, a way out of a cage."""
    active = context.object
    if active != obj and active.mode == "EDIT":
        layout.operator("object.mode_set", text="Done", icon="CHECKMARK").mode = "OBJECT"
    elif obj.mode == "EDIT" and targets.is_mesh(obj):
        draw_selection(layout, obj)
    elif obj.mode == "WEIGHT_PAINT" and obj.vertex_groups.active is not None:
        layout.label(text=f"Painting: {obj.vertex_groups.active.name}", icon="BRUSH_DATA")


def _draw_list(layout: UILayout, obj: Object) -> None:
    row = layout.row()
    row.template_list("SINEW_UL_deformers", "", obj.sinew, "deformers", obj.sinew, "active_deformer", rows=3)
    side = row.column(align=True)
    side.operator(Operators.DEFORMER_REMOVE, text="", icon="REMOVE")
    side.menu(Menus.DEFORMER, text="", icon="DOWNARROW_HLT")


def _draw_method(layout: UILayout, deformer: SinewDeformer) -> None:
    method, _values = deformer.methods[-1]
    column = beside_picture(layout, method.id, _ON_PANEL, 0.28).column(align=True)
    column.label(text=_task(deformer).label)
    column.operator(Operators.CHOOSE_METHOD, text=label_of(method), icon="DOWNARROW_HLT")
