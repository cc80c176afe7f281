# SPDX-License-Identifier: GPL-3.0-or-later
"""Two popups. A click on a task starts it and closes the first; a click on a method leaves the other open."""

from collections.abc import Sequence
from dataclasses import dataclass

from bpy.props import StringProperty
from bpy.types import Context, Event, Operator, UILayout
from bpy.utils import register_classes_factory

from ... import compat
from ...core.labels import fails_of, known_as, label_of
from ...core.methods import Method
from ...core.tasks import TASKS, Task, found, task_for, task_of
from ...ids import Operators
from ...operators import choice_refusal, method_refusal, page_of, target_of, task_refusal, tasks_beside
from ...operators.offered import Offered
from ...properties import field
from ...session.evaluation.binding import duration, expected_seconds
from ..layouts import invoking
from .pictures import beside_picture, draw_picture

_WIDTH = 760  # pixels at scale 1: eight labels of methods beside each other
_ON_CARD = 5.0  # the height of a picture, in buttons
_SPEEDS = ("quick", "medium", "slow")  # by the cost of a method

Cell = tuple[Task, Method | None]


@dataclass(frozen=True)
class _Grid:
    """How cells are laid out: so many in a row, with pictures so many buttons high."""

    columns: int
    scale: float


_OF_TASKS, _OF_METHODS = _Grid(6, 5.2), _Grid(8, 3.9)


def _search_changed(_popup: Operator, context: Context) -> None:
    compat.refresh_popup(context)


class _Browser(Offered):
    """Base of the popups: a search, groups of cells with pictures, and a card about the chosen one."""

    bl_options = set()

    search: field(StringProperty, options={"SKIP_SAVE", "TEXTEDIT_UPDATE"}, update=_search_changed).named(
        "Search", "Search by a name, by what another program calls it, or by what you want to do"
    )
    QUESTION = ""

    def invoke(self, context: Context, _event: Event) -> set[str]:
        self.search = ""
        return context.window_manager.invoke_popup(self, width=_WIDTH)

    def execute(self, _context: Context) -> set[str]:
        return {"FINISHED"}

    def draw(self, context: Context) -> None:
        layout = invoking(self.layout)
        head = layout.row()
        head.label(text=self.QUESTION)
        head.prop(self, "search", text="", icon="VIEWZOOM")
        hits = self.hits(context) if self.search.strip() else None
        if hits is None:
            self.draw_all(context, layout)
        else:
            layout.label(text="Found" if hits else "Nothing found - try another word")
            self.draw_cells(context, layout, hits, _OF_METHODS)
        chosen = self.chosen(context)
        if hits and chosen not in hits:
            chosen = hits[0]
        if chosen is not None:
            _draw_card(context, layout, *chosen)

    def hits(self, context: Context) -> Sequence[Cell]:
        """What the search finds."""
        raise TypeError(f"{type(self).__name__} finds nothing")

    def draw_all(self, context: Context, layout: UILayout) -> None:
        """Draw all cells, while nothing is searched for."""
        raise TypeError(f"{type(self).__name__} draws nothing")

    def draw_cell(self, context: Context, layout: UILayout, cell: Cell, grid: _Grid) -> None:
        """Draw a picture and the button below it."""
        raise TypeError(f"{type(self).__name__} draws no cells")

    def draw_cells(self, context: Context, layout: UILayout, cells: Sequence[Cell], grid: _Grid) -> None:
        """Draw them from left to right, the last row as wide as the others."""
        flow = layout.grid_flow(row_major=True, columns=grid.columns, even_columns=True)
        for cell in cells:
            self.draw_cell(context, flow.column(align=True), cell, grid)
        for _ in range(-len(cells) % grid.columns):
            flow.label(text="")

    def chosen(self, context: Context) -> Cell | None:
        """What the card describes while nothing is searched for."""
        raise TypeError(f"{type(self).__name__} describes nothing")


