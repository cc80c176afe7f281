# SPDX-License-Identifier: GPL-3.0-or-later
"""Access to the inner parts of the add-on: tests reach them by their names, wherever they stand.

Without a window there are no timers, threads and drags, so tests call the functions that these would call.
"""

import functools
import gc
import importlib
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

import addon_utils
import bpy
import installed
import pytest
from rigs.rig import update

OPACITY = 0.5  # of overlays, in tests


# Modules whose names others have, too, or that tests call otherwise.
MODULES = {
    "bake": "bake",
    "bind": "session.actions.bind",
    "control": "ui.control",
    "control_drag": "operators.tools.control_drag",
    "core_rigs": "core.rigs",
    "drag": "session.actions.drag",
    "evaluation": "handlers.evaluation",
    "handles": "session.actions.handles.handles",
    "kind": "session.controls.handles.kind",
    "kinds": "session.controls.kinds",
    "live_drag": "session.evaluation.drag",
    "parameters": "ui.parameters",
    "posing": "session.actions.puppet.posing",
    "reach": "ui.overlays.reach",
    "refining": "ui.refining",
    "repair": "session.actions.repair",
    "rigging": "session.actions.rigging",
    "sides": "core.sides",
    "tasks": "core.tasks",
    "traits": "session.datablocks.traits",
    "try_it": "session.actions.try_it",
}

# Functions that work in proportion to the mesh; that read its arrays; that read a control; that look through
# the rig.
WRITES = {"write_shape", "write_positions"}
WORK = {"solve", "read_incoming", "read_rest", "read_shape", "read_positions", *WRITES}
READS = {"read_positions", "read_incoming", "read_attributes", "read_shape", "read_rest", "read_faces"}
CONTROL_READS = {"read_state", "read_place"}  # of a kind of control; of an object or a bone
LOOKS = {"group_weights", "read_weights", "rest_meshes"}


def room(path: str) -> ModuleType:
    """A room of the add-on by name, as ``inner.status``; looked up anew, for tests load it again."""
    return importlib.import_module(f"{installed.name()}.{path}")


@functools.cache
def _path_of(name: str) -> str:
    """Where the module of this name stands in the add-on."""
    folder = Path(sys.modules[installed.name()].__file__).parent
    inside = [path.relative_to(folder) for path in folder.rglob("*.py")]
    known = [path.parent if path.name == "__init__.py" else path.with_suffix("") for path in inside]
    (found,) = (path for path in known if path.name == name)
    return ".".join(found.parts)


class _Inner:
    """Rooms and modules of the add-on by their names; looked up anew, for tests load the add-on again."""

    def __getattr__(self, name: str) -> ModuleType:
        return room(MODULES.get(name) or _path_of(name))


inner = _Inner()


def native() -> ModuleType:
    """The compiled module."""
    return inner.backend.availability().module


def catch_up() -> bool:
    """What a window's timer does when the user pauses; True while a thread is at work."""
    return inner.deferred.catch_up()


def settle() -> None:
    """A pause in which the timer works, and the evaluations around it."""
    update()
    catch_up()
    update()


def finish(seconds: float = 20.0) -> bool:
    """Pauses until no thread is at work; False where that takes longer."""
    end = time.monotonic() + seconds
    while catch_up():
        if time.monotonic() > end:
            return False
        time.sleep(0.002)
        update()
    update()
    return True


def factor_of(deformer) -> object:
    """The native factor that a deformer is bound with."""
    return inner.sessions.find(deformer.uid).bound.factor


def notes_of(deformer) -> list[str]:
    """The lines that the panel shows below the status of a deformer, without buttons."""
    return [line.text for line in inner.status.notes(deformer.uid)]


def use_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """Binds and solves go to threads, as those of heavy meshes do in a window."""
    monkeypatch.setattr(inner.binding, "may_wait", lambda _count: True)


def bind_in_thread(obj: bpy.types.Object, deformer, monkeypatch: pytest.MonkeyPatch) -> None:
    """A bind for another value of a parameter is under way in a window; nobody wants it any more."""
    numbers = [row for row in deformer.definition.parameters if row.rebinds and hasattr(row, "span")]
    if not numbers:
        pytest.skip("no number of this method makes a new factor")
    parameter = numbers[0]
    before = getattr(deformer.parameters, parameter.id)
    with monkeypatch.context() as patch:
        use_threads(patch)
        setattr(deformer.parameters, parameter.id, parameter.span.soft)
        inner.sessions.find(deformer.uid).bound = None
        inner.bind.bind(obj, deformer, wait=False)
    assert inner.binding.job(deformer.uid) is not None
    setattr(deformer.parameters, parameter.id, before)


