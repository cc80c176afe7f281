# SPDX-License-Identifier: GPL-3.0-or-later
"""Why a task or a method cannot be used on what is selected; empty where it can.

Panels and menus ask in every redraw, so nothing here looks at vertices.
"""

from collections.abc import Callable

from bpy.types import Context, Object

from ...core.labels import label_of
from ...core.methods import Method, Moved, UvMap
from ...core.tasks import TASKS, Task, task_of
from ...properties import SinewDeformer
from ...session.actions.controls import making
from ...session.actions.controls.making import BEING_MADE
from ...session.datablocks.movers import armatures_of, is_animated_before, is_moved_before
from ...session.targets import targets
from ..target import LINKED, explain_no_target, target_of

_MODES = {"EDIT", "OBJECT", "POSE"}


def task_refusal(context: Context, task: Task, method: Method | None = None) -> str:
    """Why the task cannot be started now, with the remedy; with another method than the recommended one."""
    if context.object is not None and context.object.mode not in _MODES:
        return f"Leave {_mode_name(context.object)} first"
    obj = subject_of(context)
    if obj is None:
        return explain_no_target(context)[0]
    if obj.library is not None:
        return LINKED
    if method is not None and not _takes(obj, method):
        return _needs_surface(obj)
    return next(filter(None, (ask(context, obj) for ask in _ASKED[task.id])), "")


def subject_of(context: Context) -> Object | None:
    """The object that a task is for: the target, or the mesh that is selected together with an armature."""
    obj = target_of(context)
    if obj is not None or context.object is None or context.object.type != "ARMATURE":
        return obj
    meshes = [other for other in context.selected_objects if targets.is_mesh(other)]
    return meshes[0] if len(meshes) == 1 else None


def method_refusal(deformer: SinewDeformer, method: Method) -> str:
    """Why a deformer cannot go over to the method, with the remedy."""
    obj = deformer.id_data
    if deformer.bake.is_baked:
        return f"{deformer.name} is baked - Unbake it first"
    if not _takes(obj, method):
        return _needs_surface(obj)
    if not method.is_space and any(not handle.vertex_group for handle in deformer.handles):
        return "Needs regions of the mesh, and some handles of this deformer have none"
    if any(isinstance(parameter, UvMap) for parameter in method.parameters) and not obj.data.uv_layers:
        return "Needs a UV map - unwrap the mesh first"
    return ""


def tasks_beside(method: Method) -> tuple[Task, ...]:
    """The tasks whose methods a deformer may change to: those with several that the same controls steer."""
    own = task_of(method)
    if not own.more:
        return ()
    return tuple(task for task in TASKS if task.more and task.recommended.control is own.recommended.control)


def choice_refusal(context: Context) -> str:
    """Why there is no other method to choose for the active deformer."""
    obj = target_of(context)
    deformer = None if obj is None else obj.sinew.active
    if deformer is None:
        return "Start a task first"
    if obj.library is not None:
        return LINKED
    method = deformer.definition
    return (
        "" if tasks_beside(method) else f"{task_of(method).label} has no other method than {label_of(method)}"
    )


def armature_for(context: Context, obj: Object) -> Object | None:
    """The armature that is to move a mesh: the selected one, or that of its modifier."""
    selected = [other for other in context.selected_objects if other.type == "ARMATURE"]
    found = selected or armatures_of(obj)[-1:]
    return found[0] if len(found) == 1 else None


def twin_for(context: Context, obj: Object) -> Object | None:
    """The one other mesh that is selected."""
    others = [other for other in context.selected_objects if other != obj and targets.is_mesh(other)]
    return others[0] if len(others) == 1 else None


def curves_for(context: Context, obj: Object) -> list[Object]:
    """The other selected curves."""
    return [other for other in context.selected_objects if other != obj and other.type == "CURVE"]


def _mode_name(obj: Object) -> str:
    return obj.bl_rna.properties["mode"].enum_items[obj.mode].name


def _takes(obj: Object, method: Method) -> bool:
    return targets.is_mesh(obj) or Moved.POINTS in method.moves


def _needs_surface(obj: Object) -> str:
    return f"Needs a surface: this is a {targets.label(obj)} - use Move Loose Parts"


def _surface(_context: Context, obj: Object) -> str:
    return "" if targets.is_mesh(obj) else _needs_surface(obj)


def _selection(_context: Context, obj: Object) -> str:
    chosen = obj.mode != "EDIT" or obj.data.total_vert_sel > 0
    return "" if chosen else "Select the vertices that are to move first"


def _moved(_context: Context, obj: Object) -> str:
    if is_moved_before(obj, None):
        return ""
    return "Nothing moves this mesh yet - it needs an Armature, shape keys or another modifier"


def _no_cage(_context: Context, obj: Object) -> str:
    return "" if making.cage_work(obj.name) is None else BEING_MADE


def _carriers(context: Context, obj: Object) -> str:
    if targets.is_mesh(obj) or curves_for(context, obj):
        return ""
    return f"Needs a curve - select it, and then {obj.name}"


def _armature(context: Context, obj: Object) -> str:
    found = armature_for(context, obj)
    return "" if found else f"Needs an armature - select one together with {obj.name}"


def _animated(_context: Context, obj: Object) -> str:
    if is_animated_before(obj, None):
        return ""
    return "Nothing before Sinew is keyed or cached - animate the armature or the shape keys first"


def _twin(context: Context, obj: Object) -> str:
    other = twin_for(context, obj)
    if obj.mode != "OBJECT":
        return "Go to Object Mode first"
    if other is None:
        return f"Select the mesh to morph to, and then {obj.name}"
    apart = len(other.data.vertices) - len(obj.data.vertices)
    if apart == 0:
        return ""
    return f"{other.name} has {abs(apart):,} vertices {'more' if apart > 0 else 'fewer'} than {obj.name}"


_Ask = Callable[[Context, Object], str]
_ASKED: dict[str, tuple[_Ask, ...]] = {  # by the task
    "limb": (_surface, _selection),
    "joint": (_surface, _moved, _selection),
    "sheet": (_surface, _selection),
    "box": (),
    "cage": (_no_cage,),
    "parts": (),
    "lines": (_carriers,),
    "clay": (),
    "figure": (_surface, _armature),
    "animation": (_surface, _animated, _selection),
    "morph": (_surface, _twin),
    "once": (_surface, _selection),
}