class SINEW_OT_all_tasks(_Browser, Operator):
    """Choose what to do, by pictures or by words"""

    bl_idname = Operators.ALL_TASKS
    bl_label = "All Tasks..."
    QUESTION = "What do you want to do?"

    @classmethod
    def refusal(cls, _context: Context) -> str:
        return ""

    def hits(self, _context: Context) -> Sequence[Cell]:
        return found(self.search)

    def draw_all(self, context: Context, layout: UILayout) -> None:
        self.draw_cells(context, layout, [(task, task.recommended) for task in TASKS], _OF_TASKS)

    def draw_cell(self, context: Context, layout: UILayout, cell: Cell, grid: _Grid) -> None:
        task, method = cell
        is_task = grid is _OF_TASKS or method is None or task is not task_of(method)
        layout.enabled = not task_refusal(context, task, None if is_task else method)
        draw_picture(layout, task.shown_as if is_task else method.id, grid.scale)
        start = layout.operator(
            Operators.TASK_START,
            text=task.label if is_task else label_of(method),
            depress=cell == self.chosen(context),
        )
        start.task, start.method = task.id, "" if is_task else method.id

    def chosen(self, context: Context) -> Cell | None:
        """What the active deformer does; without one, the first task that can be started."""
        offered = (task for task in TASKS if not task_refusal(context, task))
        return _in_use(context) or next(((task, task.recommended) for task in offered), None)


class SINEW_OT_choose_method(_Browser, Operator):
    """Choose another method for the active deformer; its regions, controls, keys and poses stay"""

    bl_idname = Operators.CHOOSE_METHOD
    bl_label = "Choose Method..."
    QUESTION = "Which method? The first of each row is recommended"

    @classmethod
    def refusal(cls, context: Context) -> str:
        return choice_refusal(context)

    def draw_all(self, context: Context, layout: UILayout) -> None:
        for task in self.tasks(context):
            layout.label(text=compat.told(f"{task.label}: {task.purpose}"), icon="SOLO_ON")
            cells = [(task, method) for method in (task.recommended, *task.more)]
            self.draw_cells(context, layout, cells, _OF_METHODS)

    def draw_cell(self, context: Context, layout: UILayout, cell: Cell, grid: _Grid) -> None:
        _task, method = cell
        layout.enabled = not method_refusal(target_of(context).sinew.active, method)
        draw_picture(layout, method.id, grid.scale)
        use = layout.operator(
            Operators.METHOD_USE, text=label_of(method), depress=cell == self.chosen(context)
        )
        use.method = method.id

    def hits(self, context: Context) -> Sequence[Cell]:
        rows = {method.id for task in self.tasks(context) for method in (task.recommended, *task.more)}
        return [cell for cell in found(self.search) if cell[1] is not None and cell[1].id in rows]

    def chosen(self, context: Context) -> Cell | None:
        return _in_use(context)

    def tasks(self, context: Context) -> Sequence[Task]:
        """The tasks whose methods are offered; none once the deformer is gone."""
        chosen = _in_use(context)
        return () if chosen is None else tasks_beside(chosen[1])


def _in_use(context: Context) -> Cell | None:
    """What the active deformer does; of a method that keeps the details of another one, that one."""
    obj = target_of(context)
    deformer = None if obj is None else obj.sinew.active
    if deformer is None:
        return None
    method, _values = deformer.methods[-1]
    return task_for(method, deformer.name), method


def _draw_card(context: Context, layout: UILayout, task: Task, method: Method | None) -> None:
    picture = task.shown_as if method is None else method.id
    column = beside_picture(layout.box(), picture, _ON_CARD, 0.17).column(align=True)
    head = column.row()
    head.label(text=task.label if method is None else _both_names(method))
    page = task.page if method is None else page_of(method)
    head.operator(Operators.HELP, text="", icon="QUESTION", emboss=False).page = page
    if method is None:
        column.label(text=compat.told(f"For: {task.purpose}"), icon="CHECKMARK")
        return
    column.label(text=method.summary, icon="BLANK1")
    column.label(text=compat.told(f"Best for: {task.purpose}"), icon="CHECKMARK")
    column.label(text=compat.told(fails_of(method)), icon="ERROR")
    needs = [f"Needs: {method.needs}"] if method.needs else []
    said = (f"Speed: {_speed(context, method)}", *needs)
    column.label(text="    ".join(map(compat.told, said)), icon="TIME")


def _both_names(method: Method) -> str:
    other = known_as(method)
    return label_of(method) if other == label_of(method) else f"{label_of(method)}  (known as {other})"


def _speed(context: Context, method: Method) -> str:
    """How quick a method is, and how long a bind is expected to take on the active object."""
    said, obj = _SPEEDS[method.cost - 1], target_of(context)
    seconds = 0.0 if obj is None else expected_seconds(obj, method)
    return f"{said}, binds {obj.name} in about {duration(1000.0 * seconds)}" if seconds else said


_CLASSES = (SINEW_OT_all_tasks, SINEW_OT_choose_method)
for _cls in _CLASSES:
    _cls.bl_description = _cls.__doc__

register, unregister = register_classes_factory(_CLASSES)
