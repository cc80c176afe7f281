# SPDX-License-Identifier: GPL-3.0-or-later
"""An object without a deformer: what to do first."""

from bpy.types import Context, Object, UILayout

from ...core.tasks import Task, suggested
from ...core.traits import PLAIN, Trait
from ...ids import Operators
from ...operators import target_of, task_refusal
from ...session.actions import selection
from ...session.actions.controls import making
from ...session.datablocks.traits import traits_of
from ...session.targets import targets
from ..layouts import Button
from ..pose import draw_drag
from ..status_box import draw_message, draw_progress, without_native
from ..text import draw_text
from ..try_it import draw_offer
from .strays import draw_strays

_MOVED = (
    (Trait.CACHED, "{}, played from a cache"),
    (Trait.MOVED, "{}, moved before Sinew"),
)
_REGIONS = (
    Button(Operators.HANDLE_ADD, "Make Handle", "EMPTY_AXIS", (("kind", "HANDLE"),)),
    Button(Operators.HANDLE_ADD, "Hold Still", "PINNED", (("kind", "FIXED"),)),
)
_MORE = (
    Button(Operators.HANDLE_ADD, "Free Around It", "SELECT_SUBTRACT", (("kind", "SUPPORT"),)),
    Button(Operators.WIRE_ADD, "Wire along Edges", "CURVE_DATA", (("source", "EDGES"),)),
    Button(Operators.GRAB_REGION, "Grab Once", "VIEW_PAN"),
)


def is_there(context: Context) -> bool:
    """Whether nothing deforms the object yet."""
    return target_of(context).sinew.active is None


def page(context: Context) -> str:
    """How to begin with such an object; of a plain mesh, the first five minutes."""
    traits = traits_of(target_of(context), context.selected_objects)
    first = suggested(traits)[0]
    return first.page if _is_special(first, traits) or Trait.POINTS in traits else "start"


def draw(context: Context, layout: UILayout) -> None:
    """Draw what the object is, and what can be done with it."""
    obj = target_of(context)
    missing = without_native()
    if missing is not None:
        draw_message(context, layout, missing)
    draw_strays(context, layout, obj)
    work = making.cage_work(obj.name)
    if work is not None:
        layout.label(text="Making the cage...")
        draw_progress(layout, work, "making a cage")
    elif obj.mode == "EDIT":
        draw_selection(layout, obj)
    elif obj.mode == "WEIGHT_PAINT":
        _REGIONS[0].draw(layout)
    else:
        _draw_tasks(context, layout, obj)


def draw_selection(layout: UILayout, obj: Object) -> None:
    """Draw what can be done with the vertices that are selected in Edit Mode."""
    chosen, all_vertices = selection.counts(obj)
    layout.label(text=f"{chosen:,} of {all_vertices:,} vertices", icon="VERTEXSEL")
    large = layout.column(align=True)
    large.scale_y = 1.3
    for button in _REGIONS:
        button.draw(large)
    column = layout.column(align=True)
    for button in _MORE:
        button.draw(column)


def _draw_tasks(context: Context, layout: UILayout, obj: Object) -> None:
    """Draw the tool that drags, and the tasks that suit the object: first what is special about it."""
    traits = traits_of(obj, context.selected_objects)
    tasks = list(suggested(traits))
    is_plain = not (tasks and _is_special(tasks[0], traits))
    if is_plain:
        draw_offer(context, layout)
    text = next((said for trait, said in _MOVED if trait in traits), "{}")
    if {Trait.MOVED, Trait.BONES} <= traits:
        text = "{}, moved by bones"
    draw_text(context, layout, text.format(obj.name), f"OUTLINER_OB_{obj.type}")
    large, others = layout.column(), layout.column(align=True)
    large.scale_y, others.scale_y = 1.5, 1.15
    drag = "SURFACE" if targets.is_mesh(obj) else "POINTS"
    if is_plain:
        draw_drag(large, drag)
    else:
        _draw_task(context, large, tasks.pop(0))
        draw_drag(others, drag)
    for task in tasks:
        _draw_task(context, others, task)
    layout.operator(Operators.ALL_TASKS, icon="IMGDISPLAY")


def _is_special(task: Task, traits: frozenset[Trait]) -> bool:
    """Whether a task is suggested for more than that the object has a surface, or points."""
    return any(trait in traits - PLAIN for trait in task.suits)


def _draw_task(context: Context, layout: UILayout, task: Task) -> None:
    row = layout.row(align=True)
    row.enabled = not task_refusal(context, task)
    row.operator(Operators.TASK_START, text=task.label, icon=task.icon).task = task.id
