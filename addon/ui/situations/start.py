# SPDX-License-Identifier: GPL-3.0-or-later
"""An object without a deformer: what to do first."""

from bpy.types import Context, Object, UILayout

from ...backend import availability
from ...core.tasks import TASKS, Task, suggested
from ...core.traits import PLAIN, Trait
from ...ids import Menus, Operators
from ...operators import target_of
from ...session.actions import selection
from ...session.actions.controls import making
from ...session.datablocks.traits import traits_of
from ...session.targets import targets
from ..layouts import Button, later
from ..pose import draw_drag
from ..status_box import NATIVE_MISSING, draw_message, draw_progress
from ..text import draw_text
from .strays import draw_strays

_TOOL = (("name", Operators.DRAG), ("space_type", "VIEW_3D"))
_DRAG = {True: ("Drag the Surface", "SURFACE"), False: ("Drag Points", "POINTS")}  # on meshes, and others
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


def _adding(name: str, icon: str) -> Button:
    """The button of a task that begins with a deformer without controls."""
    task = next(task for task in TASKS if task.id == name)
    return Button(Operators.DEFORMER_ADD, task.label, icon, (("method", task.recommended.id),))


# How a task begins.
_STARTS = {
    "joint": Button("wm.tool_set_by_id", "Correct a Joint", "BONE_DATA", _TOOL),
    "sheet": _adding("sheet", "MOD_CLOTH"),
    "box": Button(Operators.LATTICE_ADD, "Put in a Box", "LATTICE_DATA", (("source", "FIT"),)),
    "cage": Button(Operators.CAGE_ADD, "Wrap in a Cage", "MESH_ICOSPHERE", (("source", "AUTO"),)),
    "parts": Button(Operators.POINT_ADD, "Move Loose Parts", "STICKY_UVS_DISABLE"),
    "figure": Button(Operators.PUPPET_RIG, "Pose by Bones", "ARMATURE_DATA"),
    "animation": _adding("animation", "RENDER_ANIMATION"),
    "morph": Button(Operators.MORPH, "Morph to a Mesh", "MOD_DATA_TRANSFER"),
}


def is_there(context: Context) -> bool:
    """Whether nothing deforms the object yet."""
    return target_of(context).sinew.active is None


def page(context: Context) -> str:
    """How to begin with such an object; of a plain mesh, how a surface is posed."""
    traits = traits_of(target_of(context), context.selected_objects)
    first = suggested(traits)[0]
    return first.page if _is_special(first, traits) or Trait.POINTS in traits else "surface"


def draw(context: Context, layout: UILayout) -> None:
    """Draw what the object is, and what can be done with it."""
    obj = target_of(context)
    if availability().module is None:
        draw_message(context, layout, NATIVE_MISSING)
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
    text = next((said for trait, said in _MOVED if trait in traits), "{}")
    if {Trait.MOVED, Trait.BONES} <= traits:
        text = "{}, moved by bones"
    draw_text(context, layout, text.format(obj.name), f"OUTLINER_OB_{obj.type}")
    tasks = list(suggested(traits))
    large, others = layout.column(), layout.column(align=True)
    large.scale_y, others.scale_y = 1.5, 1.15
    drag = _DRAG[targets.is_mesh(obj)]
    if tasks and _is_special(tasks[0], traits):
        _draw_task(large, tasks.pop(0))
        draw_drag(others, *drag)
    else:
        draw_drag(large, *drag)
    for task in tasks:
        _draw_task(others, task)
    if later("ALL_TASKS"):
        layout.operator(later("ALL_TASKS"), text="All Tasks...", icon="IMGDISPLAY")
    else:
        layout.menu(Menus.ADD, text="All Tasks...", icon="IMGDISPLAY")


def _is_special(task: Task, traits: frozenset[Trait]) -> bool:
    """Whether a task is suggested for more than that the object has a surface, or points."""
    return any(trait in traits - PLAIN for trait in task.suits)


def _draw_task(layout: UILayout, task: Task) -> None:
    start = _STARTS[task.id]
    if later("TASK_START"):
        layout.operator(later("TASK_START"), text=task.label, icon=start.icon).task = task.id
    else:
        start.draw(layout)