def ask_for_factor(deformer) -> object:
    """What an evaluation in a window asks for: the factor, or None while a thread makes it."""
    return inner.binding.ensure(inner.sessions.find(deformer.uid), deformer, deformer, wait=False)


def calls_of(action: Callable[[], object]) -> Counter:
    """Python functions of ours that ran during the action, by name, and our calls of ``foreach_get``."""
    found: Counter = Counter()

    def note(frame, event: str, called: object) -> None:
        if event not in ("call", "c_call"):
            return
        name = frame.f_code.co_name if event == "call" else getattr(called, "__name__", "")
        is_counted = event == "call" or name == "foreach_get"
        if is_counted and frame.f_globals.get("__name__", "").startswith(f"{installed.name()}."):
            found[name] += 1

    gc.disable()  # Python 3.11.2 has crashed where a thread collected garbage among frames that are profiled
    sys.setprofile(note)
    try:
        action()
    finally:
        sys.setprofile(None)
        gc.enable()
    return found


@contextmanager
def evaluated_by(handler) -> Iterator[None]:
    """Another handler takes the place of the one that solves when something was edited; None takes it out."""
    handlers, ours = bpy.app.handlers.depsgraph_update_post, inner.evaluation.on_depsgraph_update
    place = handlers.index(ours)
    handlers[place : place + 1] = [] if handler is None else [handler]
    try:
        yield
    finally:
        if handler is not None:
            handlers.remove(handler)
        handlers.insert(place, ours)


@contextmanager
def dragging() -> Iterator[None]:
    """Edits are steps of a drag, as in a window: each shows what its budget allows."""

    def preview(_scene, depsgraph) -> None:
        inner.evaluate.update(depsgraph, preview=True, edit=True)

    with evaluated_by(preview):
        yield


MOST_PAUSES = 4  # each may cause another: an edit is looked at, a mesh bound anew, a preview made final


def assert_at_rest(seconds: float = 20.0) -> None:
    """The user does nothing any more: threads end, all is collected, and no evaluation causes another."""
    caused: list[list[str]] = []

    def note(_scene, depsgraph) -> None:
        caused[-1] += [change.id.name for change in depsgraph.updates]

    bpy.app.handlers.depsgraph_update_post.append(note)
    try:
        for _ in range(MOST_PAUSES):
            caused.append([])
            update()
            assert finish(seconds), (
                f"threads of {_under_way()} start again and again, or nobody collects them"
            )
            if not caused[-1]:
                break
    finally:
        bpy.app.handlers.depsgraph_update_post.remove(note)
    assert not caused[-1], f"evaluations cause each other, pause after pause: {caused}"
    assert not _under_way(), f"nobody collects what was computed for {_under_way()}"
    unsettled = inner.sessions.unsettled()
    assert not unsettled, f"a preview never becomes final: {unsettled}"


def _under_way() -> list[str]:
    """Deformers with a bind or a solve that runs, or that ended and waits to be taken in."""
    find, binding = inner.sessions.find, inner.binding
    keys = [deformer.uid for obj in inner.owners.owners() for deformer in obj.sinew.deformers]
    found = {key for key in keys if binding.job(key) is not None} | set(binding.unwatched())
    return sorted(found | {key for key in keys if (held := find(key)) and held.work is not None})


def functions() -> set[str]:
    """The names of all functions of the add-on: what ``calls_of`` may find."""
    ours = [
        module for name, module in sys.modules.items() if name.startswith(f"{installed.name()}.") and module
    ]
    return {name for module in ours for name, value in vars(module).items() if callable(value)}


@contextmanager
def without_the_add_on() -> Iterator[None]:
    """The add-on is off for a while, and leaves no handler behind."""
    name, count = inner.ids.__package__, handlers_of_ours()
    addon_utils.disable(name)
    try:
        assert handlers_of_ours() == 0
        assert not hasattr(bpy.types.Object, "sinew")
        yield
    finally:
        addon_utils.enable(name)
    assert handlers_of_ours() == count


def handlers_of_ours() -> int:
    return sum(
        "sinew" in getattr(handler, "__module__", "")
        for kind in dir(bpy.app.handlers)
        if isinstance(getattr(bpy.app.handlers, kind), list)
        for handler in getattr(bpy.app.handlers, kind)
    )
