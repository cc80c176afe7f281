# SPDX-License-Identifier: GPL-3.0-or-later
"""The menus of tasks, with their methods, and of the names that others have for them.

Blender's search finds entries of menus by their labels, so every word that finds a method in the browser
stands in one.
"""

from bpy.types import Context, Menu, UILayout
from bpy.utils import register_classes_factory

from ...core.labels import known_as, label_of
from ...core.methods import BY_ID, Method
from ...core.tasks import TASKS, Task, task_of
from ...ids import Menus, Operators
from ...operators import task_refusal
from ..layouts import invoking


def draw_tasks(context: Context, layout: UILayout) -> None:
    """Draw a menu for each task, and a plain entry for one without methods of its own."""
    for task in TASKS:
        if _own_methods(task):
            layout.menu(Menus.OF_TASK.format(task.id), icon=task.icon)
        else:
            _draw_entry(context, layout, task, None, task.label, task.icon)
    layout.menu(Menus.OTHER_NAMES, icon="VIEWZOOM")
    layout.operator(Operators.ALL_TASKS, icon="IMGDISPLAY")


class SINEW_MT_other_names(Menu):
    """What other programs call tasks"""

    bl_idname = Menus.OTHER_NAMES
    bl_label = "By Other Names"

    def draw(self, context: Context) -> None:
        layout = invoking(self.layout)
        for task in TASKS:
            for name in task.other_names:
                _draw_entry(context, layout, task, None, f"{name} ({task.label})", task.icon)
        layout.separator()
        layout.menu(Menus.LEARNED_NAMES, icon="BLANK1")


class SINEW_MT_learned_names(Menu):
    """What the literature calls methods, and further words for them"""

    bl_idname = Menus.LEARNED_NAMES
    bl_label = "Methods"

    def draw(self, context: Context) -> None:
        layout = invoking(self.layout)
        for task in TASKS:
            for method in _own_methods(task):
                words = f"{label_of(method)} ({known_as(method)}): {method.search}"
                _draw_entry(context, layout, task, method, words, task.icon)


def _own_methods(task: Task) -> list[Method]:
    """Its methods, but for one that another task recommends."""
    return [BY_ID[name] for name in task.methods if task_of(BY_ID[name]) is task]


def _draw_entry(
    context: Context, layout: UILayout, task: Task, method: Method | None, text: str, icon: str
) -> None:
    row = layout.row()
    row.enabled = not task_refusal(context, task, method)
    start = row.operator(Operators.TASK_START, text=text, icon=icon)
    start.task, start.method = task.id, method.id if method else ""


def _menu_of(task: Task) -> type[Menu]:
    """The methods of a task, the recommended one first."""

    def draw(menu: Menu, context: Context) -> None:
        layout = invoking(menu.layout)
        for method in _own_methods(task):
            if not method.wraps:  # which is a switch: it keeps the details of another method
                icon = "SOLO_ON" if method is task.recommended else "BLANK1"
                _draw_entry(context, layout, task, method, label_of(method), icon)

    name = Menus.OF_TASK.format(task.id)
    about = f"Ways to do it: {task.purpose}"
    return type(name, (Menu,), {"__doc__": about, "bl_idname": name, "bl_label": task.label, "draw": draw})


register, unregister = register_classes_factory(
    (*(_menu_of(task) for task in TASKS if _own_methods(task)), SINEW_MT_learned_names, SINEW_MT_other_names)
)
