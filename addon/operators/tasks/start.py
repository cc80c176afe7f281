# SPDX-License-Identifier: GPL-3.0-or-later
"""Start a task, and change the method of a deformer: what a click in the browser does."""

from bpy.props import EnumProperty, StringProperty
from bpy.types import Context, Event, Operator

from ... import compat
from ...core import status
from ...core.errors import SinewError
from ...core.labels import fails_of, tooltip_of
from ...core.methods import BY_ID, wrapper_of
from ...core.status import Level
from ...core.tasks import TASK_BY_ID, TASKS
from ...ids import Operators
from ...properties import BASE
from ...session.actions import rigging
from ..arguments import once
from ..offered import Offered, OnLiveDeformer
from ..reporting import reporting_for, reports_errors
from ..target import explain_no_target, object_mode, target_of
from .refusals import method_refusal, task_refusal
from .starts import Start


class SINEW_OT_start_task(Offered, Operator):
    """Start a task on what is selected: it finds the handles, the cage or the lattice by itself"""

    bl_idname = Operators.TASK_START
    bl_label = "Start Task"
    bl_options = set()  # the operators that it calls can be undone and adjusted

    task: once(
        EnumProperty,
        items=tuple(
            (task.id, task.label, task.purpose, task.icon, number) for number, task in enumerate(TASKS)
        ),
        default=TASKS[0].id,
    ).named("Task", "Choose what is to be done")
    method: once(StringProperty).named(
        "Method", "Give the method to start with; if empty, the recommended one"
    )

    @classmethod
    def description(cls, context: Context, properties: "SINEW_OT_start_task") -> str:
        """The tooltip: why it is grey, and what it is for."""
        task = TASK_BY_ID[properties.task]
        method = BY_ID.get(properties.method)
        about = tooltip_of(method) if method else f"{task.label}: {task.purpose}"
        return _with_reason(task_refusal(context, task, method), about)

    @classmethod
    def refusal(cls, context: Context) -> str:
        return "" if context.object is not None else explain_no_target(context)[0]

    def invoke(self, context: Context, _event: Event) -> set[str]:
        return self._start(context, "INVOKE_DEFAULT")

    def execute(self, context: Context) -> set[str]:
        return self._start(context, "EXEC_DEFAULT")

    @reports_errors
    def _start(self, context: Context, call: str) -> set[str]:
        task = TASK_BY_ID[self.task]
        method = self.method or (task.methods[0] if task.methods else "")
        if method and method not in task.methods:
            raise SinewError(f"{task.label} has no method '{method}' - choose {', '.join(task.methods)}")
        refusal = task_refusal(context, task, BY_ID.get(method))
        if refusal:
            raise SinewError(refusal)
        with reporting_for(self):
            started = Start(context, task, method, call, self.tell).run()
        if context.window is not None and started != {"CANCELLED"}:
            compat.close_popups(context.window)  # else no event would reach an operator that stays
        return started - {"RUNNING_MODAL", "PASS_THROUGH"} or {"FINISHED"}  # the other operator stays


class SINEW_OT_use_method(OnLiveDeformer, Operator):
    """Let the active deformer use another method; its regions, controls, keys and poses stay"""

    bl_idname = Operators.METHOD_USE
    bl_label = "Use Method"
    bl_options = {"UNDO", "INTERNAL"}

    method: once(StringProperty).named("Method", "Give the method to use")

    @classmethod
    def description(cls, context: Context, properties: "SINEW_OT_use_method") -> str:
        """The tooltip: why it is grey, and what the method does."""
        method, obj = BY_ID.get(properties.method), target_of(context)
        if method is None:
            return cls.bl_description
        refusal = method_refusal(obj.sinew.active, method) if obj is not None and obj.sinew.active else ""
        return _with_reason(refusal, f"{tooltip_of(method)}.\n{fails_of(method)}")

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        if self.method not in BY_ID:
            raise SinewError(f"There is no method '{self.method}' - choose one of: {', '.join(BY_ID)}")
        method = BY_ID[self.method]
        refusal = method_refusal(deformer, method)
        if refusal:
            raise SinewError(refusal)
        around = wrapper_of(method) if deformer.definition.wraps else None
        deformer.method = method.id if around is None else around.id
        if around is not None:
            setattr(deformer.parameters, BASE, method.id)
        if not deformer.is_bound and status.current(deformer.uid).level is Level.ERROR:
            with object_mode(context, obj):
                rigging.try_bind(obj, deformer, wait=False)  # as its bind was refused with the other method
        context.view_layer.update()
        return {"FINISHED"}


def _with_reason(reason: str, about: str) -> str:
    return ".\n".join(map(compat.told, filter(None, (reason, *about.split(".\n")))))
